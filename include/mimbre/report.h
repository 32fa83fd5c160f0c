#pragma once
#include <string>
#include <vector>

#include "mimbre/reduced_body.h"
#include "mimbre/results.h"

namespace mimbre {

struct ReportOptions {
  /// At most so many instants of the animation are kept, evenly thinned, the first and last among them.
  int max_frames = 1000;
  /// At most so many samples of every channel are kept. A longer record is thinned to the smallest and
  /// largest value of equal stretches, so that no peak is lost.
  int max_samples = 5000;
  /// Names of the channels plotted when the page opens; empty: the first few.
  std::vector<std::string> channels;
};

/// Whether the page was built into this library (CMake option MIMBRE_WITH_REPORT, needs npm).
bool report_available();

/// One self-contained HTML page: summary, plots and animation; it opens from disk, without server and
/// network. Throws std::runtime_error when the page was not built in, InputError when the results contradict
/// themselves (sizes) or a channel of the options does not exist.
std::string report_html(const Results& results, const ReportOptions& options = {});

/// Writes `report_html` to `path`: next to it first, then renamed, so that an old report is never half
/// overwritten. Throws also std::runtime_error when the file cannot be written.
void write_report(const Results& results, const std::string& path, const ReportOptions& options = {});

/// One of the runs that a page compares.
struct ComparedRun {
  Results results;
  std::string file;  ///< where the results were read from; shown, not opened
  /// Its name in legends and tables; empty: what was set, formulation, formalism, integrator and step as far
  /// as they differ between the runs, or else the file's name.
  std::string label;
};

/// One page of at least two runs: every channel (same name, same unit) that two of them have, drawn over each
/// other; what the others differ by from the first, on the instants of the coarser of both within the time
/// that both have, linearly interpolated (as `compare`), as curves and as mean and largest deviation; a table
/// of the runs; the animations of all over each other. Angles count turns. Runs may have different time grids
/// and ends. `max_samples` holds for each run, the names in `channels` are those of shared channels. Throws
/// as `report_html`, and InputError for fewer than two runs, for runs without a shared channel, and for times
/// that do not ascend.
std::string comparison_html(const std::vector<ComparedRun>& runs, const ReportOptions& options = {});

/// Writes `comparison_html` as `write_report` does.
void write_comparison(const std::vector<ComparedRun>& runs, const std::string& path,
                      const ReportOptions& options = {});

/// One page of a body: the validation report of its reduction, and its modes, animated, with their stresses
/// where the body has them: its eigenmodes and, by user_from_modal, the user's. Throws as `report_html`.
std::string modes_html(const ReducedBody& body);

/// Writes `modes_html` as `write_report` does.
void write_modes_report(const ReducedBody& body, const std::string& path);

}  // namespace mimbre

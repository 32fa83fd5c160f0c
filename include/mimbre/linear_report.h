#pragma once
#include <functional>
#include <string>
#include <vector>

#include "mimbre/linearise.h"
#include "mimbre/modes.h"

/// Pages and files of modes and of linear models (docs/linear-analyses.md). Functions that write a file write
/// it beside its target first, then rename it; they throw std::runtime_error when it cannot be written, or
/// where this mimbre was built without its pages (report_available()).
namespace mimbre {

/// One self-contained HTML page: the modes in a list, the chosen one animated. Needs ModesOptions::shapes:
/// throws std::invalid_argument without. Of very many modes of very many bodies the page has the first ones
/// and states how many.
std::string mode_shapes_html(const LinearisedModes& modes);

/// Throws UsageError where the path ends with no format of write_modes().
void check_modes_path(const std::string& path);

/// The modes with their shapes: a page (.html) or HDF5 (.h5, docs/results-format.md), by the ending. Throws
/// as check_modes_path() and mode_shapes_html().
void write_modes(const LinearisedModes& modes, const std::string& path);

struct ModesVtkOptions {
  int frames = 24;                            ///< of a period
  double share = 0.1;                         ///< amplitude, drawing_factor()
  std::function<void(double done)> progress;  ///< 0 to 1
};

/// Each mode over one period for ParaView: FOLDER/mode_1.pvd and so on, each a time series of PolyData files
/// (.vtp) of the whole mechanism: points in global axes, triangles and lines, solids as triangles; at the
/// points `displacement` (from the place at rest, m) and `body` (number, from 0). Time is that of the
/// oscillation, s; of modes that do not oscillate a part of a swing, 0 to 1. Makes the folder where it is
/// missing; an older export in it is replaced at the end, all or none, and other files stay. Returns the
/// path of the first series. Throws as mode_shapes_html(), and where nothing of the model can be drawn.
std::string write_modes_vtk(const LinearisedModes& modes, const std::string& folder,
                            const ModesVtkOptions& options = {});

/// One self-contained HTML page: Bode plots of the responses from the inputs to the outputs at these
/// frequencies, Hz, ascending. Throws InputError where the model has no inputs or no outputs, or there are
/// fewer than two frequencies.
std::string bode_html(const LinearModel& model, const std::vector<double>& frequencies);

/// Throws UsageError where the path ends with no format of write_linear_file(), or a page has no
/// frequencies.
void check_linear_path(const std::string& path, const std::vector<double>& frequencies);

/// A page of Bode plots (.html), or what write_linear_model() writes (.h5, .mat, .json), by the ending.
/// Throws as check_linear_path() and both of these.
void write_linear_file(const LinearModel& model, const std::string& path,
                       const std::vector<double>& frequencies = {});

}  // namespace mimbre

#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "mimbre/channels.h"

namespace mimbre {

/// Writes one HDF5 file (layout in docs/results-format.md), in chunks while running; what was flushed stays
/// readable when the process is killed. Where an older file stands at `path` it is replaced by finish() only,
/// and the new one grows beside it (NAME.part-PID.h5) until then. Throws std::runtime_error with a clear
/// message (disk full, no permission, another program writes the file); after an error the rows flushed
/// before remain readable at the place that the message names. Data are identical bytes for identical rows
/// (no time stamps). A writer that is destroyed before its end keeps its rows as keep() does.
class ResultsWriter {
 public:
  ResultsWriter(const std::string& path, const ResultsHeader& header);
  ~ResultsWriter();
  ResultsWriter(const ResultsWriter&) = delete;
  ResultsWriter& operator=(const ResultsWriter&) = delete;
  void add(const ResultsRow& row);
  /// Writes rows that have been waiting for half a second: to be called now and then where rows are seldom.
  void flush_if_due();
  /// Writes the rows that have been waiting.
  void flush();
  /// The file that grows, where the rows of a killed run are found: the one asked for or one beside it.
  std::string path() const;
  /// Further numbers, single precision, in a group of their own: attributes, and columns of one length each.
  /// They are written at the end.
  struct Group {
    std::string name;
    std::vector<std::pair<std::string, double>> attributes;
    std::vector<std::pair<std::string, std::string>> texts;  ///< attributes, too
    std::vector<std::pair<std::string, std::vector<float>>> columns;
  };
  void add_group(Group group);
  /// Writes what is buffered, and the run's summary (JSON text, may be empty); closes the file, which takes
  /// its place.
  void finish(const std::string& summary_json);
  /// The same for a run that came to no good end: an older file stays. Returns the path of what was written:
  /// the one asked for where nothing stood there.
  std::string keep(const std::string& summary_json);
  /// In the file so far.
  std::int64_t rows() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Everything of a results file. Throws InputError when the file is missing, truncated or not a results file.
struct Results {
  ResultsHeader header;
  std::string summary_json;  ///< empty when the run was cut short
  Eigen::VectorXd time;
  Eigen::MatrixXd channels;                                     ///< instants × channels
  std::vector<Eigen::Matrix<double, 7, Eigen::Dynamic>> poses;  ///< one per instant
  Eigen::MatrixXd modes;                                        ///< instants × all modes
};
Results read_results(const std::string& path);

/// Time and the named columns as CSV. The file is written beside its target (NAME.part-PID.csv) and takes its
/// place by finish(); `flush_if_due`, `flush`, `path`, `keep`, `rows` and errors as with ResultsWriter. The
/// first line has the names, with an apostrophe before those that a spreadsheet would take for formulas (= +
/// - @); where `units` are given, one for each column, the second line has these.
class CsvWriter {
 public:
  CsvWriter(const std::string& path, std::vector<std::string> columns,
            const std::vector<std::string>& units = {});
  ~CsvWriter();
  CsvWriter(const CsvWriter&) = delete;
  CsvWriter& operator=(const CsvWriter&) = delete;
  void add(double time, const Eigen::VectorXd& values);
  void flush_if_due();
  void flush();
  std::string path() const;
  void finish();
  std::string keep();
  std::int64_t rows() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Largest and mean absolute difference of every channel that both have, on the common time range: at
/// the instants of the coarser grid, where values of the finer are interpolated, by cubics where it is
/// smooth.
struct ChannelDifference {
  std::string name;
  double max_difference = 0;
  double mean_difference = 0;
  double at_time = 0;    ///< of the largest
  double amplitude = 0;  ///< largest absolute value in A
  /// How far the interpolated values may be off, about; 0: none are.
  double interpolation_error = 0;
};
std::vector<ChannelDifference> compare(const Results& a, const Results& b);

}  // namespace mimbre

#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mimbre/channels.h"

namespace mimbre {

/// Writes one HDF5 file (layout in docs/results-format.md), in chunks while running; what was flushed stays
/// readable when the process is killed. Throws std::runtime_error with a clear message (disk full, no
/// permission); after an error the rows flushed before remain readable. Data are identical bytes for
/// identical rows (no time stamps).
class ResultsWriter {
 public:
  ResultsWriter(const std::string& path, const ResultsHeader& header);
  ~ResultsWriter();
  ResultsWriter(const ResultsWriter&) = delete;
  ResultsWriter& operator=(const ResultsWriter&) = delete;
  void add(const ResultsRow& row);
  /// Writes what is buffered, and the run's summary (JSON text, may be empty); closes the file.
  void finish(const std::string& summary_json);

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

/// Time and the named channels as CSV, written next to its target and renamed when complete. All channels
/// when `names` is empty.
class CsvWriter {
 public:
  CsvWriter(const std::string& path, std::vector<std::string> columns);
  ~CsvWriter();
  CsvWriter(const CsvWriter&) = delete;
  CsvWriter& operator=(const CsvWriter&) = delete;
  void add(double time, const Eigen::VectorXd& values);
  void finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Largest and mean absolute difference of every channel that both have, on the common time range (the
/// coarser grid's instants, linear interpolation on the finer).
struct ChannelDifference {
  std::string name;
  double max_difference = 0;
  double mean_difference = 0;
  double at_time = 0;    ///< of the largest
  double amplitude = 0;  ///< largest absolute value in A
};
std::vector<ChannelDifference> compare(const Results& a, const Results& b);

}  // namespace mimbre

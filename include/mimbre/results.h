#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "mimbre/spec.h"

namespace mimbre {

struct ChannelInfo {
  std::string name;
  std::string unit;     ///< "m", "rad", "N", "J", "1", …
  std::string meaning;  ///< one line for people
};

/// How a body is drawn: points (body axes), mode shapes of the points, lines between points, solid shapes.
struct BodyDrawing {
  std::string name;
  Eigen::Matrix3Xd points;
  Eigen::MatrixXd point_shapes;  ///< 3·points × modes; no columns for a rigid body
  std::vector<std::array<int, 2>> lines;
  std::vector<std::array<int, 3>> triangles;  ///< of points: the surface, counterclockwise from outside
  std::vector<std::int64_t> labels;           ///< of the points in the file of their mesh; none: unknown
  Eigen::MatrixXd stress;                     ///< 6·points × modes, see ReducedBody::stress; empty: unknown
  double line_radius = 0.01;
  std::vector<spec::Shape> shapes;
  int modes = 0;
};

struct RoadDrawing {
  std::string name;
  Eigen::Matrix2Xd profile;  ///< x, z
};

/// What describes a run, written before the first step.
struct ResultsHeader {
  std::string title;
  std::string model_text;
  std::string options_json;  ///< parameters and command-line overrides
  double step = 0;
  std::vector<ChannelInfo> channels;
  std::vector<BodyDrawing> bodies;
  std::vector<RoadDrawing> roads;
};

/// One output instant. Poses: 7 × bodies (position, quaternion w x y z); modes: all bodies' amplitudes one
/// after another.
struct ResultsRow {
  double time = 0;
  Eigen::VectorXd channels;
  Eigen::Matrix<double, 7, Eigen::Dynamic> poses;
  Eigen::VectorXd modes;
};

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

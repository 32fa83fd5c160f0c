#pragma once
#include <Eigen/Dense>
#include <map>
#include <string>
#include <vector>

#include "app/program.h"

/// Runs of the examples, whose figures are then compared with what can be found without the program.
namespace mimbre::examples_test {

/// The columns of a run's CSV file by their names, `t` among them.
class Table {
 public:
  explicit Table(const app_test::fs::path& csv);
  /// Rows; the test fails where there is no such column.
  const Eigen::ArrayXd& operator[](const std::string& name) const;
  /// The rows from this time on.
  Table from(double time) const;

 private:
  Table() = default;
  std::map<std::string, Eigen::ArrayXd> columns_;
};

class ExampleTest : public app_test::ProgramTest {
 protected:
  /// Runs examples/NAME/model.yaml with further options of `mimbre run`; no warning is taken.
  Table run_example(const std::string& name, const std::vector<std::string>& options = {}) const;
};

app_test::fs::path model_of(const std::string& example);

/// How often per second the values rise through their mean, Hz: over whole periods.
double frequency(const Eigen::ArrayXd& time, const Eigen::ArrayXd& values);

/// Half of what lies between the largest value and the smallest.
double amplitude(const Eigen::ArrayXd& values);

}  // namespace mimbre::examples_test

#include "examples/example.h"

#include <sstream>
#include <stdexcept>

namespace mimbre::examples_test {

Table::Table(const app_test::fs::path& csv) {
  std::ifstream file(csv);
  std::string heading;
  std::getline(file, heading);
  const std::vector<std::vector<double>> rows = app_test::csv_rows(csv);
  std::istringstream names(heading);
  std::string name;
  for (std::size_t column = 0; std::getline(names, name, ','); ++column) {
    Eigen::ArrayXd& values = columns_[name];
    values.resize(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t row = 0; row < rows.size(); ++row)
      values[static_cast<Eigen::Index>(row)] = rows[row].at(column);
  }
}

const Eigen::ArrayXd& Table::operator[](const std::string& name) const {
  const auto found = columns_.find(name);
  if (found == columns_.end()) throw std::out_of_range("no column " + name);
  return found->second;
}

Table Table::from(double time) const {
  const Eigen::ArrayXd& t = (*this)["t"];
  const Eigen::Index rows = (t >= time).count();
  Table rest;
  for (const auto& [name, values] : columns_) rest.columns_[name] = values.tail(rows);
  return rest;
}

app_test::fs::path model_of(const std::string& example) {
  return app_test::fs::path(MIMBRE_SOURCE_DIR) / "examples" / example / "model.yaml";
}

Table ExampleTest::run_example(const std::string& name, const std::vector<std::string>& options) const {
  std::vector<std::string> arguments{"run", model_of(name).string(), "--json", "--csv", "run.csv"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const app_test::Outcome outcome = run(arguments);
  if (outcome.code != 0) throw std::runtime_error(outcome.err);
  EXPECT_TRUE(outcome.json().at("warnings").empty()) << outcome.err;
  return Table(folder / "run.csv");
}

double frequency(const Eigen::ArrayXd& time, const Eigen::ArrayXd& values) {
  const double mean = values.mean();
  double first = 0, last = 0;
  int rises = 0;
  for (Eigen::Index row = 1; row < values.size(); ++row) {
    const double before = values[row - 1] - mean, after = values[row] - mean;
    if (before >= 0 || after < 0) continue;
    last = time[row] - (time[row] - time[row - 1]) * after / (after - before);
    if (rises++ == 0) first = last;
  }
  return (rises - 1) / (last - first);
}

double amplitude(const Eigen::ArrayXd& values) { return 0.5 * (values.maxCoeff() - values.minCoeff()); }

}  // namespace mimbre::examples_test

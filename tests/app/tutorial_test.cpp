#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "app/program.h"
#include "support/text.h"

/// The tutorial's commands run as they stand, print what it shows, and give the numbers in its prose.
namespace mimbre::app_test::tutorial_test {
namespace {

const fs::path source = MIMBRE_SOURCE_DIR;

std::vector<std::string> words(const std::string& line) {
  std::vector<std::string> result;
  std::istringstream stream(line.substr(0, line.find('#')));
  for (std::string word; stream >> word;) result.push_back(word);
  return result;
}

double numerical_energy(const std::string& summary) {
  const auto found = test::matches(summary, "energy, numerical +([-0-9.e]+)");
  return found.empty() ? NAN : std::stod(found[0][1]);
}

/// A column of a CSV file.
std::vector<double> column(const fs::path& path, const std::string& name) {
  const std::string text = read_file(path);
  std::istringstream head(text.substr(0, text.find('\n')));
  std::size_t k = 0;
  for (std::string cell; std::getline(head, cell, ',') && cell != name;) ++k;
  std::vector<double> values;
  for (const auto& row : csv_rows(path)) values.push_back(row.at(k));
  return values;
}

double largest(const std::vector<double>& values) {
  double most = 0;
  for (const double x : values) most = std::max(most, std::abs(x));
  return most;
}

class TutorialRuns : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    for (const auto& entry : fs::directory_iterator(source / "examples/tutorial"))
      fs::copy(entry.path(), folder / entry.path().filename());
  }
  /// Largest difference of a channel.
  double difference(const std::string& a, const std::string& b, const std::string& channel) {
    return run({"compare", a, b, "--json"}).json().at("channels").at(channel).at("max_difference").number();
  }
  std::map<std::string, double> measured();
};

/// What the numbers with a mark `<!-- measured: NAME -->` before them are.
std::map<std::string, double> TutorialRuns::measured() {
  std::map<std::string, double> m;
  m["pendulum numerical"] = numerical_energy(run({"run", "pendulum.yaml"}).out);
  m["angle by half the step"] = difference("fine.h5", "pendulum.h5", "angle");
  const auto t = column(folder / "pendulum.csv", "t"), angle = column(folder / "pendulum.csv", "angle");
  std::vector<double> passes;  // upwards through the lowest point
  for (std::size_t k = 1; k < t.size(); ++k)
    if (angle[k - 1] < std::numbers::pi / 2 && angle[k] >= std::numbers::pi / 2)
      passes.push_back(t[k - 1] +
                       (std::numbers::pi / 2 - angle[k - 1]) / (angle[k] - angle[k - 1]) * (t[k] - t[k - 1]));
  m["first pass"] = passes.at(0);
  m["second pass"] = passes.at(1);
  m["period"] = passes[1] - passes[0];
  m["deflection, mm"] = 1e3 * largest(column(folder / "flexible.csv", "deflection"));
  m["deflection by more modes, mm"] = 1e3 * difference("flexible.h5", "more.h5", "deflection");
  const auto rocker = column(folder / "four-bar.csv", "rocker");
  m["rocker least"] = *std::min_element(rocker.begin(), rocker.end());
  m["rocker most"] = *std::max_element(rocker.begin(), rocker.end());
  auto sag = column(folder / "four-bar.csv", "coupler.middle");
  const auto end = column(folder / "four-bar.csv", "coupler.end");
  for (std::size_t k = 0; k < sag.size(); ++k) sag[k] -= end[k] / 2;
  m["sag, mm"] = 1e3 * largest(sag);
  m["four-bar numerical, mJ"] = 1e3 * numerical_energy(run({"run", "four-bar.yaml"}).out);
  m["four-bar numerical at 5 ms, mJ"] =
      1e3 * numerical_energy(run({"run", "four-bar.yaml", "--step", "0.005"}).out);
  return m;
}

TEST_F(TutorialRuns, SaysWhatItsCommandsPrint) {
  const std::string tutorial = read_file(source / "docs/tutorial.md");
  // Commands, each with the output that is shown right after it, if it is.
  int shown = 0;
  for (const auto& block : test::matches(tutorial, "```sh\\n([^`]*)```(\\s*```\\n([^`]*)```)?")) {
    Outcome last;
    std::istringstream lines(block[1]);
    for (std::string line; std::getline(lines, line);) {
      auto command = words(line);
      if (command.empty() || command[0] != "mimbre") continue;
      command.erase(command.begin());
      last = run(command);
      EXPECT_EQ(last.code, 0) << line << '\n' << last.err;
    }
    if (block[3].empty()) continue;
    EXPECT_EQ(last.out, block[3]);
    ++shown;
  }
  EXPECT_EQ(shown, 4);

  const auto is = measured();
  std::size_t told = 0;
  for (const auto& number : test::matches(tutorial, "<!-- measured: ([^>]*) -->((?:−)?[0-9.]+)")) {
    ASSERT_TRUE(is.contains(number[1])) << number[1];
    const std::string text = test::replaced(number[2], "−", "-");
    const auto point = text.find('.');
    const std::size_t decimals = point == std::string::npos ? 0 : text.size() - point - 1;
    EXPECT_EQ(fmt::format("{:.{}f}", is.at(number[1]), decimals), text) << number[1];
    ++told;
  }
  EXPECT_EQ(told, is.size());
}

}  // namespace
}  // namespace mimbre::app_test::tutorial_test

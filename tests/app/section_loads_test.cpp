#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "app/output_schema.h"
#include "app/program.h"

/// Loads in all sections of a body of bars: recorded by one output, told and written by mimbre stress.
namespace mimbre::app_test::section_loads_test {
namespace {

using testing::HasSubstr;

constexpr double diameter = 0.03, length = 1.2, density = 2700, acceleration = 6;
const double area = std::numbers::pi / 4 * diameter * diameter;

/// A blade that is sped up evenly about a hub: two bars, the second of rectangular section.
const std::string blade = fmt::format(R"y(mimbre: 1
materials: {{alloy: {{young: 7e10, poisson: 0.33, density: {0}}}}}
sections:
  rod: {{type: round, diameter: {1}}}
  bar: {{type: rectangle, height: 0.02, width: {2:.17g}}}
bodies:
  blade:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: alloy
      section: rod
      nodes: {{root: [0, 0, 0], middle: [0.5, 0, 0], tip: [{3}, 0, 0]}}
      bars:
        inner: {{from: root, to: middle, elements: 5, y: [0, 1, 0]}}
        outer: {{from: middle, to: tip, elements: 7, section: bar, y: [0, 1, 0]}}
      clamped: [root]
      dynamic_modes: 4
      stiffness_damping: 2e-3
gravity: [0, 0, 0]
joints: {{hub: {{type: revolute, between: [ground, blade.root], axis: [0, 0, 1], drive: {{position: "{4}*t^2"}}}}}}
outputs:
  - {{name: N there, section_force: blade, at: [0.9, 0, 0], component: N}}
  - {{name: loads, section_force: blade}}
simulation: {{step: 0.002, end: 1}}
)y",
                                      density, diameter, area / 0.02, length, acceleration / 2);

std::vector<std::vector<std::string>> rows_of(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

class SectionLoads : public ProgramTest {
 protected:
  void run_blade() {
    write_file(folder / "blade.yaml", blade);
    const Outcome ran = run({"run", "blade.yaml", "--output", "blade.h5", "--csv", "blade.csv"});
    ASSERT_EQ(ran.code, 0) << ran.err;
  }
};

/// N(x) = ½ ρ A ω² (L² − x²), Vy(x) = −½ ρ A α (L² − x²), in both sections at every node.
TEST_F(SectionLoads, OfABladeThatIsSpedUp) {
  run_blade();
  const Outcome told =
      run({"stress", "blade.h5", "--loads", "loads.csv", "--envelopes", "envelopes.csv", "--json"});
  ASSERT_EQ(told.code, 0) << told.err;
  expect_schema(told.out);

  const auto rows = rows_of(read_file(folder / "loads.csv"));
  EXPECT_EQ(rows.front(), (std::vector<std::string>{"body", "bar", "element", "end", "along", "t", "N", "Vy",
                                                    "Vz", "T", "My", "Mz", "von_mises"}));
  const auto recorded = rows_of(read_file(folder / "blade.csv"));
  const auto column =
      std::find(recorded.front().begin(), recorded.front().end(), "N there") - recorded.front().begin();
  const std::size_t instants = recorded.size() - 1;
  ASSERT_EQ(rows.size() - 1, 24 * instants);
  const double whole = 0.5 * density * area * length * length;
  std::size_t compared = 0;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const auto& row = rows[k];
    ASSERT_EQ(row.size(), 13u);
    const double t = std::stod(row[5]), x = std::stod(row[4]) + (row[1] == "outer" ? 0.5 : 0);
    const double share = 1 - x * x / (length * length), omega = acceleration * t;
    if (t > 0.6) {  // it has stopped shaking
      EXPECT_NEAR(std::stod(row[6]), whole * omega * omega * share, 1e-4 * whole * 36) << row[1] << x << t;
      EXPECT_NEAR(std::stod(row[7]), -whole * acceleration * share, 0.01 * whole * 6) << x << t;
    }
    if (row[1] == "outer" && row[2] == "4" && row[3] == "end") {
      const std::string& same = recorded[1 + (k - 1) % instants][static_cast<std::size_t>(column)];
      EXPECT_EQ(std::stod(row[6]), std::stod(same));
      ++compared;
    }
  }
  EXPECT_EQ(compared, instants);

  // Envelopes are the extremes of the loads.
  std::map<std::string, std::array<double, 4>> extremes;
  for (std::size_t k = 1; k < rows.size(); ++k)
    for (std::size_t c = 6; c < 13; ++c) {
      const auto& row = rows[k];
      const double t = std::stod(row[5]), value = std::stod(row[c]);
      const auto [place, first] = extremes.try_emplace(row[1] + row[2] + row[3] + rows.front()[c],
                                                       std::array<double, 4>{value, t, value, t});
      auto& [least, least_time, most, most_time] = place->second;
      if (value < least) least = value, least_time = t;
      if (value > most) most = value, most_time = t;
    }
  const auto envelopes = rows_of(read_file(folder / "envelopes.csv"));
  ASSERT_EQ(envelopes.size() - 1, extremes.size());
  for (std::size_t k = 1; k < envelopes.size(); ++k) {
    const auto& row = envelopes[k];
    ASSERT_EQ(row.size(), 10u);
    const auto& expected = extremes.at(row[1] + row[2] + row[3] + row[5]);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(std::stod(row[6 + i]), expected[i]) << row[5];
  }

  const test::Json body = told.json().at("bodies")[0];
  EXPECT_EQ(body.at("name").text(), "blade");
  ASSERT_EQ(body.at("sections").size(), 24u);
  const test::Json& root = body.at("sections")[0];
  EXPECT_EQ(root.at("bar").text(), "inner");
  EXPECT_EQ(root.at("end").text(), "start");
  EXPECT_EQ(root.at("envelopes").at("N").at("max_time").number(), 1);
  EXPECT_NEAR(root.at("envelopes").at("N").at("max").number(), 36 * whole, 1e-3 * 36 * whole);
}

TEST_F(SectionLoads, AreToldForPeople) {
  run_blade();
  const std::string text = run({"stress", "blade.h5", "--body", "blade"}).out;
  EXPECT_THAT(text, HasSubstr("blade: loads in 24 sections of its bars"));
  EXPECT_THAT(text, HasSubstr("inner at 0 m"));
  const Outcome none = run({"stress", "blade.h5", "--body", "blades"});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.err, HasSubstr("did you mean 'blade'"));
}

/// One component of all sections; of a section given by numbers there is no stress.
TEST_F(SectionLoads, OfOneComponentAndOfUnknownShape) {
  std::string text = blade;
  text.replace(text.find("section_force: blade}"), 21, "section_force: blade, component: Mz}");
  text.replace(text.find("{type: round, diameter: 0.03}"), 29, "{area: 7e-4, Iy: 4e-8, Iz: 4e-8, J: 8e-8}");
  write_file(folder / "blade.yaml", text);
  const Outcome ran = run({"run", "blade.yaml", "--output", "blade.h5", "--until", "0.01"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  ASSERT_EQ(run({"stress", "blade.h5", "--loads", "loads.csv"}).code, 0);
  const auto rows = rows_of(read_file(folder / "loads.csv"));
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const bool there = rows[k][1] == "outer" && rows[k][2] == "4" && rows[k][3] == "end";
    EXPECT_EQ(rows[k][6].empty(), !there);  // N has an output of its own in one section
    EXPECT_FALSE(rows[k][11].empty());
    EXPECT_TRUE(rows[k].size() == 12 || rows[k][12].empty());
  }
}

TEST_F(SectionLoads, OfARunWithoutThemAreRefused) {
  const Outcome ran = run({"run", MIMBRE_SOURCE_DIR "/examples/pendulum/flexible.yaml", "--output", "p.h5"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const Outcome none = run({"stress", "p.h5", "--loads", "loads.csv"});
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.err, HasSubstr("no section loads were recorded"));
  EXPECT_FALSE(fs::exists(folder / "loads.csv"));
}

}  // namespace
}  // namespace mimbre::app_test::section_loads_test

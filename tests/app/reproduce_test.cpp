#include <fmt/format.h>
#include <gmock/gmock.h>

#include <set>

#include "app/output_schema.h"
#include "app/program.h"

/// mimbre reproduce: the tables that cost little.
namespace mimbre::app_test::reproduce_test {
namespace {

using json = test::Json;
using testing::HasSubstr;

class Reproduce : public ProgramTest {
 protected:
  /// The rows of the tables; each has its five keys.
  json rows(const std::vector<std::string>& tables) const {
    std::vector<std::string> arguments{"reproduce", "--json"};
    for (const std::string& table : tables) arguments.insert(arguments.end(), {"--table", table});
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");  // no progress line where nobody looks
    expect_schema(outcome.out);
    const json list = outcome.json().at("rows");
    EXPECT_TRUE(list.is_array());
    for (const json& row : list) {
      for (const char* key : {"table", "case", "unit"}) EXPECT_TRUE(row.at(key).is_string()) << row;
      for (const char* key : {"published", "ours", "ratio"})
        EXPECT_TRUE(row.at(key).is_number() || row.at(key).is_null()) << row;
      if (row.at("published").is_number() && row.at("ours").is_number())
        EXPECT_DOUBLE_EQ(row.at("ratio"), row.at("ours").number() / row.at("published").number());
      else
        EXPECT_TRUE(row.at("ratio").is_null()) << row;
      // A number of ours is missing only where a run failed, and then the note says why.
      EXPECT_TRUE(row.at("ours").is_number() || row.contains("note")) << row;
    }
    return list;
  }
};

json of(const json& rows, const std::string& name) {
  for (const json& row : rows)
    if (row.at("case") == name) return row;
  ADD_FAILURE() << "no case " << name;
  return {};
}

TEST_F(Reproduce, NamesItsTables) {
  const json list = run({"reproduce", "--list", "--json"}).json().at("tables");
  std::set<std::string> names;
  for (const json& table : list) {
    names.insert(table.at("name"));
    EXPECT_FALSE(table.at("title").text().empty());
  }
  EXPECT_EQ(names, (std::set<std::string>{"coordinates-double-four-bar", "coordinates-suspension",
                                          "coordinates-vehicle", "cpu-double-four-bar", "cpu-suspension",
                                          "cpu-vehicle", "cpu-inertia", "accuracy", "real-time", "energy",
                                          "spin-up-plane", "spin-up-substructures", "spin-up-stiffness",
                                          "spin-up-foreshortening", "bases-solid-arm", "bases-vehicle"}));
  for (const std::string& name : names) EXPECT_THAT(run({"reproduce", "--list"}).out, HasSubstr(name));
}

/// Against our own converged nonlinear beam; the published deviations are from another code's.
TEST_F(Reproduce, ForeshorteningIsNoWorseThanPublished) {
  const json list = rows({"spin-up-foreshortening"});
  int compared = 0;
  for (const json& row : list) {
    const std::string name = row.at("case");
    ASSERT_TRUE(row.at("ours").is_number()) << row;
    if (name.find("CPU") != std::string::npos) continue;
    EXPECT_GT(row.at("ratio"), 0) << row;
    EXPECT_LT(row.at("ratio"), 1.1) << row;
    ++compared;
  }
  EXPECT_GE(compared, 2);
}

TEST_F(Reproduce, RelativeCoordinatesAreThePublishedOnes) {
  const json list = rows({"coordinates-double-four-bar", "coordinates-suspension", "coordinates-vehicle"});
  EXPECT_EQ(list.size(), 2u * (6 + 8 + 8));
  int relative = 0;
  for (const json& row : list) {
    EXPECT_TRUE(row.at("published").is_number());
    if (!row.at("case").text().starts_with("relative")) continue;
    ++relative;
    EXPECT_EQ(row.at("ours"), row.at("published")) << row;
    EXPECT_EQ(row.at("ratio"), 1);
  }
  EXPECT_EQ(relative, 6 + 8 + 8);
}

TEST_F(Reproduce, EnergyLossesAreOfThePublishedSize) {
  const json list = rows({"energy"});
  EXPECT_EQ(list.size(), 8u);
  EXPECT_EQ(of(list, "double four-bar, mean loss, rigid relative").at("published"), 0.004);
  for (const char* name :
       {"double four-bar, mean loss, rigid relative", "double four-bar, mean loss, flexible relative",
        "suspension, loss at the end, rigid relative", "suspension, loss at the end, flexible relative"}) {
    const json row = of(list, name);
    EXPECT_EQ(row.at("unit"), "J");
    EXPECT_GT(row.at("ratio"), 0.1) << name;
    EXPECT_LT(row.at("ratio"), 3) << name;
  }
}

TEST_F(Reproduce, TimesAreMeasuredAndCompared) {
  const json list = rows({"cpu-double-four-bar"});
  EXPECT_EQ(list.size(), 3u * 6);
  for (const char* bars : {"0", "5"}) EXPECT_GT(of(list, fmt::format("relative, {}", bars)).at("ours"), 0);
  const json quotient = of(list, "natural over relative, 5");
  EXPECT_NEAR(quotient.at("published"), 15.22 / 20.92, 1e-12);
  EXPECT_EQ(quotient.at("unit"), "1");
}

/// Errors against 64 modes: all bases converge, those with inertia's deflections at once; the fewest modes
/// are combinations.
TEST_F(Reproduce, ComparesBasesOnTheSolidArm) {
  const json list = rows({"bases-solid-arm"});
  EXPECT_EQ(list.size(), 2u * 6 * 4);
  const auto number = [&](const std::string& series, const std::string& what, const std::string& size) {
    return of(list, fmt::format("{}, {}, {}", series, what, size)).at("ours").number();
  };
  const std::string attachment = "eigenmodes with attachment modes",
                    truncation = "modal truncation augmentation";
  for (const std::string& series : {std::string("Craig–Bampton"), attachment}) {
    EXPECT_EQ(number(series, "modes", "smallest"), 18);
    EXPECT_EQ(number(series, "modes", "large"), 28);
    EXPECT_LT(number(series, "error", "large"), 0.1 * number(series, "error", "smallest"));
  }
  for (const std::string& series : {truncation, std::string("free interface"), std::string("Krylov")}) {
    EXPECT_EQ(number(series, "modes", "smallest"), 24);
    EXPECT_LT(number(series, "error", "smallest"), 1e-5);
  }
  EXPECT_LE(number("proper orthogonal", "modes", "large"), 6);
  EXPECT_LT(number("proper orthogonal", "error", "large"), 0.5);
}

TEST_F(Reproduce, PrintsTablesForPeople) {
  const Outcome text = run({"reproduce", "--table", "coordinates-suspension"});
  EXPECT_EQ(text.code, 0) << text.err;
  for (const char* part :
       {"coordinates-suspension", "natural", "relative", "published", "ours", "ratio", "A+L"})
    EXPECT_THAT(text.out, HasSubstr(part));
  const Outcome markdown = run({"reproduce", "--table", "coordinates-suspension", "--markdown"});
  EXPECT_THAT(markdown.out, HasSubstr("### coordinates-suspension"));
  EXPECT_THAT(markdown.out, HasSubstr("| published |"));
}

TEST_F(Reproduce, LeavesNothingBehind) {
  fs::create_directory(folder / "temporary");
  const std::string temporary = (folder / "temporary").string();
  const Outcome outcome = run({"reproduce", "--table", "coordinates-double-four-bar"},
                              [&] { setenv("TMPDIR", temporary.c_str(), 1); });
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(fs::is_empty(temporary));
}

TEST_F(Reproduce, RefusesUnknownTables) {
  const Outcome outcome = run({"reproduce", "--table", "coordinates-vehicel"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.err, HasSubstr("did you mean 'coordinates-vehicle'"));
  EXPECT_EQ(run({"reproduce", "--json", "--markdown"}).code, 2);
}

}  // namespace
}  // namespace mimbre::app_test::reproduce_test

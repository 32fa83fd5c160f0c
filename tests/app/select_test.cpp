#include <gmock/gmock.h>

#include "app/output_schema.h"
#include "app/program.h"
#include "mimbre/reduced_body.h"

/// mimbre select, and the options of mimbre reduce for further modes.
namespace mimbre::app_test::select_test {
namespace {

using testing::HasSubstr;

const fs::path examples = fs::path(MIMBRE_SOURCE_DIR) / "examples";
const std::string suspension = (examples / "solid-arm/suspension.yaml").string();

class SelectCommand : public ProgramTest {
 protected:
  ReducedBody body(const char* name) const { return load_reduced_body((folder / name).string()); }
};

TEST_F(SelectCommand, MakesABodyOfFewerModes) {
  const Outcome outcome =
      run({"select", suspension, "--body", "front_left.arm", "--error", "1", "-o", "small.h5", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_schema(outcome.out);
  const test::Json json = outcome.json();
  EXPECT_EQ(json["status"], "ok");
  EXPECT_EQ(json["candidates"], 20);
  EXPECT_LE(json["modes"], 3);
  EXPECT_EQ(json["kept"].size(), json["modes"]);
  EXPECT_GT(json["kept"][0]["participation"], 1);
  EXPECT_GT(json["dropped"].size(), 0U);
  EXPECT_LE(json["achieved_error"], 1);
  EXPECT_GT(json["estimated_error"], 0);
  const ReducedBody small = body("small.h5");
  EXPECT_EQ(small.modes, json["modes"]);
  EXPECT_EQ(small.name, "small");
  EXPECT_EQ(small.checks.back().name, "mode selection");
  EXPECT_TRUE(small.checks.back().passed);
}

TEST_F(SelectCommand, TellsPeopleTheSame) {
  const Outcome outcome = run({"select", suspension, "--body", "front_left.arm", "--keep", "modes", "--end",
                               "3", "--error", "2", "-o", "small.h5"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("of 20 modes; deflections within"));
  EXPECT_THAT(outcome.out, HasSubstr("dropped"));
  EXPECT_THAT(body("small.h5").mode_names[0], HasSubstr("mode "));
}

TEST_F(SelectCommand, ABodyIsNotOverwrittenByWhatWasMadeOfIt) {
  fs::copy(examples / "solid-arm/arm.h5", folder / "arm.h5");
  const std::string made = read_file(folder / "arm.h5");
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"select", suspension, "--body", "front_left.arm", "-o", "arm.h5"},
        std::vector<std::string>{"run", suspension, "--output", "arm.h5"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.err, HasSubstr("would be overwritten"));
    EXPECT_EQ(read_file(folder / "arm.h5"), made);
  }
}

TEST_F(SelectCommand, MistakesAreNamed) {
  const auto select = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{"select", suspension, "-o", "small.h5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  };
  const Outcome unknown = select({"--body", "front_left.arn"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("front_left.arm"));
  const Outcome rigid = select({"--body", "chassis"});
  EXPECT_EQ(rigid.code, 1);
  EXPECT_THAT(rigid.err, HasSubstr("it is rigid"));
  EXPECT_EQ(select({"--body", "front_left.arm", "--error", "0"}).code, 2);
  // In the rigid run the eyes hold the arm twice: what it answers does not fit the flexible one.
  const Outcome far = select({"--body", "front_left.arm", "--pre", "rigid", "--end", "1"});
  EXPECT_EQ(far.code, 3);
  EXPECT_THAT(far.err, HasSubstr("--pre candidates"));
  EXPECT_FALSE(fs::exists(folder / "small.h5"));
}

/// The solid arm with a load on its seat.
std::vector<std::string> reduce_arm(const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"reduce",       (examples / "solid-arm/arm.msh").string(),
                                     "--units",      "mm",
                                     "--material",   "2.1e11,0.3,7850",
                                     "--interface",  "front=group:front",
                                     "--interface",  "rear=group:rear",
                                     "--free-modes", "0",
                                     "-o",           "arm.h5",
                                     "--json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST_F(SelectCommand, ReduceTakesLoads) {
  const Outcome outcome = run(reduce_arm({"--modes", "1", "--load", "seat=group:seat,0,0,-1", "--load",
                                          "box=box(-40,300,-40, 40,360,40),1,0,0"}));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.json()["modes"], 6 + 1 + 2);
  EXPECT_THAT(outcome.out, HasSubstr("load seat"));
  for (const char* bad : {"seat", "seat=group:seat", "seat=group:seat,1,2", "seat=group:seat,1,2,x",
                          "seat=group:seat,0,0,0", "=group:seat,0,0,1", "seat=group:nowhere,0,0,1"}) {
    const Outcome mistake = run(reduce_arm({"--modes", "1", "--load", bad}));
    EXPECT_EQ(mistake.code, 2) << bad;
    EXPECT_THAT(mistake.err,
                HasSubstr(bad == std::string("seat=group:nowhere,0,0,1") ? "nowhere" : "--load"));
  }
}

TEST_F(SelectCommand, ReduceTakesTheUsersModes) {
  write_file(folder / "modes.csv",
             "node,direction,bending\n1,z,0\n2,z,0\n3,z,0.1\n4,z,0.2\n5,z,0.3\n6,z,0.1\n"
             "1,x,0\n1,y,0\n2,x,0\n");
  const Outcome outcome = run(reduce_arm({"--modes", "0", "--user-modes", "modes.csv"}));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.json()["modes"], 6 + 1);
  EXPECT_THAT(outcome.out, HasSubstr("user modes"));
  write_file(folder / "modes.csv", "node,direction,bending\n1,up,0\n");
  const Outcome mistake = run(reduce_arm({"--user-modes", "modes.csv"}));
  EXPECT_EQ(mistake.code, 1);
  EXPECT_THAT(mistake.err, HasSubstr("modes.csv:2"));
}

}  // namespace
}  // namespace mimbre::app_test::select_test

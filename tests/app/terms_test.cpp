#include <gmock/gmock.h>

#include "app/output_schema.h"
#include "app/program.h"

/// mimbre terms.
namespace mimbre::app_test::terms_test {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string crank = R"(mimbre: 1
gravity: [0, 0, 0]
parameters: {rate: 2}
materials: {alloy: {young: 7e10, poisson: 0.3, density: 2700}}
sections: {strip: {type: rectangle, height: 0.004, width: 0.02}}
bodies:
  bar:
    frame: {at: [0, 0, 0]}
    flexible:
      material: alloy
      section: strip
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {all: {from: root, to: tip, elements: 4}}
      clamped: [root]
      dynamic_modes: 2
joints:
  motor: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 0, 1], drive: {position: "rate*t^2"}}
outputs:
  - {name: tip, deflection: bar.tip, along: [0, 1, 0]}
simulation: {step: 1e-3, end: 0.5, output_interval: 1e-2}
)";

class TermsCommand : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file(folder / "crank.yaml", crank);
  }
};

TEST_F(TermsCommand, SavesTheChoiceWithTheModel) {
  const Outcome outcome = run({"terms", "crank.yaml", "--error", "0.5%", "-o", "lean.yaml", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_schema(outcome.out);
  const test::Json json = outcome.json();
  EXPECT_EQ(json.at("terms").size(), 10u);
  EXPECT_LE(json.at("error").number(), 0.5);
  const std::string made = read_file(folder / "lean.yaml");
  EXPECT_THAT(made, HasSubstr("include: [\"crank.yaml\"]"));
  EXPECT_THAT(made, HasSubstr("  bar: ["));
  EXPECT_THAT(made, HasSubstr("coriolis_body"));
  EXPECT_THAT(made, Not(HasSubstr("rotation_coupling,")));
  EXPECT_EQ(run({"run", "crank.yaml", "-q", "-o", "full.h5"}).code, 0);
  EXPECT_EQ(run({"run", "lean.yaml", "-q", "-o", "lean.h5"}).code, 0);
  const Outcome compared = run({"compare", "full.h5", "lean.h5", "--json"});
  EXPECT_EQ(compared.code, 0) << compared.err;
  const Outcome again = run({"terms", "lean.yaml", "-o", "leaner.yaml"});
  EXPECT_EQ(again.code, 1);
  EXPECT_THAT(again.err, HasSubstr("take its section neglected_inertia out first"));
}

TEST_F(TermsCommand, TellsPeopleTheSame) {
  const Outcome outcome = run({"terms", "crank.yaml", "--error", "0.5", "--outputs", "motor.torque"});
  EXPECT_EQ(outcome.code, 2) << "an output that the model does not have";
  EXPECT_THAT(outcome.err, HasSubstr("motor.torque"));
  const Outcome good = run({"terms", "crank.yaml", "--error", "0.5", "--end", "0.2"});
  ASSERT_EQ(good.code, 0) << good.err;
  EXPECT_THAT(good.out, HasSubstr("rotation_coupling"));
  EXPECT_THAT(good.out, HasSubstr("asked 0.5 %"));
}

TEST_F(TermsCommand, MistakesAreNamed) {
  for (const char* error : {"0", "-1%", "200%", "0.1 percent", "nan", "%"}) {
    const Outcome outcome = run({"terms", "crank.yaml", "--error", error});
    EXPECT_EQ(outcome.code, 2) << error;
    EXPECT_THAT(outcome.err, HasSubstr("--error: '" + std::string(error) + "' is no share"));
  }
  const Outcome over = run({"terms", "crank.yaml", "-o", "crank.yaml"});
  EXPECT_EQ(over.code, 2);
  EXPECT_EQ(read_file(folder / "crank.yaml"), crank);
  const Outcome nowhere = run({"terms", "crank.yaml", "-o", "nowhere/lean.yaml"});
  EXPECT_EQ(nowhere.code, 3);
  EXPECT_THAT(nowhere.err, HasSubstr("nowhere/lean.yaml"));
  const Outcome set = run({"terms", "crank.yaml", "--set", "rate=3", "-o", "lean.yaml"});
  EXPECT_EQ(set.code, 0) << set.err;
  EXPECT_THAT(read_file(folder / "lean.yaml"), HasSubstr("# With rate=3; give these again."));
}

}  // namespace
}  // namespace mimbre::app_test::terms_test

#include <gmock/gmock.h>

#include "app/program.h"

/// mimbre reduce and mimbre convert.
namespace mimbre::app_test::reduce_test {
namespace {

using json = test::Json;
using testing::HasSubstr;

const std::string data = MIMBRE_SOURCE_DIR "/tests/data/";
const std::string bar = data + "calculix/beam.inp", block = data + "gmsh/block-41.msh";

class Reduce : public ProgramTest {};

TEST_F(Reduce, TakesTheMatricesBesideTheInput) {
  const Outcome outcome = run({"reduce", bar, "--interface", "root=box(0,0,0, 0,1,1)", "--interface",
                               "tip=set:end", "--modes", "5", "-o", "bar.h5", "--json"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json summary = outcome.json();
  EXPECT_EQ(summary.at("dofs"), 36);
  EXPECT_EQ(summary.at("modes"), 6 + 5);
  EXPECT_EQ(summary.at("interfaces").size(), 2u);
  EXPECT_EQ(summary.at("frequencies_hz").size(), 5u);
  EXPECT_EQ(summary.at("free_frequencies_hz").size(), 10u);
  EXPECT_NEAR(summary.at("mass").number(), 2 * 7800, 0.02 * 15600);  // CalculiX's mass is a little off
  EXPECT_GT(summary.at("seconds").number(), 0);
  for (const json& check : summary.at("checks"))
    for (const char* key : {"name", "detail"}) EXPECT_TRUE(check.at(key).is_string());
  const Outcome text =
      run({"reduce", bar, "--interface", "root=box(0,0,0, 0,1,1)", "--modes", "3", "-o", "bar.h5"});
  EXPECT_EQ(text.code, 4) << text.err;  // three modes are too few, and the certificate says so
  EXPECT_THAT(text.out, HasSubstr("rigid motions"));
}

TEST_F(Reduce, ChoosesTheBasis) {
  const std::vector<std::string> common{"reduce",      bar,           "--interface", "root=box(0,0,0, 0,1,1)",
                                        "--interface", "tip=set:end", "-o",          "bar.h5",
                                        "--json"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = common;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  };
  const json all = with({"--modes", "5"}).json();
  ASSERT_EQ(all.at("effective_mass").size(), 5u);
  EXPECT_EQ(all.at("effective_mass")[0].size(), 6u);
  // The first three coincide.
  const double limit = 0.5 * (all.at("frequencies_hz")[2].number() + all.at("frequencies_hz")[3].number());
  const json below = with({"--max-frequency", std::to_string(limit)}).json();
  EXPECT_EQ(below.at("frequencies_hz").size(), 3u);
  EXPECT_EQ(with({"--basis", "krylov", "--modes", "3"}).json().at("modes"), 6 + 3);
  EXPECT_EQ(with({"--basis", "attachment", "--modes", "3"}).json().at("modes"), 6 + 3);
  // One of the six by inertia depends on the others in so small a model.
  EXPECT_EQ(with({"--basis", "modal_truncation", "--modes", "3"}).json().at("modes"), 6 + 6 + 3 - 1);
  const Outcome foreign = with({"--mass-matrix", "lumped"});
  EXPECT_EQ(foreign.code, 1);
  EXPECT_THAT(foreign.out, HasSubstr("these matrices are another program's"));
  // Twelve attachment modes and three, of which one depends on the others in so small a model.
  EXPECT_EQ(with({"--basis", "free_interface", "--modes", "3"}).json().at("modes"), 12 + 3 - 1);
  const json some = with({"--modes", "5", "--effective-mass", "5"}).json();
  EXPECT_LE(some.at("frequencies_hz").size(), 5u);
  EXPECT_THAT(some.at("checks").dump(), HasSubstr("mode selection"));
  EXPECT_NE(with({"--max-frequency", "100", "--modes", "3"}).code, 0);
  EXPECT_NE(with({"--basis", "krylov", "--effective-mass", "90"}).code, 0);
}

/// From Gmsh's mesh to a mechanism that moves.
TEST_F(Reduce, MakesABodyThatSwings) {
  const Outcome outcome = run({"reduce", block, "--units", "SI", "--material", "2.1e11,0.3,7850",
                               "--interface", "left=group:left", "--interface", "right=group:right", "--mean",
                               "right", "--modes", "4", "--output", "block.h5"});
  ASSERT_EQ(outcome.code, 4) << outcome.err;  // four modes are too few, and the certificate says so
  write_file(folder / "swing.yaml", R"(mimbre: 1
title: A block on a hinge
gravity: [0, 0, -9.81]
bodies:
  block: {frame: {at: [0, 0, 0]}, reduced: block.h5}
joints:
  hinge: {type: revolute, between: [ground, block.left], axis: [0, 1, 0]}
outputs:
  - {name: angle, joint: hinge}
simulation: {step: 0.001, end: 0.2}
)");
  const Outcome swing = run({"run", "swing.yaml", "--json"});
  EXPECT_EQ(swing.code, 0) << swing.err;
}

TEST_F(Reduce, ConvertsBodies) {
  ASSERT_EQ(run({"reduce", bar, "--interface", "root=box(0,0,0, 0,1,1)", "--interface", "tip=set:end",
                 "--modes", "2", "-o", "bar.h5"})
                .code,
            0);
  for (const std::string to : {"fem", "sid"}) {
    const Outcome there = run({"convert", "bar.h5", "--to", to});
    ASSERT_EQ(there.code, 0) << there.err;
    EXPECT_EQ(there.out, "bar." + to + "\n");
    const Outcome back = run({"convert", "bar." + to, "--to", "h5", "-o", "back-" + to + ".h5"});
    EXPECT_EQ(back.code, 0) << back.err;
  }
}

TEST_F(Reduce, SaysWhatIsWrong) {
  const auto fails = [&](std::vector<std::string> arguments, int code, const std::string& message) {
    arguments.insert(arguments.begin(), "reduce");
    arguments.insert(arguments.end(), {"-o", "body.h5"});
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, code) << message;
    EXPECT_THAT(outcome.err, HasSubstr(message));
    EXPECT_FALSE(fs::exists(folder / "body.h5"));
  };
  fails({bar, "--interface", "tip=set:ends"}, 2, "no group or set 'ends'; it has:");
  fails({bar, "--interface", "tip"}, 2, "NAME=SELECTION");
  fails({bar, "--interface", "tip=box(0,0,0)"}, 2, "box needs 6 numbers");
  fails({bar, "--interface", "tip=box(5,5,5,6,6,6)"}, 2, "no node of the model is there");
  fails({bar, "--interface", "tip=sphere(0,0,0,1)"}, 2, "selects nothing");
  fails({bar, "--interface", "tip=set:end", "--mean", "top"}, 2, "no interface 'top'");
  fails({block, "--interface", "left=group:left"}, 1, "material");
  fails({"nothing.inp", "--interface", "left=group:left"}, 1, "nothing.inp");
  fails({data + "scipy/stiffness.mtx", "--interface", "a=set:a"}, 2, "--mass");
}

/// Motions, axes and several interfaces after one option; and what is wrong with them.
TEST_F(Reduce, TakesMotionsOfInterfaces) {
  const std::vector<std::string> common{"reduce",      bar,       "--interface", "root=box(0,0,0, 0,1,1)",
                                        "tip=set:end", "--modes", "2",           "-o",
                                        "bar.h5",      "--json"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = common;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  };
  EXPECT_EQ(with({}).json().at("modes"), 6 + 2);
  EXPECT_EQ(with({"--free", "tip=rx,ry,rz"}).json().at("modes"), 3 + 2);
  EXPECT_EQ(with({"--free", "tip=x,ry", "--hold", "tip=y", "--axes", "tip=1,0,0"}).json().at("modes"), 3 + 2);
  EXPECT_EQ(with({"--hold", "tip"}).json().at("modes"), 2);
  for (const auto& [arguments, message] :
       {std::pair{std::vector<std::string>{"--free", "tip=w"}, "'w' is no motion"},
        {{"--free", "top=x"}, "no interface 'top'"},
        {{"--free", "tip=x", "--hold", "tip"}, "x is free and held at once"},
        {{"--axes", "tip=0,0,0"}, "z must have a direction"},
        {{"--axes", "tip=0,0,1,0,0,2"}, "x another one"},
        {{"--point", "tip=1,2"}, "NAME=x,y,z"}}) {
    const Outcome outcome = with(arguments);
    EXPECT_EQ(outcome.code, 2) << message;
    EXPECT_THAT(outcome.err, HasSubstr(message));
  }
}

}  // namespace
}  // namespace mimbre::app_test::reduce_test

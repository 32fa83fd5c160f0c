#include <gmock/gmock.h>

#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <map>

#include "app/program.h"
#include "mimbre/results.h"

/// Where outputs go: through links, to devices, over older files, and never over an input.
namespace mimbre::app_test::outputs_test {
namespace {

using ::testing::HasSubstr;

class Outputs : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file(folder / "pendulum.yaml", pendulum);
  }
  std::string at(const std::string& name) const { return (folder / name).string(); }
  int mode(const std::string& name) const {
    return static_cast<int>(fs::status(at(name)).permissions() & fs::perms::all);
  }
};

/// As root, too, who may put anything in a device's place.
TEST_F(Outputs, ADeviceStaysOne) {
  if (mknod(at("null").c_str(), S_IFCHR | 0666, makedev(1, 3)) != 0) GTEST_SKIP() << "no devices can be made";
  const Outcome results = run({"run", "pendulum.yaml", "-q", "-o", "null"});
  EXPECT_EQ(results.code, 3);
  EXPECT_THAT(results.err, HasSubstr("'null': it is not a plain file"));
  EXPECT_TRUE(fs::is_character_file(at("null")));
  EXPECT_EQ(run({"run", "pendulum.yaml", "-q", "--csv", "null"}).code, 0);
  EXPECT_TRUE(fs::is_character_file(at("null")));
}

TEST_F(Outputs, LinksAreFollowedAndModesKept) {
  fs::create_directory(folder / "far");
  for (const char* name : {"a.h5", "a.csv", "a.html"}) {
    write_file(folder / "far" / name, "older");
    chmod(at(std::string("far/") + name).c_str(), 0600);
    fs::create_symlink(fs::path("far") / name, folder / name);
  }
  write_file(folder / "victim", "precious");
  fs::create_symlink("victim", folder / "a.csv.part");
  ASSERT_EQ(run({"run", "pendulum.yaml", "-q", "-o", "a.h5", "--csv", "a.csv"}).code, 0);
  ASSERT_EQ(run({"report", "a.h5", "-o", "a.html"}).code, 0);
  EXPECT_EQ(read_results(at("far/a.h5")).time.size(), 101);
  EXPECT_EQ(csv_rows(at("far/a.csv")).size(), 101u);
  EXPECT_THAT(read_file(at("far/a.html")), HasSubstr("<html"));
  for (const char* name : {"a.h5", "a.csv", "a.html"}) {
    EXPECT_TRUE(fs::is_symlink(folder / name)) << name;
    EXPECT_EQ(mode(std::string("far/") + name), 0600) << name;
  }
  EXPECT_EQ(read_file(folder / "victim"), "precious");
}

TEST_F(Outputs, AFirstStepThatFailsLeavesOlderFilesWhole) {
  ASSERT_EQ(run({"run", "pendulum.yaml", "-q", "-o", "out.h5", "--csv", "out.csv"}).code, 0);
  const std::string h5 = read_file(folder / "out.h5"), csv = read_file(folder / "out.csv");
  std::string failing = pendulum;
  const std::string axis = "axis: [0, 1, 0]";
  failing.insert(failing.find(axis) + axis.size(), ", drive: {position: \"t < 0.005 ? 0 : 1e200*t^3\"}");
  write_file(folder / "failing.yaml", failing);
  const Outcome outcome = run({"run", "failing.yaml", "-q", "-o", "out.h5", "--csv", "out.csv"});
  EXPECT_EQ(outcome.code, 3) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("1 row in 'out.part-"));
  EXPECT_TRUE(read_file(folder / "out.h5") == h5);
  EXPECT_TRUE(read_file(folder / "out.csv") == csv);
}

/// An older table is not that of newer results: what belongs to them is said, and where it is.
TEST_F(Outputs, AnOlderTableIsNotTakenForThatOfNewerResults) {
  write_file(folder / "out.csv", "older");
  const pid_t child = start({"run", "pendulum.yaml", "--until", "1e8", "--set", "interval=1", "-q", "-o",
                             "out.h5", "--csv", "out.csv"});
  ASSERT_TRUE(has_rows(folder / "out.h5", 2));
  kill(child, SIGHUP);
  const Outcome outcome = wait_for(child);
  EXPECT_EQ(outcome.code, 3);
  const std::string rows = std::to_string(read_results(at("out.h5")).time.size());
  EXPECT_THAT(outcome.err,
              HasSubstr("are kept: " + rows + " rows in 'out.h5', " + rows + " rows in 'out.part-"));
  EXPECT_EQ(read_file(folder / "out.csv"), "older");
}

/// By its own name, by a link, by a second name.
TEST_F(Outputs, NoCommandWritesOverItsInput) {
  ASSERT_EQ(run({"reduce", MIMBRE_SOURCE_DIR "/tests/data/gmsh/block-22.msh", "--material", "2.1e11,0.3,7850",
                 "--interface", "left=group:left", "--modes", "2", "--no-cache", "-o", "arm.h5"})
                .signal,
            0);
  ASSERT_EQ(run({"run", "pendulum.yaml", "-q", "-o", "run.h5"}).code, 0);
  for (const char* name : {"pendulum.yaml", "arm.h5", "run.h5"}) {
    fs::create_symlink(name, folder / (std::string("link-") + name));
    fs::create_hard_link(folder / name, folder / (std::string("hard-") + name));
  }
  const std::string model = read_file(folder / "pendulum.yaml"), body = read_file(folder / "arm.h5"),
                    results = read_file(folder / "run.h5");
  for (const char* same : {"", "link-", "hard-"})
    for (std::vector<std::string> command : {std::vector<std::string>{"run", "pendulum.yaml", "-q", "-o"},
                                             {"run", "pendulum.yaml", "-q", "--csv"},
                                             {"run", "pendulum.yaml", "-q", "--every", "1", "--save-state"},
                                             {"convert", "arm.h5", "--to", "fem", "-o"},
                                             {"report", "arm.h5", "-o"},
                                             {"report", "run.h5", "-o"},
                                             {"report", "run.h5", "run.h5", "-o"}}) {
      command.push_back(same + command[1]);
      const Outcome outcome = run(command);
      EXPECT_EQ(outcome.code, 2) << command[0] << ' ' << command.back() << outcome.err;
      EXPECT_THAT(outcome.err, HasSubstr("would be overwritten"));
    }
  EXPECT_TRUE(read_file(folder / "pendulum.yaml") == model);
  EXPECT_TRUE(read_file(folder / "arm.h5") == body);
  EXPECT_TRUE(read_file(folder / "run.h5") == results);
}

/// Nor over a file that its model names, or a table, whatever they are called.
TEST_F(Outputs, NoCommandWritesOverWhatItReads) {
  write_file(folder / "part.csv",
             "joints:\n  hinge: {type: revolute, between: [ground, bob], at: [0, 0, 0], "
             "axis: [0, 1, 0], drive: {position: \"t\"}}\n");
  write_file(
      folder / "model.csv",
      "mimbre: 1\ninclude: [part.csv]\nbodies: {bob: {mass: 2, com: [1, 0, 0], inertia: [0.1, 0.1, "
      "0.1]}}\nloads: {pull: {on: bob, at: [1, 0, 0], force: [1, 0, 0]}}\nsimulation: {step: 0.01, end: "
      "0.1}\n");
  write_file(folder / "free.yaml", pendulum);
  write_file(folder / "motion.csv", "time,hinge\n0,0\n0.5,0.1\n1,0\n");
  write_file(folder / "step.c", pendulum);
  write_file(folder / "bar.yaml", R"(mimbre: 1
materials: {s: {young: 2.1e11, poisson: 0.3, density: 7850}}
sections: {q: {type: rectangle, width: 0.02, height: 0.01}}
bodies:
  beam:
    frame: {at: [0, 0, 0]}
    flexible:
      material: s
      section: q
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {all: {from: root, to: tip, elements: 2}}
      clamped: [root]
      dynamic_modes: 1
joints: {base: {type: fixed, between: [ground, beam], at: [0, 0, 0]}}
outputs: [{name: loads, section_force: beam}]
simulation: {step: 0.01, end: 0.02}
)");
  ASSERT_EQ(run({"run", "bar.yaml", "-q", "-o", "bar.h5"}).code, 0);
  std::map<std::string, std::string> before;
  for (const char* name : {"part.csv", "model.csv", "free.yaml", "motion.csv", "step.c", "bar.h5"})
    before[name] = read_file(folder / name);
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"fmu", "model.csv", "-o", "model.csv"},
        {"fmu", "model.csv", "-o", "part.csv"},
        {"generate", "step.c", "-o", "."},
        {"kinematics", "model.csv", "-o", "model.csv"},
        {"kinematics", "model.csv", "-o", "part.csv"},
        {"inverse-dynamics", "free.yaml", "--motion", "motion.csv", "-o", "motion.csv"},
        {"inverse-dynamics", "model.csv", "-o", "part.csv"},
        {"static", "model.csv", "--path", "-o", "part.csv"},
        {"stress", "bar.h5", "--loads", "bar.h5"},
        {"stress", "bar.h5", "--envelopes", "bar.h5"},
        {"stress", "bar.h5", "--loads", "new.csv", "--envelopes", "./new.csv"},
        {"page", "free.yaml", "--solver", "motion.csv", "-o", "motion.csv"}}) {
    const Outcome outcome = run(command);
    EXPECT_EQ(outcome.code, 2) << command[0] << ' ' << command.back() << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("would be overwritten")) << command[0];
  }
  for (const auto& [name, text] : before) EXPECT_TRUE(read_file(folder / name) == text) << name;
}

}  // namespace
}  // namespace mimbre::app_test::outputs_test

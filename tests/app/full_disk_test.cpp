#include <gmock/gmock.h>

#include "app/program.h"

namespace mimbre::app_test {
namespace {

using ::testing::HasSubstr;

/// Commands whose outputs find no room: a limit on the size of files stands for a full disk, which fails in
/// the same calls.
class FullDisk : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    ASSERT_EQ(run(reduction("arm.h5")).signal, 0);
    ASSERT_TRUE(fs::exists(folder / "arm.h5"));
    write_file(folder / "swing.yaml", R"(mimbre: 1
bodies:
  arm: {reduced: arm.h5, frame: {at: [0, 0, 0]}}
joints:
  hinge: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0]}
outputs:
  - {name: angle, joint: hinge}
simulation: {step: 0.001, end: 0.02}
)");
    ASSERT_EQ(run({"run", "swing.yaml", "-o", "swing.h5", "-q"}).code, 0);
  }

  static std::vector<std::string> reduction(const std::string& output) {
    return {"reduce",      MIMBRE_SOURCE_DIR "/tests/data/gmsh/block-22.msh",
            "--material",  "2.1e11,0.3,7850",
            "--interface", "left=group:left",
            "--modes",     "2",
            "--no-cache",  "-o",
            output};
  }

  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file()) result.push_back(entry.path().filename().string());
    std::sort(result.begin(), result.end());
    return result;
  }

  /// The command has one message and code 3, an older file of its output stands, and nothing else is left.
  void leaves_all_as_it_was(const std::vector<std::string>& command, const std::string& output) {
    for (const rlim_t room : {300, 2000}) {
      fs::remove(folder / output);
      for (const bool older : {false, true}) {
        SCOPED_TRACE(command[0] + (older ? " over an older file, " : ", ") + std::to_string(room) + " bytes");
        if (older) write_file(folder / output, "older");
        const auto before = names();
        const Outcome outcome = run(command, [room] {
          const rlimit limit{room, room};
          setrlimit(RLIMIT_FSIZE, &limit);
        });
        EXPECT_EQ(outcome.code, 3);
        EXPECT_EQ(outcome.signal, 0);
        EXPECT_THAT(outcome.err, HasSubstr("mimbre: error: cannot "));
        EXPECT_THAT(outcome.err, HasSubstr("File too large\n"));
        EXPECT_THAT(outcome.err, Not(HasSubstr("HDF5")));
        EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
        EXPECT_EQ(names(), before);
        if (older) {
          EXPECT_EQ(read_file(folder / output), "older");
        }
      }
    }
  }
};

TEST_F(FullDisk, ResultsAreAllOrNothingBeforeTheFirstRow) {
  leaves_all_as_it_was({"run", "swing.yaml", "-o", "out.h5", "-q"}, "out.h5");
}

TEST_F(FullDisk, BodiesAreAllOrNothing) {
  leaves_all_as_it_was(reduction("out.h5"), "out.h5");
  leaves_all_as_it_was({"select", "swing.yaml", "--body", "arm", "--error", "50", "-o", "out.h5"}, "out.h5");
  for (const std::string format : {"fem", "sid"})
    leaves_all_as_it_was({"convert", "arm.h5", "--to", format, "-o", "out." + format}, "out." + format);
  ASSERT_EQ(run({"convert", "arm.h5", "--to", "fem", "-o", "arm.fem"}).code, 0);
  leaves_all_as_it_was({"convert", "arm.fem", "--to", "h5", "-o", "out.h5"}, "out.h5");
}

TEST_F(FullDisk, TablesWithoutARowAreNotKept) {
  leaves_all_as_it_was({"run", "swing.yaml", "--until", "0.2", "--csv", "out.csv", "-q"}, "out.csv");
}

TEST_F(FullDisk, PagesAreAllOrNothing) {
  leaves_all_as_it_was({"report", "swing.h5", "-o", "out.html"}, "out.html");
  leaves_all_as_it_was({"report", "swing.h5", "swing.h5", "-o", "out.html"}, "out.html");
  leaves_all_as_it_was({"report", "arm.h5", "-o", "out.html"}, "out.html");
}

}  // namespace
}  // namespace mimbre::app_test

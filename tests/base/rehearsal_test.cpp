#include "base/rehearsal.h"

#include <gmock/gmock.h>
#include <pthread.h>
#include <signal.h>
#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>
#include <vector>

#include "mimbre/diagnostics.h"
#include "mimbre/isolation.h"
#include "mimbre/surface_mesh.h"

namespace mimbre::rehearsal_test {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

/// With programs that rehearse as told: shell scripts.
class Rehearsal : public testing::Test {
 protected:
  ~Rehearsal() override {
    isolate_reading(MIMBRE_PROGRAM);
    fs::remove_all(folder);
  }
  std::string script(const std::string& text) {
    fs::create_directories(folder);
    const fs::path path = folder / "program";
    std::ofstream(path) << "#!/bin/sh\n" << text << "\n";
    chmod(path.c_str(), 0700);
    return path.string();
  }
  /// "read there", "read here", or why it was refused.
  std::string outcome(const std::string& program, RehearsalBounds bounds = {1e9, 5, 20}) {
    isolate_reading(program);
    try {
      return rehearse("body", "some file.h5", bounds) ? "read there" : "read here";
    } catch (const InputError& error) {
      return error.what();
    }
  }

  const fs::path folder = fs::path(testing::TempDir()) / ("rehearsal-" + std::to_string(getpid()));
  const std::string greet = "printf 'mimbre rehearsal 1\\n'; ";
};

TEST_F(Rehearsal, LetsPassWhatComesToItsEnd) {
  EXPECT_EQ(outcome(script(greet + "printf d")), "read there");
  EXPECT_EQ(outcome(script(greet + "printf o")), "read there") << "the caller throws it again";
  EXPECT_EQ(
      outcome(script("test \"$1 $2 $3\" = '--rehearse-reading body some file.h5' && " + greet + "printf d")),
      "read there");
}

TEST_F(Rehearsal, IsLeftOutWhereThereIsNoneToBeHad) {
  EXPECT_EQ(outcome(""), "read here");
  EXPECT_EQ(outcome("/no/such/program"), "read here");
  EXPECT_EQ(outcome(MIMBRE_SOURCE_DIR "/CMakeLists.txt"), "read here");
  EXPECT_EQ(outcome("/bin/true"), "read here");
  EXPECT_EQ(outcome("/bin/echo"), "read here");
  EXPECT_EQ(outcome(script("kill -SEGV $$")), "read here") << "it did not begin";
}

TEST_F(Rehearsal, HandsOnWhatIsRefused) {
  isolate_reading(script(greet + "printf 'ra.h5\\0003\\0007\\000wrong\\000\\0000\\0000\\000bad\\ntoo\\000'"));
  try {
    rehearse("body", "some file.h5");
    FAIL() << "nothing thrown";
  } catch (const InputError& error) {
    ASSERT_EQ(error.diagnostics().size(), 2u);
    EXPECT_EQ(error.diagnostics()[0].mark.file, "a.h5");
    EXPECT_EQ(error.diagnostics()[0].mark.line, 3);
    EXPECT_EQ(error.diagnostics()[0].mark.column, 7);
    EXPECT_EQ(error.diagnostics()[1].message, "bad\ntoo");
  }
}

TEST_F(Rehearsal, RefusesWhatCrashesOrTakesAllMemory) {
  const char* const damaged = "some file.h5: is damaged: it cannot be read to its end";
  EXPECT_THAT(outcome(script(greet + "kill -SEGV $$")), HasSubstr(damaged));
  EXPECT_THAT(outcome(script(greet + "exit 1")), HasSubstr(damaged)) << "as under a sanitizer";
  EXPECT_THAT(outcome(script(greet + "printf m")), HasSubstr("needs more memory"));
}

TEST_F(Rehearsal, SaysWhenTheTimeWasOver) {
  const auto begin = std::chrono::steady_clock::now();
  const std::string waited = outcome(script(greet + "sleep 60"), {1e9, 0.05, 0.3});
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  EXPECT_THAT(waited, HasSubstr("some file.h5: time-out: "));
  EXPECT_THAT(waited, Not(HasSubstr("damaged")));
  EXPECT_THAT(outcome(script(greet + "kill -XCPU $$")),
              HasSubstr("time-out: reading it takes more than 5 s"));
}

std::atomic<int> forks{0};

/// A host may have threads, locks that they hold, and handlers of its own.
TEST_F(Rehearsal, ForksNothingAndLeavesSignalsAlone) {
  pthread_atfork([] { ++forks; }, nullptr, nullptr);
  struct sigaction before {
  }, after{};
  sigaction(SIGCHLD, nullptr, &before);
  std::vector<std::thread> threads;
  std::atomic<bool> over{false};
  std::mutex mutex;
  for (int k = 0; k < 3; ++k)
    threads.emplace_back([&] {
      while (!over) {
        const std::lock_guard lock(mutex);
        std::vector<char> memory(100'000);
      }
    });
  for (int k = 0; k < 20; ++k) EXPECT_EQ(outcome(script(greet + "printf d")), "read there");
  over = true;
  for (std::thread& thread : threads) thread.join();
  sigaction(SIGCHLD, nullptr, &after);
  EXPECT_EQ(before.sa_handler, after.sa_handler);
  EXPECT_EQ(forks, 0);
}

TEST_F(Rehearsal, ReadsTheSameFileHereAndThere) {
  const std::string path = MIMBRE_SOURCE_DIR "/tests/data/surfaces/block.obj";
  isolate_reading("");
  const SurfaceMesh here = read_surface_mesh(path);
  isolate_reading(MIMBRE_PROGRAM);
  const SurfaceMesh there = read_surface_mesh(path);
  EXPECT_EQ(here.vertices, there.vertices);
  EXPECT_EQ(here.triangles, there.triangles);
}

}  // namespace
}  // namespace mimbre::rehearsal_test

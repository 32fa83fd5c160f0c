#include "base/output_place.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

namespace mimbre::output_place_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

class OutputPlaceTest : public testing::Test {
 protected:
  OutputPlaceTest() {
    std::string name = (fs::temp_directory_path() / "mimbre-place-XXXXXX").string();
    if (mkdtemp(name.data())) folder = name;
  }
  ~OutputPlaceTest() override {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  std::string at(const std::string& name) const { return (folder / name).string(); }
  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const auto& entry : fs::directory_iterator(folder))
      result.push_back(entry.path().filename().string());
    std::sort(result.begin(), result.end());
    return result;
  }
  fs::path folder;
};

void put(const std::string& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

std::string get(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

template <class Work>
std::string error_of(Work&& work) {
  try {
    work();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

TEST_F(OutputPlaceTest, TheOlderFileStandsUntilTheNewOneIsCommitted) {
  put(at("a.txt"), "old");
  {
    OutputPlace place(at("a.txt"));
    put(place.path(), "given up");
    EXPECT_EQ(get(at("a.txt")), "old");
  }
  EXPECT_THAT(names(), ElementsAre("a.txt"));
  OutputPlace place(at("a.txt"));
  put(place.path(), "new");
  EXPECT_EQ(get(at("a.txt")), "old");
  place.commit();
  EXPECT_EQ(get(at("a.txt")), "new");
  EXPECT_THAT(names(), ElementsAre("a.txt"));
}

TEST_F(OutputPlaceTest, WhatIsKeptIsBesideTheOlderFileOrInItsPlace) {
  {
    OutputPlace place(at("a.txt"));
    put(place.path(), "part");
    EXPECT_EQ(place.keep(), at("a.txt"));
  }
  EXPECT_EQ(get(at("a.txt")), "part");
  std::string kept;
  {
    OutputPlace place(at("a.txt"));
    put(place.path(), "other");
    kept = place.keep();
  }
  EXPECT_EQ(get(at("a.txt")), "part");
  EXPECT_EQ(get(kept), "other");
  EXPECT_TRUE(kept.ends_with(".txt"));
}

TEST_F(OutputPlaceTest, LinksAreFollowedAndModesKept) {
  fs::create_directory(at("far"));
  put(at("far/real.txt"), "old");
  chmod(at("far/real.txt").c_str(), 0640);
  fs::create_symlink("far/real.txt", at("link.txt"));
  fs::create_symlink("far/new.txt", at("dangling.txt"));
  write_whole(at("link.txt"), "new");
  write_whole(at("dangling.txt"), "fresh");
  EXPECT_TRUE(fs::is_symlink(at("link.txt")));
  EXPECT_EQ(get(at("far/real.txt")), "new");
  EXPECT_EQ(get(at("far/new.txt")), "fresh");
  EXPECT_EQ(static_cast<int>(fs::status(at("far/real.txt")).permissions()), 0640);
  fs::create_symlink("loop.txt", at("loop.txt"));
  EXPECT_THAT(error_of([&] { write_whole(at("loop.txt"), "x"); }), HasSubstr("symbolic links"));
}

TEST_F(OutputPlaceTest, DevicesAreWrittenStraight) {
  fs::create_symlink("/dev/null", at("null"));
  write_whole(at("null"), "nothing");
  write_whole("/dev/null", "nothing");
  EXPECT_TRUE(fs::is_symlink(at("null")));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_FALSE(OutputPlace("/dev/null").plain());
  EXPECT_THAT(names(), ElementsAre("null"));
  EXPECT_THAT(error_of([] { write_whole("/dev/full", "something"); }), HasSubstr("No space left"));
}

TEST_F(OutputPlaceTest, NothingThatIsThereIsTakenForTheTemporaryFile) {
  put(at("victim"), "safe");
  const std::string own = fs::path(at("a.part-")).string() + std::to_string(getpid()) + ".txt";
  fs::create_symlink("victim", own);
  write_whole(at("a.txt"), "new");
  EXPECT_EQ(get(at("victim")), "safe");
  EXPECT_TRUE(fs::is_symlink(own));
}

TEST_F(OutputPlaceTest, TheSecondWriterIsTold) {
  put(at("a.txt"), "old");
  OutputPlace first(at("a.txt"));
  EXPECT_EQ(error_of([&] { OutputPlace second(at("a.txt")); }), "another program is writing it");
  put(first.path(), "first");
  first.commit();
  EXPECT_EQ(get(at("a.txt")), "first");
}

TEST_F(OutputPlaceTest, WhoFindsAnotherFileAtItsEndKeepsItsOwnBesideIt) {
  OutputPlace slow(at("a.txt")), growing(at("b.txt"));
  growing.show();
  put(slow.path(), "slow");
  write_whole(at("a.txt"), "quick");
  const std::string message = error_of([&] { slow.commit(); });
  EXPECT_THAT(message,
              HasSubstr("another program has written it meanwhile; this one's is kept in '" + slow.path()));
  EXPECT_EQ(get(at("a.txt")), "quick");
  EXPECT_EQ(get(slow.path()), "slow");
  EXPECT_EQ(growing.path(), at("b.txt"));
  fs::remove(at("b.txt"));
  put(at("b.txt"), "other");
  EXPECT_THAT(error_of([&] { growing.commit(); }), HasSubstr("removed or replaced"));
  EXPECT_EQ(get(at("b.txt")), "other");
}

TEST_F(OutputPlaceTest, AGrowingFileIsShownWhereNothingStands) {
  put(at("a.txt"), "old");
  OutputPlace beside(at("a.txt")), growing(at("b.txt")), late(at("b.txt"));
  beside.write("half");
  beside.show();
  EXPECT_EQ(get(at("a.txt")), "old");
  growing.write("half");
  EXPECT_FALSE(fs::exists(at("b.txt")));
  growing.show();
  EXPECT_EQ(growing.path(), at("b.txt"));
  EXPECT_EQ(get(at("b.txt")), "half");
  EXPECT_EQ(error_of([&] { late.show(); }), "another program is writing it");
  EXPECT_EQ(error_of([&] { OutputPlace second(at("b.txt")); }), "another program is writing it");
  growing.commit();
  EXPECT_EQ(get(at("b.txt")), "half");
}

TEST_F(OutputPlaceTest, OfManyRacingWritersOneWinsWhole) {
  put(at("a.txt"), "old");
  for (int round = 0; round < 20; ++round) {
    std::vector<std::string> errors(4);
    {
      std::vector<std::jthread> writers;
      for (std::size_t k = 0; k < errors.size(); ++k)
        writers.emplace_back([&, k] {
          errors[k] =
              error_of([&] { write_whole(at("a.txt"), std::string(100'000, static_cast<char>('0' + k))); });
        });
    }
    const std::string text = get(at("a.txt"));
    ASSERT_EQ(text, std::string(100'000, text[0]));
    EXPECT_EQ(errors[static_cast<std::size_t>(text[0] - '0')], "no error");
  }
}

/// Whether something stood at the target when it was begun or not, whatever modes files get here: what killed
/// writers left is told from what was kept, and the files have the modes of any others.
TEST_F(OutputPlaceTest, PartsOfKilledWritersAreToldFromKeptOnes) {
  for (const mode_t hidden : {mode_t{022}, mode_t{077}, mode_t{0}})
    for (const bool older : {false, true}) {
      SCOPED_TRACE(std::to_string(hidden) + (older ? " over an older file" : ""));
      const mode_t before = umask(hidden);
      const std::string target = at("a.csv");
      if (older) put(target, "older");
      const auto end_in_another_process = [&](bool killed) {
        const pid_t child = fork();
        if (child == 0) {
          OutputPlace place(target);
          place.write("part");
          if (!killed) {
            if (!older) put(target, "of another");
            place.keep();
          }
          _exit(0);
        }
        waitpid(child, nullptr, 0);
        return at("a.part-" + std::to_string(child) + ".csv");
      };
      const std::string left = end_in_another_process(true), kept = end_in_another_process(false);
      ASSERT_TRUE(fs::exists(left) && fs::exists(kept));
      write_whole(target, "whole");
      EXPECT_FALSE(is_kept(left, target));
      EXPECT_TRUE(is_kept(kept, target));
      remove_abandoned_parts(target, [&](const std::string& part) { return !is_kept(part, target); });
      EXPECT_FALSE(fs::exists(left));
      EXPECT_TRUE(fs::exists(kept));
      for (const std::string& file : {target, kept})
        EXPECT_EQ(static_cast<mode_t>(fs::status(file).permissions()), 0666 & ~hidden) << file;
      fs::remove(target);
      {
        OutputPlace shown(target);
        shown.show();
        EXPECT_EQ(static_cast<mode_t>(fs::status(target).permissions()), 0666 & ~hidden);
      }
      fs::remove(kept);
      EXPECT_THAT(names(), ElementsAre());
      umask(before);
    }
}

TEST_F(OutputPlaceTest, AVanishedFolderIsAnError) {
  fs::create_directory(at("far"));
  OutputPlace place(at("far/a.txt"));
  fs::remove_all(at("far"));
  EXPECT_THAT(error_of([&] { place.commit(); }), HasSubstr("No such file or directory"));
  EXPECT_EQ(error_of([&] { write_whole(at("far/a.txt"), ""); }), "No such file or directory");
  EXPECT_EQ(error_of([&] { write_whole(folder.string(), ""); }), "Is a directory");
}

}  // namespace
}  // namespace mimbre::output_place_test

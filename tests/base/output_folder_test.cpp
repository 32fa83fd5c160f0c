#include "base/output_folder.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>

namespace mimbre::output_folder_test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

class OutputFolderTest : public testing::Test {
 protected:
  OutputFolderTest() {
    std::string name = (fs::temp_directory_path() / "mimbre-folder-XXXXXX").string();
    if (mkdtemp(name.data())) folder = name;
  }
  ~OutputFolderTest() override {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  std::string at(const std::string& name) const { return (folder / name).string(); }

  /// Of all files, by their paths.
  std::map<std::string, std::string> files() const {
    std::map<std::string, std::string> result;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file()) continue;
      std::ifstream file(entry.path());
      result[entry.path().lexically_relative(folder).string()] = {std::istreambuf_iterator<char>(file), {}};
    }
    return result;
  }
  fs::path folder;
};

void put(const std::string& path, const std::string& text) { std::ofstream(path) << text; }
bool is_frame(const std::string& name) { return name.ends_with(".frame"); }

template <class Work>
std::string error_of(Work&& work) {
  try {
    work();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

TEST_F(OutputFolderTest, IsMadeWithThoseAboveIt) {
  OutputFolder made(at("a/b/c/"), is_frame);
  put(made.path() + "/0.frame", "new");
  EXPECT_FALSE(fs::exists(at("a/b/c")));
  made.commit();
  EXPECT_THAT(files(), ElementsAre(Pair("a/b/c/0.frame", "new")));
}

TEST_F(OutputFolderTest, ReplacesWhatItOwnsAndKeepsTheRest) {
  fs::create_directory(at("a"));
  put(at("a/0.frame"), "old");
  put(at("a/1.frame"), "old");
  put(at("a/notes"), "mine");
  const auto before = files();
  {
    OutputFolder given_up(at("a"), is_frame);
    put(given_up.path() + "/0.frame", "half");
  }
  EXPECT_EQ(files(), before);
  {
    OutputFolder made(at("a"), is_frame);
    put(made.path() + "/0.frame", "new");
    put(at("a/later"), "mine, too");
    made.commit();
  }
  EXPECT_THAT(files(),
              ElementsAre(Pair("a/0.frame", "new"), Pair("a/later", "mine, too"), Pair("a/notes", "mine")));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);
}

TEST_F(OutputFolderTest, RefusesToTakeFoldersAway) {
  fs::create_directories(at("a/precious"));
  EXPECT_THAT(error_of([&] { OutputFolder(at("a"), is_frame); }),
              HasSubstr("it holds the folder 'precious'"));
  put(at("file"), "x");
  EXPECT_EQ(error_of([&] { OutputFolder(at("file"), is_frame); }), "it is a file");
  const fs::path here = fs::current_path();
  fs::create_directory(at("b"));
  fs::current_path(at("b"));
  EXPECT_THAT(error_of([&] { OutputFolder(".", is_frame); }), HasSubstr("the working folder lies in it"));
  fs::current_path(here);
  EXPECT_TRUE(fs::exists(at("a/precious")));
}

/// A program that was killed leaves its folder; one that still writes is not disturbed.
TEST_F(OutputFolderTest, ClearsWhatKilledProgramsLeft) {
  const pid_t child = fork();
  if (child == 0) {
    OutputFolder left(at("a"), is_frame);
    put(left.path() + "/0.frame", "left over");
    _exit(0);
  }
  waitpid(child, nullptr, 0);
  EXPECT_EQ(files().size(), 1u);
  OutputFolder first(at("a"), is_frame);
  put(first.path() + "/0.frame", "first");
  EXPECT_THAT(files(), ElementsAre(Pair(testing::_, "first")));
  fs::create_directory(at("a.part-1x"));  // not of ours
  const pid_t other = fork();
  if (other == 0) {
    OutputFolder second(at("a"), is_frame);
    put(second.path() + "/0.frame", "second");
    second.commit();
    _exit(0);
  }
  waitpid(other, nullptr, 0);
  EXPECT_TRUE(fs::exists(first.path()));
  EXPECT_TRUE(fs::exists(at("a.part-1x")));
  EXPECT_EQ(error_of([&] { first.commit(); }), "another program has made it meanwhile");
  EXPECT_EQ(files().at("a/0.frame"), "second");
}

}  // namespace
}  // namespace mimbre::output_folder_test

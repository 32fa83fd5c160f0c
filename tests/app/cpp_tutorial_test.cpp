#include <gmock/gmock.h>

#include <cstdio>

#include "app/program.h"
#include "mimbre/model_builder.h"
#include "support/text.h"

/// docs/cpp.md quotes the program to the letter, and it prints what is shown.
namespace mimbre::app_test::cpp_tutorial_test {
namespace {

const fs::path source = MIMBRE_SOURCE_DIR;

/// Lines that say something.
std::string without_empty_lines(const std::string& text) { return test::replaced(text, "\n+", "\n"); }

TEST(CppTutorial, QuotesAProgramThatPrintsWhatItShows) {
  const std::string page = read_file(source / "docs/cpp.md");
  std::string quoted;
  for (const auto& block : test::matches(page, "```cpp\n([^`]*)```")) quoted += block[1];
  EXPECT_EQ(without_empty_lines(quoted),
            without_empty_lines(read_file(source / "examples/cpp/four_bar.cpp")));

  FILE* const program = popen(MIMBRE_CPP_EXAMPLE, "r");
  ASSERT_NE(program, nullptr);
  std::string printed;
  for (int c = std::fgetc(program); c != EOF; c = std::fgetc(program)) printed += static_cast<char>(c);
  EXPECT_EQ(pclose(program), 0);
  EXPECT_THAT(page, testing::HasSubstr("It prints\n\n```\n" + printed + "```\n"));
}

TEST(CppTutorial, ShowsTheMessagesOfMistakes) {
  const std::string page = read_file(source / "docs/cpp.md");
  const auto expect_shown = [&](const auto& call) {
    try {
      call();
      ADD_FAILURE() << "no error";
    } catch (const InputError& error) {
      EXPECT_THAT(page, testing::HasSubstr(std::string("```\n") + error.what() + "\n```"));
    }
  };
  ModelBuilder m;
  for (const char* body : {"crank", "coupler", "rocker"})
    m.add_body(body, {.mass = 1, .inertia = build::inertia(1, 1, 1)});
  const Eigen::Vector3d at = Eigen::Vector3d::Zero(), y = Eigen::Vector3d::UnitY();
  using spec::JointType;
  expect_shown([&] {
    m.add_joint("motor", {.type = JointType::revolute, .between = {"ground", "crnk"}, .at = at, .axis = y});
  });
  ModelBuilder wrong;
  wrong.add_body("crank", {.mass = 1, .inertia = build::inertia(0.002, 0.02, 0.0001)});
  wrong.add_joint(
      "pivot",
      {.type = JointType::spherical, .between = {"ground", "crank"}, .at = at, .position = {0.0, 1.0}});
  expect_shown([&] { wrong.compile(); });
}

}  // namespace
}  // namespace mimbre::app_test::cpp_tutorial_test

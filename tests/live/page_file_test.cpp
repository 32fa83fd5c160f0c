#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "mimbre/model_file.h"
#include "mimbre/page.h"

namespace mimbre::test::page_file_test {

using testing::HasSubstr;
using testing::Not;

class PageFile : public testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = std::filesystem::path(testing::TempDir()) / ("page_file_" + name);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string file(const std::string& name, const std::string& bytes) const {
    const std::filesystem::path path = folder_ / name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path.string();
  }
  static std::string read(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  /// A hinge, with a title that would end an element of the page.
  static std::shared_ptr<const Model> model() {
    return Model::compile(parse_model(R"(
mimbre: 1
title: "swing </script><b>"
bodies:
  bar: {mass: 0.6, com: [0.5, 0, 0], inertia: [1e-5, 0.05, 0.05]}
joints:
  hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}
inputs: {push: 0}
outputs:
  - {name: angle, joint: hinge}
simulation: {step: 0.01, end: 1}
)",
                                      "hinge.yaml", ""));
  }

  std::filesystem::path folder_;
};

TEST_F(PageFile, HasTheSceneTheSolverAndTheModel) {
  std::string html;
  try {
    html = page_html(model(), file("solver.wasm", std::string("\0asm\1\0\0\0", 8)));
  } catch (const std::runtime_error& error) {
    if (std::string(error.what()).find("without its pages") != std::string::npos)
      GTEST_SKIP() << "built without npm";
    throw;
  }
  const std::size_t data = html.find("id=\"data\">");
  ASSERT_NE(data, std::string::npos);
  const std::string rest = html.substr(data, html.find("</script>", data) - data);
  for (const char* part : {R"("scene":)", R"("wasm":"H4sI)", R"("model":"H4sI)", R"("name":"push")"})
    EXPECT_THAT(rest, HasSubstr(part));
  EXPECT_THAT(rest, HasSubstr("swing \\u003c/script>"));
  EXPECT_THAT(html, Not(HasSubstr("%MIMBRE_DATA%")));
}

TEST_F(PageFile, RefusesAFileThatIsNoSolver) {
  const auto message = [&](const std::string& wasm) -> std::string {
    try {
      page_html(model(), wasm);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  if (message("").find("without its pages") != std::string::npos) GTEST_SKIP() << "built without npm";
  EXPECT_THAT(message(file("text.wasm", "hello")), HasSubstr("text.wasm' is not WebAssembly"));
  EXPECT_THAT(message((folder_ / "none.wasm").string()), HasSubstr("cannot read"));
  if (!has_page_solver()) {
    EXPECT_THAT(message(""), HasSubstr("`make page`"));
  }
}

TEST_F(PageFile, AnOlderPageStaysWhereNoneIsMade) {
  const std::string path = file("page.html", "older");
  EXPECT_THROW(write_page(model(), path, file("text.wasm", "hello")), std::runtime_error);
  EXPECT_EQ(read(path), "older");
}

}  // namespace mimbre::test::page_file_test

#include "app/output_schema.h"

/// What the commands answer with --json is what schema/output.schema.json says.
namespace mimbre::app_test::json_output_test {
namespace {

class JsonOutput : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file(folder / "pendulum.yaml", pendulum);
  }

  /// The answer, checked; its command and the exit code are as expected.
  test::Json answer(const std::vector<std::string>& arguments, int code = 0,
                    const std::string& status = "ok") {
    std::vector<std::string> all = arguments;
    all.push_back("--json");
    const Outcome outcome = run(all);
    EXPECT_EQ(outcome.code, code) << arguments[0] << ": " << outcome.err;
    SCOPED_TRACE(arguments[0]);
    expect_schema(outcome.out);
    const test::Json json = outcome.json();
    EXPECT_EQ(json.at("command"), arguments[0]);
    EXPECT_EQ(json.at("status"), status);
    return json;
  }
  static std::string source(const std::string& path) { return (fs::path(MIMBRE_SOURCE_DIR) / path).string(); }
};

TEST_F(JsonOutput, OfARunAndOfWhatReadsItKeepsTheSchema) {
  const test::Json run_of = answer({"run", "pendulum.yaml", "-o", "a.h5", "--until", "0.2"});
  EXPECT_EQ(run_of.at("units").at("angle"), "rad");
  EXPECT_EQ(run_of.at("units").keys(), run_of.at("outputs").keys());
  answer({"run", "pendulum.yaml", "-o", "b.h5", "--until", "0.2", "--integrator", "newmark"});
  answer({"compare", "a.h5", "b.h5"});
  answer({"bench", "pendulum.yaml", "--runs", "1"});
  EXPECT_EQ(answer({"report", "a.h5"}).at("output"), "a.html");
  EXPECT_EQ(answer({"export", "a.h5", "--vtk", "frames"}).at("output"), "frames/run.pvd");
}

TEST_F(JsonOutput, OfModelsKeepsTheSchema) {
  const test::Json check = answer({"check", source("examples/tutorial/four-bar.yaml")});
  EXPECT_EQ(check.at("bodies").size(), 3u);
  EXPECT_EQ(check.at("joints").size(), 4u);
  const test::Json rest = answer({"static", "pendulum.yaml"});
  EXPECT_EQ(rest.at("units").keys(), rest.at("outputs").keys());
  answer({"run", source("examples/tutorial/flexible.yaml"), "--until", "0.1"});
  answer({"verify", "pendulum.yaml", "--until", "0.1"});
  answer({"verify", "pendulum.yaml", "--until", "0.1", "--no-refine"});
  answer({"reproduce", "--list"});
}

/// A body of two modes only, whose certificate has a NO: that is no success.
TEST_F(JsonOutput, OfFiniteElementsKeepsTheSchema) {
  const test::Json summary =
      answer({"reduce", source("tests/data/gmsh/block-22.msh"), "--material", "2.1e11,0.3,7850",
              "--interface", "left=group:left", "--modes", "2", "--no-cache", "-o", "block.h5"},
             4);
  EXPECT_FALSE(summary.at("passed").boolean());
  EXPECT_EQ(answer({"convert", "block.h5", "--to", "fem"}).at("output"), "block.fem");
}

TEST_F(JsonOutput, OfFailuresKeepsTheSchema) {
  answer({"check", "no-such.yaml"}, 1, "error");
  answer({"compare", "a.h5", "no-such.h5"}, 1, "error");
  write_file(folder / "bad.yaml", "mimbre: 1\nbodies: {arm: {mass: -1, com: [0, 0], inertia: [1, 1, 1]}}\n");
  const test::Json errors = answer({"run", "bad.yaml"}, 1, "error").at("errors");
  EXPECT_EQ(errors.size(), 2u);
  EXPECT_EQ(errors[0].at("line"), 2);
}

/// The first line is the address of the page.
TEST_F(JsonOutput, AgainstTheClockKeepsTheSchema) {
  const Outcome live = run({"live", "pendulum.yaml", "--duration", "0.1", "--no-open", "--no-lock", "--idle",
                            "0.05", "--udp", "0", "--record", "live.h5", "--json"});
  EXPECT_EQ(live.code, 0) << live.err;
  const std::size_t line = live.out.find('\n');
  EXPECT_THAT(live.out.substr(0, line), testing::StartsWith("http://127.0.0.1:"));
  expect_schema(live.out.substr(line + 1));
  EXPECT_TRUE(fs::exists(folder / "live.h5"));
  const test::Json plan = answer(
      {"plan", "pendulum.yaml", "--deadline", "20ms", "--load", "100", "--watch", "0.2", "--until", "0.2"});
  EXPECT_EQ(plan.at("options")[0], "--formulation");
}

/// They answer before any file is read.
TEST_F(JsonOutput, OfWrongUseKeepsTheSchema) {
  for (const char* command :
       {"run", "check", "static", "report", "compare", "bench", "verify", "reduce", "select", "terms",
        "convert", "stress", "export", "generate", "fmu", "page", "live", "plan"}) {
    answer({command}, 2, "error");
    answer({command, "--no-such-option"}, 2, "error");
  }
  answer({"compare", "a.h5"}, 2, "error");
  answer({"reproduce", "--no-such-option"}, 2, "error");
  const Outcome unknown = run({"chekc", "a.yaml", "--json"});
  expect_schema(unknown.out);
  EXPECT_EQ(unknown.json().at("status"), "error");
}

/// A name like that of a key, and one that no text should have.
TEST_F(JsonOutput, NamesCannotHideKeys) {
  std::string text = pendulum;
  text.replace(text.find("name: angle"), 11, "name: status");
  write_file(folder / "status.yaml", text);
  const test::Json rest = answer({"static", "status.yaml"});
  EXPECT_NEAR(rest.at("outputs").at("status").number(), 1.5707963, 1e-6);
}

}  // namespace
}  // namespace mimbre::app_test::json_output_test

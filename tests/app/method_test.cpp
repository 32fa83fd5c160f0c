#include <gmock/gmock.h>

#include "app/program.h"
#include "mimbre/results.h"

/// The options that choose the method, and what is said about it.
namespace mimbre::app_test::method_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Arguments = std::vector<std::string>;

class Method : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    write_file(folder / "pendulum.yaml", pendulum);
    std::string damped = pendulum;
    damped.insert(damped.find("step: 0.01"), "integrator: {type: hht, rho: 0.8}, ");
    write_file(folder / "hht.yaml", damped);
  }

  test::Json summary(const char* model, Arguments options) const {
    options.insert(options.begin(), {"run", model, "--until", "0.1", "--json"});
    const Outcome outcome = run(options);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.json();
  }
};

TEST_F(Method, TheSummarySaysWhatIsInForce) {
  const auto preset = summary("pendulum.yaml", {});
  EXPECT_EQ(preset.at("formulation"), "relative");
  EXPECT_EQ(preset.at("inertia"), "integrals");
  EXPECT_EQ(preset.at("formalism"), "index3");
  EXPECT_EQ(preset.at("integrator"), "generalized_alpha");
  EXPECT_EQ(preset.at("rho"), 0.4);
  EXPECT_FALSE(preset.contains("xi"));
  const auto chosen = summary("pendulum.yaml", {"--inertia", "projection", "--integrator", "newmark"});
  EXPECT_EQ(chosen.at("inertia"), "projection");
  EXPECT_EQ(chosen.at("integrator"), "newmark");
  EXPECT_EQ(chosen.at("xi"), 0);
  EXPECT_FALSE(chosen.contains("rho"));
}

TEST_F(Method, TheParametersChooseTheirIntegrator) {
  const auto in_force = [&](const char* model, const Arguments& options) {
    const auto json = summary(model, options);
    const std::string name = json.at("integrator");
    return std::pair(name, json.at(name == "newmark" ? "xi" : "rho").number());
  };
  EXPECT_EQ(in_force("hht.yaml", {}), std::pair(std::string("hht"), 0.8));
  EXPECT_EQ(in_force("hht.yaml", {"--rho", "0.6"}), std::pair(std::string("hht"), 0.6));
  EXPECT_EQ(in_force("hht.yaml", {"--integrator-xi", "-0.1"}), std::pair(std::string("newmark"), -0.1));
  EXPECT_EQ(in_force("hht.yaml", {"--integrator", "generalized_alpha", "--rho", "0.2"}),
            std::pair(std::string("generalized_alpha"), 0.2));
  // The least that hht can have, where nobody gave one.
  EXPECT_EQ(in_force("pendulum.yaml", {"--integrator", "hht"}), std::pair(std::string("hht"), 0.5));
}

TEST_F(Method, TheIntegratorsAreDifferentOnes) {
  const auto angle = [&](const Arguments& options) {
    return summary("pendulum.yaml", options).at("outputs").at("angle").number();
  };
  const double preset = angle({"--integrator", "generalized_alpha"});
  EXPECT_EQ(preset, angle({}));
  EXPECT_NE(preset, angle({"--integrator", "newmark"}));
  EXPECT_NE(preset, angle({"--integrator", "hht"}));
  EXPECT_NEAR(preset, angle({"--integrator", "newmark"}), 1e-3);
  EXPECT_NEAR(preset, angle({"--integrator", "hht"}), 1e-3);
}

TEST_F(Method, TheResultsKeepWhatTheCommandLineChose) {
  const Outcome outcome =
      run({"run", "pendulum.yaml", "--until", "0.1", "--formulation", "relative", "--inertia", "projection",
           "--formalism", "index3", "--integrator", "hht", "--rho", "0.7", "--output", "out.h5", "-q"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const Results results = read_results((folder / "out.h5").string());
  const auto options = test::Json::parse(results.header.options_json);
  EXPECT_EQ(options.at("formulation"), "relative");
  EXPECT_EQ(options.at("inertia"), "projection");
  EXPECT_EQ(options.at("formalism"), "index3");
  EXPECT_EQ(options.at("integrator"), "hht");
  EXPECT_EQ(options.at("rho"), 0.7);
  const auto kept = test::Json::parse(results.summary_json);
  EXPECT_EQ(kept.at("integrator"), "hht");
  EXPECT_EQ(kept.at("rho"), 0.7);
  // What it did not choose stands in the model's text.
  ASSERT_EQ(run({"run", "pendulum.yaml", "--until", "0.1", "--output", "out.h5", "-q"}).code, 0);
  EXPECT_FALSE(test::Json::parse(read_results((folder / "out.h5").string()).header.options_json)
                   .contains("formulation"));
}

TEST_F(Method, TheCommandsThatComputeTakeIt) {
  const Arguments method{"--formulation", "relative", "--inertia", "integrals"};
  const Arguments motion{"--formalism", "index3", "--integrator", "newmark", "--integrator-xi", "-0.1"};
  const auto with = [](Arguments first, const Arguments& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
  };
  const Outcome bench =
      run(with(with({"bench", "pendulum.yaml", "--runs", "1", "--until", "0.1", "--json"}, method), motion));
  ASSERT_EQ(bench.code, 0) << bench.err;
  EXPECT_EQ(bench.json().at("models")[0].at("formulation"), "relative");
  EXPECT_EQ(bench.json().at("models")[0].at("xi"), -0.1);
  EXPECT_EQ(run(with(with({"check", "pendulum.yaml"}, method), motion)).code, 0);
  const Outcome rest = run(with({"static", "pendulum.yaml", "--json"}, method));
  ASSERT_EQ(rest.code, 0) << rest.err;
  EXPECT_EQ(rest.json().at("formulation"), "relative");
  EXPECT_EQ(rest.json().at("inertia"), "integrals");
  // Formalisms and integrators make steps, which a state of rest does not need.
  EXPECT_EQ(run(with({"static", "pendulum.yaml"}, motion)).code, 2);
}

/// What the model has can be taken back, and what does not go with it is not left out silently.
TEST_F(Method, AFixedCostOfTheModelCanBeTakenBack) {
  std::string text = pendulum;
  text.insert(text.find("step: 0.01"), "fixed_cost: true, max_iterations: 8, ");
  write_file(folder / "fixed.yaml", text);
  EXPECT_EQ(summary("fixed.yaml", {}).at("resolved").at("fixed_cost"), true);
  const auto taken_back = summary("fixed.yaml", {"--no-fixed-cost", "--substeps", "3"});
  EXPECT_EQ(taken_back.at("resolved").at("fixed_cost"), false);
  EXPECT_EQ(taken_back.at("resolved").at("substeps"), 3);
  for (const auto& [words, said] :
       {std::pair(Arguments{"--substeps", "3"}, "take --no-fixed-cost, too"),
        std::pair(Arguments{"--formalism", "penalty"}, "take --no-fixed-cost, too"),
        std::pair(Arguments{"--fixed-cost", "--no-fixed-cost"}, "--fixed-cost")}) {
    Arguments all{"run", "fixed.yaml"};
    all.insert(all.end(), words.begin(), words.end());
    const Outcome outcome = run(all);
    EXPECT_EQ(outcome.code, 2) << said;
    EXPECT_THAT(outcome.err, HasSubstr(said));
  }
}

TEST_F(Method, AFixedCostCountsWhatItTakesUnconverged) {
  const auto fixed = summary("pendulum.yaml", {"--fixed-cost"});
  EXPECT_EQ(fixed.at("resolved").at("fixed_cost"), true);
  EXPECT_EQ(fixed.at("resolved").at("substeps"), 1);
  EXPECT_EQ(fixed.at("resolved").at("max_iterations"), 6);
  EXPECT_EQ(fixed.at("unconverged_steps"), 0);
  EXPECT_FALSE(summary("pendulum.yaml", {}).contains("unconverged_steps"));
  // Two iterations are not what a step of a quarter of a second needs.
  const Outcome few = run({"run", "pendulum.yaml", "--fixed-cost", "--max-iterations", "2", "--step", "0.25",
                           "--until", "5", "--json"});
  EXPECT_GT(few.json().at("unconverged_steps"), 0);
  EXPECT_THAT(run({"run", "pendulum.yaml", "--fixed-cost"}).out, HasSubstr("steps taken unconverged"));
  for (const auto& [words, said] :
       {std::pair(Arguments{"--substeps", "4"}, "--fixed-cost makes each step once; leave --substeps out"),
        std::pair(Arguments{"--formalism", "penalty"}, "--fixed-cost is of the formalism index3"),
        std::pair(Arguments{"--max-iterations", "1"}, "two iterations at least")}) {
    Arguments all{"run", "pendulum.yaml", "--fixed-cost"};
    all.insert(all.end(), words.begin(), words.end());
    const Outcome outcome = run(all);
    EXPECT_NE(outcome.code, 0);
    EXPECT_THAT(outcome.err, HasSubstr(said));
  }
}

TEST_F(Method, WrongNamesAreAnsweredWithTheRightOnes) {
  const auto error = [&](const Arguments& options) {
    Arguments all{"run", "pendulum.yaml"};
    all.insert(all.end(), options.begin(), options.end());
    const Outcome outcome = run(all);
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    return outcome.err;
  };
  EXPECT_THAT(error({"--formulation", "natral"}),
              HasSubstr("--formulation: 'natral' is not one of relative, natural (did you mean 'natural'?)"));
  EXPECT_THAT(error({"--inertia", "projektion"}), HasSubstr("did you mean 'projection'?"));
  EXPECT_THAT(error({"--formalism", "index2"}),
              HasSubstr("index3, index1, baumgarte, penalty, index1_augmented, independent, global_modes, "
                        "transfer_matrices"));
  EXPECT_THAT(error({"--integrator", "newmak"}), HasSubstr("did you mean 'newmark'?"));
  EXPECT_THAT(error({"--integrator", "newmark", "--rho", "0.5"}), HasSubstr("newmark has --integrator-xi"));
  EXPECT_THAT(error({"--integrator", "hht", "--integrator-xi", "0"}), HasSubstr("hht has --rho"));
  EXPECT_THAT(error({"--integrator", "hht", "--rho", "0.4"}), HasSubstr("--rho is 0.4; hht takes 0.5 to 1"));
  EXPECT_THAT(error({"--rho", "0.5", "--integrator-xi", "0"}), HasSubstr("exclude each other"));
}

TEST_F(Method, AParameterDoesNotReplaceConserve) {
  std::string text = pendulum;
  text.insert(text.find("step: 0.01"), "integrator: {type: conserve}, ");
  write_file(folder / "conserve.yaml", text);
  const Outcome refused = run({"run", "conserve.yaml", "--until", "0.1", "--rho", "0.5"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err,
              HasSubstr("--rho is 0.5, but the integrator is conserve in the model; --rho belongs to "
                        "generalized_alpha and hht"));
  EXPECT_EQ(summary("conserve.yaml", {"--integrator", "generalized_alpha", "--rho", "0.5"}).at("rho"), 0.5);
}

TEST_F(Method, HelpExplainsTheNames) {
  for (const char* command : {"run", "bench", "check", "verify"}) {
    const std::string help = run({command, "--help"}).out;
    for (const char* word : {"integrals", "projection", "projection_translations", "index3", "index1",
                             "baumgarte", "penalty", "index1_augmented", "independent", "global_modes",
                             "transfer_matrices", "generalized_alpha", "newmark", "hht"})
      EXPECT_THAT(help, HasSubstr(word)) << command;
  }
  EXPECT_THAT(run({"static", "--help"}).out, HasSubstr("natural"));
  EXPECT_THAT(run({"verify", "--help"}).out, Not(HasSubstr("--formulation")));
}

}  // namespace
}  // namespace mimbre::app_test::method_test

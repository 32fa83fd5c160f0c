#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "mimbre/diagnostics.h"
#include "support/exchange_importer.h"

/// Models that have no FMU for model exchange.
namespace mimbre::test::model_exchange_refusals_test {
namespace {

using testing::HasSubstr;

class ModelExchangeRefusals : public ExchangeTest {};

struct Refused {
  std::string what;
  std::size_t reasons = 0;
};

/// Why there is no FMU of a model; empty: there is one.
Refused refused(const std::string& text, int version) {
  try {
    exchange_fmu(model_of(text), version, "refused");
  } catch (const InputError& error) {
    return {error.what(), error.diagnostics().size()};
  }
  return {};
}

TEST_P(ModelExchangeRefusals, RefusesWhatHasNoDerivatives) {
  const auto refusal = [&](const std::string& text) { return refused(text, GetParam()).what; };
  const std::string slider = R"yaml(
bodies: {block: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}}
joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]MORE}}
)yaml";
  const auto with = [&](const std::string& joint, const std::string& rest) {
    std::string text = slider;
    return text.replace(text.find("MORE"), 4, joint) + rest;
  };
  EXPECT_EQ(refusal(with("", "")), "");
  EXPECT_THAT(refusal(with("", "frictions: {base: {joint: guide, force: 3}}")),
              testing::AllOf(HasSubstr("base"), HasSubstr("friction")));
  EXPECT_THAT(refusal(with(", drive: {position: place}", "inputs: {place: 0}")),
              testing::AllOf(HasSubstr("guide"), HasSubstr("input")));
  EXPECT_THAT(refusal(with("", "signals: {place: {joint: guide}, slow: {rate_limit: place, rising: 2}}")),
              testing::AllOf(HasSubstr("slow"), HasSubstr("rate_limit, which switches between steps")));
  EXPECT_THAT(
      refusal(
          with("",
               "signals: {place: {joint: guide}, slow: {transfer_function: place - 2*slow, numerator: [1], "
               "denominator: [1, 1]}}")),
      HasSubstr("signals go around in loops"));
  EXPECT_THAT(refusal(with("", "stops: {end: {joint: guide, lower: 0, stiffness: 1e6}}")),
              testing::AllOf(HasSubstr("stop 'end'"), HasSubstr("no differential equation")));
  EXPECT_THAT(refusal(with("", R"yaml(
roads: {field: {over: distance, points: [[-9, 0], [9, 0]]}}
tyres:
  tyre:
    {on: block, at: [0, 0, 0.3], road: field, model: brush, stiffness: 2e5, damping: 500, radius: 0.32,
     longitudinal_stiffness: 6e4, cornering_stiffness: 5e4, friction: 0.9, longitudinal_relaxation: 0.3,
     lateral_relaxation: 0.5, half_length: 0.07, load: 4000}
)yaml")),
              testing::AllOf(HasSubstr("tyre 'tyre'"), HasSubstr("footprint")));
  const auto hoist = [&](const std::string& length) {
    return with("",
                "cables: {hoist: {over: [ground, block], at: [[0, 0, 3], [0, 0, 0]], axial_stiffness: 5e5, "
                "length: " +
                    length + "}}");
  };
  EXPECT_EQ(refusal(hoist("2.9")), "");
  EXPECT_THAT(refusal(hoist("\"2.9 - 0.2*t\"")),
              testing::AllOf(HasSubstr("cable 'hoist'"), HasSubstr("no differential equation")));
  EXPECT_THAT(refusal(R"yaml(
bodies: {disc: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0.3]}}
joints: {free: {type: floating, between: [ground, disc], at: [0, 0, 0.3]}}
constraints:
  wheel: {type: rolling, between: [ground, disc], at: [[0, 0, 0], [0, 0, 0.3]], axis: [0, 0, 1], axis2: [0, 1, 0], radius: 0.3}
)yaml"),
              testing::AllOf(HasSubstr("constraint 'wheel'"), HasSubstr("velocities")));
  // Accelerations are seen at instants alone, which code does not have.
  EXPECT_THAT(refusal(with("", "signals: {a: {joint_acceleration: guide}}")),
              testing::AllOf(HasSubstr("signal 'a'"), HasSubstr("every")));
  EXPECT_THAT(refusal(with("", "signals: {a: {joint_acceleration: guide, every: 0.01}}")),
              HasSubstr("leave 'every' away"));
}

/// All reasons at once: of elements, and of what is found once the model is recorded.
TEST_P(ModelExchangeRefusals, RefusesWithAllReasons) {
  const auto reasons = [&](const std::string& text) { return refused(text, GetParam()).reasons; };
  EXPECT_EQ(reasons(R"yaml(
bodies: {block: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}}
joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]}}
stops: {end: {joint: guide, lower: 0, stiffness: 1e6}}
frictions: {base: {joint: guide, force: 3}}
signals: {place: {joint: guide}, slow: {rate_limit: place, rising: 2}}
)yaml"),
            3u);
  EXPECT_EQ(reasons(R"yaml(
inputs: {place: 0}
bodies:
  a: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}
  b: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}
  hub: {mass: 0, inertia: [0, 0, 0], com: [0, 0, 0]}
  pin: {mass: 0, inertia: [0, 0, 0], com: [0, 0, 0]}
joints:
  first: {type: prismatic, between: [ground, a], at: [0, 0, 0], axis: [1, 0, 0], drive: {position: place}}
  second: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0], drive: {position: "2*place"}}
  slide: {type: prismatic, between: [ground, hub], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 10}}
  lift: {type: prismatic, between: [ground, pin], at: [0, 0, 0], axis: [0, 0, 1], spring: {stiffness: 10}}
)yaml"),
            4u);
}

TEST_P(ModelExchangeRefusals, RefusesMotionsWithoutMass) {
  const Refused found = refused(R"yaml(
bodies: {hub: {mass: 0, inertia: [0, 0, 0], com: [0, 0, 0]}, arm: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0.5, 0, 0]}}
joints:
  slide: {type: prismatic, between: [ground, hub], at: [0, 0, 0], axis: [1, 0, 0], spring: {stiffness: 10}}
  lift: {type: prismatic, between: [ground, arm], at: [0.5, 0, 0], axis: [0, 0, 1]}
)yaml",
                                GetParam());
  EXPECT_EQ(found.reasons, 1u);
  EXPECT_THAT(found.what, testing::AllOf(HasSubstr("slide"), HasSubstr("mass")));
}

INSTANTIATE_TEST_SUITE_P(Versions, ModelExchangeRefusals, testing::Values(2, 3), name_of_version);

}  // namespace
}  // namespace mimbre::test::model_exchange_refusals_test

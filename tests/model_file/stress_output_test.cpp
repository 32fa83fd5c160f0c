#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mimbre/model_file.h"

namespace mimbre::test::stress_output_test {
namespace {

TEST(StressOutput, OfARigidBodyIsWarnedOf) {
  std::vector<Diagnostic> warnings;
  parse_model(R"(mimbre: 1
bodies: {block: {mass: 1, com: [0.5, 0, 0], inertia: [1, 1, 1]}}
joints: {hinge: {type: revolute, between: [ground, block], at: [0, 0, 0], axis: [0, 1, 0]}}
outputs:
  - {name: peak, stress: block}
)",
              "stress.yaml", "", {}, &warnings);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].mark.line, 5);
  EXPECT_THAT(warnings[0].message, testing::HasSubstr("'block' is rigid"));
}

}  // namespace
}  // namespace mimbre::test::stress_output_test

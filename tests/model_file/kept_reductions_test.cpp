#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>

#include "mimbre/reduced_body.h"
#include "support/models.h"

/// Reduced bodies of bars are found again by what they were made of, within a model and between models.
namespace mimbre::test::kept_reductions_test {
namespace {

/// Cantilevers, each of a section and a density of its own.
std::string arms(const std::vector<std::pair<std::string, double>>& each) {
  std::string text = "materials:\n", bodies = "bodies:\n", joints = "joints:\n", sections = "sections:\n";
  for (std::size_t k = 0; k < each.size(); ++k) {
    text += fmt::format("  m{}: {{young: 2.1e11, poisson: 0.3, density: {}}}\n", k, each[k].second);
    sections += fmt::format("  s{}: {{{}}}\n", k, each[k].first);
    bodies += fmt::format(
        "  arm{0}: {{frame: {{at: [0, {0}, 0]}}, flexible: {{material: m{0}, section: s{0}, nodes: {{root: "
        "[0, {0}, 0], "
        "tip: [1, {0}, 0]}}, bars: {{bar: {{from: root, to: tip, elements: 4}}}}, clamped: [root], "
        "static_modes: "
        "[{{node: tip, along: [0, 0, 1], name: z}}], dynamic_modes: 2}}}}\n",
        k);
    joints += fmt::format(
        "  hinge{0}: {{type: revolute, between: [ground, arm{0}], at: [0, {0}, 0], axis: [0, 1, 0]}}\n", k);
  }
  return text + sections + bodies + joints;
}

const std::string plain = "area: 1e-3, Iy: 1e-7, Iz: 2e-7, J: 1e-8";

const ReducedBody* reduced(const std::shared_ptr<const Model>& model, std::size_t body) {
  return model->spec().bodies[body].flexible.get();
}

TEST(KeptReductions, VariantsOfAModelShareThem) {
  const auto one = model_of(arms({{plain, 7850}})), same = model_of(arms({{plain, 7850}})),
             heavy = model_of(arms({{plain, 7900}}));
  EXPECT_EQ(reduced(one, 0), reduced(same, 0));
  EXPECT_NE(reduced(one, 0), reduced(heavy, 0));
  EXPECT_NEAR(reduced(heavy, 0)->mass / reduced(one, 0)->mass, 7900.0 / 7850, 1e-12);
  // By another name it is another one.
  EXPECT_NE(reduced(model_of(arms({{plain, 1000}, {plain, 7850}})), 1), reduced(one, 0));
}

TEST(KeptReductions, EqualBodiesOfAModelShareOne) {
  const auto model = model_of(arms({{plain, 7850}, {plain, 7850}, {plain, 7800}}));
  EXPECT_EQ(reduced(model, 0), reduced(model, 1));
  EXPECT_NE(reduced(model, 0), reduced(model, 2));
}

TEST(KeptReductions, BodiesWithOtherOutermostFibresAreOthers) {
  const std::string fibres = ", outermost: [0.02, 0.03], torsion_modulus: 2e-7",
                    further = ", outermost: [0.04, 0.03], torsion_modulus: 2e-7",
                    stiffer = ", outermost: [0.02, 0.03], torsion_modulus: 3e-7";
  const auto model = model_of(arms(
      {{plain + fibres, 7850}, {plain + further, 7850}, {plain + stiffer, 7850}, {plain + fibres, 7850}}));
  EXPECT_NE(reduced(model, 0), reduced(model, 1));
  EXPECT_NE(reduced(model, 0), reduced(model, 2));
  EXPECT_EQ(reduced(model, 0), reduced(model, 3));
}

TEST(KeptReductions, ManyThreadsMayAskForMoreThanAreKept) {
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int k = 0; k < 150; ++k) {
        const double density = 1000 + (k * 7 + t) % 300;
        const auto model = model_of(arms({{plain, density}}));
        if (std::abs(reduced(model, 0)->mass - 1e-3 * density) > 1e-9) ++wrong;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace mimbre::test::kept_reductions_test

#include "compile/image.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "dynamics/relative/system.h"
#include "mimbre/diagnostics.h"
#include "support/models.h"
#include "support/probe.h"
#include "support/random_mechanism.h"

/// What a step needs of a model, as one block of bytes.
namespace mimbre::test::image_test {
namespace {

struct Mechanism {
  const char* name;
  std::function<std::shared_ptr<const Model>()> model;

  friend void PrintTo(const Mechanism& mechanism, std::ostream* out) { *out << mechanism.name; }
};

std::shared_ptr<const Model> random_model(unsigned seed) {
  RandomOptions options;
  options.springs = options.damping = options.loads = options.drives = options.tyres = true;
  options.flexible_share = 0.5;
  options.loops = 2;
  return random_mechanism(seed, options).model;
}

class Images : public testing::TestWithParam<Mechanism> {};

/// Residual, matrix and equations in an arbitrary state.
std::vector<double> evaluated(const Compiled& m, unsigned seed) {
  Random random(seed);
  relative::RelativeSystem system(m);
  const int n = system.velocities();
  const VectorXd q = assembled_position(m), v = random.values(n, 1), a = random.values(n, 3),
                 multipliers = random.values(system.equations(), 5);
  VectorXd r(n);
  MatrixXd matrix(n, n);
  system.begin_step(q.data());
  system.residual(0.3, q.data(), v.data(), a.data(), multipliers.data(), 1e3, r.data());
  system.dense_matrix(q.data(), {0.01, 1e-4, 1e3}, matrix.data());
  std::vector<double> out(r.begin(), r.end());
  out.insert(out.end(), matrix.data(), matrix.data() + matrix.size());
  for (const double* phi : {system.phi(), system.phi_dot(), system.phi_ddot()})
    out.insert(out.end(), phi, phi + system.equations());
  return out;
}

/// Also where nothing stands beside it any more and the first one is gone.
TEST_P(Images, WorkWhereverTheirBytesAre) {
  std::vector<std::byte> bytes;
  std::vector<double> expected;
  {
    const std::shared_ptr<const Model> model = GetParam().model();
    bytes = model->image().bytes();
    expected = evaluated(model->compiled(), 3);
  }
  const Image first(bytes, nullptr);
  const std::vector<std::byte> again = first.bytes();
  EXPECT_EQ(again, bytes);
  std::fill(bytes.begin(), bytes.end(), std::byte{0xff});
  const Image second(again, nullptr);
  EXPECT_EQ(second.hash(), first.hash());
  const std::vector<double> found = evaluated(second.model(), 3);
  ASSERT_EQ(found.size(), expected.size());
  EXPECT_EQ(std::memcmp(found.data(), expected.data(), found.size() * sizeof(double)), 0);
}

TEST_P(Images, OfEqualModelsAreEqual) {
  const std::vector<std::byte> bytes = GetParam().model()->image().bytes();
  // What the heap held before must not show.
  std::vector<std::vector<char>> rubbish;
  for (int k = 0; k < 200; ++k) rubbish.emplace_back(static_cast<std::size_t>(100 + 37 * k), '\xa5');
  rubbish.clear();
  EXPECT_EQ(GetParam().model()->image().bytes(), bytes);
}

INSTANTIATE_TEST_SUITE_P(
    Mechanisms, Images,
    testing::Values(Mechanism{"controlled_four_bar", controlled_four_bar},
                    Mechanism{"geared_four_bar", geared_four_bar},
                    Mechanism{"car", [] { return example("iltis/vehicle.yaml"); }},
                    Mechanism{"first_random", [] { return random_model(3); }},
                    Mechanism{"second_random", [] { return random_model(14); }},
                    Mechanism{"beam", [] { return example("spin-up-beam/beam-2d.yaml"); }},
                    Mechanism{"absolute_nodal_coordinates",
                              [] {
                                return example("spin-up-beam/beam-2d.yaml", {{"method", "ancf"}});
                              }},
                    Mechanism{"absolute_nodal_coordinates_in_space",
                              [] {
                                return example("spin-up-beam/beam-3d.yaml", {{"method", "ancf_thick"}});
                              }}),
    [](const auto& mechanism) { return mechanism.param.name; });

TEST(Image, OfAnotherNumberIsAnotherOne) {
  std::string text = four_bar_text();
  const std::uint64_t hash = model_of(text)->image().hash();
  EXPECT_EQ(model_of(text)->image().hash(), hash);
  text.replace(text.find("mass: "), 6, "mass: 1");
  EXPECT_NE(model_of(text)->image().hash(), hash);
}

TEST(Image, IsNotTakenFromDamagedBytes) {
  const std::vector<std::byte> bytes = model_of(four_bar_text())->image().bytes();
  Random random(5);
  for (int k = 0; k < 500; ++k) {
    std::vector<std::byte> damaged = bytes;
    damaged[static_cast<std::size_t>(random.number(0, 1) * static_cast<double>(bytes.size() - 1))] ^=
        std::byte{0x10};
    if (k % 5 == 0) damaged.resize(damaged.size() * static_cast<std::size_t>(k) / 500);
    EXPECT_THROW(Image(damaged, nullptr), InputError);
  }
}

}  // namespace
}  // namespace mimbre::test::image_test

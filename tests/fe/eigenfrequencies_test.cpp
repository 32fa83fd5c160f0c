#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <functional>

#include "fe/meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/beam_reduction.h"

namespace mimbre::test::eigenfrequencies_test {
namespace {

// Roots βL of the frequency equations (Blevins 1979, table 8-1).
constexpr double kClampedFree[] = {1.87510406871196, 4.69409113297417, 7.85475743823761};
constexpr double kClampedClamped[] = {4.73004074486270, 7.85320462409584, 10.9956078380017};

const fe::Section kSection = rectangle(0.02, 0.03);
constexpr double kLength = 1.3;

/// ω of bending in the plane with the second moment I.
double bending(double beta, double I) {
  const fe::Material m = steel();
  return beta * beta / (kLength * kLength) * std::sqrt(m.young * I / (m.density * kSection.area));
}

/// Dofs left to a plane beam: v and θz.
std::vector<int> all_but_plane_bending(int nodes) {
  std::vector<int> fixed;
  for (int node = 0; node < nodes; ++node)
    for (int k : {0, 2, 3, 4}) fixed.push_back(6 * node + k);
  return fixed;
}

struct Support {
  const char* name;
  std::vector<int> end_dofs;  // fixed at both ends (v = 1, θz = 5), or at the root only
  bool root_only;
  int rigid;
  std::array<double, 3> roots;
};

void PrintTo(const Support& support, std::ostream* out) { *out << support.name; }

class BeamFrequencies : public testing::TestWithParam<Support> {
 protected:
  Eigen::VectorXd computed(int elements) const {
    const fe::Mesh mesh = straight_beam(kLength, elements, kSection);
    std::vector<int> fixed = all_but_plane_bending(elements + 1);
    for (int dof : GetParam().end_dofs) {
      fixed.push_back(dof);
      if (!GetParam().root_only) fixed.push_back(6 + dof);
    }
    return fe::eigenfrequencies_fixed_dofs(mesh, fixed, GetParam().rigid + 3);
  }
};

TEST_P(BeamFrequencies, ConvergeToTheClosedFormFromAboveWithTheFourthPowerOfTheElementSize) {
  const int rigid = GetParam().rigid;
  const Eigen::VectorXd coarse = computed(12);
  const Eigen::VectorXd fine = computed(24);
  EXPECT_TRUE(fine.head(rigid).isZero(0));
  for (int k = 0; k < 3; ++k) {
    const double exact = bending(GetParam().roots[k], kSection.Iz);
    const double error = fine[rigid + k] / exact - 1;
    const double coarse_error = coarse[rigid + k] / exact - 1;
    // Cubic elements of size h err by (βh)⁴/1440 (Strang, Fix 1973, 6.3: half of the eigenvalue's (βh)⁴/720).
    EXPECT_NEAR(error / (std::pow(GetParam().roots[k] / 24, 4) / 1440), 1, 0.1) << "mode " << k;
    EXPECT_NEAR(std::log2(coarse_error / error), 4, 0.15) << "mode " << k;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Supports, BeamFrequencies,
    testing::Values(
        Support{"cantilever", {1, 5}, true, 0, std::to_array(kClampedFree)},
        Support{"clamped", {1, 5}, false, 0, std::to_array(kClampedClamped)},
        Support{"pinned", {1}, false, 0, {std::numbers::pi, 2 * std::numbers::pi, 3 * std::numbers::pi}},
        Support{"free", {}, false, 2, std::to_array(kClampedClamped)}),
    [](const auto& support) { return support.param.name; });

TEST(Eigenfrequencies, OfASpatialCantileverAreThoseOfBothPlanes) {
  const Eigen::VectorXd omega = fe::eigenfrequencies(straight_beam(kLength, 30, kSection), {0}, 4);
  const double expected[] = {bending(kClampedFree[0], kSection.Iz), bending(kClampedFree[0], kSection.Iy),
                             bending(kClampedFree[1], kSection.Iz), bending(kClampedFree[1], kSection.Iy)};
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(omega[k] / expected[k], 1, 1e-6);
}

TEST(Eigenfrequencies, OfTwistAndStretchConvergeToTheBarsClosedForm) {
  const int elements = 200;
  const fe::Mesh mesh = straight_beam(kLength, elements, kSection);
  const fe::Material m = steel();
  const auto only = [&](int free) {
    std::vector<int> fixed;
    for (int dof = 0; dof < 6 * (elements + 1); ++dof)
      if (dof < 6 || dof % 6 != free) fixed.push_back(dof);
    return fe::eigenfrequencies_fixed_dofs(mesh, fixed, 1)[0];
  };
  const double quarter_wave = std::numbers::pi / (2 * kLength);
  const double shear = m.young / (2 * (1 + m.poisson));
  EXPECT_NEAR(only(0) / (quarter_wave * std::sqrt(m.young / m.density)), 1, 1e-5);
  EXPECT_NEAR(
      only(3) / (quarter_wave * std::sqrt(shear * kSection.J / (m.density * (kSection.Iy + kSection.Iz)))), 1,
      1e-5);
}

TEST(Eigenfrequencies, FindBothOfEveryDoubleEigenvalueOfARoundBar) {
  const fe::Section section = round_bar(0.02);
  const Eigen::VectorXd omega = fe::eigenfrequencies(straight_beam(kLength, 100, section), {0}, 6);
  for (int pair = 0; pair < 3; ++pair) {
    const double exact = std::pow(kClampedFree[pair] / kLength, 2) *
                         std::sqrt(steel().young * section.Iy / (steel().density * section.area));
    EXPECT_NEAR(omega[2 * pair] / exact, 1, 1e-6);
    EXPECT_NEAR(omega[2 * pair + 1] / exact, 1, 1e-6);
  }
}

TEST(Eigenfrequencies, OfAFreeFrameStartWithSixZerosAndAgreeWithADenseSolver) {
  fe::Mesh mesh = with_nodes({{0, 0, 0}, {1, 0, 0}, {1, 0.7, 0.4}, {2, 0.7, 0.4}});
  add_bar(mesh, 0, 1, 12, round_bar(0.02));
  add_bar(mesh, 1, 2, 12, rectangle(0.02, 0.03));
  add_bar(mesh, 2, 3, 12, round_bar(0.03));
  const Eigen::VectorXd omega = fe::eigenfrequencies(mesh, {}, 12);
  const fe::Matrices matrices = fe::assemble(mesh);
  const Eigen::VectorXd dense = symmetric_eigenvalues(matrices.stiffness, matrices.mass);
  EXPECT_TRUE(omega.head(6).isZero(0));
  for (int k = 6; k < 12; ++k) EXPECT_NEAR(omega[k] / std::sqrt(dense[k]), 1, 1e-6);
}

TEST(Eigenfrequencies, DoNotDependOnWhereTheMeshLies) {
  const fe::Mesh mesh = bent_frame();
  const Eigen::VectorXd omega = fe::eigenfrequencies(mesh, {0}, 8);
  const Eigen::VectorXd turned = fe::eigenfrequencies(moved(mesh, some_rotation(), {3, -2, 5}), {0}, 8);
  for (int k = 0; k < 8; ++k) EXPECT_NEAR(turned[k] / omega[k], 1, 1e-9);
}

TEST(Eigenfrequencies, RefuseWhatMakesNoSense) {
  fe::Mesh mesh = straight_beam(1, 2, kSection);
  const auto message = [](const std::function<void()>& call) -> std::string {
    try {
      call();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  using testing::HasSubstr;
  EXPECT_THAT(message([&] { fe::eigenfrequencies(mesh, {7}, 1); }), HasSubstr("fixed dof 42 does not exist"));
  EXPECT_THAT(message([&] { fe::eigenfrequencies(mesh, {0}, 13); }), HasSubstr("12 free dofs"));
  mesh.nodes.conservativeResize(3, 4);
  mesh.nodes.col(3).setOnes();
  EXPECT_THAT(message([&] { fe::eigenfrequencies(mesh, {0}, 1); }),
              HasSubstr("node 3 belongs to no element"));
  mesh.elements[1].y_direction = Eigen::Vector3d::UnitX();
  EXPECT_THAT(message([&] { fe::assemble(mesh); }), HasSubstr("beam element 1: its y direction is parallel"));
  mesh.elements[0].section.Iy = 0;
  EXPECT_THAT(message([&] { fe::assemble(mesh); }), HasSubstr("beam element 0: section Iy must be positive"));
  mesh.elements[0].nodes = {0, 9};
  EXPECT_THAT(message([&] { fe::assemble(mesh); }), HasSubstr("node 9 does not exist"));
}

}  // namespace
}  // namespace mimbre::test::eigenfrequencies_test

#include <gtest/gtest.h>

#include <cmath>

#include "fe/bar_ends.h"
#include "fe/meshes.h"
#include "fe/solid_meshes.h"
#include "math/decompositions.h"
#include "mimbre/beam_reduction.h"
#include "mimbre/fe_reduce.h"

/// Section forces of a slender bar against the stress of the same bar as a solid.
namespace mimbre::test {
namespace {

constexpr double length = 1, width = 0.1, height = 0.05, force = -1000;
const fe::Material steel_bar{2.1e11, 0.3, 7850};

TEST(BarSections, HaveTheStressOfTheSolidBar) {
  constexpr int count = 10;
  const fe::Section rectangular = rectangle(width, height);
  const fe::Mesh bars = straight_beam(length, count, rectangular);
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.dynamic_modes = 1;
  options.sections = true;
  const ReducedBody beam = fe::reduce(bars, options, {{"root", 0}, {"tip", 1}});
  ASSERT_TRUE(beam.sections);
  ASSERT_EQ(beam.sections->sections.size(), 2u * count);
  // A force on the tip along z, in the sections at both sides of the node in the middle.
  const Eigen::Index load = GeometricStiffness::boundary + 4 * beam.modes + 6 * 1 + 2;
  const double bending = force * length / 2 * (height / 2) / rectangular.Iy;

  const fe::SolidMesh mesh = block(fe::ElementType::hex20, {length, width, height}, {20, 2, 2}, steel_bar);
  fe::ModelReduction o;
  o.interfaces = {end(mesh, "root", 0), end(mesh, "tip", length)};
  o.basis = fe::ModelReduction::Basis::craig_bampton;
  o.dynamic_modes = 2;
  o.free_modes = 0;
  const ReducedBody solid = fe::reduce(mesh, fe::assemble(mesh), o).body;
  const Eigen::VectorXd y =
      PivotedCholesky(solid.stiffness).solve(solid.frames[1].X.transpose() * Eigen::Vector3d(0, 0, force));
  Eigen::Index top = 0;
  (solid.nodes.colwise() - Eigen::Vector3d(length / 2, width / 2, height)).colwise().norm().minCoeff(&top);

  for (const Eigen::Index section : {count - 1, count}) {
    const auto forces = force * beam.sections->influence.block<6, 1>(6 * section, load);
    EXPECT_NEAR(beam.sections->sections[static_cast<std::size_t>(section)].position.x(), length / 2, 1e-12);
    EXPECT_NEAR(forces[2], force, 1e-6 * std::abs(force));
    // The moment of the tip's force about the section.
    EXPECT_NEAR(forces[4], -force * length / 2, 1e-6 * std::abs(force));
    EXPECT_NEAR(forces[4] * (height / 2) / rectangular.Iy, solid.stress.row(6 * top).dot(y),
                0.02 * std::abs(bending));
  }
}

}  // namespace
}  // namespace mimbre::test

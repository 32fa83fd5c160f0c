#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "fe/bar_ends.h"
#include "fe/meshes.h"
#include "fe/solid_meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/beam_reduction.h"
#include "mimbre/fe_reduce.h"

/// Section forces of a slender bar against the stress of the same bar as a solid.
namespace mimbre::test::bar_sections_test {
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

/// By the modes' deflection alone: exact where static modes carry the loads. A force and a moment on the tip.
TEST(BarStress, IsThatOfACantileverWithItsStaticModes) {
  for (const bool round : {false, true}) {
    const double r = 0.03, pi = std::numbers::pi;
    fe::Section section = rectangle(width, height);
    if (round)
      section = {pi * r * r, pi * std::pow(r, 4) / 4, pi * std::pow(r, 4) / 4, pi * std::pow(r, 4) / 2};
    section.reach_y = round ? r : width / 2;
    section.reach_z = round ? r : height / 2;
    section.torsion_modulus = round ? pi * std::pow(r, 3) / 2 : 1e-4;
    section.round = round;
    constexpr int count = 8;
    fe::ReductionOptions options;
    options.clamped_nodes = {0};
    for (const bool rotation : {false, true})
      for (int k = 0; k < 3; ++k)
        options.boundary.push_back({1, rotation, Eigen::Vector3d::Unit(k), std::to_string(k)});
    options.dynamic_modes = 2;
    const fe::Mesh mesh = straight_beam(length, count, section);
    const ReducedBody body = fe::reduce(mesh, options, {{"tip", 1}});
    ASSERT_TRUE(body.bar_stress);
    ASSERT_EQ(body.bar_stress->round, std::vector<bool>(count, round));
    const Eigen::Vector3d F(2000, 300, -500), M(40, 70, -90);
    const Eigen::VectorXd y =
        PivotedCholesky(body.stiffness)
            .solve(body.frames[0].X.transpose() * F + body.frames[0].X_theta.transpose() * M);
    const Eigen::VectorXd stress = body.bar_stress->shapes * y;
    for (int line = 0; line < count; ++line)
      for (int end = 0; end < 2; ++end) {
        const double rest = length - mesh.nodes(0, mesh.elements[static_cast<std::size_t>(line)].nodes[end]);
        const auto parts = stress.segment<4>(8 * line + 4 * end);
        const double about_y = (M.y() - F.z() * rest) * section.reach_z / section.Iy,
                     about_z = (M.z() + F.y() * rest) * section.reach_y / section.Iz;
        EXPECT_NEAR(parts[0], F.x() / section.area, 1e-5 * F.x() / section.area);
        EXPECT_NEAR(parts[1], about_y, 1e-5 * std::abs(about_y)) << rest;
        EXPECT_NEAR(parts[2], about_z, 1e-5 * std::abs(about_z)) << rest;
        EXPECT_NEAR(parts[3], std::sqrt(3.0) * M.x() / section.torsion_modulus,
                    1e-5 * M.x() / section.torsion_modulus);
      }
  }
}

TEST(BarStress, IsUnknownWhereASectionsShapeIs) {
  fe::Section section = rectangle(width, height);
  section.torsion_modulus = 0;
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  options.dynamic_modes = 2;
  EXPECT_FALSE(fe::reduce(straight_beam(length, 3, section), options, {}).bar_stress);
}

}  // namespace
}  // namespace mimbre::test::bar_sections_test

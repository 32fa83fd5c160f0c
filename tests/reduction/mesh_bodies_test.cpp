#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "fe_files/fe_files.h"
#include "mimbre/fe_import.h"

/// Bodies of .inp files with shells, beams, masses and constraints.
namespace mimbre::fe::mesh_bodies_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

const std::string kSteel = "*MATERIAL, NAME=S\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7850\n";

FeModel model_of(const std::string& text, const FeCompanions& companions = {}) {
  Folder folder;
  return read_model(folder.write("body.inp", text), companions);
}

ReductionResult reduced(const FeModel& model, const std::vector<int>& nodes, int modes, int free_modes) {
  Interface interface;
  interface.name = "a";
  interface.nodes = nodes;
  interface.point = centre_of(model.mesh, nodes);
  ModelReduction options;
  options.interfaces = {interface};
  options.dynamic_modes = modes;
  options.free_modes = free_modes;
  return reduce(model.mesh, model.matrices, options);
}

std::string failed_checks(const ReducedBody& body) {
  std::string failed;
  for (const Check& line : body.checks)
    if (!line.passed && line.name != "free frequencies") failed += line.name + ": " + line.detail + "\n";
  for (const std::string& message : check(body)) failed += message + "\n";
  return failed;
}

std::string node_lines(const std::vector<Eigen::Vector3d>& nodes) {
  std::string text = "*NODE\n";
  for (std::size_t k = 0; k < nodes.size(); ++k)
    text += std::to_string(k + 1) + ", " + std::to_string(nodes[k].x()) + ", " +
            std::to_string(nodes[k].y()) + ", " + std::to_string(nodes[k].z()) + "\n";
  return text;
}

TEST(MeshBodies, OneOrTwoElementsHavePositiveEnergy) {
  const std::string square = node_lines({{0, 0, 0},
                                         {0.1, 0, 0},
                                         {0.1, 0.1, 0},
                                         {0, 0.1, 0},
                                         {0.05, 0, 0},
                                         {0.1, 0.05, 0},
                                         {0.05, 0.1, 0},
                                         {0, 0.05, 0},
                                         {0.05, 0.05, 0}});
  const std::string section = kSteel + "*SHELL SECTION, ELSET=E, MATERIAL=S\n0.001\n";
  for (const std::string& elements : {std::string("*ELEMENT, TYPE=S4, ELSET=E\n1, 1,2,3,4\n"),
                                      std::string("*ELEMENT, TYPE=S3, ELSET=E\n1, 1,2,3\n"),
                                      std::string("*ELEMENT, TYPE=S3, ELSET=E\n1, 1,2,3\n2, 1,3,4\n"),
                                      std::string("*ELEMENT, TYPE=S8R, ELSET=E\n1, 1,2,3,4,5,6,7,8\n"),
                                      std::string("*ELEMENT, TYPE=S6, ELSET=E\n1, 1,2,3,5,6,9\n")})
    for (const int modes : {3, 9}) {
      const FeModel model = model_of(square + elements + section);
      const ReductionResult result = reduced(model, {0}, modes, 0);
      EXPECT_THAT(failed_checks(result.body), IsEmpty()) << elements << modes;
    }
}

TEST(MeshBodies, OneBeamHasPositiveEnergyAndItsInertia) {
  const FeModel model =
      model_of(node_lines({{0, 0, 0}, {0.5, 0, 0}, {1, 0, 0}}) + "*ELEMENT, TYPE=B32R, ELSET=E\n1, 1,2,3\n" +
               kSteel + "*BEAM SECTION, ELSET=E, MATERIAL=S, SECTION=RECT\n0.04, 0.06\n0,0,1\n");
  const ReductionResult result = reduced(model, {0}, 6, 0);
  EXPECT_THAT(failed_checks(result.body), IsEmpty());
  const double mass = 7850 * 0.04 * 0.06;
  EXPECT_NEAR(result.body.mass, mass, 1e-9 * mass);
  // First axis z: 0.04 along z, 0.06 along y.
  EXPECT_NEAR(result.body.second_moment(1, 1), mass * 0.06 * 0.06 / 12, 1e-9 * mass);
  EXPECT_NEAR(result.body.second_moment(2, 2), mass * 0.04 * 0.04 / 12, 1e-9 * mass);
  EXPECT_NEAR(result.body.second_moment(0, 0), mass / 3, 1e-9 * mass);
}

constexpr int kBarElements = 20;

/// Lowest free frequencies, Hz, of a bar of elements B32R along curve(0 … 1).
template <class Curve>
Eigen::VectorXd bar_frequencies(const Curve& curve, const std::string& section, BeamTorsion torsion,
                                int count) {
  std::vector<Eigen::Vector3d> nodes;
  for (int k = 0; k <= 2 * kBarElements; ++k) nodes.push_back(curve(k / (2.0 * kBarElements)));
  std::string text = node_lines(nodes) + "*ELEMENT, TYPE=B32R, ELSET=E\n";
  for (int k = 0; k < kBarElements; ++k)
    text += std::to_string(k + 1) + ", " + std::to_string(2 * k + 1) + ", " + std::to_string(2 * k + 2) +
            ", " + std::to_string(2 * k + 3) + "\n";
  FeCompanions companions;
  companions.beam_torsion = torsion;
  const FeModel model =
      model_of(text + kSteel + "*BEAM SECTION, ELSET=E, MATERIAL=S, SECTION=" + section, companions);
  return reduced(model, {0}, 2, count).free_frequencies;
}

/// The torsion constant of a square that cannot warp is its polar moment a⁴/6: torsion waves have the speed
/// √(G/ρ). The first torsion mode of a free bar is half a wave.
TEST(MeshBodies, SquareBarOfBricksTwistsAtTheSpeedOfShear) {
  const auto frequencies = [](BeamTorsion torsion) {
    return bar_frequencies([](double s) { return Eigen::Vector3d(s, 0, 0); }, "RECT\n0.1, 0.1\n0,0,1\n",
                           torsion, 7);
  };
  const Eigen::VectorXd section = frequencies(BeamTorsion::section), brick = frequencies(BeamTorsion::brick);
  const double unwarped = std::sqrt(2.1e11 / 2.6 / 7850) / 2;  // Hz, 1 m long
  const double warped = unwarped * std::sqrt(6 * 0.14058);     // Saint-Venant's constant: 0.14058 a⁴
  const double of_elements = std::pow(EIGEN_PI / (2 * kBarElements), 2) / 24;  // their error, relative
  constexpr double of_formula = 1e-3;  // Roark's formula for the constant of a rectangle
  const auto nearest = [](const Eigen::VectorXd& f, double to) {
    return (f.array() / to - 1).abs().minCoeff();
  };
  EXPECT_LT(nearest(brick, unwarped), 1.01 * of_elements);
  EXPECT_LT(nearest(section, warped), of_elements + of_formula);
  EXPECT_GT(nearest(section, unwarped), 0.02);
  EXPECT_GT(nearest(brick, warped), 0.02);
}

/// CalculiX 2.20 expands B32R into one C3D20R across the section. Recorded: a bow of 1.5 rad and 0.5 m, the
/// lowest frequencies of *FREQUENCY.
TEST(MeshBodies, BowsOfBricksTwistAsInCalculix) {
  const auto bow = [](double s) {
    return Eigen::Vector3d(0.5 * std::sin(1.5 * s), 0.5 * std::cos(1.5 * s), 0);
  };
  struct Row {
    const char* section;
    std::array<double, 5> calculix;  ///< Hz
  };
  for (const Row& row : {Row{"RECT\n0.02, 0.02\n0,0,1\n", {175.618, 462.623, 497.585, 778.785, 986.566}},
                         Row{"RECT\n0.03, 0.02\n0,0,1\n", {175.625, 497.639, 652.406, 986.781, 1012.98}},
                         Row{"RECT\n0.01, 0.04\n0,0,1\n", {241.124, 318.148, 349.144, 531.894, 805.917}},
                         Row{"RECT, OFFSET1=0.5, OFFSET2=-0.5\n0.02, 0.02\n0,0,1\n",
                             {182.844, 481.497, 517.969, 804.301, 1026.73}}}) {
    const Eigen::VectorXd own = bar_frequencies(bow, row.section, BeamTorsion::brick, 5);
    for (Eigen::Index k = 0; k < 5; ++k) {
      const double theirs = row.calculix[static_cast<std::size_t>(k)];
      EXPECT_NEAR(own[k], theirs, 0.004 * theirs) << row.section << k;
    }
  }
}

TEST(MeshBodies, TorsionOfBricksIsForBeams) {
  FeCompanions companions;
  companions.beam_torsion = BeamTorsion::brick;
  const auto message = [&](const std::string& path) {
    try {
      read_model(path, companions);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(message(data_file("calculix/beam.inp")), HasSubstr("without matrices beside it"));
  EXPECT_THAT(message(data_file("gmsh/block-22.msh")), HasSubstr("beams of an .inp file"));
  EXPECT_THROW(model_of(node_lines({{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}}) +
                            "*ELEMENT, TYPE=S3, ELSET=E\n1, 1,2,3\n" + kSteel +
                            "*SHELL SECTION, ELSET=E, MATERIAL=S\n0.001\n",
                        companions),
               std::invalid_argument);
}

/// A ring whose nodes lie inside its sheet: the sheet is as long as its own circle.
TEST(MeshBodies, OffsetShellsHaveTheSizeOfTheirMiddleSurface) {
  constexpr int count = 24;
  const double radius = 0.2, thickness = 0.02, offset = 0.5 * thickness;
  std::vector<Eigen::Vector3d> nodes;
  std::string elements = "*ELEMENT, TYPE=S4, ELSET=E\n";
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * EIGEN_PI * k / count;
    for (const double z : {0.0, 0.1})
      nodes.emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    const int a = 2 * k + 1, b = 2 * ((k + 1) % count) + 1;
    elements += std::to_string(k + 1) + ", " + std::to_string(a) + ", " + std::to_string(b) + ", " +
                std::to_string(b + 1) + ", " + std::to_string(a + 1) + "\n";
  }
  // The normal points outwards; so does the sheet from its nodes.
  const FeModel model = model_of(node_lines(nodes) + elements + kSteel +
                                 "*SHELL SECTION, ELSET=E, MATERIAL=S, OFFSET=-0.5\n0.02\n");
  const ReductionResult result = reduced(model, {0, 1}, 3, 0);
  EXPECT_THAT(failed_checks(result.body), IsEmpty());
  const double around = count * 2 * (radius + offset) * std::sin(EIGEN_PI / count);
  const double mass = 7850 * thickness * 0.1 * around;
  EXPECT_NEAR(result.body.mass, mass, 1e-5 * mass);  // nodes have six figures
  // ∫ ρ z² about the middle of the height.
  const double height = result.body.second_moment(2, 2) - mass * 0.05 * 0.05;
  EXPECT_NEAR(height, mass * 0.1 * 0.1 / 12, 0.02 * height);
}

/// A torsion spring turns a node of solids about x; about y and z nothing resists its rotor's inertia, and
/// nothing of the rest depends on that.
TEST(MeshBodies, RotationsThatNothingResistsAreLeftOut) {
  std::vector<Eigen::Vector3d> nodes;
  for (const double x : {0.0, 1.0, 2.0})
    for (const auto& [y, z] : {std::pair(0.0, 0.0), {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}})
      nodes.emplace_back(x, y, z);
  const std::string solids =
      node_lines(nodes) + "*ELEMENT, TYPE=C3D8, ELSET=E\n1, 1,2,3,4,5,6,7,8\n2, 5,6,7,8,9,10,11,12\n" +
      "*ELEMENT, TYPE=B31, ELSET=B\n3, 10, 11\n6, 11, 12\n" + kSteel +
      "*SOLID SECTION, ELSET=E, MATERIAL=S\n*BEAM SECTION, ELSET=B, MATERIAL=S, SECTION=RECT\n0.2, 0.3\n"
      "1, 0, 0\n*ELEMENT, TYPE=SPRING2, ELSET=T\n4, 11, 9\n*SPRING, ELSET=T\n4, 4\n1e7\n";
  const auto rotor = [&](const std::string& inertia) {
    return reduced(model_of(solids + "*ELEMENT, TYPE=ROTARYI, ELSET=R\n5, 9\n*ROTARY INERTIA, ELSET=R\n" +
                            inertia + "\n"),
                   {0, 1, 2, 3}, 4, 0);
  };
  const ReductionResult thin = rotor("9, 9, 9, 0, 0, 0"), thick = rotor("9, 80, 75, 0, 0, 0");
  for (Eigen::Index k = 0; k < thin.fixed_frequencies.size(); ++k)
    EXPECT_NEAR(thick.fixed_frequencies[k], thin.fixed_frequencies[k], 1e-7 * thin.fixed_frequencies[k]) << k;
  for (const ReductionResult* result : {&thin, &thick}) {
    const auto line = std::find_if(result->body.checks.begin(), result->body.checks.end(),
                                   [](const Check& one) { return one.name == "loose rotations"; });
    ASSERT_NE(line, result->body.checks.end());
    EXPECT_THAT(line->detail,
                HasSubstr("2 rotations that nothing resists are left out, the first of node 9"));
  }
  const ReductionResult none = reduced(model_of(solids), {0, 1, 2, 3}, 4, 0);
  EXPECT_GT(none.fixed_frequencies[0] / thin.fixed_frequencies[0], 1 - 1e-9);
}

/// n quadrilaterals along x, 1 m long.
std::string strip(int n, const std::string& rest) {
  std::vector<Eigen::Vector3d> nodes;
  for (int k = 0; k <= n; ++k) {
    nodes.emplace_back(1.0 * k / n, 0, 0);
    nodes.emplace_back(1.0 * k / n, 0.1, 0);
  }
  std::string text = node_lines(nodes) + "*ELEMENT, TYPE=S4, ELSET=E\n";
  for (int k = 0; k < n; ++k)
    text += std::to_string(k + 1) + ", " + std::to_string(2 * k + 1) + ", " + std::to_string(2 * k + 3) +
            ", " + std::to_string(2 * k + 4) + ", " + std::to_string(2 * k + 2) + "\n";
  return text + rest;
}

TEST(MeshBodies, UnitsOfThinFlatShellsAreSound) {
  for (const char* thickness : {"0.01", "0.001", "1e-5"}) {
    const FeModel model =
        model_of(strip(4, kSteel + "*SHELL SECTION, ELSET=E, MATERIAL=S\n" + thickness + "\n"));
    EXPECT_THAT(failed_checks(reduced(model, {0, 1}, 3, 0).body), IsEmpty()) << thickness;
  }
  // Steel in t/mm³ where the file is taken for SI.
  FeModel wrong = model_of(strip(4,
                                 "*MATERIAL, NAME=S\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7.85e-9\n*SHELL "
                                 "SECTION, ELSET=E, MATERIAL=S\n0.001\n"));
  EXPECT_THAT(failed_checks(reduced(wrong, {0, 1}, 3, 0).body), HasSubstr("units"));
}

TEST(MeshBodies, DensityAndThicknessComeFromOutside) {
  const std::string bare = strip(4, "*MATERIAL, NAME=S\n*ELASTIC\n2.1e11, 0.3\n");
  const std::string whole = strip(4, kSteel + "*SHELL SECTION, ELSET=E, MATERIAL=S\n0.002\n");
  FeCompanions companions;
  companions.materials = {{"", {2.1e11, 0.3, 7850}}};
  companions.thicknesses = {{"", 0.002}};
  const Eigen::SparseMatrix<double> given = model_of(strip(4, ""), companions).matrices.mass;
  EXPECT_LT((given - model_of(whole).matrices.mass).norm(), 1e-12 * given.norm());
  FeCompanions density;
  density.densities = {{"s", 7850}};
  const FeModel one = model_of(strip(4,
                                     "*MATERIAL, NAME=S\n*ELASTIC\n2.1e11, 0.3\n*SHELL SECTION, ELSET=E, "
                                     "MATERIAL=S\n0.002\n"),
                               density);
  EXPECT_LT((one.matrices.mass - given).norm(), 1e-12 * given.norm());
  EXPECT_THAT(one.warnings, IsEmpty());
  EXPECT_THROW(model_of(whole, density), std::invalid_argument);
  EXPECT_THROW(model_of(whole, companions), std::invalid_argument);
}

/// A mass at the end of a rigid arm, as an element and by a reference node that follows.
TEST(MeshBodies, MassesOnRigidArmsAreWhatTheyAreWithAnOffset) {
  const std::string section = kSteel + "*SHELL SECTION, ELSET=E, MATERIAL=S\n0.004\n";
  FeModel direct = model_of(strip(5, section));
  PointMass point;
  point.name = "motor";
  point.node = 10;
  point.mass = 2;
  point.offset = {0.1, 0.05, 0.2};
  point.inertia = Eigen::Vector3d(0.01, 0.012, 0.015).asDiagonal();
  direct.mesh.point_masses = {point};
  direct.matrices = assemble(direct.mesh);

  const FeModel linked = model_of(strip(
      5, section +
             "*NODE\n99, 1.1, 0.05, 0.2\n*ELEMENT, TYPE=MASS, ELSET=M\n91, 99\n*ELEMENT, TYPE=ROTARYI, "
             "ELSET=I\n92, 99\n*MASS, ELSET=M\n2\n*ROTARY INERTIA, ELSET=I\n0.01, 0.012, 0.015, 0, 0, 0\n"
             "*MPC\nBEAM, 99, 11\n"));
  ASSERT_THAT(linked.warnings, IsEmpty());
  const ReductionResult a = reduced(direct, {0, 1}, 5, 5), b = reduced(linked, {0, 1}, 5, 5);
  EXPECT_THAT(failed_checks(a.body), IsEmpty());
  EXPECT_THAT(failed_checks(b.body), IsEmpty());
  EXPECT_NEAR(a.body.mass, 0.1 * 0.004 * 7850 + 2, 1e-9);
  EXPECT_NEAR(b.body.mass, a.body.mass, 1e-5 * a.body.mass);
  EXPECT_LT((a.body.second_moment - b.body.second_moment).norm(), 1e-4 * a.body.second_moment.norm());
  for (Eigen::Index k = 0; k < 5; ++k) {
    EXPECT_NEAR(a.free_frequencies[k], b.free_frequencies[k], 1e-4 * a.free_frequencies[k]);
    EXPECT_NEAR(a.fixed_frequencies[k], b.fixed_frequencies[k], 1e-4 * a.fixed_frequencies[k]);
  }
}

/// A bar of n bricks of the size 0.2 from x0 on, labels from `first` on.
std::string bricks(int n, double x0, int first, const std::string& set) {
  std::string nodes = "*NODE\n", elements = "*ELEMENT, TYPE=C3D8, ELSET=" + set + "\n";
  for (int k = 0; k <= n; ++k)
    for (int c = 0; c < 4; ++c)
      nodes += std::to_string(first + 4 * k + c) + ", " + std::to_string(x0 + 0.2 * k) + ", " +
               std::to_string(c == 1 || c == 2 ? 0.2 : 0) + ", " + std::to_string(c > 1 ? 0.2 : 0) + "\n";
  for (int k = 0; k < n; ++k) {
    elements += std::to_string(first + k);
    for (int j = 0; j < 8; ++j) elements += ", " + std::to_string(first + 4 * k + j);
    elements += "\n";
  }
  return nodes + elements;
}

const std::string kSolid = "*SOLID SECTION, ELSET=A, MATERIAL=S\n";

TEST(MeshBodies, TiedAndEquatedAndRigidlyJoinedPartsAreOne) {
  const FeModel one = model_of(bricks(5, 0, 1, "A") + kSteel + kSolid);
  const ReductionResult whole = reduced(one, {0, 1, 2, 3}, 4, 4);
  const std::string two = bricks(2, 0, 1, "A") + bricks(3, 0.4, 101, "B") + kSteel + kSolid +
                          "*SOLID SECTION, ELSET=B, MATERIAL=S\n";
  std::string equations;
  for (int c = 0; c < 4; ++c)
    for (int d = 1; d <= 3; ++d)
      equations += "*EQUATION\n2\n" + std::to_string(101 + c) + "," + std::to_string(d) + ",1., " +
                   std::to_string(9 + c) + "," + std::to_string(d) + ",-1.\n";
  // Faces S1 and S2 of these bricks are x = const.
  for (const std::string& joint :
       {equations, std::string("*SURFACE, NAME=s\n101, S1\n*SURFACE, NAME=m\n2, S2\n*TIE, NAME=t\ns, m\n")}) {
    const FeModel model = model_of(two + joint);
    ASSERT_FALSE(model.mesh.equations.empty());
    const ReductionResult result = reduced(model, {0, 1, 2, 3}, 4, 4);
    EXPECT_THAT(failed_checks(result.body), IsEmpty());
    EXPECT_NEAR(result.body.mass, whole.body.mass, 1e-9 * whole.body.mass);
    for (Eigen::Index k = 0; k < 4; ++k) {
      EXPECT_NEAR(result.free_frequencies[k], whole.free_frequencies[k], 1e-6 * whole.free_frequencies[k]);
      EXPECT_NEAR(result.fixed_frequencies[k], whole.fixed_frequencies[k], 1e-6 * whole.fixed_frequencies[k]);
    }
  }
}

TEST(MeshBodies, InterfaceAtTheReferenceOfARigidBodyIsThatAtItsNodes) {
  const std::string text = bricks(4, 0, 1, "A") + kSteel + kSolid;
  const ReductionResult plain = reduced(model_of(text), {0, 1, 2, 3}, 4, 3);
  const FeModel spider = model_of(text +
                                  "*NODE\n99, -0.3, 0.1, 0.1\n*NSET, NSET=end\n1,2,3,4\n"
                                  "*RIGID BODY, NSET=end, REF NODE=99\n");
  const int reference = static_cast<int>(spider.mesh.nodes.cols()) - 1;
  for (const std::vector<int>& nodes : {std::vector<int>{reference}, std::vector<int>{0, 1, 2, 3}}) {
    const ReductionResult result = reduced(spider, nodes, 4, 3);
    EXPECT_THAT(failed_checks(result.body), IsEmpty());
    for (Eigen::Index k = 0; k < 4; ++k)
      EXPECT_NEAR(result.fixed_frequencies[k], plain.fixed_frequencies[k], 1e-6 * plain.fixed_frequencies[k]);
  }
}

TEST(MeshBodies, SpringAlongTheLineActsAsItShould) {
  // Two heavy blocks on a spring: ω² = k (1/m1 + 1/m2), the blocks being stiff.
  const std::string blocks = bricks(1, 0, 1, "A") + bricks(1, 0.6, 101, "B") + kSteel + kSolid +
                             "*SOLID SECTION, ELSET=B, MATERIAL=S\n";
  std::string springs = "*ELEMENT, TYPE=SPRINGA, ELSET=K\n";
  for (int c = 0; c < 4; ++c)
    springs += std::to_string(500 + c) + ", " + std::to_string(5 + c) + ", " + std::to_string(101 + c) + "\n";
  springs += "*SPRING, ELSET=K\n\n1000\n*NODE\n900, 0.4, 0.1, 0.1\n";
  const FeModel model = model_of(blocks + springs);
  ASSERT_EQ(model.mesh.springs.size(), 4u);
  Eigen::VectorXd apart = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.matrices.dofs.size()));
  for (std::size_t r = 0; r < model.matrices.dofs.size(); ++r)
    if (model.matrices.dofs[r].direction == 0 && model.matrices.dofs[r].node >= 8)
      apart[static_cast<Eigen::Index>(r)] = 1;
  const Eigen::VectorXd force = model.matrices.stiffness.selfadjointView<Eigen::Lower>() * apart;
  EXPECT_NEAR(apart.dot(force), 4000, 1e-3);
}

TEST(MeshBodies, WhatIsRigidAltogetherIsNone) {
  const FeModel model =
      model_of(bricks(3, 0, 1, "A") + kSteel + kSolid + "*RIGID BODY, ELSET=A, REF NODE=1\n");
  try {
    reduced(model, {0}, 2, 0);
    FAIL() << "no complaint";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("cannot deform"));
  }
}

TEST(MeshBodies, EquationsThatHoldTheBodyAreNamed) {
  const FeModel model = model_of(bricks(3, 0, 1, "A") + kSteel + kSolid + "*EQUATION\n2\n1,2,1., 13,3,-1.\n");
  try {
    reduced(model, {0, 1, 2, 3}, 2, 0);
    FAIL() << "no complaint";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("*EQUATION of line"));
    EXPECT_THAT(error.what(), HasSubstr("holds the body"));
  }
}

}  // namespace
}  // namespace mimbre::fe::mesh_bodies_test

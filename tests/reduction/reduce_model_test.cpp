#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "fe/bar_ends.h"
#include "fe/skin.h"
#include "fe/solid_meshes.h"
#include "fe/solve/block_lanczos.h"
#include "math/once/decompositions.h"
#include "mimbre/fe_reduce.h"
#include "reduction/bases/rigid_shapes.h"
#include "reduction/tied_model.h"

/// Reduction of finite-element models of any origin.
namespace mimbre::test::reduce_model_test {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using fe::Interface;
using fe::ModelReduction;

const fe::Material steel{2.1e11, 0.3, 7850};
constexpr double length = 1, width = 0.1, height = 0.05;

fe::SolidMesh bar(fe::ElementType type = fe::ElementType::hex20, std::array<int, 3> cells = {8, 2, 1}) {
  return block(type, {length, width, height}, cells, steel);
}

ModelReduction both_ends(const fe::SolidMesh& mesh, Interface::Tie tie, int modes = 6) {
  ModelReduction o;
  o.interfaces = {end(mesh, "root", 0, tie), end(mesh, "tip", length, tie)};
  o.dynamic_modes = modes;
  o.free_modes = 6;
  return o;
}

const Check& find(const ReducedBody& body, const std::string& name) {
  for (const Check& c : body.checks)
    if (c.name == name) return c;
  ADD_FAILURE() << "no check " << name;
  return body.checks.front();
}

TEST(BlockLanczos, FindsWhatTheDenseSolverFinds) {
  const fe::SolidMesh mesh = bar(fe::ElementType::hex8, {4, 2, 1});
  const fe::FeMatrices m = fe::assemble(mesh);
  const MatrixXd K = full(m.stiffness), M = full(m.mass);
  const double shift = 1e5;
  const Cholesky factor(K + shift * M);
  const fe::Pencil pencil{K.rows(), [&](const MatrixXd& b) -> MatrixXd { return factor.solve(b); },
                          [&](const MatrixXd& x) -> MatrixXd { return M * x; }, -shift};
  const fe::Modes modes = fe::block_lanczos(pencil, 16);
  const VectorXd exact = symmetric_eigenvalues(K, M);
  for (int k = 6; k < 16; ++k) EXPECT_NEAR(modes.eigenvalues[k] / exact[k], 1, 1e-8) << k;
  EXPECT_LT(modes.eigenvalues.head(6).cwiseAbs().maxCoeff(), 1e-6 * modes.eigenvalues[6]);
  EXPECT_LT((modes.vectors.transpose() * M * modes.vectors - MatrixXd::Identity(16, 16)).norm(), 1e-9);
}

/// The tied model solves what a dense elimination solves, for both kinds of ties.
TEST(TiedModel, SolvesWithInterfacesHeld) {
  const fe::SolidMesh mesh = bar(fe::ElementType::hex8, {4, 2, 1});
  const fe::FeMatrices m = fe::assemble(mesh);
  const MatrixXd K = full(m.stiffness);
  for (const auto tie : {Interface::Tie::rigid, Interface::Tie::mean}) {
    const ModelReduction o = both_ends(mesh, tie);
    const fe::TiedModel tied(mesh, m, o.interfaces);
    EXPECT_EQ(tied.boundaries(), 12);
    const MatrixXd none = MatrixXd::Zero(12, tied.internals());
    const MatrixXd Tx = tied.expand(MatrixXd::Identity(tied.internals(), tied.internals()), none);
    const MatrixXd f = MatrixXd::Random(tied.internals(), 2);
    const MatrixXd exact = PivotedCholesky(Tx.transpose() * K * Tx).solve(f);
    EXPECT_LT((tied.solve(f) - exact).norm(), 1e-8 * exact.norm());
    const MatrixXd load = MatrixXd::Random(K.rows(), 3);
    EXPECT_LT((tied.restrict(load) - Tx.transpose() * load).norm(), 1e-12 * load.norm());
    // The interfaces' rigid motion is the model's.
    const MatrixXd R = fe::rigid_shapes(mesh, m);
    MatrixXd z(12, 6);
    for (int i = 0; i < 2; ++i) {
      const Vector3d p = o.interfaces[static_cast<std::size_t>(i)].point;
      z.middleRows<6>(6 * i).setIdentity();
      for (int k = 0; k < 3; ++k) z.block<3, 1>(6 * i, 3 + k) = Vector3d(Vector3d::Unit(k)).cross(p);
    }
    MatrixXd x(tied.internals(), 6);
    const MatrixXd Txx = Tx.transpose() * Tx;
    x = PivotedCholesky(Txx).solve(Tx.transpose() *
                                   (R - tied.expand(MatrixXd::Zero(tied.internals(), 6), z)));
    EXPECT_LT((tied.expand(x, z) - R).norm(), 1e-9 * R.norm());
  }
}

TEST(ReduceModel, CantileverOfSolidsHasItsFrequencies) {
  const fe::SolidMesh mesh = bar();
  ModelReduction o = both_ends(mesh, Interface::Tie::rigid, 4);
  o.interfaces.pop_back();
  const fe::ReductionResult r = fe::reduce(mesh, fe::assemble(mesh), o);
  EXPECT_EQ(r.body.modes, 4);
  // 3.516² √(EI/ρAL⁴), slender enough for 2 %, whose end cannot shrink where it is held.
  const double soft = 3.51602 * std::sqrt(steel.young * height * height / 12 / steel.density) /
                      (2 * std::numbers::pi * length * length);
  EXPECT_NEAR(r.fixed_frequencies[0] / soft, 1, 0.02);
  EXPECT_NEAR(r.fixed_frequencies[1] / (soft * width / height), 1, 0.02);
  EXPECT_NEAR(r.body.eigenfrequencies[0] / (2 * std::numbers::pi) / r.fixed_frequencies[0], 1, 1e-9);
  EXPECT_TRUE(check(r.body).empty());
}

/// Static modes are exact: a force at the tip bends the reduced body as it bends the model.
TEST(ReduceModel, StaticDeflectionIsTheFullModels) {
  const fe::SolidMesh mesh = bar();
  const fe::FeMatrices m = fe::assemble(mesh);
  for (const auto tie : {Interface::Tie::rigid, Interface::Tie::mean}) {
    const ModelReduction o = both_ends(mesh, tie, 0);
    const fe::ReductionResult r = fe::reduce(mesh, m, o);
    ASSERT_EQ(r.body.modes, 6);
    const BodyFrame& tip = r.body.frames[1];
    EXPECT_LT((r.body.frames[0].X).norm() + r.body.frames[0].X_theta.norm(), 1e-12);
    const MatrixXd K = r.body.stiffness;
    const double force = 1000;
    const Eigen::VectorXd y = PivotedCholesky(K).solve(tip.X.transpose() * Vector3d(0, 0, force));
    const double deflection = (tip.X * y).z();
    const double EI = steel.young * width * std::pow(height, 3) / 12;
    EXPECT_NEAR(deflection / (force * std::pow(length, 3) / (3 * EI)), 1,
                0.03);  // rigid ends stiffen a little
    // By the full model, directly.
    const fe::TiedModel held(mesh, m, {o.interfaces[0]});
    MatrixXd load = MatrixXd::Zero(m.stiffness.rows(), 1);
    const auto& nodes = o.interfaces[1].nodes;
    if (tie == Interface::Tie::mean) {
      for (std::size_t k = 0; k < m.dofs.size(); ++k)
        if (m.dofs[k].direction == 2 && std::find(nodes.begin(), nodes.end(), m.dofs[k].node) != nodes.end())
          load(static_cast<Eigen::Index>(k), 0) = force / static_cast<double>(nodes.size());
      const MatrixXd u = held.expand(held.solve(held.restrict(load)), MatrixXd::Zero(6, 1));
      double mean = 0;
      for (std::size_t k = 0; k < m.dofs.size(); ++k)
        if (m.dofs[k].direction == 2 && std::find(nodes.begin(), nodes.end(), m.dofs[k].node) != nodes.end())
          mean += u(static_cast<Eigen::Index>(k), 0) / static_cast<double>(nodes.size());
      EXPECT_NEAR(deflection / mean, 1, 1e-8);
    }
  }
}

/// Mean-axis modes carry no momentum, and the free body has the same frequencies in either frame.
TEST(ReduceModel, MeanAxesCarryNoMomentum) {
  const fe::SolidMesh mesh = bar();
  const fe::FeMatrices m = fe::assemble(mesh);
  ModelReduction o = both_ends(mesh, Interface::Tie::mean, 8);
  const fe::ReductionResult tangent = fe::reduce(mesh, m, o);
  o.frame = ModelReduction::Frame::mean_axis;
  const fe::ReductionResult mean = fe::reduce(mesh, m, o);
  EXPECT_EQ(mean.body.modes, tangent.body.modes);
  EXPECT_LT(mean.body.S.norm(), 1e-6 * std::sqrt(mean.body.mass));
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    EXPECT_LT((mean.body.S_position[static_cast<std::size_t>(i)].row(j) -
               mean.body.S_position[static_cast<std::size_t>(j)].row(i))
                  .norm(),
              1e-6 * std::sqrt(mean.body.mass));
  }
  for (int k = 0; k < 6; ++k) {
    EXPECT_NEAR(mean.reduced_free_frequencies[k] / tangent.reduced_free_frequencies[k], 1, 1e-6);
    EXPECT_NEAR(mean.body.eigenfrequencies[k] / (2 * std::numbers::pi) / mean.reduced_free_frequencies[k], 1,
                1e-6);
    if (k >= 3) continue;
    EXPECT_NEAR(mean.reduced_free_frequencies[k] / mean.free_frequencies[k], 1, 0.02);
  }
}

TEST(ReduceModel, CertificateFindsNothingWrongWithASoundModel) {
  const fe::SolidMesh mesh = bar(fe::ElementType::tet10, {8, 2, 1});
  const fe::ReductionResult r =
      fe::reduce(mesh, fe::assemble(mesh), both_ends(mesh, Interface::Tie::mean, 10));
  for (const Check& c : r.body.checks) EXPECT_TRUE(c.passed) << c.name << ": " << c.detail;
  EXPECT_NEAR(r.body.mass, steel.density * length * width * height, 1e-9);
  EXPECT_THAT(find(r.body, "number of modes").detail, testing::HasSubstr("16 = 12 motions"));
}

TEST(ReduceModel, CertificateSuspectsMillimetresAndTonnes) {
  fe::SolidMesh mesh = block(fe::ElementType::hex8, {1000, 100, 50}, {6, 2, 1}, {2.1e5, 0.3, 7.85e-9});
  const std::vector<Check> checks = fe::check_matrices(mesh, fe::assemble(mesh));
  for (const Check& c : checks)
    if (c.name == "units") {
      EXPECT_FALSE(c.passed);
      EXPECT_THAT(c.detail, testing::HasSubstr("--units mm"));
    }
}

/// A mesh in millimetres with a material in SI has a sound density, but is as heavy as no part.
TEST(ReduceModel, CertificateSuspectsMillimetresAlone) {
  const fe::SolidMesh mesh = block(fe::ElementType::hex8, {80, 20, 20}, {4, 1, 1}, {2.1e11, 0.3, 7850});
  for (const Check& c : fe::check_matrices(mesh, fe::assemble(mesh)))
    if (c.name == "units") {
      EXPECT_FALSE(c.passed);
      EXPECT_THAT(c.detail, testing::AllOf(testing::HasSubstr("--units mm"), testing::HasSubstr("0.08 m")));
    }
}

TEST(ReduceModel, CertificateSuspectsOddMaterials) {
  const auto said = [](const fe::Material& material) -> std::string {
    const fe::SolidMesh mesh = block(fe::ElementType::hex8, {1, 0.1, 0.1}, {4, 1, 1}, material);
    for (const Check& c : fe::check_matrices(mesh, fe::assemble(mesh)))
      if (c.name == "materials") return c.passed ? std::string() : c.detail;
    return "nothing";
  };
  EXPECT_EQ(said({2.1e11, 0.3, 7850}), "");
  EXPECT_EQ(said({5e6, 0.49, 1100}), "");  // rubber
  EXPECT_THAT(said({70000, 0.33, 2.7}),
              testing::AllOf(testing::HasSubstr("MPa"), testing::HasSubstr("g/cm³")));
  EXPECT_THAT(said({210, 0.3, 7850}), testing::HasSubstr("GPa"));
  EXPECT_THAT(said({2.1e5, 0.3, 7850}), testing::HasSubstr("MPa"));  // too soft to be so dense
  EXPECT_THAT(said({2.1e11, 0.3, 7.85e-9}), testing::HasSubstr("t/mm³"));
}

/// Nodes of no element, and a mean of too few displacements, however many rotations there are.
TEST(TiedModel, RefusesInterfacesWithoutAHold) {
  const auto refused = [](const fe::SolidMesh& mesh, std::vector<int> nodes, Interface::Tie tie) {
    Interface interface { "end", std::move(nodes) };
    interface.tie = tie;
    try {
      fe::TiedModel(mesh, fe::assemble(mesh), {interface});
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  fe::SolidMesh solid = bar(fe::ElementType::hex8);
  const auto count = static_cast<int>(solid.nodes.cols());
  solid.nodes.conservativeResize(3, count + 2);
  solid.nodes.rightCols(2).setRandom();
  const fe::SolidMesh shell = [] {
    fe::SolidMesh mesh;
    mesh.nodes.resize(3, 4);
    mesh.nodes << 0, 1, 1, 0, 0, 0, 1, 1, 0, 0, 0, 0;
    mesh.materials = {{"steel", steel}};
    fe::ElementGroup group;
    group.type = fe::ElementType::quad4;
    group.material = 0;
    group.thickness = 0.01;
    group.nodes = {0, 1, 2, 3};
    mesh.groups = {group};
    return mesh;
  }();
  for (const auto tie : {Interface::Tie::rigid, Interface::Tie::mean})
    EXPECT_THAT(refused(solid, {count, count + 1}, tie), testing::HasSubstr("has no hold"));
  EXPECT_EQ(refused(shell, {0}, Interface::Tie::rigid), "");
  EXPECT_THAT(refused(shell, {0}, Interface::Tie::mean), testing::HasSubstr("has no hold"));
  EXPECT_THAT(refused(shell, {0, 1}, Interface::Tie::mean), testing::HasSubstr("has no hold"));
  EXPECT_EQ(refused(shell, {0, 1, 2}, Interface::Tie::mean), "");
}

/// A laminate has hundreds of layers: the first few name what is odd.
TEST(ReduceModel, CertificateListsTheFirstOddMaterials) {
  fe::SolidMesh mesh = block(fe::ElementType::hex8, {1, 0.1, 0.1}, {4, 1, 1}, {210, 0.3, 7850});
  for (int k = 0; k < 20; ++k) mesh.materials.push_back({fmt::format("layer {}", k), {70, 0.3, 2700}, {}});
  for (const Check& c : fe::check_matrices(mesh, fe::assemble(mesh)))
    if (c.name == "materials") {
      EXPECT_FALSE(c.passed);
      EXPECT_THAT(c.detail, testing::AllOf(testing::HasSubstr("'layer 3'"), testing::HasSubstr("and 16 more"),
                                           testing::Not(testing::HasSubstr("'layer 4'"))));
    }
}

/// A mesh that was brought to metres, but its material in MPa and t/mm³: the mesh is not to blame.
TEST(ReduceModel, CertificateSuspectsTheMaterialOfAPartOfGoodSize) {
  const fe::SolidMesh mesh =
      block(fe::ElementType::hex8, {0.08, 0.02, 0.02}, {4, 1, 1}, {2.1e5, 0.3, 7.85e-9});
  int told = 0;
  for (const Check& c : fe::check_matrices(mesh, fe::assemble(mesh))) {
    if (c.name == "materials") {
      EXPECT_FALSE(c.passed);
      EXPECT_THAT(c.detail, testing::AllOf(testing::HasSubstr("MPa"), testing::HasSubstr("t/mm³")));
      ++told;
    }
    if (c.name == "units") {
      EXPECT_FALSE(c.passed);
      EXPECT_THAT(c.detail, testing::AllOf(testing::HasSubstr("is the density in kg/m³"),
                                           testing::Not(testing::HasSubstr("--units mm"))));
      ++told;
    }
  }
  EXPECT_EQ(told, 2);
}

/// With few modes the upper free frequencies are off; the certificate draws the line where they begin to be.
TEST(ReduceModel, CertificateSaysUpToWhichFrequency) {
  const fe::SolidMesh mesh = bar(fe::ElementType::tet10, {8, 2, 1});
  ModelReduction o = both_ends(mesh, Interface::Tie::mean, 1);
  o.free_modes = 10;
  const fe::ReductionResult r = fe::reduce(mesh, fe::assemble(mesh), o);
  double trusted = 0, off = 0;
  for (int k = 0; k < r.reduced_free_frequencies.size() && off == 0; ++k)
    (std::abs(r.reduced_free_frequencies[k] / r.free_frequencies[k] - 1) < 0.1 ? trusted : off) =
        r.free_frequencies[k];
  ASSERT_GT(off, 0);
  const std::string said = find(r.body, "free frequencies").detail;
  ASSERT_THAT(said, testing::StartsWith("to be trusted up to "));
  const double line = std::stod(said.substr(std::string("to be trusted up to ").size()));
  EXPECT_LE(line, trusted * (1 + 1e-4));  // its shape may be off before its frequency is
  EXPECT_GE(line, r.free_frequencies[0] * (1 - 1e-4));
  EXPECT_LT(line, off);
}

TEST(ReduceModel, SaysWhatIsWrong) {
  const fe::SolidMesh mesh = bar(fe::ElementType::hex8, {4, 2, 1});
  const fe::FeMatrices m = fe::assemble(mesh);
  const auto fails = [&](const ModelReduction& o, const fe::FeMatrices& matrices, const std::string& text) {
    try {
      fe::reduce(mesh, matrices, o);
      ADD_FAILURE() << "no error; expected " << text;
    } catch (const std::invalid_argument& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr(text));
    }
  };
  fails({}, m, "at least one interface");
  ModelReduction o = both_ends(mesh, Interface::Tie::rigid);
  o.interfaces[1].name = "root";
  fails(o, m, "two interfaces are called 'root'");
  o = both_ends(mesh, Interface::Tie::rigid);
  o.interfaces[1].nodes.push_back(o.interfaces[0].nodes[0]);
  fails(o, m, "is in the interfaces 'root' and 'tip'");
  o = both_ends(mesh, Interface::Tie::rigid);
  o.interfaces[1].nodes.resize(1);
  fails(o, m, "no hold in all six directions");
  fe::FeMatrices held = m;
  held.stiffness.coeffRef(0, 0) *= 2;
  fails(both_ends(mesh, Interface::Tie::rigid), held, "is the model held somewhere");
  fe::FeMatrices broken = m;
  broken.mass.coeffRef(3, 3) = NAN;
  fails(both_ends(mesh, Interface::Tie::rigid), broken, "not finite");
}

TEST(ReduceModel, PartsThatNothingJoinsAreNamed) {
  // Two blocks end to end whose nodes were never merged.
  fe::SolidMesh mesh = block(fe::ElementType::hex8, {1, 0.1, 0.1}, {4, 1, 1}, steel);
  const auto one = static_cast<int>(mesh.nodes.cols());
  const fe::SolidMesh other = block(fe::ElementType::hex8, {0.5, 0.1, 0.1}, {2, 1, 1}, steel);
  Eigen::Matrix3Xd nodes(3, one + other.nodes.cols());
  nodes << mesh.nodes, other.nodes.colwise() + Vector3d(1, 0, 0);
  mesh.nodes = nodes;
  for (const int node : other.groups[0].nodes) mesh.groups[0].nodes.push_back(one + node);
  for (int k = 0; k < nodes.cols(); ++k) mesh.labels.push_back(k + 1);
  if (!mesh.groups[0].labels.empty()) mesh.groups[0].labels.clear();
  const fe::FeMatrices m = fe::assemble(mesh);
  ModelReduction o;
  o.interfaces = {end(mesh, "root", 0, Interface::Tie::rigid)};
  o.free_modes = 0;
  try {
    fe::reduce(mesh, m, o);
    ADD_FAILURE();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(),
                testing::HasSubstr("in 2 parts that no element joins; the smallest has 12 nodes"));
    EXPECT_THAT(error.what(), testing::HasSubstr("4 nodes of different parts coincide"));
  }
  // An interface may join them.
  o.interfaces.push_back(end(mesh, "seam", 1, Interface::Tie::rigid));
  EXPECT_EQ(fe::reduce(mesh, m, o).body.modes, 6 + 10);
}

TEST(Skin, EnclosesTheBlock) {
  for (const auto type : {fe::ElementType::tet4, fe::ElementType::hex20, fe::ElementType::wedge6}) {
    const fe::SolidMesh mesh = block(type, {1, 0.5, 0.25}, {3, 2, 2}, steel);
    const fe::Skin outside = fe::skin(mesh);
    EXPECT_TRUE(outside.closed);
    EXPECT_NEAR(fe::enclosed(mesh, outside).volume, 0.125, 1e-12);
    EXPECT_LT((fe::enclosed(mesh, outside).centre - Vector3d(0.5, 0.25, 0.125)).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace mimbre::test::reduce_model_test

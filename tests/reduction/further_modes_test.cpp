#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <numbers>

#include "fe/solid_meshes.h"
#include "fe_files/bodies/user_modes_file.h"
#include "math/once/decompositions.h"
#include "mimbre/fe_reduce.h"
#include "reduction/tied_model.h"

/// Modes of loads and of the user beside the dynamic ones.
namespace mimbre::test::further_modes_test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using fe::Interface;
using fe::ModelReduction;
using Basis = ModelReduction::Basis;
using testing::HasSubstr;

/// A bent arm with interfaces at its ends: one rigid, one mean.
struct Part {
  fe::SolidMesh mesh;
  fe::FeMatrices matrices;
  ModelReduction options;
  std::vector<int> loaded;  ///< nodes of the middle's top
};
Part arm() {
  Part p;
  p.mesh = block(fe::ElementType::hex8, {1, 0.1, 0.06}, {8, 2, 1}, {2.1e11, 0.3, 7850});
  p.options.interfaces.resize(2);
  for (std::size_t i = 0; i < 2; ++i) {
    Interface& interface = p.options.interfaces[i];
    interface.name = i == 0 ? "root" : "tip";
    interface.tie = i == 0 ? Interface::Tie::rigid : Interface::Tie::mean;
    for (int k = 0; k < p.mesh.nodes.cols(); ++k)
      if (std::abs(p.mesh.nodes(0, k) - static_cast<double>(i)) < 1e-9) interface.nodes.push_back(k);
  }
  for (int k = 0; k < p.mesh.nodes.cols(); ++k)
    if (std::abs(p.mesh.nodes(0, k) - 0.5) < 1e-9 && p.mesh.nodes(2, k) > 0.05) p.loaded.push_back(k);
  for (auto column : p.mesh.nodes.colwise()) column.y() += 0.3 * column.x() * column.x();
  for (Interface& interface : p.options.interfaces) interface.point = fe::centre_of(p.mesh, interface.nodes);
  p.matrices = fe::assemble(p.mesh);
  p.mesh.labels.clear();
  for (Index k = 0; k < p.mesh.nodes.cols(); ++k) p.mesh.labels.push_back(100 + k);
  p.options.dynamic_modes = 3;
  p.options.free_modes = 6;
  return p;
}

/// The full model with its interfaces tied: u = T (x, z).
struct Full {
  MatrixXd T, K, M;
};
Full full_model(const Part& p) {
  const fe::TiedModel tied(p.mesh, p.matrices, p.options.interfaces);
  const Index n = tied.internals(), b = tied.boundaries();
  MatrixXd x = MatrixXd::Zero(n, n + b), z = MatrixXd::Zero(b, n + b);
  x.leftCols(n).setIdentity();
  z.rightCols(b).setIdentity();
  Full f;
  f.T = tied.expand(x, z);
  f.K = f.T.transpose() * full(p.matrices.stiffness) * f.T;
  f.M = f.T.transpose() * full(p.matrices.mass) * f.T;
  return f;
}

/// Displacements of all nodes by the part's force with its root held, and the same of the reduced body's
/// nodes (each body node is a node of the mesh).
VectorXd static_deflection(const Part& p, const VectorXd& force) {
  const Full f = full_model(p);
  std::vector<Index> free;
  for (Index k = 0; k < f.K.rows(); ++k)
    if (k < f.K.rows() - 12 || k >= f.K.rows() - 6) free.push_back(k);
  const VectorXd y = PivotedCholesky(f.K(free, free)).solve(VectorXd(f.T.transpose() * force)(free));
  return f.T(Eigen::all, free) * y;
}

double deflection_error(const Part& p, const ReducedBody& body, const VectorXd& force) {
  const VectorXd exact = static_deflection(p, force);
  const auto mesh_node = [&](Index k) {
    Index at = 0;
    (p.mesh.nodes.colwise() - body.nodes.col(k)).colwise().norm().minCoeff(&at);
    return at;
  };
  VectorXd generalised = VectorXd::Zero(body.modes);
  for (Index k = 0; k < body.nodes.cols(); ++k)
    generalised += body.node_shapes.middleRows<3>(3 * k).transpose() * force.segment<3>(3 * mesh_node(k));
  const VectorXd y = PivotedCholesky(body.stiffness).solve(generalised);
  double worst = 0;
  for (Index k = 0; k < body.nodes.cols(); ++k)
    worst = std::max(worst,
                     (body.node_shapes.middleRows<3>(3 * k) * y - exact.segment<3>(3 * mesh_node(k))).norm());
  return worst / exact.cwiseAbs().maxCoeff();
}

VectorXd force_of(const Part& p, const Vector3d& force) {
  VectorXd f = VectorXd::Zero(3 * p.mesh.nodes.cols());
  for (const int node : p.loaded) f.segment<3>(3 * node) += force / static_cast<double>(p.loaded.size());
  return f;
}

const Check* find_check(const ReducedBody& body, const std::string& name) {
  for (const Check& check : body.checks)
    if (check.name == name) return &check;
  return nullptr;
}

TEST(LoadModes, HaveTheFullModelsDeflection) {
  const Part p = arm();
  const Vector3d force(30, -20, 100);
  for (const Basis basis : {Basis::craig_bampton, Basis::krylov, Basis::free_interface})
    for (const auto frame : {ModelReduction::Frame::tangent, ModelReduction::Frame::mean_axis}) {
      if (frame == ModelReduction::Frame::mean_axis && basis != Basis::craig_bampton) continue;
      ModelReduction options = p.options;
      options.basis = basis;
      options.free_modes = 0;
      options.frame = frame;
      const int before = fe::reduce(p.mesh, p.matrices, options).body.modes;
      options.frame = ModelReduction::Frame::tangent;
      const double without =
          deflection_error(p, fe::reduce(p.mesh, p.matrices, options).body, force_of(p, force));
      options.frame = frame;
      options.loads = {{"seat", p.loaded, force}};
      const ReducedBody body = fe::reduce(p.mesh, p.matrices, options).body;
      EXPECT_EQ(body.modes, before + 1);
      if (frame == ModelReduction::Frame::mean_axis) continue;  // nothing holds the root there
      const double with = deflection_error(p, body, force_of(p, force));
      std::cout << "basis " << static_cast<int>(basis) << ": deflection without the load's mode " << without
                << ", with it " << with << '\n';
      EXPECT_GT(without, 1e-4);
      EXPECT_LT(with, 1e-9);
      EXPECT_THAT(body.mode_names.back(), "load seat");
    }
}

TEST(LoadModes, ThoseThatAreThereAreLeftOut) {
  const Part p = arm();
  ModelReduction options = p.options;
  options.free_modes = 0;
  options.loads = {{"one", p.loaded, {0, 0, 1}},
                   {"same", p.loaded, {0, 0, -7}},
                   {"held", options.interfaces[0].nodes, {0, 1, 0}}};
  const ReducedBody body = fe::reduce(p.mesh, p.matrices, options).body;
  EXPECT_EQ(body.modes, 6 + 3 + 1);
  ASSERT_NE(find_check(body, "load same"), nullptr);
  EXPECT_THAT(find_check(body, "load one")->detail, HasSubstr("now a mode"));
  EXPECT_THAT(find_check(body, "load same")->detail, HasSubstr("left out"));
  EXPECT_THAT(find_check(body, "load held")->detail, HasSubstr("left out"));
}

TEST(LoadModes, MistakesAreNamed) {
  const Part p = arm();
  const auto error_of = [&](std::vector<fe::SpreadLoad> loads) {
    ModelReduction options = p.options;
    options.loads = std::move(loads);
    try {
      fe::reduce(p.mesh, p.matrices, options);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(error_of({{"a", {}, {0, 0, 1}}}), HasSubstr("'a' has no nodes"));
  EXPECT_THAT(error_of({{"a", p.loaded, {0, 0, 0}}}), HasSubstr("'a' has no force"));
  EXPECT_THAT(error_of({{"a", {99999}, {0, 0, 1}}}), HasSubstr("no displacement"));
  EXPECT_THAT(error_of({{"a", p.loaded, {0, 0, 1}}, {"a", p.loaded, {0, 1, 0}}}), HasSubstr("two loads"));
}

/// The lowest elastic modes of the free tied model, at the nodes' translations, and their frequencies, Hz.
struct FreeModes {
  MatrixXd shapes;
  VectorXd frequencies;
};
FreeModes free_modes(const Part& p, int count) {
  const Full f = full_model(p);
  const EigenPairs solver = symmetric_eigen(f.K, f.M);
  return {f.T * solver.vectors.middleCols(6, count),
          solver.values.segment(6, count).cwiseSqrt() / (2 * std::numbers::pi)};
}

/// With every `every`-th node only.
fe::UserModes given(const Part& p, const MatrixXd& shapes, int every) {
  fe::UserModes modes;
  std::vector<Index> rows;
  for (std::size_t r = 0; r < p.matrices.dofs.size(); ++r) {
    if (p.matrices.dofs[r].node % every != 0) continue;
    modes.dofs.push_back(p.matrices.dofs[r]);
    rows.push_back(static_cast<Index>(r));
  }
  modes.shapes = shapes(rows, Eigen::all);
  return modes;
}

double frequency_error(const VectorXd& reduced, const VectorXd& exact) {
  return (reduced.head(exact.size()).array() / exact.array() - 1).abs().maxCoeff();
}

TEST(UserModes, TheModelsOwnModesHaveItsFrequencies) {
  const Part p = arm();
  const FreeModes exact = free_modes(p, 4);
  for (const Basis basis : {Basis::craig_bampton, Basis::free_interface}) {
    ModelReduction options = p.options;
    options.basis = basis;
    options.dynamic_modes = 0;
    double without = 1;
    if (basis == Basis::craig_bampton)
      without = frequency_error(fe::reduce(p.mesh, p.matrices, options).reduced_free_frequencies,
                                exact.frequencies);
    options.user_modes = given(p, exact.shapes, 1);
    const fe::ReductionResult all = fe::reduce(p.mesh, p.matrices, options);
    options.user_modes = given(p, exact.shapes, 3);
    const fe::ReductionResult some = fe::reduce(p.mesh, p.matrices, options);
    const double of_all = frequency_error(all.reduced_free_frequencies, exact.frequencies),
                 of_some = frequency_error(some.reduced_free_frequencies, exact.frequencies);
    std::cout << "basis " << static_cast<int>(basis) << ": frequencies without user modes off by "
              << 100 * without << " %, given at all nodes " << 100 * of_all << " %, at a third "
              << 100 * of_some << " %\n";
    EXPECT_GT(without, 0.01);
    EXPECT_LT(of_all, 1e-8);
    EXPECT_LT(of_some, 0.05);  // the other nodes follow without inertia
    ASSERT_NE(find_check(some.body, "user modes"), nullptr);
    EXPECT_TRUE(find_check(some.body, "user modes")->passed);
  }
}

TEST(UserModes, ComeBesideTheDynamicModes) {
  const Part p = arm();
  ModelReduction options = p.options;
  options.free_modes = 0;
  options.user_modes = given(p, free_modes(p, 2).shapes, 3);
  const ReducedBody body = fe::reduce(p.mesh, p.matrices, options).body;
  EXPECT_EQ(body.modes, 6 + 3 + 2);
  EXPECT_TRUE(check(body).empty());
  EXPECT_EQ(body.mode_names[9], "user 1");
}

TEST(UserModes, ThatContradictTheInterfacesAreTold) {
  Part p = arm();
  ModelReduction options = p.options;
  options.free_modes = 0;
  options.user_modes = given(p, free_modes(p, 1).shapes, 1);
  for (std::size_t r = 0; r < options.user_modes.dofs.size(); ++r)
    if (const fe::Dof& dof = options.user_modes.dofs[r]; dof.node == options.interfaces[0].nodes[0])
      options.user_modes.shapes(static_cast<Index>(r), 0) += options.user_modes.shapes.norm();
  const ReducedBody body = fe::reduce(p.mesh, p.matrices, options).body;
  EXPECT_FALSE(find_check(body, "user modes")->passed);
  EXPECT_THAT(find_check(body, "user modes")->detail, HasSubstr("contradict"));
}

TEST(UserModes, TooFewDisplacementsAreRefused) {
  const Part p = arm();
  ModelReduction options = p.options;
  options.user_modes = {{{40, 0}, {40, 1}, {40, 2}, {41, 0}, {41, 1}}, MatrixXd::Ones(5, 1)};
  EXPECT_THROW(fe::reduce(p.mesh, p.matrices, options), std::invalid_argument);
  options.user_modes = {{{40, 5}}, MatrixXd::Ones(1, 1)};
  EXPECT_THROW(fe::reduce(p.mesh, p.matrices, options), std::invalid_argument);
}

std::string little(std::uint64_t number, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(number >> 8 * i & 0xff);
  return text;
}

std::uint32_t crc32(const std::string& bytes) {
  std::uint32_t crc = 0xffffffffU;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int i = 0; i < 8; ++i) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320U : 0U);
  }
  return ~crc;
}

/// A ZIP archive, nothing compressed.
std::string zip(const std::vector<std::pair<std::string, std::string>>& members) {
  std::string bytes, directory;
  for (const auto& [name, data] : members) {
    const auto size = static_cast<std::uint32_t>(data.size());
    const std::string sizes = little(crc32(data), 4) + little(size, 4) + little(size, 4) +
                              little(static_cast<std::uint32_t>(name.size()), 2) + little(0, 2);
    const auto offset = static_cast<std::uint32_t>(bytes.size());
    bytes += "PK\x03\x04" + little(20, 2) + little(0, 8) + sizes + name + data;
    directory += "PK\x01\x02" + little(20, 2) + little(20, 2) + little(0, 8) + sizes + little(0, 10) +
                 little(offset, 4) + name;
  }
  const auto count = static_cast<std::uint32_t>(members.size());
  return bytes + directory + "PK\x05\x06" + little(0, 4) + little(count, 2) + little(count, 2) +
         little(static_cast<std::uint32_t>(directory.size()), 4) +
         little(static_cast<std::uint32_t>(bytes.size()), 4) + little(0, 2);
}

template <class Number>
std::pair<std::string, std::string> array(const std::string& name, const std::string& kind,
                                          const std::string& shape, const std::vector<Number>& values,
                                          bool by_columns = false) {
  const std::string head = fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}\n", kind,
                                       by_columns ? "True" : "False", shape);
  std::string data =
      "\x93NUMPY" + std::string("\x01\0", 2) + little(static_cast<std::uint32_t>(head.size()), 2) + head;
  data.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number));
  return {name + ".npy", data};
}

class UserModesFile : public testing::Test {
 protected:
  void SetUp() override {
    path = fmt::format("{}/mimbre-user-modes-{}.csv", testing::TempDir(), getpid());
    mesh.nodes = Eigen::Matrix3Xd::Zero(3, 2);
    mesh.labels = {7, 9};
  }
  void TearDown() override { std::filesystem::remove(path); }
  fe::UserModes read(const std::string& text, const fe::FileUnits& units = {}) {
    std::ofstream(path, std::ios::binary) << text;
    return fe::read_user_modes(path, mesh, units);
  }
  std::string error(const std::string& text) {
    try {
      read(text);
    } catch (const InputError& e) {
      return e.what();
    }
    return "read";
  }
  std::string path;
  fe::SolidMesh mesh;
};

TEST_F(UserModesFile, IsATableByNodeAndDirection) {
  const fe::UserModes m =
      read("node; direction; first; second\n# measured\n9; z; 0.5; -1\n7;4;2;3e0\n", {1e-3, 1, 1});
  ASSERT_EQ(m.dofs.size(), 2U);
  EXPECT_EQ(m.dofs[0].node, 1);
  EXPECT_EQ(m.dofs[0].direction, 2);
  EXPECT_EQ(m.dofs[1].direction, 3);
  EXPECT_TRUE(m.shapes.isApprox((MatrixXd(2, 2) << 0.5e-3, -1e-3, 2, 3).finished()));
}

TEST_F(UserModesFile, IsNumPysArrays) {
  path = fmt::format("{}/mimbre-user-modes-{}.npz", testing::TempDir(), getpid());
  using Integers = std::vector<std::int64_t>;
  const auto label = array("label", "<i8", "(3,)", Integers{9, 7, 7}),
             direction = array("direction", "<i8", "(3,)", Integers{3, 1, 6});
  const std::vector<double> rows{1, 2, 3, 4, 5, 6};
  const MatrixXd expected = (MatrixXd(3, 2) << 1, 2, 3, 4, 5, 6).finished();
  for (const bool by_columns : {false, true}) {
    const std::vector<double> values = by_columns ? std::vector<double>{1, 3, 5, 2, 4, 6} : rows;
    const fe::UserModes m =
        read(zip({label, direction, array("shapes", "<f8", "(3, 2)", values, by_columns)}));
    EXPECT_EQ(m.shapes, expected);
    ASSERT_EQ(m.dofs.size(), 3U);
    EXPECT_EQ(m.dofs[0].node, 1);
    EXPECT_EQ(m.dofs[2].direction, 5);
  }
  EXPECT_EQ(read(zip({label, direction, array("shapes", "<f8", "(3,)", std::vector<double>{1, 2, 3})}))
                .shapes.cols(),
            1);
  const auto shapes = array("shapes", "<f8", "(3, 2)", rows);
  EXPECT_THAT(error(zip({label, shapes})), HasSubstr("no array 'direction'"));
  EXPECT_THAT(error(zip({label, array("direction", "<i8", "(3,)", Integers{3, 0, 1}), shapes})),
              HasSubstr("the direction 0"));
  EXPECT_THAT(error(zip({array("label", "<i8", "(3,)", Integers{9, 9, 7}),
                         array("direction", "<i8", "(3,)", Integers{3, 3, 1}), shapes})),
              HasSubstr("twice"));
  EXPECT_THAT(error(zip({array("label", "<i8", "(2,)", Integers{9, 7}), direction, shapes})),
              HasSubstr("2 labels, 3 directions and 3 x 2"));
  EXPECT_THAT(error(zip({label, direction, array("shapes", "<f8", "(3, 2, 1)", rows)})),
              HasSubstr("no table"));
}

TEST_F(UserModesFile, RubbishGetsClearErrors) {
  EXPECT_THAT(error(""), HasSubstr("has no modes"));
  EXPECT_THAT(error("label,direction,mode\n"), HasSubstr("has no modes"));
  EXPECT_THAT(error("7,x,1\n7,q,1\n"), HasSubstr("'7,q,1' is no row of modes"));
  EXPECT_THAT(error("7,x\n"), HasSubstr("is no row of modes"));
  EXPECT_THAT(error("7,x,1\n8,x,1\n"), HasSubstr("node 8 is not there"));
  EXPECT_THAT(error("7,x,1\n7,1,1\n"), HasSubstr("twice"));
  EXPECT_THAT(error("7,x,1,2\n9,x,1\n"), HasSubstr("has 1 displacements where the rows before have 2"));
  EXPECT_THAT(error("7,x,nan\n"), HasSubstr("'nan' is no number"));
  EXPECT_THAT(error("7,x,0\n"), HasSubstr("mode 1 moves nothing"));
  EXPECT_THROW(fe::read_user_modes("/nowhere/modes.csv", mesh), InputError);
  path = fmt::format("{}/mimbre-user-modes-{}.npz", testing::TempDir(), getpid());
  EXPECT_NE(error("this is no archive"), "read");
}

}  // namespace
}  // namespace mimbre::test::further_modes_test

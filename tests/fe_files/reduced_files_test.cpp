#include "fe_files/bodies/reduced_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <functional>
#include <random>

#include "fe_files/bodies/sid_file.h"
#include "fe_files/fe_files.h"
#include "reduction/shape_integrals.h"

namespace mimbre::fe::reduced_files_test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// A body of points with masses and modes of their own, so that every integral is a sum.
struct Cloud {
  static constexpr int modes = 4;
  std::vector<double> masses;
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Matrix3Xd> shapes;
  ReducedBody body;

  Cloud() {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto matrix = [&](int rows, int columns) -> Eigen::MatrixXd {
      return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return uniform(random); });
    };
    body.name = "cloud";
    body.modes = modes;
    clear_shape_integrals(body, modes);
    body.mass_matrix = Eigen::MatrixXd::Zero(modes, modes);
    for (int i = 0; i < 9; ++i) {
      masses.push_back(1.5 + uniform(random));
      positions.push_back(matrix(3, 1));
      shapes.push_back(matrix(3, modes));
      add_mass_point(body, masses.back(), positions.back(), shapes.back());
      body.mass_matrix += masses.back() * shapes.back().transpose() * shapes.back();
      if (i % 3 > 0) continue;
      BodyFrame frame{"node " + std::to_string(10 + i), positions.back(), Eigen::Matrix3d::Identity(),
                      shapes.back(), matrix(3, modes)};
      body.frames.push_back(frame);
    }
    complete_shape_integrals(body);
    const Eigen::MatrixXd K = matrix(modes, modes), C = matrix(modes, modes);
    body.stiffness = 1e4 * K * K.transpose();
    body.damping = C * C.transpose();
    body.user_from_modal = Eigen::MatrixXd::Identity(modes, modes);
    for (int m = 0; m < modes; ++m) body.mode_names.push_back("mode " + std::to_string(m + 1));
    body.nodes.resize(3, static_cast<Eigen::Index>(body.frames.size()));
    body.node_shapes.resize(3 * body.nodes.cols(), modes);
    for (std::size_t i = 0; i < body.frames.size(); ++i) {
      body.nodes.col(static_cast<Eigen::Index>(i)) = body.frames[i].position;
      body.node_shapes.middleRows<3>(3 * static_cast<Eigen::Index>(i)) = body.frames[i].X;
    }
  }

  using Term =
      std::function<Eigen::MatrixXd(const Eigen::Vector3d&, const Eigen::Vector3d&, const Eigen::Vector3d&)>;
  /// Σ m f(u, φ_a, φ_b)
  Eigen::MatrixXd sum(int a, int b, const Term& term) const {
    Eigen::MatrixXd result = masses[0] * term(positions[0], shapes[0].col(a), shapes[0].col(b));
    for (std::size_t i = 1; i < masses.size(); ++i)
      result += masses[i] * term(positions[i], shapes[i].col(a), shapes[i].col(b));
    return result;
  }
};

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d result;
  result << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return result;
}

void expect_near(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, const char* what) {
  ASSERT_EQ(a.rows(), b.rows()) << what;
  ASSERT_EQ(a.cols(), b.cols()) << what;
  if (a.size() == 0) return;
  EXPECT_LE((a - b).cwiseAbs().maxCoeff(), 1e-12 * std::max(1.0, b.cwiseAbs().maxCoeff())) << what;
}

void expect_same(const ReducedBody& a, const ReducedBody& b, bool rotations) {
  EXPECT_NEAR(a.mass, b.mass, 1e-12);
  expect_near(a.first_moment, b.first_moment, "first_moment");
  expect_near(a.second_moment, b.second_moment, "second_moment");
  expect_near(a.S, b.S, "S");
  for (std::size_t i = 0; i < 3; ++i) {
    expect_near(a.S_position[i], b.S_position[i], "S_position");
    for (std::size_t j = 0; j < 3; ++j) expect_near(a.S_modes[i][j], b.S_modes[i][j], "S_modes");
  }
  expect_near(a.mass_matrix, b.mass_matrix, "mass_matrix");
  expect_near(a.stiffness, b.stiffness, "stiffness");
  expect_near(a.damping, b.damping, "damping");
  expect_near(a.nodes, b.nodes, "nodes");
  expect_near(a.node_shapes, b.node_shapes, "node_shapes");
  EXPECT_EQ(a.mode_names, b.mode_names);
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.frames[i].name, b.frames[i].name);
    expect_near(a.frames[i].position, b.frames[i].position, "frame position");
    expect_near(a.frames[i].X, b.frames[i].X, "frame X");
    expect_near(a.frames[i].X_theta, b.frames[i].X_theta, "frame X_theta");
    if (rotations) expect_near(a.frames[i].rotation, b.frames[i].rotation, "frame rotation");
  }
}

/// The numbers of a record group.
std::vector<double> group(const std::string& text, int number) {
  const std::string head = "** RECORD GROUP " + std::to_string(number) + ",";
  std::istringstream stream(text.substr(text.find('\n', text.find(head)) + 1));
  std::vector<double> values;
  double value = 0;
  while (stream >> value) values.push_back(value);
  return values;
}

std::string text_of(const std::string& path) {
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(MbdynFem, WrittenAndReadIsTheSameBody) {
  const Cloud cloud;
  Folder folder;
  write_mbdyn_fem(cloud.body, folder.path("a.fem"));
  const ImportedBody read = read_mbdyn_fem(folder.path("a.fem"));
  EXPECT_THAT(read.warnings, IsEmpty());
  expect_same(read.body, cloud.body, true);
}

TEST(MbdynFem, InvariantsAreSumsOverThePoints) {
  const Cloud cloud;
  const int n = Cloud::modes;
  Folder folder;
  write_mbdyn_fem(cloud.body, folder.path("a.fem"));
  const std::string text = text_of(folder.path("a.fem"));
  const auto I4 = group(text, 15), I8 = group(text, 16), I5 = group(text, 17), I9 = group(text, 18);
  const auto at = [](const std::vector<double>& values, int row, int columns, int column) {
    return values[static_cast<std::size_t>(row * columns + column)];
  };
  using V = Eigen::Vector3d;
  for (int j = 0; j < n; ++j) {
    const V i4 = cloud.sum(j, j, [](const V& u, const V& a, const V&) -> V { return u.cross(a); });
    const Eigen::Matrix3d i8 = cloud.sum(
        j, j, [](const V& u, const V& a, const V&) -> Eigen::Matrix3d { return -skew(u) * skew(a); });
    for (int r = 0; r < 3; ++r) {
      EXPECT_NEAR(at(I4, r, n, j), i4(r), 1e-13);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(at(I8, r, 3 * n, 3 * j + c), i8(r, c), 1e-13);
    }
    for (int k = 0; k < n; ++k) {
      const V i5 = cloud.sum(j, k, [](const V&, const V& a, const V& b) -> V { return a.cross(b); });
      const Eigen::Matrix3d i9 = cloud.sum(
          j, k, [](const V&, const V& a, const V& b) -> Eigen::Matrix3d { return skew(a) * skew(b); });
      for (int r = 0; r < 3; ++r) {
        EXPECT_NEAR(at(I5, r, n * n, j * n + k), i5(r), 1e-13);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(at(I9, r, 3 * n * n, 3 * (j * n + k) + c), i9(r, c), 1e-13);
      }
    }
  }
}

TEST(MbdynFem, ReadsLumpedMassesAsWell) {
  // Two masses on a weightless rod along y, of which one mode bends the ends up, another twists the first.
  const std::string head =
      "** MBDyn MODAL DATA FILE\n** RECORD GROUP 1, HEADER\n** REVISION, ...\n REV0 2 2 0 0 0\n"
      "** RECORD GROUP 2, FINITE ELEMENT NODE LIST\n 1001 tip\n** RECORD GROUP 5, NODAL X COORDINATES\n0\n0\n"
      "** RECORD GROUP 6, NODAL Y COORDINATES\n-2.\n1\n** RECORD GROUP 7, NODAL Z COORDINATES\n0\n0\n"
      "** RECORD GROUP 8, MODE SHAPES\n** NORMAL MODE SHAPE # 1\n0 0 1 0 0 0\n0 0 1 0 0 0\n"
      "** NORMAL MODE SHAPE # 2\n0 0 0 0 1 0\n0 0 0 0 0 0\n"
      "** RECORD GROUP 9, MODAL MASS MATRIX\n0 0\n0 0\n** RECORD GROUP 10, MODAL STIFFNESS MATRIX\n1 0\n0 "
      "1D+2\n";
  TextFile file(head + "** RECORD GROUP 11, DIAGONAL OF LUMPED MASS MATRIX\n3 3 3 .1 .2 .3\n5 5 5 0 0 0\n",
                "a.fem");
  const ImportedBody read = parse_mbdyn_fem(file);
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_THAT(read.warnings[0].message, HasSubstr("the modal mass is that of the lumped masses"));
  const ReducedBody& body = read.body;
  EXPECT_EQ(body.mass, 8);
  EXPECT_EQ(body.first_moment, Eigen::Vector3d(0, -1, 0));
  EXPECT_EQ(body.S(2, 0), 8);
  EXPECT_NEAR(body.mass_matrix(0, 0), 8, 1e-14);
  EXPECT_NEAR(body.mass_matrix(1, 1), 0.2, 1e-14);
  // ∫ r̄ × φ: about x, −1·8 for the first, the rotary inertia for the second.
  EXPECT_NEAR(body.S_position[1](2, 0) - body.S_position[2](1, 0), -1, 1e-14);
  EXPECT_NEAR(body.S_position[2](0, 1) - body.S_position[0](2, 1), 0.2, 1e-14);
  EXPECT_EQ(body.frames[0].name, "node 1001");
  EXPECT_EQ(body.frames[1].name, "tip");
}

TEST(MbdynFem, SaysWhatIsWrong) {
  const Cloud cloud;
  Folder folder;
  write_mbdyn_fem(cloud.body, folder.path("a.fem"));
  const std::string good = text_of(folder.path("a.fem"));
  const auto wrong = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return complaint([&] {
      TextFile file(text, "a.fem");
      parse_mbdyn_fem(file);
    });
  };
  EXPECT_THAT(wrong("REV0 3 4", "REV0 4 4"), HasSubstr("record group 2 has 3 nodes, the head has 4"));
  EXPECT_THAT(wrong("REV0 3 4", "REV0 3 999999"), HasSubstr("numbers, "));
  EXPECT_THAT(wrong("REV0 3 4", "REV0 0 0"), HasSubstr("has no nodes"));
  EXPECT_THAT(wrong("** RECORD GROUP 10,", "** RECORD GROUP 9,"), HasSubstr("record group 9 is there twice"));
  EXPECT_THAT(wrong("** RECORD GROUP 10,", "** RECORD GROUP 99,"),
              HasSubstr("record group '99' is not one of 1 to 19"));
  EXPECT_THAT(wrong("** RECORD GROUP 7,", "** GROUP 7,"), HasSubstr("ends without record group 7"));
  EXPECT_THAT(wrong("** RECORD GROUP 12,", "** RECORD GROUP 12,\nnan"),
              HasSubstr("'nan' in record group 12 is no finite number"));
  EXPECT_THAT(wrong(" 10\n 13", " 10\n 10"), HasSubstr("node 10 is there twice"));
  EXPECT_THAT(wrong(good, "binary"), HasSubstr("a.fem:1:1: is no .fem file"));
  EXPECT_THAT(complaint([] { read_mbdyn_fem("/nowhere.fem"); }), HasSubstr("cannot be opened"));
  EXPECT_THROW(write_mbdyn_fem(cloud.body, "/nowhere/a.fem"), std::runtime_error);
}

TEST(ReducedFiles, HaveNoPlaceForAbsoluteNodalCoordinates) {
  ReducedBody body = Cloud().body;
  body.ancf.emplace();
  Folder folder;
  EXPECT_THROW(write_mbdyn_fem(body, folder.path("a.fem")), std::invalid_argument);
  EXPECT_THROW(write_sid(body, folder.path("a.sid")), std::invalid_argument);
}

/// Record group 19 by its index: products of angular velocity, angular acceleration, acceleration.
TEST(MbdynFem, StiffeningHasTheOrderOfTheFormat) {
  ReducedBody body = Cloud().body;
  GeometricStiffness geometric;
  geometric.boundary_loads.resize(0, 4);
  for (int load = 0; load < 12; ++load) {
    geometric.loads.push_back(load);
    geometric.stiffness.push_back((load + 1) * Eigen::MatrixXd::Identity(4, 4));
  }
  geometric.stiffness[3](0, 2) = geometric.stiffness[3](2, 0) = 7;
  body.geometric = geometric;
  Folder folder;
  write_mbdyn_fem(body, folder.path("a.fem"));
  const std::vector<double> values = group(text_of(folder.path("a.fem")), 19);
  ASSERT_EQ(values.size(), 1u + 12 * 17);
  EXPECT_EQ(values[0], 12);
  const double expected[] = {1, 2, 3, 4, 5, 6, 10, 11, 12, 7, 8, 9};
  for (std::size_t k = 0; k < 12; ++k) {
    EXPECT_EQ(values[1 + 17 * k], static_cast<double>(k + 1));
    EXPECT_EQ(values[2 + 17 * k], expected[k]);
  }
  const ImportedBody read = read_mbdyn_fem(folder.path("a.fem"));
  EXPECT_THAT(read.warnings, IsEmpty());
  expect_same(read.body, body, true);
  ASSERT_TRUE(read.body.geometric);
  EXPECT_EQ(read.body.geometric->loads, geometric.loads);
  for (std::size_t l = 0; l < 12; ++l) EXPECT_EQ(read.body.geometric->stiffness[l], geometric.stiffness[l]);

  const std::string good = text_of(folder.path("a.fem"));
  const auto wrong = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from, text.find("RECORD GROUP 19")), from.size(), to);
    return complaint([&] {
      TextFile file(text, "a.fem");
      parse_mbdyn_fem(file);
    });
  };
  EXPECT_THAT(wrong("\n12\n", "\n11\n"), HasSubstr("record group 19 has 205 numbers, 188 are needed"));
  EXPECT_THAT(wrong("\n12\n", "\n1e300\n"), HasSubstr("must begin with the number of its matrices"));
  EXPECT_THAT(wrong("\n1\n", "\n2\n"), HasSubstr("has the index 2 twice"));
  EXPECT_THAT(wrong("\n1\n", "\n31\n"), HasSubstr("has the index 31: 1 to 12"));
  EXPECT_THAT(wrong("\n1\n", "\n1.5\n"), HasSubstr("has the index 1.5"));
  EXPECT_THAT(wrong("\n1\n", "\n0\n"), HasSubstr("has the index 0"));
}

ReducedBody with_axes_and_stress() {
  ReducedBody body = Cloud().body;
  body.frames[1].rotation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  body.mode_names[2] = "static ball.n";
  GeometricStiffness geometric;
  geometric.loads = {1, 3, 8, 10};
  for (int i = 0; i < 4; ++i) {
    const Eigen::MatrixXd A = Eigen::MatrixXd::Random(4, 4);
    geometric.stiffness.push_back(A + A.transpose());
  }
  geometric.boundary_loads.resize(0, 4);
  body.geometric = geometric;
  return body;
}

TEST(Sid, WrittenAndReadIsTheSameBody) {
  const ReducedBody body = with_axes_and_stress();
  Folder folder;
  write_sid(body, folder.path("a.SID_FEM"));
  const ImportedBody read = read_sid(folder.path("a.SID_FEM"));
  EXPECT_THAT(read.warnings, IsEmpty());
  expect_same(read.body, body, true);
  ASSERT_TRUE(read.body.geometric);
  EXPECT_EQ(read.body.geometric->loads, body.geometric->loads);
  for (std::size_t i = 0; i < 4; ++i)
    expect_near(read.body.geometric->stiffness[i], body.geometric->stiffness[i], "geometric");
}

/// Of a mesh beside the frames, of which one is at a point.
ReducedBody with_points() {
  ReducedBody body = Cloud().body;
  body.nodes = Eigen::Matrix3Xd::Random(3, 5);
  body.node_shapes = Eigen::MatrixXd::Random(15, 4);
  body.stress = 1e9 * Eigen::MatrixXd::Random(30, 4);
  body.stress.row(7).setZero();
  body.node_labels = {4, 101, 7, 8, 9};
  body.frames[0].position = body.nodes.col(1);
  body.frames[0].X = body.node_shapes.middleRows<3>(3);
  return body;
}

/// Stress of a point as row, found by its place.
Eigen::MatrixXd stress_at(const ReducedBody& body, const Eigen::Vector3d& place) {
  for (Eigen::Index k = 0; k < body.nodes.cols(); ++k)
    if (body.nodes.col(k) == place) return body.stress.middleRows<6>(6 * k);
  return {};
}

TEST(Sid, HasTheStressOfThePoints) {
  const ReducedBody body = with_points();
  Folder folder;
  write_sid(body, folder.path("a.sid"));
  const ImportedBody read = read_sid(folder.path("a.sid"));
  EXPECT_THAT(read.warnings, IsEmpty());
  ASSERT_EQ(read.body.frames.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.body.frames[i].name, body.frames[i].name);
    EXPECT_EQ(read.body.frames[i].X_theta, body.frames[i].X_theta);
  }
  ASSERT_EQ(read.body.nodes.cols(), 5);
  for (Eigen::Index k = 0; k < 5; ++k)
    EXPECT_EQ(stress_at(read.body, body.nodes.col(k)), (body.stress.middleRows<6>(6 * k))) << k;
  // The point at a frame comes first, by the frame's label.
  EXPECT_EQ(read.body.node_labels, (std::vector<std::int64_t>{10, 4, 7, 8, 9}));
  // From then on nothing changes.
  write_sid(read.body, folder.path("b.sid"));
  const ReducedBody again = read_sid(folder.path("b.sid")).body;
  expect_same(again, read.body, true);
  EXPECT_EQ(again.stress, read.body.stress);
  EXPECT_EQ(again.node_labels, read.body.node_labels);
}

TEST(Sid, NumbersPointsWhoseLabelsWouldBeThereTwice) {
  ReducedBody body = with_points();
  body.node_labels = {13, 13, 7, 8, 9};  // 13 is a frame too
  Folder folder;
  write_sid(body, folder.path("a.sid"));
  EXPECT_EQ(read_sid(folder.path("a.sid")).body.node_labels, (std::vector<std::int64_t>{10, 17, 18, 19, 20}));
  body.frames[2].name = "ball";
  body.node_labels = {4, 101, 7, 8, 9};
  write_sid(body, folder.path("a.sid"));
  const ReducedBody read = read_sid(folder.path("a.sid")).body;
  EXPECT_EQ(read.frames[2].name, "node 12");  // frames have no names there
  EXPECT_EQ(read.node_labels, (std::vector<std::int64_t>{10, 4, 7, 8, 9}));
}

TEST(Sid, SaysThatInitialStressIsLeftOut) {
  Folder folder;
  write_sid(with_points(), folder.path("a.sid"));
  std::string text = text_of(folder.path("a.sid"));
  const auto insert = [&](const std::string& block, const std::string& line) {
    const std::size_t at = text.find("           end " + block + "\n");
    ASSERT_NE(at, std::string::npos);
    text.insert(at, line);
  };
  insert("sigma", "m0( 2, 1) = 5.0D6\n");
  insert("ksigma", "m0( 1, 1) = 3.0\nm1( 1, 2, 1) = 5.0\nm1( 2, 1, 1) = 5.0\n");
  TextFile file(text, "a.sid");
  const ImportedBody read = parse_sid(file);
  ASSERT_EQ(read.warnings.size(), 2u);
  EXPECT_THAT(read.warnings[0].message, HasSubstr("forces of initial stress"));
  EXPECT_THAT(read.warnings[1].message, HasSubstr("initial stress (m0 of sigma) is left out"));
  const ReducedBody body = with_points();
  EXPECT_NEAR(read.body.stiffness(0, 1), body.stiffness(0, 1) + 5, 1e-9);
  EXPECT_NEAR(read.body.stiffness(2, 1), body.stiffness(2, 1), 1e-9);
}

TEST(Sid, BlocksAreSumsOverThePoints) {
  const Cloud cloud;
  Folder folder;
  write_sid(cloud.body, folder.path("a.sid"));
  TextFile file(folder.path("a.sid"));
  const SidFile sid = parse_sid_file(file);
  using V = Eigen::Vector3d;
  const int n = Cloud::modes;
  const Eigen::MatrixXd Cr0 = constant_part(sid.blocks.at("Cr")), Gr0 = constant_part(sid.blocks.at("Gr"));
  const Eigen::MatrixXd Ge0 = constant_part(sid.blocks.at("Ge")), Oe0 = constant_part(sid.blocks.at("Oe"));
  const auto Oe1 = linear_parts(sid.blocks.at("Oe"), sid), Cr1 = linear_parts(sid.blocks.at("Cr"), sid);
  const auto J1 = linear_parts(sid.blocks.at("J"), sid);
  const V w(0.3, -0.8, 0.5);
  Eigen::VectorXd products(6);
  products << w.x() * w.x(), w.y() * w.y(), w.z() * w.z(), w.x() * w.y(), w.y() * w.z(), w.x() * w.z();
  for (int k = 0; k < n; ++k) {
    const V cr = cloud.sum(k, k, [](const V& u, const V& a, const V&) -> V { return u.cross(a); });
    EXPECT_LT((Cr0.row(k).transpose() - cr).norm(), 1e-13);
    const Eigen::Matrix3d gr = cloud.sum(
        k, k, [](const V& u, const V& a, const V&) -> Eigen::Matrix3d { return -2 * skew(u) * skew(a); });
    EXPECT_LT((Gr0.middleCols<3>(3 * k) - gr).norm(), 1e-13);
    using One = Eigen::Matrix<double, 1, 1>;
    const One oe =
        cloud.sum(k, k, [&](const V& u, const V& a, const V&) { return One(a.dot(w.cross(w.cross(u)))); });
    EXPECT_NEAR(Oe0.row(k).dot(products), oe(0), 1e-13);
    const Eigen::Matrix3d j1 = cloud.sum(k, k, [](const V& u, const V& a, const V&) -> Eigen::Matrix3d {
      return -skew(u) * skew(a) - skew(a) * skew(u);
    });
    const Eigen::VectorXd column = J1[static_cast<std::size_t>(k)];
    EXPECT_LT((column -
               (Eigen::VectorXd(6) << j1(0, 0), j1(1, 1), j1(2, 2), j1(0, 1), j1(0, 2), j1(1, 2)).finished())
                  .norm(),
              1e-13);
    // Off the diagonal Oe is −J1, on it half the sum of the others' loss: xx yy zz xy yz xz against xx yy zz
    // xy xz yz.
    EXPECT_NEAR(Oe0(k, 0), -0.5 * column(0), 1e-13);
    EXPECT_NEAR(Oe0(k, 4), -column(5), 1e-13);
    for (int m = 0; m < n; ++m) {
      const V ge = cloud.sum(k, m, [](const V&, const V& a, const V& b) -> V { return 2 * b.cross(a); });
      EXPECT_LT((Ge0.row(k).segment<3>(3 * m).transpose() - ge).norm(), 1e-13);
      EXPECT_LT((Cr1[static_cast<std::size_t>(m)].row(k).transpose() - 0.5 * ge).norm(), 1e-13);
      const One oe1 =
          cloud.sum(k, m, [&](const V&, const V& a, const V& b) { return One(a.dot(w.cross(w.cross(b)))); });
      EXPECT_NEAR(Oe1[static_cast<std::size_t>(m)].row(k).dot(products), oe1(0), 1e-13);
    }
  }
}

/// The same file with what stands from `first` to `last` (line by line) changed.
std::string without(std::string text, const std::string& block) {
  const std::size_t first = text.find("           " + block + "\n"),
                    last = text.find("           end " + block + "\n");
  return text.erase(first, last - first + block.size() + 16);
}

TEST(Sid, FindsTheIntegralsWithoutGr) {
  const Cloud cloud;
  Folder folder;
  write_sid(cloud.body, folder.path("a.sid"));
  TextFile file(without(text_of(folder.path("a.sid")), "Gr"), "a.sid");
  const ImportedBody read = parse_sid(file);
  EXPECT_THAT(read.warnings, IsEmpty());
  expect_same(read.body, cloud.body, true);
  EXPECT_FALSE(read.body.geometric);
}

TEST(Sid, TakesTheOtherOrderOfIndices) {
  const Cloud cloud;
  Folder folder;
  write_sid(cloud.body, folder.path("a.sid"));
  std::istringstream lines(text_of(folder.path("a.sid")));
  std::string swapped;
  for (std::string line; std::getline(lines, line); swapped += line + "\n") {
    int row = 0, mode = 0, column = 0, end = 0;
    if (std::sscanf(line.c_str(), " m1( %d, %d, %d) =%n", &row, &mode, &column, &end) == 3)
      line = fmt::format("   m1( {}, {}, {}) ={}", row, column, mode,
                         line.substr(static_cast<std::size_t>(end)));
  }
  TextFile file(swapped, "a.sid");
  expect_same(parse_sid(file).body, cloud.body, true);
}

TEST(Sid, SaysWhatIsWrong) {
  const Cloud cloud;
  Folder folder;
  write_sid(cloud.body, folder.path("a.sid"));
  const std::string good = text_of(folder.path("a.sid"));
  const auto read = [](const std::string& text) {
    return complaint([&] {
      TextFile file(text, "a.sid");
      parse_sid(file);
    });
  };
  const auto wrong = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return read(text.replace(at, from.size(), to));
  };
  EXPECT_EQ(read(good), "");
  EXPECT_THAT(read("hello\n"), HasSubstr("a.sid:1:1: is no SID file"));
  EXPECT_THAT(read("1 999999999\n"), HasSubstr("is no SID file"));
  EXPECT_THAT(read(good.substr(0, good.size() / 2)), HasSubstr("ends without 'end part'"));
  EXPECT_THAT(wrong(" end part", ""), HasSubstr("ends without 'end part'"));
  EXPECT_THAT(wrong("nelastq = 4", "nelastq = 5"), HasSubstr("nelastq"));
  EXPECT_THAT(wrong("new node = 13", "new node = 10"), HasSubstr("node 10 is there twice"));
  EXPECT_THAT(wrong("    3     4 ", "    2     4 "), HasSubstr("has 3 nodes, its head has 2"));
  EXPECT_THAT(wrong("m0( 1, 1) =", "m0( 9, 1) ="), HasSubstr("outside of 3 x 1"));
  EXPECT_THAT(wrong("m0( 1, 1) =", "m0( 1, 1) = x"), HasSubstr("is no finite number"));
  EXPECT_THAT(wrong("nqn = 0", "nqn = 1"), HasSubstr("terms of higher order (nqn) are not read"));
  EXPECT_THAT(wrong("mass = ", "mass = -"), HasSubstr("mass must be positive"));
  EXPECT_THAT(read(without(good, "Ke")), HasSubstr("has no block Ke"));
  EXPECT_THAT(read(without(good, "psi")), HasSubstr("has no block psi"));
  write_sid(with_points(), folder.path("b.sid"));
  std::string stressed = text_of(folder.path("b.sid"));
  stressed.replace(stressed.find("nrow = 6"), 8, "nrow = 5");
  EXPECT_NE(read(stressed), "");
}

}  // namespace
}  // namespace mimbre::fe::reduced_files_test

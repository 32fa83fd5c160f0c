#include "support/brick_mesh.h"

#include <Eigen/LU>
#include <cmath>

namespace mimbre::test {

BrickMesh random_bricks(Random& random, int x, int y, int z) {
  BrickMesh mesh;
  mesh.density = random.number(50, 80);
  mesh.nodes.resize(3, (x + 1) * (y + 1) * (z + 1));
  const auto node = [&](int i, int j, int k) { return i + (x + 1) * (j + (y + 1) * k); };
  const Vec3d place = random.vector(0.5);
  const Mat3d turn = random.rotation();
  for (int k = 0; k <= z; ++k)
    for (int j = 0; j <= y; ++j)
      for (int i = 0; i <= x; ++i)
        mesh.nodes.col(node(i, j, k)) =
            place + turn * (Vec3d(0.3 * i, 0.2 * j, 0.15 * k) + random.vector(0.03));
  for (int k = 0; k < z; ++k)
    for (int j = 0; j < y; ++j)
      for (int i = 0; i < x; ++i) {
        std::array<int, 8> brick{};
        for (int c = 0; c < 8; ++c)
          brick[static_cast<std::size_t>(c)] = node(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1));
        mesh.bricks.push_back(brick);
      }
  return mesh;
}

void integrate(const BrickMesh& mesh, int points, const AtPoint& at) {
  struct Point {
    double x, weight;
  };
  const std::vector<Point> three{{-std::sqrt(0.6), 5. / 9}, {0, 8. / 9}, {std::sqrt(0.6), 5. / 9}};
  const double a = std::sqrt(3. / 7 - 2. / 7 * std::sqrt(1.2)),
               b = std::sqrt(3. / 7 + 2. / 7 * std::sqrt(1.2)), wa = (18 + std::sqrt(30.)) / 36,
               wb = (18 - std::sqrt(30.)) / 36;
  const std::vector<Point> four{{-b, wb}, {-a, wa}, {a, wa}, {b, wb}};
  const std::vector<Point>& rule = points == 3 ? three : four;
  for (const auto& brick : mesh.bricks)
    for (const Point& p : rule)
      for (const Point& q : rule)
        for (const Point& r : rule) {
          const Vec3d xi(p.x, q.x, r.x);
          Eigen::Matrix<double, 8, 1> N;
          Mat3d jacobian = Mat3d::Zero();
          for (int c = 0; c < 8; ++c) {
            const Vec3d corner(c & 1 ? 1 : -1, c >> 1 & 1 ? 1 : -1, c >> 2 & 1 ? 1 : -1);
            const Vec3d f = 0.5 * (Vec3d::Ones() + corner.cwiseProduct(xi));
            N[c] = f.prod();
            for (int i = 0; i < 3; ++i)
              jacobian.col(i) += mesh.nodes.col(brick[static_cast<std::size_t>(c)]) * 0.5 * corner[i] *
                                 f[(i + 1) % 3] * f[(i + 2) % 3];
          }
          at(brick, N, mesh.density * p.weight * q.weight * r.weight * jacobian.determinant());
        }
}

Eigen::SparseMatrix<double> nodal_mass(const BrickMesh& mesh) {
  std::vector<Eigen::Triplet<double>> entries;
  integrate(mesh, 3, [&](const auto& brick, const auto& N, double dm) {
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 8; ++j)
        entries.emplace_back(brick[static_cast<std::size_t>(i)], brick[static_cast<std::size_t>(j)],
                             dm * N[i] * N[j]);
  });
  Eigen::SparseMatrix<double> mass(mesh.nodes.cols(), mesh.nodes.cols());
  mass.setFromTriplets(entries.begin(), entries.end());
  return Eigen::SparseMatrix<double>(0.5 * (mass + Eigen::SparseMatrix<double>(mass.transpose())));
}

Eigen::SparseMatrix<double> translational_mass(const Eigen::SparseMatrix<double>& nodal) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = 0; c < nodal.outerSize(); ++c)
    for (Eigen::SparseMatrix<double>::InnerIterator it(nodal, c); it; ++it)
      for (int k = 0; k < 3; ++k)
        entries.emplace_back(static_cast<int>(3 * it.row() + k), 3 * c + k, it.value());
  Eigen::SparseMatrix<double> mass(3 * nodal.rows(), 3 * nodal.cols());
  mass.setFromTriplets(entries.begin(), entries.end());
  return mass;
}

ReducedBody random_brick_body(Random& random, const BrickMesh& mesh, int modes) {
  ReducedBody b;
  b.name = "bricks";
  b.modes = modes;
  b.mode_names.assign(static_cast<std::size_t>(modes), "random");
  b.nodes = mesh.nodes;
  b.node_shapes.resize(3 * mesh.nodes.cols(), modes);
  for (int m = 0; m < modes; ++m)
    b.node_shapes.col(m) = random.values(static_cast<int>(b.node_shapes.rows()), 0.5);

  b.S.setZero(3, modes);
  for (auto& s : b.S_position) s.setZero(3, modes);
  for (auto& row : b.S_modes)
    for (auto& s : row) s.setZero(modes, modes);
  integrate(mesh, 4, [&](const auto& brick, const auto& N, double dm) {
    Vec3d r = Vec3d::Zero();
    Eigen::Matrix3Xd X = Eigen::Matrix3Xd::Zero(3, modes);
    for (int c = 0; c < 8; ++c) {
      const int node = brick[static_cast<std::size_t>(c)];
      r += N[c] * mesh.nodes.col(node);
      X += N[c] * b.node_shapes.middleRows<3>(3 * node);
    }
    b.mass += dm;
    b.first_moment += dm * r;
    b.second_moment += dm * r * r.transpose();
    b.S += dm * X;
    for (std::size_t i = 0; i < 3; ++i) {
      b.S_position[i] += dm * r[static_cast<int>(i)] * X;
      for (std::size_t j = 0; j < 3; ++j)
        b.S_modes[i][j] += dm * X.row(static_cast<int>(i)).transpose() * X.row(static_cast<int>(j));
    }
  });
  b.mass_matrix = b.S_modes[0][0] + b.S_modes[1][1] + b.S_modes[2][2];
  b.mass_matrix = (0.5 * (b.mass_matrix + b.mass_matrix.transpose())).eval();
  MatrixXd root(modes, modes);
  for (int m = 0; m < modes; ++m) root.col(m) = random.values(modes, 30);
  b.stiffness = root * root.transpose() + 100 * MatrixXd::Identity(modes, modes);
  b.damping = 0.01 * b.stiffness;
  b.user_from_modal.setIdentity(modes, modes);
  BodyFrame frame;
  frame.name = "origin";
  frame.X.setZero(3, modes);
  frame.X_theta.setZero(3, modes);
  b.frames.push_back(frame);
  b.mesh_inertia = MeshInertia{3, translational_mass(nodal_mass(mesh)), b.node_shapes, {}};
  return b;
}

std::shared_ptr<const Model> floating_model(const ReducedBody& body) {
  spec::Model m;
  m.bodies.emplace_back();
  m.bodies.back().name = "body";
  m.bodies.back().flexible = std::make_shared<const ReducedBody>(body);
  m.frames.resize(2);
  m.frames[0].name = "ground";
  m.frames[1].name = "body";
  m.frames[1].body = 0;
  m.joints.emplace_back();
  m.joints.back().name = "floating";
  m.joints.back().type = spec::JointType::floating;
  m.joints.back().frame_a = 0;
  m.joints.back().frame_b = 1;
  return Model::compile(m);
}

}  // namespace mimbre::test

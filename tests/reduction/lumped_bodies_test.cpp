#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <random>

#include "fe/bar_ends.h"
#include "fe/elements/beam_element.h"
#include "fe/meshes.h"
#include "fe/solid_meshes.h"
#include "math/cross_matrix.h"
#include "mimbre/beam_reduction.h"
#include "mimbre/fe_reduce.h"

/// Reduced bodies with masses lumped at the nodes: their integrals against sums over the nodes.
namespace mimbre::test::lumped_bodies_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

VectorXd random(Eigen::Index size, unsigned seed) {
  std::mt19937 generator(seed);
  VectorXd v(size);
  for (double& x : v) x = generator() / 2147483648.0 - 1.0;
  return v;
}

/// Kinetic energy of the undeformed body by what it stores: velocity and angular velocity of the frame, rates
/// of the modes.
double energy(const ReducedBody& b, const Vector3d& v, const Vector3d& w, const VectorXd& rates) {
  const Matrix3d inertia = b.second_moment.trace() * Matrix3d::Identity() - b.second_moment;
  Matrix3Xd turning(3, b.modes);
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>((k + 1) % 3), j = static_cast<std::size_t>((k + 2) % 3);
    turning.row(k) = b.S_position[i].row(static_cast<int>(j)) - b.S_position[j].row(static_cast<int>(i));
  }
  return 0.5 * b.mass * v.squaredNorm() + v.dot(w.cross(b.first_moment)) + 0.5 * w.dot(inertia * w) +
         v.dot(b.S * rates) + w.dot(turning * rates) + 0.5 * rates.dot(b.mass_matrix * rates);
}

/// ∫ (r̄ + X y)(r̄ + X y)ᵀ dm by what the body stores.
Matrix3d second_moment(const ReducedBody& b, const VectorXd& y) {
  Matrix3d P = b.second_moment;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      P(i, j) += b.S_position[static_cast<std::size_t>(i)].row(j).dot(y) +
                 b.S_position[static_cast<std::size_t>(j)].row(i).dot(y) +
                 y.dot(b.S_modes[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] * y);
  return P;
}

/// A stiff part at an end of a beam: its place and inertia are stated here once more.
struct Part {
  Vector3d place;
  double mass;
  Matrix3d second;  ///< ∫ d dᵀ dm
  Matrix3d twist;   ///< further inertia against turning
  Matrix3Xd move, turn;
};

std::vector<Part> parts_of(const fe::Mesh& mesh, const ReducedBody& body) {
  std::vector<Part> parts;
  for (int e = 0; e < static_cast<int>(mesh.elements.size()); ++e) {
    const fe::BeamElement& beam = mesh.elements[static_cast<std::size_t>(e)];
    const fe::ElementGeometry geometry = fe::element_geometry(mesh, e);
    const double half = 0.5 * beam.material.density * geometry.length;
    const double L = geometry.length;
    const Vector3d axis = geometry.axes.col(0);
    for (std::size_t end = 0; end < 2; ++end) {
      const int node = beam.nodes[end];
      const MatrixXd dofs = body.mesh_inertia->shapes.middleRows<6>(6 * node);
      Part part;
      part.place = mesh.nodes.col(node) + beam.offsets[end];
      part.mass = half * beam.section.area;
      part.second = part.mass * L * L / 39 * axis * axis.transpose();
      part.twist.setZero();
      if (beam.theory == fe::BeamTheory::euler_bernoulli)
        part.twist = half * (beam.section.Iy + beam.section.Iz) * axis * axis.transpose();
      else
        part.second += half * geometry.axes * Vector3d(0, beam.section.Iz, beam.section.Iy).asDiagonal() *
                       geometry.axes.transpose();
      part.turn = dofs.bottomRows(3);
      part.move = dofs.topRows(3) - cross_matrix(beam.offsets[end]) * part.turn;
      parts.push_back(part);
    }
  }
  return parts;
}

double energy(const std::vector<Part>& parts, const Vector3d& v, const Vector3d& w, const VectorXd& rates) {
  double sum = 0;
  for (const Part& p : parts) {
    const Vector3d speed = v + w.cross(p.place) + p.move * rates, spin = w + p.turn * rates;
    const Matrix3d inertia = p.second.trace() * Matrix3d::Identity() - p.second + p.twist;
    sum += 0.5 * p.mass * speed.squaredNorm() + 0.5 * spin.dot(inertia * spin);
  }
  return sum;
}

ReducedBody lumped_frame(fe::Mesh& mesh, fe::BeamTheory theory) {
  mesh = bent_frame();
  for (fe::BeamElement& element : mesh.elements) {
    element.theory = theory;
    element.section.shear_y = element.section.shear_z = 0.85 * element.section.area;
  }
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  for (int k = 0; k < 6; ++k) options.boundary.push_back({2, k > 2, Vector3d::Unit(k % 3), ""});
  for (int k = 0; k < 6; ++k) options.boundary[static_cast<std::size_t>(k)].name = std::to_string(k);
  options.dynamic_modes = 5;
  options.mass_matrix = fe::MassMatrix::lumped;
  return fe::reduce(mesh, options, {{"tip", 2, Matrix3d::Identity()}});
}

TEST(LumpedBodies, HaveTheKineticEnergyOfTheirNodes) {
  for (const fe::BeamTheory theory :
       {fe::BeamTheory::euler_bernoulli, fe::BeamTheory::rayleigh, fe::BeamTheory::timoshenko}) {
    fe::Mesh mesh;
    const ReducedBody body = lumped_frame(mesh, theory);
    EXPECT_THAT(check(body), testing::IsEmpty());
    const std::vector<Part> parts = parts_of(mesh, body);
    for (unsigned seed = 1; seed < 5; ++seed) {
      const VectorXd x = random(6 + body.modes, seed);
      const double exact = energy(parts, x.head<3>(), x.segment<3>(3), x.tail(body.modes));
      EXPECT_NEAR(energy(body, x.head<3>(), x.segment<3>(3), x.tail(body.modes)), exact, 1e-9 * exact);
    }
  }
}

/// Where the body is deformed, its points and its turned parts have moved: exact to the second order.
TEST(LumpedBodies, HaveTheSecondMomentOfTheirNodesWhenDeformed) {
  fe::Mesh mesh;
  const ReducedBody body = lumped_frame(mesh, fe::BeamTheory::timoshenko);
  const std::vector<Part> parts = parts_of(mesh, body);
  const auto error = [&](double size) {
    const VectorXd y = size * random(body.modes, 3);
    Matrix3d exact = Matrix3d::Zero();
    for (const Part& p : parts) {
      const Vector3d place = p.place + p.move * y, turn = p.turn * y;
      const Matrix3d R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
      exact += p.mass * place * place.transpose() + R * p.second * R.transpose();
    }
    return (second_moment(body, y) - exact).norm();
  };
  const double coarse = error(0.02), fine = error(0.01);
  EXPECT_GT(coarse, 0);
  EXPECT_NEAR(std::log2(coarse / fine), 3, 0.2);
}

/// Displacements that are quadratic in the amplitudes are those of the nodes, too.
TEST(LumpedBodies, OfForeshorteningAreSumsOverNodes) {
  const fe::Mesh mesh = straight_beam(1, 6, rectangle(0.02, 0.03));
  fe::ReductionOptions options;
  options.clamped_nodes = {0};
  for (int k = 0; k < 6; ++k)
    options.boundary.push_back({1, k > 2, Vector3d::Unit(k % 3), std::to_string(k)});
  options.dynamic_modes = 2;
  options.stiffening = fe::Stiffening::foreshortening;
  options.mass_matrix = fe::MassMatrix::lumped;
  const ReducedBody body = fe::reduce(mesh, options, {});
  EXPECT_THAT(check(body), testing::IsEmpty());
  const SecondOrder& second = *body.second_order;
  const VectorXd masses = MatrixXd(body.mesh_inertia->nodal_mass).diagonal();
  EXPECT_NEAR(masses.sum(), body.mass, 1e-12 * body.mass);
  const Eigen::Index products = static_cast<Eigen::Index>(second.products.size());
  MatrixXd S = MatrixXd::Zero(3, second.S.cols()), mass = MatrixXd::Zero(products, products);
  for (Eigen::Index node = 0; node < masses.size(); ++node) {
    const MatrixXd X = second.node_shapes.middleRows<3>(3 * node);
    S += masses[node] * X;
    mass += masses[node] * X.rightCols(products).transpose() * X.rightCols(products);
  }
  EXPECT_LT((second.S - S).norm(), 1e-10 * S.norm());
  EXPECT_LT((second.mass_matrix.bottomRightCorner(products, products) - mass).norm(), 1e-10 * mass.norm());
}

/// Stress by rotation and by weight along the bar stiffens its bending as that of consistent masses does,
/// with order 2.
TEST(LumpedBodies, StiffenGeometricallyLikeConsistentOnes) {
  const auto stiffness = [](int elements, fe::MassMatrix mass_matrix, int load) {
    fe::ReductionOptions options;
    options.clamped_nodes = {0};
    options.boundary = {{1, false, Vector3d::UnitY(), "tip"}};
    options.stiffening = fe::Stiffening::geometric_stiffness;
    options.mass_matrix = mass_matrix;
    const ReducedBody body = fe::reduce(straight_beam(1, elements, rectangle(0.02, 0.03)), options, {});
    const GeometricStiffness& geometric = *body.geometric;
    for (std::size_t k = 0; k < geometric.loads.size(); ++k)
      if (geometric.loads[k] == load)
        return geometric.stiffness[k](0, 0) / std::pow(body.user_from_modal(0, 0), 2);
    ADD_FAILURE() << "no load " << load;
    return 0.0;
  };
  for (const int load : {GeometricStiffness::angular_velocity + 2, GeometricStiffness::acceleration + 0}) {
    const auto error = [&](int n) {
      return std::abs(
          stiffness(n, fe::MassMatrix::lumped, load) / stiffness(n, fe::MassMatrix::consistent, load) - 1);
    };
    EXPECT_LT(error(10), 0.02) << load;
    EXPECT_NEAR(std::log2(error(10) / error(20)), 2, 0.1) << load;
  }
}

/// Solids, beams and a mass off its node in one body: energy of the lumps, by the mesh's own matrix.
TEST(LumpedBodies, OfMeshesHaveTheEnergyOfTheMatrix) {
  fe::SolidMesh mesh = block(fe::ElementType::hex20, {1, 0.1, 0.06}, {6, 1, 1}, steel());
  fe::ModelReduction options;
  options.interfaces = {end(mesh, "root", 0), end(mesh, "tip", 1)};
  options.mass_matrix = fe::MassMatrix::lumped;
  options.dynamic_modes = 4;
  options.frame = fe::ModelReduction::Frame::mean_axis;
  for (const bool mixed : {false, true}) {
    if (mixed) {
      const auto at = static_cast<int>(mesh.nodes.cols());
      const int from = options.interfaces[1].nodes.front();
      mesh.nodes.conservativeResize(3, at + 1);
      mesh.nodes.col(at) = mesh.nodes.col(from) + Vector3d(0.2, 0.05, 0.1);
      fe::Mesh bars;
      bars.nodes = mesh.nodes;
      add_bar(bars, from, at, 1, rectangle(0.02, 0.01));
      mesh.beams = bars.elements;
      fe::PointMass point;
      point.node = at;
      point.mass = 0.4;
      point.inertia = Vector3d(0.002, 0.003, 0.004).asDiagonal();
      point.offset = {0.01, 0.02, -0.03};
      mesh.point_masses = {point};
    }
    const fe::FeMatrices consistent = fe::assemble(mesh);
    const fe::ReductionResult result = fe::reduce(mesh, consistent, options);
    EXPECT_THAT(check(result.body), testing::IsEmpty());
    // Momenta of the modes vanish in the mean, by the lumped masses.
    EXPECT_LT(result.body.S.norm(), 1e-6 * std::sqrt(result.body.mass));
    const fe::FeMatrices lumped = fe::lump_masses(mesh, consistent);
    MatrixXd R = MatrixXd::Zero(lumped.mass.rows(), 6);
    for (Eigen::Index r = 0; r < R.rows(); ++r) {
      const fe::Dof& dof = lumped.dofs[static_cast<std::size_t>(r)];
      R(r, dof.direction) = 1;
      if (dof.direction < 3)
        for (int k = 0; k < 3; ++k)
          R(r, 3 + k) = Vector3d(Vector3d::Unit(k)).cross(Vector3d(mesh.nodes.col(dof.node)))[dof.direction];
    }
    const VectorXd x = random(6, 2);
    const double exact = 0.5 * x.dot(R.transpose() * full(lumped.mass) * R * x);
    // Slender beams twist by the matrix alone, as consistent ones do.
    EXPECT_NEAR(energy(result.body, x.head<3>(), x.tail<3>(), VectorXd::Zero(result.body.modes)), exact,
                (mixed ? 1e-5 : 1e-10) * exact);
  }
}

/// The more elements, the nearer to the body of consistent masses, with order 2.
TEST(LumpedBodies, ConvergeToTheConsistentOnes) {
  const auto frequencies = [](int n, fe::MassMatrix mass_matrix) {
    const fe::SolidMesh mesh = block(fe::ElementType::hex8, {1, 0.1, 0.06}, {n, n / 4, n / 4}, steel());
    fe::ModelReduction options;
    options.interfaces = {end(mesh, "root", 0), end(mesh, "tip", 1)};
    options.mass_matrix = mass_matrix;
    options.dynamic_modes = 4;
    options.free_modes = 0;
    return VectorXd(fe::reduce(mesh, fe::assemble(mesh), options).fixed_frequencies);
  };
  const auto difference = [&](int n) {
    return VectorXd(1 - frequencies(n, fe::MassMatrix::lumped).array() /
                            frequencies(n, fe::MassMatrix::consistent).array());
  };
  const VectorXd coarse = difference(8), fine = difference(16);
  for (int k = 0; k < 4; ++k) {
    EXPECT_GT(fine[k], 0);
    EXPECT_NEAR(std::log2(coarse[k] / fine[k]), 2, 0.25) << k;
  }
}

}  // namespace
}  // namespace mimbre::test::lumped_bodies_test

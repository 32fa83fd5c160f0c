#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <complex>
#include <iostream>
#include <map>
#include <numbers>

#include "fe/solid_meshes.h"
#include "math/once/decompositions.h"
#include "mimbre/fe_reduce.h"
#include "reduction/bases/rigid_shapes.h"
#include "reduction/tied_model.h"

/// Bases of the reduction of finite-element models, against the full model.
namespace mimbre::test::model_bases_test {
namespace {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using fe::Interface;
using fe::ModelReduction;
using Basis = ModelReduction::Basis;

const fe::Material steel{2.1e11, 0.3, 7850};
constexpr double two_pi = 2 * std::numbers::pi;

/// An arm that turns off, so that bending and torsion couple, with interfaces at its ends.
struct Part {
  fe::SolidMesh mesh;
  fe::FeMatrices matrices;
  ModelReduction options;
};
Part arm() {
  Part p;
  p.mesh = block(fe::ElementType::hex8, {1, 0.1, 0.06}, {8, 1, 1}, steel);
  p.options.interfaces.resize(2);
  const std::array<double, 2> ends{0, 1};
  for (std::size_t i = 0; i < 2; ++i) {
    Interface& interface = p.options.interfaces[i];
    interface.name = i == 0 ? "root" : "tip";
    interface.tie = i == 0 ? Interface::Tie::rigid : Interface::Tie::mean;
    for (int k = 0; k < p.mesh.nodes.cols(); ++k)
      if (std::abs(p.mesh.nodes(0, k) - ends[i]) < 1e-9) interface.nodes.push_back(k);
  }
  for (auto column : p.mesh.nodes.colwise()) column.y() += 0.3 * column.x() * column.x();
  for (Interface& interface : p.options.interfaces) interface.point = fe::centre_of(p.mesh, interface.nodes);
  p.matrices = fe::assemble(p.mesh);
  p.options.free_modes = 0;
  return p;
}

/// The full model with its interfaces tied, dense: x, then the interfaces' z.
struct Full {
  MatrixXd K, M;
};
Full full_model(const Part& p) {
  const fe::TiedModel tied(p.mesh, p.matrices, p.options.interfaces);
  const Eigen::Index n = tied.internals(), b = tied.boundaries();
  MatrixXd x = MatrixXd::Zero(n, n + b), z = MatrixXd::Zero(b, n + b);
  x.leftCols(n).setIdentity();
  z.rightCols(b).setIdentity();
  const MatrixXd T = tied.expand(x, z);
  return {T.transpose() * full(p.matrices.stiffness) * T, T.transpose() * full(p.matrices.mass) * T};
}

constexpr double loss = 0.02;  // of the stiffness, so that resonances are finite

/// Motion of the interfaces' points by forces and moments at them, free body.
MatrixXcd response(const Full& f, double hertz, double damping = loss) {
  const std::complex<double> one(1, damping);
  const MatrixXcd D = one * f.K.cast<std::complex<double>>() - std::pow(two_pi * hertz, 2) * f.M;
  const Eigen::Index n = f.K.rows();
  return solve(D, MatrixXd::Identity(n, n).rightCols(12)).bottomRows(12);
}

/// The same of a reduced body, by nothing but what it stores.
MatrixXcd response(const ReducedBody& b, double hertz, double damping = loss) {
  const int n = b.modes;
  MatrixXd M = MatrixXd::Zero(6 + n, 6 + n), K = MatrixXd::Zero(6 + n, 6 + n);
  K.bottomRightCorner(n, n) = b.stiffness;
  M.bottomRightCorner(n, n) = b.mass_matrix;
  M.topLeftCorner(3, 3) = b.mass * MatrixXd::Identity(3, 3);
  M.block(3, 3, 3, 3) = b.second_moment.trace() * MatrixXd::Identity(3, 3) - b.second_moment;
  for (int k = 0; k < 3; ++k) {
    M.block(0, 3 + k, 3, 1) = Vector3d(Vector3d::Unit(k)).cross(b.first_moment);
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    M.block(3 + k, 6, 1, n) =
        b.S_position[static_cast<std::size_t>(i)].row(j) - b.S_position[static_cast<std::size_t>(j)].row(i);
  }
  M.block(0, 6, 3, n) = b.S;
  M = MatrixXd(M.selfadjointView<Eigen::Upper>());
  MatrixXd P = MatrixXd::Zero(12, 6 + n);
  for (int f = 0; f < 2; ++f) {
    const BodyFrame& frame = b.frames[static_cast<std::size_t>(f)];
    P.block(6 * f, 0, 6, 6).setIdentity();
    for (int k = 0; k < 3; ++k)
      P.block(6 * f, 3 + k, 3, 1) = Vector3d(Vector3d::Unit(k)).cross(frame.position);
    P.block(6 * f, 6, 3, n) = frame.X;
    P.block(6 * f + 3, 6, 3, n) = frame.X_theta;
  }
  const std::complex<double> one(1, damping);
  const MatrixXcd D = one * K.cast<std::complex<double>>() - std::pow(two_pi * hertz, 2) * M;
  const MatrixXcd x = solve(D, P.transpose());
  MatrixXcd moved(12, 12);
  moved.real() = P * x.real();
  moved.imag() = P * x.imag();
  return moved;
}

double first_free_frequency(const Full& f) { return std::sqrt(symmetric_eigenvalues(f.K, f.M)[6]) / two_pi; }

const char* name(Basis basis) {
  constexpr std::array names{"craig_bampton", "free_interface", "krylov", "attachment", "modal_truncation"};
  return names[static_cast<std::size_t>(basis)];
}

/// Largest error of the tip's motion by forces at the tip, relative, over frequencies up to 1.5 times the
/// first of the free body.
class TipResponse {
 public:
  explicit TipResponse(const Full& full) {
    const double first = first_free_frequency(full);
    for (int k = 1; k <= 15; ++k) {
      hertz_.push_back(0.1 * k * first);
      exact_.push_back(response(full, hertz_.back()).block<3, 3>(6, 6));
    }
  }
  double error(const ReducedBody& body) const {
    double worst = 0;
    for (std::size_t k = 0; k < hertz_.size(); ++k)
      worst = std::max(worst,
                       (response(body, hertz_[k]).block<3, 3>(6, 6) - exact_[k]).norm() / exact_[k].norm());
    return worst;
  }

 private:
  std::vector<double> hertz_;
  std::vector<MatrixXcd> exact_;
};

TEST(ModelBases, ConvergeToTheFullModelsResponse) {
  Part p = arm();
  const TipResponse tip(full_model(p));
  std::map<Basis, int> enough;
  for (const Basis basis : {Basis::craig_bampton, Basis::free_interface, Basis::krylov, Basis::attachment,
                            Basis::modal_truncation}) {
    p.options.basis = basis;
    std::string table = fmt::format("{:15}", name(basis));
    double last = 0;
    for (const int count : {1, 2, 3, 4, 6, 8, 12, 18}) {
      p.options.dynamic_modes = count;
      const ReducedBody body = fe::reduce(p.mesh, p.matrices, p.options).body;
      last = tip.error(body);
      table += fmt::format(" {} ({}): {:.1e}", count, body.modes, last);
      if (last < 0.01 && !enough.contains(basis)) enough[basis] = body.modes;
    }
    std::cout << table << '\n';
    EXPECT_LT(last, basis == Basis::craig_bampton ? 2e-3
                    : basis == Basis::attachment  ? 5e-3
                                                  : 1e-6)
        << name(basis);
    ASSERT_TRUE(enough.contains(basis)) << name(basis);
  }
  EXPECT_LE(enough[Basis::krylov], enough[Basis::craig_bampton]);
  EXPECT_LE(enough[Basis::modal_truncation], enough[Basis::attachment]);
}

/// What every basis has without any dynamic mode's help.
TEST(ModelBases, HaveTheSameMassAndStaticCompliance) {
  Part p = arm();
  p.options.dynamic_modes = 4;
  const ReducedBody exact = fe::reduce(p.mesh, p.matrices, p.options).body;
  const auto compliance = [](const ReducedBody& b) {
    MatrixXd P(6, b.modes);
    P << b.frames[1].X, b.frames[1].X_theta;
    return MatrixXd(P * PivotedCholesky(b.stiffness).solve(P.transpose()));
  };
  for (const Basis basis :
       {Basis::free_interface, Basis::krylov, Basis::attachment, Basis::modal_truncation}) {
    p.options.basis = basis;
    const ReducedBody body = fe::reduce(p.mesh, p.matrices, p.options).body;
    EXPECT_NEAR(body.mass, exact.mass, 1e-9 * exact.mass);
    EXPECT_LT((body.first_moment - exact.first_moment).norm(), 1e-9 * exact.first_moment.norm());
    EXPECT_LT((body.second_moment - exact.second_moment).norm(), 1e-9 * exact.second_moment.norm());
    EXPECT_LT((compliance(body) - compliance(exact)).norm(), 1e-7 * compliance(exact).norm()) << name(basis);
    EXPECT_LT(body.frames[0].X.norm() + body.frames[0].X_theta.norm(), 1e-12);
    EXPECT_TRUE(check(body).empty());
    for (const Check& c : body.checks) EXPECT_TRUE(c.passed) << c.name << ": " << c.detail;
  }
}

TEST(ModelBases, AreTheSameSpaceInEitherFrame) {
  Part p = arm();
  p.options.dynamic_modes = 5;
  for (const Basis basis : {Basis::craig_bampton, Basis::free_interface, Basis::krylov}) {
    p.options.basis = basis;
    p.options.frame = ModelReduction::Frame::tangent;
    const ReducedBody tangent = fe::reduce(p.mesh, p.matrices, p.options).body;
    p.options.frame = ModelReduction::Frame::mean_axis;
    const ReducedBody mean = fe::reduce(p.mesh, p.matrices, p.options).body;
    EXPECT_EQ(tangent.modes, mean.modes);
    EXPECT_LT(mean.S.norm(), 1e-6 * std::sqrt(mean.mass)) << name(basis);
    const MatrixXcd a = response(tangent, 300), b = response(mean, 300);
    EXPECT_LT((a - b).norm(), 1e-5 * a.norm()) << name(basis);
  }
}

/// Modes of the free body are exact in the free-interface basis; so is the response where the Krylov basis is
/// matched, below and above the held model's first frequency.
TEST(ModelBases, AreExactWhereTheyPromise) {
  Part p = arm();
  const Full full = full_model(p);
  const VectorXd exact = symmetric_eigenvalues(full.K, full.M);
  p.options.basis = Basis::free_interface;
  p.options.dynamic_modes = 6;
  p.options.frame = ModelReduction::Frame::mean_axis;
  const ReducedBody free = fe::reduce(p.mesh, p.matrices, p.options).body;
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(free.eigenfrequencies[k] / std::sqrt(exact[6 + k]), 1, 1e-7) << k;

  p.options.basis = Basis::krylov;
  p.options.dynamic_modes = 12;
  const double first = first_free_frequency(full);
  for (const double hertz : {0.4 * first, 2.3 * first, 5.1 * first}) {
    p.options.krylov_frequency = hertz;
    const MatrixXcd H = response(full, hertz, 0),
                    h = response(fe::reduce(p.mesh, p.matrices, p.options).body, hertz, 0);
    EXPECT_LT((h - H).norm(), 1e-6 * H.norm()) << hertz;
  }
}

/// The full model held at its root, dense: x, then the tip's coordinates.
Full held_model(const Full& full) {
  const Eigen::Index n = full.K.rows(), inner = n - 12;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < n; ++k)
    if (k < inner || k >= inner + 6) kept.push_back(k);
  return {full.K(kept, kept), full.M(kept, kept)};
}

/// Eigenmodes of the body as its frame holds it are exact, and nothing else changes them.
TEST(ModelBases, OfAttachmentHaveTheEigenmodesOfTheHeldBody) {
  Part p = arm();
  const Full held = held_model(full_model(p));
  const VectorXd exact = symmetric_eigenvalues(held.K, held.M);
  for (const Basis basis : {Basis::attachment, Basis::modal_truncation}) {
    p.options.basis = basis;
    p.options.dynamic_modes = 5;
    const ReducedBody body = fe::reduce(p.mesh, p.matrices, p.options).body;
    EXPECT_EQ(body.modes, 6 + 5 + (basis == Basis::modal_truncation ? 6 : 0));
    for (int k = 0; k < 5; ++k)
      EXPECT_NEAR(body.eigenfrequencies[k] / std::sqrt(exact[k]), 1, 1e-7) << name(basis) << ' ' << k;
    EXPECT_GT(body.eigenfrequencies[5], std::sqrt(exact[5]) * (1 + 1e-9));
  }
}

/// A body whose frame is that of the mean floats: there both are free modes with attachment modes by inertia
/// relief.
TEST(ModelBases, OfAttachmentAreThoseOfTheFreeBodyInMeanAxes) {
  Part p = arm();
  p.options.frame = ModelReduction::Frame::mean_axis;
  p.options.dynamic_modes = 4;
  p.options.basis = Basis::free_interface;
  const ReducedBody free = fe::reduce(p.mesh, p.matrices, p.options).body;
  for (const Basis basis : {Basis::attachment, Basis::modal_truncation}) {
    p.options.basis = basis;
    EXPECT_EQ(fe::reduce(p.mesh, p.matrices, p.options).body.stiffness, free.stiffness);
  }
}

/// Deflection of the tip by the body's own inertia where its frame accelerates: exact by augmentation even
/// without eigenmodes; the others converge to it.
TEST(ModelBases, WithTruncationAugmentedAreExactForInertia) {
  Part p = arm();
  const Full held = held_model(full_model(p));
  const fe::TiedModel tied(p.mesh, p.matrices, p.options.interfaces);
  const Eigen::Index n = tied.internals();
  MatrixXd x = MatrixXd::Zero(n, n + 6), z = MatrixXd::Zero(12, n + 6);
  x.leftCols(n).setIdentity();
  z.bottomRightCorner(6, 6).setIdentity();
  const MatrixXd forces = -tied.expand(x, z).transpose() * full(p.matrices.mass) *
                          fe::rigid_shapes(p.mesh, p.matrices).leftCols(3);
  const MatrixXd exact = mimbre::solve(held.K, forces).bottomRows(6).topRows(3);
  const auto error = [&](Basis basis, int modes) {
    p.options.basis = basis;
    p.options.dynamic_modes = modes;
    const ReducedBody b = fe::reduce(p.mesh, p.matrices, p.options).body;
    // Of the whole body: strain energy by unit accelerations.
    const MatrixXd y = PivotedCholesky(b.stiffness).solve(-b.S.transpose());
    const double energy = (forces.transpose() * mimbre::solve(held.K, forces)).trace();
    EXPECT_LT((b.frames[1].X * y - exact).norm(), 1e-7 * exact.norm()) << name(basis);
    return 1 - (b.S * PivotedCholesky(b.stiffness).solve(b.S.transpose())).trace() / energy;
  };
  EXPECT_NEAR(error(Basis::modal_truncation, 0), 0, 1e-9);
  EXPECT_NEAR(error(Basis::modal_truncation, 3), 0, 1e-9);
  EXPECT_GT(error(Basis::attachment, 0), 1e-4);
  EXPECT_LT(error(Basis::attachment, 6), 0.3 * error(Basis::attachment, 0));
}

/// A load between the interfaces: exact in statics in both.
TEST(ModelBases, OfAttachmentTakeLoads) {
  Part p = arm();
  const Full held = held_model(full_model(p));
  p.options.dynamic_modes = 3;
  int middle = 0;
  for (int k = 0; k < p.mesh.nodes.cols(); ++k)
    if (std::abs(p.mesh.nodes(0, k) - 0.5) < std::abs(p.mesh.nodes(0, middle) - 0.5)) middle = k;
  const Vector3d force(0, 100, 20);
  const fe::TiedModel tied(p.mesh, p.matrices, p.options.interfaces);
  VectorXd f = VectorXd::Zero(p.matrices.stiffness.rows()), all = VectorXd::Zero(held.K.rows());
  f.segment<3>(3 * static_cast<Eigen::Index>(middle)) = force;
  all.head(tied.internals()) = tied.restrict(f);
  const double exact = all.dot(VectorXd(mimbre::solve(held.K, all)));
  for (const Basis basis : {Basis::attachment, Basis::modal_truncation}) {
    p.options.basis = basis;
    const auto compliance = [&] {
      const ReducedBody body = fe::reduce(p.mesh, p.matrices, p.options).body;
      Eigen::Index at = 0;
      (body.nodes.colwise() - p.mesh.nodes.col(middle)).colwise().norm().minCoeff(&at);
      const VectorXd modal = body.node_shapes.middleRows<3>(3 * at).transpose() * force;
      return modal.dot(VectorXd(PivotedCholesky(body.stiffness).solve(modal)));
    };
    p.options.loads.clear();
    EXPECT_LT(compliance(), exact * (1 - 1e-4)) << name(basis);
    p.options.loads = {{"push", {middle}, force}};
    EXPECT_NEAR(compliance(), exact, 1e-8 * exact) << name(basis);
  }
}

/// Motions that joints leave free have no attachment mode; held ones stay held in the eigenmodes.
TEST(ModelBases, OfAttachmentHaveFreeAndHeldMotions) {
  Part p = arm();
  const Full held = held_model(full_model(p));
  const VectorXd exact = symmetric_eigenvalues(held.K, held.M);
  p.options.basis = Basis::attachment;
  p.options.dynamic_modes = 3;
  auto& motions = p.options.interfaces[1].motions;
  motions.fill(Interface::Motion::free);
  const ReducedBody free = fe::reduce(p.mesh, p.matrices, p.options).body;
  EXPECT_EQ(free.modes, 3);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(free.eigenfrequencies[k] / std::sqrt(exact[k]), 1, 1e-7);
  motions[2] = Interface::Motion::held;
  const ReducedBody propped = fe::reduce(p.mesh, p.matrices, p.options).body;
  EXPECT_LT(propped.frames[1].X.row(2).norm(), 1e-9 * propped.frames[1].X.norm());
  const Eigen::Index n = held.K.rows();
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < n; ++k)
    if (k != n - 4) kept.push_back(k);
  const VectorXd lower = symmetric_eigenvalues(held.K(kept, kept), held.M(kept, kept));
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(propped.eigenfrequencies[k] / std::sqrt(lower[k]), 1, 1e-7);
}

TEST(ModelBases, TakeAllModesBelowAFrequency) {
  Part p = arm();
  const Full full = full_model(p);
  const Eigen::Index n = full.K.rows() - 12;
  const VectorXd held = symmetric_eigenvalues(full.K.topLeftCorner(n, n), full.M.topLeftCorner(n, n)),
                 free = symmetric_eigenvalues(full.K, full.M);
  for (const double hertz : {1.0, 1000.0, 6000.0}) {
    p.options.max_frequency = hertz;
    p.options.basis = Basis::craig_bampton;
    const double limit = std::pow(two_pi * hertz, 2);
    EXPECT_EQ(fe::reduce(p.mesh, p.matrices, p.options).fixed_frequencies.size(),
              (held.array() <= limit).count());
    p.options.basis = Basis::free_interface;
    EXPECT_EQ(fe::reduce(p.mesh, p.matrices, p.options).body.modes, (free.array() <= limit).count() - 6 + 12);
  }
}

/// A clamped bar: 61.3 % of its mass moves with the first bending mode, and with all modes all of it but what
/// the held nodes carry.
TEST(EffectiveMass, OfAClampedBarIsItsMass) {
  Part p;
  p.mesh = block(fe::ElementType::hex20, {1, 0.05, 0.03}, {8, 1, 1}, steel);
  p.matrices = fe::assemble(p.mesh);
  p.options.interfaces.resize(1);
  Interface& root = p.options.interfaces[0];
  root.name = "root";
  for (int k = 0; k < p.mesh.nodes.cols(); ++k)
    if (p.mesh.nodes(0, k) < 1e-9) root.nodes.push_back(k);
  root.point = fe::centre_of(p.mesh, root.nodes);
  p.options.free_modes = 0;
  p.options.dynamic_modes = 3;
  const fe::ReductionResult few = fe::reduce(p.mesh, p.matrices, p.options);
  EXPECT_NEAR(few.effective_mass(2, 0), 61.3, 0.6);
  EXPECT_NEAR(few.effective_mass(1, 1), 61.3, 0.6);
  EXPECT_NEAR(few.effective_mass(4, 0), 97.1, 0.5);  // (∫ x φ)² / (L³/3)
  EXPECT_LT(few.effective_mass(0, 0), 1e-6);

  p.mesh = block(fe::ElementType::hex8, {1, 0.05, 0.03}, {12, 1, 1}, steel);
  p.matrices = fe::assemble(p.mesh);
  root.nodes.clear();
  for (int k = 0; k < p.mesh.nodes.cols(); ++k)
    if (p.mesh.nodes(0, k) < 1e-9) root.nodes.push_back(k);
  root.point = fe::centre_of(p.mesh, root.nodes);
  p.options.dynamic_modes = 12 * 4 * 3;
  const VectorXd all = fe::reduce(p.mesh, p.matrices, p.options).effective_mass.rowwise().sum();
  const fe::TiedModel tied(p.mesh, p.matrices, p.options.interfaces);
  const Eigen::Index n = tied.internals();
  const MatrixXd Tx = tied.expand(MatrixXd::Identity(n, n), MatrixXd::Zero(6, n)), M = full(p.matrices.mass);
  MatrixXd R = fe::rigid_shapes(p.mesh, p.matrices);
  for (int k = 0; k < 3; ++k) R.col(3 + k) -= R.leftCols(3) * Vector3d(Vector3d::Unit(k)).cross(root.point);
  const MatrixXd L = Tx.transpose() * M * R;
  const MatrixXd moved = L.transpose() * PivotedCholesky(Tx.transpose() * M * Tx).solve(L),
                 whole = R.transpose() * M * R;
  for (int k = 0; k < 6; ++k) {
    EXPECT_NEAR(all[k], 100 * moved(k, k) / whole(k, k), 1e-5) << k;
    EXPECT_GT(all[k], 97) << k;
    EXPECT_LT(all[k], 100) << k;
  }
}

TEST(EffectiveMass, ChoosesModes) {
  Part p = arm();
  p.options.dynamic_modes = 30;
  p.options.effective_mass = 60;
  const fe::ReductionResult some = fe::reduce(p.mesh, p.matrices, p.options);
  const Check* line = nullptr;
  for (const Check& c : some.body.checks)
    if (c.name == "mode selection") line = &c;
  ASSERT_NE(line, nullptr);
  EXPECT_TRUE(line->passed) << line->detail;
  EXPECT_LT(some.fixed_frequencies.size(), 30);
  EXPECT_EQ(some.body.modes, 6 + some.fixed_frequencies.size());
  EXPECT_EQ(some.effective_mass.cols(), some.fixed_frequencies.size());
  EXPECT_GE(some.effective_mass.rowwise().sum().minCoeff(), 60);
  EXPECT_THAT(line->detail, testing::HasSubstr("dropped: "));
  p.options.effective_mass = 99.9;
  p.options.dynamic_modes = 8;
  for (const Check& c : fe::reduce(p.mesh, p.matrices, p.options).body.checks)
    EXPECT_EQ(c.passed, c.name != "mode selection") << c.name << ": " << c.detail;
}

TEST(ModelBases, SayWhatDoesNotGoTogether) {
  const Part p = arm();
  const auto fails = [&](const auto& change, const std::string& text) {
    ModelReduction o = p.options;
    change(o);
    try {
      fe::reduce(p.mesh, p.matrices, o);
      ADD_FAILURE() << "no error; expected " << text;
    } catch (const std::invalid_argument& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr(text));
    }
  };
  fails([](ModelReduction& o) { o.max_frequency = -1; }, "frequencies must not be negative");
  fails([](ModelReduction& o) { o.krylov_frequency = NAN; }, "frequencies must not be negative");
  fails([](ModelReduction& o) { o.krylov_frequency = 10; }, "belongs to the Krylov basis");
  fails([](ModelReduction& o) { o.effective_mass = 101; }, "between 0 and 100 %");
  fails(
      [](ModelReduction& o) {
        o.basis = Basis::krylov;
        o.max_frequency = 10;
      },
      "have no frequencies");
  fails(
      [](ModelReduction& o) {
        o.basis = Basis::free_interface;
        o.effective_mass = 90;
      },
      "of the Craig-Bampton basis");
  fails(
      [](ModelReduction& o) {
        o.interfaces.resize(1);
        o.max_frequency = 1;
      },
      "no dynamic mode below the frequency");
  fails(
      [](ModelReduction& o) {
        o.basis = Basis::attachment;
        o.interfaces[1].motions[0] = Interface::Motion::free;
        o.frame = ModelReduction::Frame::mean_axis;
      },
      "in the tangent frame, in attachment and modal_truncation");
}

}  // namespace
}  // namespace mimbre::test::model_bases_test

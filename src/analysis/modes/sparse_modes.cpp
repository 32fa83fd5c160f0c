#include "analysis/modes/sparse_modes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/modes/mode_shapes.h"
#include "analysis/modes/mode_shares.h"
#include "analysis/modes/sparse_core.h"
#include "integrate/sparse_statics.h"
#include "mimbre/diagnostics.h"
#include "simulation/start/assembly.h"

namespace mimbre::linear {

using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

/// Unbalanced work, of the weight of the heaviest part moved by its scale: beyond, it is no equilibrium.
constexpr double unbalanced_share = 1e-5;

/// δ of the relative coordinates of motions in natural coordinates.
class RelativeMotions {
 public:
  RelativeMotions(natural::NaturalSystem& system, const State& natural, const State& relative)
      : system_(system), natural_(natural), relative_(relative) {}
  VectorXd of(const VectorXd& x) {
    natural_.v = x;
    system_.to_relative(natural_, relative_);
    return relative_.v;
  }
  VectorXcd of(const VectorXcd& x) {
    VectorXcd out(relative_.v.size());
    out.real() = of(VectorXd(x.real()));
    out.imag() = of(VectorXd(x.imag()));
    return out;
  }

 private:
  natural::NaturalSystem& system_;
  State natural_, relative_;
};

/// Whether the eigenvalue is that of a neighbour, too.
bool equal_values(const VectorXcd& values, Eigen::Index k) {
  const auto same = [&](Eigen::Index other) {
    return other >= 0 && other < values.size() &&
           std::abs(values[other] - values[k]) <= 1e-7 * std::abs(values[k]);
  };
  return same(k - 1) || same(k + 1);
}

/// The motions found, in relative coordinates, with names and shares of energy.
LinearisedModes described(const Linearised& located, const State& relative, const SparseEquations& equations,
                          const linalg::ConstrainedModes& found, const relative::RelativeSystem& observer,
                          RelativeMotions& motions) {
  const Compiled& m = located.model->compiled();
  LinearisedModes out;
  out.sparse = true;
  out.model = located.names;
  out.model.title = m.spec().title;
  out.model.time = relative.time;
  out.model.notes.push_back("the lowest modes by sparse matrices, shifted and inverted");
  for (int k = 0; k < m.velocities; ++k) out.coordinates.push_back(coordinate_label(m, k));
  Linearised at;
  at.model = located.model;
  at.state = relative;
  ModeShares shares(at);
  const VectorXd scale = Eigen::Map<const VectorXd>(observer.scales().coordinates.data(), m.velocities);
  /// `stiffness`: that of the motion before it is normalised.
  const auto add = [&](Mode mode, const VectorXcd& motion, double stiffness, bool mixed) {
    mode.motion = motion;
    const std::complex<double> factor = normalise(mode.motion, mode.motion.size(), scale);
    mode.shape.resize(2 * mode.motion.size());
    mode.shape << mode.motion, mode.value * mode.motion;
    mode.left = VectorXcd::Zero(mode.shape.size());
    shares.describe_motion(mode, 0.5 * std::norm(factor) * stiffness, mixed);
    out.modes.push_back(std::move(mode));
  };
  MatrixXd rigid(m.velocities, found.rigid.cols());
  for (Eigen::Index k = 0; k < rigid.cols(); ++k)
    rigid.col(k) =
        motions.of(VectorXd(equations.scale.cwiseProduct(found.rigid.col(k)))).cwiseQuotient(scale);
  rigid = scale.asDiagonal() * echelon(rigid);
  for (Eigen::Index k = 0; k < rigid.cols(); ++k) {
    Mode mode;
    mode.kind = Mode::Kind::rigid;
    add(std::move(mode), rigid.col(k).cast<std::complex<double>>(), 0, rigid.cols() > 1);
  }
  for (Eigen::Index k = 0; k < found.values.size(); ++k) {
    const VectorXcd x = found.vectors.col(k), stiff = equations.pencil.K.cast<std::complex<double>>() * x;
    add(mode_of(found.values[k], 0),
        motions.of(VectorXcd(equations.scale.cast<std::complex<double>>().cwiseProduct(x))),
        std::real(x.dot(stiff)), equal_values(found.values, k));
  }
  return out;
}

}  // namespace

std::optional<LinearisedModes> sparse_modes(const Linearised& located, int most, std::string& why) {
  const Compiled& m = located.model->compiled();
  why = not_sparse(m);
  if (!why.empty()) return {};
  State relative = located.state;
  if (relative.v.size() > 0 && relative.v.cwiseAbs().maxCoeff() > 0) {
    why = "the mechanism moves at the point";
    return {};
  }
  relative.a.setZero(m.velocities);
  std::optional<natural::NaturalSystem> system;
  try {
    system.emplace(m);
  } catch (const InputError& error) {
    why = error.what();
    return {};
  }
  relative::RelativeSystem observer(m);
  observer.enter(relative.u.data(), relative.z.data(), 0);
  State natural = natural_state(*system, observer, relative);
  natural.v.setZero();
  natural.a.setZero();
  system->enter(relative.u.data(), relative.z.data(), 0);
  find_sparse_multipliers(*system, natural);
  SparseEquations equations;
  try {
    equations = sparse_equations(*system, natural, relative.u, relative.z);
  } catch (const std::runtime_error& error) {
    why = error.what();
    return {};
  }
  if (equations.unbalanced > unbalanced_share) {
    why = "the point is no equilibrium";
    return {};
  }
  const linalg::ConstrainedModes found = linalg::lowest_modes(equations.pencil, most);
  if (!found.ok) {
    why = "the iteration did not converge";
    return {};
  }
  RelativeMotions motions(*system, natural, relative);
  return described(located, relative, equations, found, observer, motions);
}

}  // namespace mimbre::linear

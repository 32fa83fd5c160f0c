#include "analysis/sparse_modes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "analysis/mode_shares.h"
#include "analysis/sparse_core.h"
#include "integrate/sparse_statics.h"
#include "mimbre/diagnostics.h"
#include "simulation/start/assembly.h"

namespace mimbre::linear {

using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

/// Unbalanced work, of the weight of the heaviest part moved by its scale: beyond, it is no equilibrium.
constexpr double unbalanced_share = 1e-5;
constexpr int usual_count = 20;
/// Re λ of what does not decay, of |λ|.
constexpr double decay_round_off = 1e-9;

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

/// The largest entry by the scales becomes 1. Returns the factor.
std::complex<double> normalise_motion(VectorXcd& x, const std::vector<double>& scales) {
  std::complex<double> largest = 0;
  double most = 0;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const double scale = scales[static_cast<std::size_t>(k)];
    if (std::abs(x[k]) / scale > most * (1 + 1e-9)) {
      most = std::abs(x[k]) / scale;
      largest = x[k] / scale;
    }
  }
  if (!(most > 0)) return 1;
  x /= largest;
  return 1. / largest;
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
  linalg::ConstrainedModes found;
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
  const int count = most > 0 ? most : usual_count;
  found = linalg::lowest_modes(equations.pencil, count);
  if (!found.ok) {
    why = "the iteration did not converge";
    return {};
  }

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
  RelativeMotions motions(*system, natural, relative);
  const auto add = [&](Mode mode, const VectorXcd& x) {
    const VectorXcd unscaled = equations.scale.cast<std::complex<double>>().cwiseProduct(x);
    mode.motion = motions.of(unscaled);
    const std::complex<double> factor = normalise_motion(mode.motion, observer.scales().coordinates);
    mode.shape.resize(2 * mode.motion.size());
    mode.shape << mode.motion, mode.value * mode.motion;
    mode.left = VectorXcd::Zero(mode.shape.size());
    const VectorXcd stiff = equations.pencil.K.cast<std::complex<double>>() * x;
    shares.describe_motion(mode, 0.5 * std::norm(factor) * std::real(x.dot(stiff)));
    out.modes.push_back(std::move(mode));
  };
  for (Eigen::Index k = 0; k < found.rigid.cols(); ++k) {
    Mode mode;
    mode.kind = Mode::Kind::rigid;
    add(std::move(mode), found.rigid.col(k).cast<std::complex<double>>());
  }
  for (Eigen::Index k = 0; k < found.values.size(); ++k) {
    Mode mode;
    const std::complex<double> value = found.values[k];
    mode.kind = value.imag() > 0 ? Mode::Kind::oscillating : Mode::Kind::real;
    mode.value = value;
    mode.frequency = std::abs(value) / (2 * std::numbers::pi);
    mode.damped = value.imag() / (2 * std::numbers::pi);
    mode.damping = std::abs(value) > 0 ? -value.real() / std::abs(value) : 0;
    mode.grows = value.real() > decay_round_off * std::abs(value);
    add(std::move(mode), found.vectors.col(k));
  }
  return out;
}

}  // namespace mimbre::linear

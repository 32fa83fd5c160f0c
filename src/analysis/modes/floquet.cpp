#include "analysis/modes/floquet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>

#include "joints/joint_kind.h"
#include "math/elementary.h"
#include "math/once/decompositions.h"

namespace mimbre::linear {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

/// Of the fastest turning: none.
constexpr double stands = 1e-9;
/// Of speeds: they are whole multiples of one speed.
constexpr double whole = 1e-9;
/// Turns of the slowest until all are back.
constexpr int most_turns = 24;
/// Of accelerations at play, and of the coefficients.
constexpr double steady = 1e-5, repeats = 1e-6;
/// Of the transition: it has settled.
constexpr double settled = 1e-8;
/// Of the largest multiplier: smaller ones are lost in its round-off.
constexpr double least_motion = 1e-9;
/// Of a multiplier: it is real.
constexpr double real_round_off = 1e-9;
constexpr int parts = 16, fewest_steps = 32, most_steps = 1024, hopeless = 8192;

/// Padé's function of degrees 6 over 6, exact to round-off up to a norm of 1/2 (Higham, SIAM J. Matrix Anal.
/// Appl. 26, 2005); larger matrices are halved and the result is squared.
MatrixXd exponential(const MatrixXd& A) {
  constexpr double c[] = {1, 1. / 2, 5. / 44, 1. / 66, 1. / 792, 1. / 15840, 1. / 665280};
  const double norm = A.cwiseAbs().colwise().sum().maxCoeff();
  const int halvings = norm > 0.5 ? static_cast<int>(std::ceil(mimbre::log2(2 * norm))) : 0;
  const MatrixXd B = std::ldexp(1, -halvings) * A, B2 = B * B, B4 = B2 * B2, B6 = B4 * B2,
                 I = MatrixXd::Identity(A.rows(), A.cols());
  const MatrixXd even = I + c[2] * B2 + c[4] * B4 + c[6] * B6, odd = B * (c[1] * I + c[3] * B2 + c[5] * B4);
  MatrixXd out = solve(even - odd, even + odd);
  for (int k = 0; k < halvings; ++k) out = (out * out).eval();
  return out;
}

/// Angular speeds of the joints.
std::vector<double> turning_speeds(const Compiled& m, const VectorXd& v) {
  std::vector<double> out;
  for (const BodyData& b : m.bodies) {
    const JointInfo& info = joint_info(b.joint);
    if (info.quaternion >= 0) {
      out.push_back(v.segment<3>(b.v + info.rotation).norm());
      continue;
    }
    for (int k = 0; k < b.joint_velocities; ++k)
      if (is_angle(b.joint, k)) out.push_back(std::abs(v[b.v + k]));
  }
  const double fastest = out.empty() ? 0 : *std::max_element(out.begin(), out.end());
  std::erase_if(out, [&](double speed) { return !(speed > stands * fastest); });
  return out;
}

/// 0: there is none.
double period_of(const std::vector<double>& speeds) {
  if (speeds.empty()) return 0;
  const double slowest = *std::min_element(speeds.begin(), speeds.end());
  for (int turns = 1; turns <= most_turns; ++turns)
    if (std::all_of(speeds.begin(), speeds.end(), [&](double speed) {
          const double all = turns * speed / slowest;
          return std::abs(all - std::round(all)) <= whole * all;
        }))
      return 2 * std::numbers::pi * turns / slowest;
  return 0;
}

/// A along the motion, along the scales of the states.
class Along {
 public:
  Along(const Compiled& m, const relative::RelativeSystem& system, const Linearised& at,
        const VectorXd& scale)
      : m_(m), system_(system), at_(at), scale_(scale) {
    const Scales& s = system.scales();
    const double speed = s.of_coordinates(at.state.v.data());
    play_ = std::max(s.accelerations(at.state.a.data()), speed * speed);
    speed_ = speed;
  }

  MatrixXd A(double time) const {
    return scale_.cwiseInverse().asDiagonal() * later(time).A * scale_.asDiagonal();
  }
  /// Throws std::runtime_error.
  Reduced later(double time) const {
    Linearised next = linearised_later(m_, system_, at_, time);
    if (next.reduced.A.rows() != at_.reduced.A.rows())
      throw std::runtime_error("states of force elements come and go");
    int where = -1;
    if (const double most = system_.scales().of_coordinates(next.state.a.data(), &where);
        most > steady * play_)
      throw std::runtime_error(fmt::format(
          "it is not steady: after {:.3g} s '{}' accelerates by {:.2g} of the accelerations at play", time,
          coordinate_label(m_, where).name, most / play_));
    const Index first = at_.reduced.first_state();
    for (Index k = 0; k < next.state_rates.size(); ++k)
      if (next.parameters[static_cast<std::size_t>(k)].kind != Parameter::Kind::integral &&
          std::abs(next.state_rates[k]) > steady * speed_ * scale_[first + k])
        throw std::runtime_error(
            fmt::format("it is not steady: after {:.3g} s states of force elements move", time));
    return std::move(next.reduced);
  }

 private:
  const Compiled& m_;
  const relative::RelativeSystem& system_;
  const Linearised& at_;
  const VectorXd& scale_;
  double play_ = 0, speed_ = 0;  ///< accelerations and rates at play, by the scales
};

/// Φ at equal parts of the period, the last one at its end.
std::vector<MatrixXd> transitions(const Along& along, double period, int steps, Eigen::Index states) {
  const double h = period / steps, root = std::sqrt(3.) / 6, near = 0.25 + root, far = 0.25 - root;
  std::vector<MatrixXd> on;
  MatrixXd all = MatrixXd::Identity(states, states);
  for (int k = 0; k < steps; ++k) {
    if (k % (steps / parts) == 0) on.push_back(all);
    const MatrixXd first = along.A((k + 0.5 - root) * h), second = along.A((k + 0.5 + root) * h);
    all =
        exponential(h * (far * first + near * second)) * exponential(h * (near * first + far * second)) * all;
  }
  on.push_back(all);
  return on;
}

/// What exponent_of() needs of the parts of the period.
void take_parts(const Along& along, const Linearised& at, const VectorXd& scale, Transition& out) {
  out.on.pop_back();
  out.first_speed = at.reduced.coordinates;
  const VectorXd speeds = scale.segment(out.first_speed, at.reduced.speeds);
  for (int k = 0; k < parts; ++k) {
    const Reduced r = along.later(k * out.period / parts);
    out.A.push_back(speeds.cwiseInverse().asDiagonal() * r.A.middleRows(out.first_speed, speeds.size()) *
                    scale.asDiagonal());
    out.mass.push_back(speeds.asDiagonal() * r.mass * speeds.asDiagonal());
  }
}

}  // namespace

std::optional<Transition> find_transition(const Compiled& m, const relative::RelativeSystem& system,
                                          const Linearised& at, const VectorXd& scale, std::string& why) {
  Transition out;
  const std::vector<double> turning = turning_speeds(m, at.state.v);
  out.period = period_of(turning);
  if (!(out.period > 0)) {
    why = turning.empty() ? "nothing turns" : "what turns has no common period";
    return {};
  }
  try {
    const Along along(m, system, at, scale);
    const MatrixXd first = along.A(0);
    for (const double part : {0., 0.29, 0.58})
      if ((along.A((1 + part) * out.period) - along.A(part * out.period)).cwiseAbs().maxCoeff() >
          repeats * first.cwiseAbs().maxCoeff()) {
        why = "the coefficients do not repeat themselves";
        return {};
      }
    MatrixXd before;
    why = "the turning is too slow beside the motions";
    for (int steps = fewest_steps; steps <= most_steps; steps *= 2) {
      out.on = transitions(along, out.period, steps, first.rows());
      out.over_period = out.on.back();
      if (!out.over_period.allFinite()) {
        why =
            "numbers over a period are not finite: a position on the way is singular, or motions grow too "
            "far";
        return {};
      }
      const double off = before.size() > 0 ? (out.over_period - before).norm() / out.over_period.norm() : 1;
      // Of fourth order.
      if (before.size() > 0 && steps * std::sqrt(std::sqrt(off / settled)) > hopeless) return {};
      if (off <= settled) {
        const VectorXd sizes = eigenvalues(out.over_period).cwiseAbs();
        if (sizes.size() > 0 && !(sizes.minCoeff() > least_motion * sizes.maxCoeff())) {
          why = "some motions grow or decay by more over a period than numbers have digits";
          return {};
        }
        take_parts(along, at, scale, out);
        why.clear();
        return out;
      }
      before = out.over_period;
    }
  } catch (const std::runtime_error& error) {
    why = error.what();
  }
  return {};
}

std::complex<double> exponent_of(const Transition& transition, std::complex<double> multiplier,
                                 const VectorXcd& shape) {
  const std::complex<double> principal =
      std::complex<double>(mimbre::log(std::abs(multiplier)),
                           mimbre::atan2(multiplier.imag(), multiplier.real())) /
      transition.period;
  const double turn = 2 * std::numbers::pi / transition.period;
  // With s = e^{λt} p the mean of s·Mṡ over s·Ms is λ and the mean harmonic of p.
  std::complex<double> mean = 0;
  double square = 0, all = 0;
  for (std::size_t k = 0; k < transition.on.size(); ++k) {
    const double time =
        transition.period * static_cast<double>(k) / static_cast<double>(transition.on.size());
    const VectorXcd x = mimbre::exp(-principal.real() * time) * (transition.on[k] * shape),
                    s = x.segment(transition.first_speed, transition.mass[k].rows()),
                    rate = transition.A[k] * x - principal.real() * s;
    mean += s.dot(transition.mass[k] * rate);
    square += std::real(rate.dot(transition.mass[k] * rate));
    all += std::real(s.dot(transition.mass[k] * s));
  }
  const bool is_real = std::abs(multiplier.imag()) <= real_round_off * std::abs(multiplier);
  const double frequency = is_real ? std::sqrt(square / all) : mean.imag() / all;
  if (!(all > 0) || !std::isfinite(frequency)) return principal;
  return {principal.real(), principal.imag() + turn * std::round((frequency - principal.imag()) / turn)};
}

}  // namespace mimbre::linear

#include "mimbre/linearise.h"

#include <algorithm>
#include <cmath>

#include "analysis/linear_point.h"
#include "math/once/decompositions.h"
#include "simulation/observe/channel_view.h"
#include "simulation/observe/channels.h"
#include "simulation/step/signal_state.h"

namespace mimbre {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// The model's outputs at a state near the point: what they vary by along a column of x|u.
class OutputsNearPoint {
 public:
  explicit OutputsNearPoint(const linear::Linearised& at)
      : at_(at), m_(at.model->compiled()), system_(m_), channels_(m_), state_(at.state), r_(m_.velocities) {
    system_.enter_rest(at_.state.u.data(), at_.state.z.data());
    system_.begin_step(at_.state.q.data());
    for (const spec::Output& o : m_.spec().outputs) outputs_.emplace_back(m_, o);
  }

  std::vector<LinearName> names() const {
    std::vector<LinearName> out;
    for (std::size_t k = 0; k < outputs_.size(); ++k)
      out.push_back({channels_.info()[k].name, channels_.info()[k].unit});
    return out;
  }

  VectorXd at(Eigen::Index column, double by) {
    const linear::Reduced& r = at_.reduced;
    state_ = at_.state;
    if (column >= 0) {
      const VectorXd x = by * r.position.col(column);
      system_.retract(at_.state.q.data(), x.data(), state_.q.data());
      state_.v += by * r.velocity.col(column);
      state_.a += by * r.acceleration.col(column);
      state_.multipliers += by * r.multipliers.col(column);
      if (const Eigen::Index p = column - r.first_state(); p >= 0)
        vary(at_.parameters[static_cast<std::size_t>(p)], by);
    }
    system_.enter_rest(state_.u.data(), state_.z.data());
    system_.residual(state_.time, state_.q.data(), state_.v.data(), state_.a.data(),
                     state_.multipliers.data(), 0, r_.data());
    VectorXd out(std::ssize(outputs_));
    for (std::size_t k = 0; k < outputs_.size(); ++k)
      out[static_cast<Eigen::Index>(k)] = channels_.value(outputs_[k], system_, state_);
    return out;
  }

  /// Central differences, extrapolated once: outputs are smooth, most of them linear.
  VectorXd along(Eigen::Index column) {
    const double width = width_of(column);
    const VectorXd wide = (at(column, width) - at(column, -width)) / (2 * width),
                   narrow = (at(column, width / 2) - at(column, -width / 2)) / width;
    return narrow + (narrow - wide) / 3;
  }

 private:
  void vary(const linear::Parameter& p, double by) {
    using Kind = linear::Parameter::Kind;
    if (p.kind == Kind::element_state) {
      const linear::LinearElement& e = at_.elements[static_cast<std::size_t>(p.item)];
      state_.z[m_.elements[static_cast<std::size_t>(e.element)].states +
               e.states[static_cast<std::size_t>(p.index)]] += by;
    } else if (p.kind == Kind::block_state) {
      const SignalsData::Block& b = m_.signals.blocks[static_cast<std::size_t>(p.item)];
      state_.u[b.held + 1 + b.inputs + p.index] += by;
    } else if (p.kind == Kind::integral) {
      state_.u[m_.signals.integrals[static_cast<std::size_t>(p.item)].held] += by;
    } else if (p.kind == Kind::input) {
      for (const SignalsData::HeldInput& h : m_.signals.held) {
        if (h.input != p.item) continue;
        state_.u[h.held] += by;
        if (h.linear) state_.u[h.held + 2] += by;
      }
    }
  }

  /// By a thousandth of the mechanism's scales.
  double width_of(Eigen::Index column) const {
    const linear::Reduced& r = at_.reduced;
    const Scales& scales = system_.scales();
    const auto size = [&](const MatrixXd& of) {
      const VectorXd x = of.col(column);
      return scales.of_coordinates(x.data());
    };
    const double rate = scales.rate(at_.state.v.data()), pace = rate > 0 ? rate : 1;
    double most = std::max(size(r.position), size(r.velocity) / pace);
    if (!(most > 0)) most = size(r.acceleration) / (pace * pace);
    return most > 0 ? 1e-3 / most : 1e-3;
  }

  const linear::Linearised& at_;
  const Compiled& m_;
  relative::RelativeSystem system_;
  Channels channels_;
  std::vector<ObservedOutput> outputs_;
  State state_;
  VectorXd r_;
};

}  // namespace

LinearModel linearise(std::shared_ptr<const Model> model, const LinearOptions& options) {
  linear::Linearised at = linear::linearise_at(std::move(model), options);
  const linear::Reduced& r = at.reduced;
  LinearModel out = at.names;
  out.A = r.A;
  out.B = r.B;
  out.mass = r.mass;
  out.damping = r.damping;
  out.stiffness = r.stiffness;
  OutputsNearPoint outputs(at);
  out.outputs = outputs.names();
  const VectorXd values = outputs.at(-1, 0);
  out.output_values.assign(values.begin(), values.end());
  MatrixXd all(values.size(), r.position.cols());
  if (values.size() > 0)
    for (Eigen::Index k = 0; k < all.cols(); ++k) all.col(k) = outputs.along(k);
  out.C = all.leftCols(r.A.cols());
  out.D = all.rightCols(r.inputs);
  return out;
}

Eigen::MatrixXcd frequency_response(const LinearModel& model, double omega) {
  // (iω − A) (X + i Y) = B, as twice as many real equations.
  const auto n = model.A.rows(), k = model.B.cols();
  MatrixXd left(2 * n, 2 * n), right = MatrixXd::Zero(2 * n, k);
  left.topLeftCorner(n, n) = left.bottomRightCorner(n, n) = -model.A;
  left.topRightCorner(n, n) = -omega * MatrixXd::Identity(n, n);
  left.bottomLeftCorner(n, n) = omega * MatrixXd::Identity(n, n);
  right.topRows(n) = model.B;
  Eigen::MatrixXcd x(n, k);
  if (n > 0 && k > 0) {
    const MatrixXd found = solve(left, right);
    x.real() = found.topRows(n);
    x.imag() = found.bottomRows(n);
  }
  Eigen::MatrixXcd out = model.D.cast<std::complex<double>>();
  if (n > 0) out += model.C.cast<std::complex<double>>() * x;
  return out;
}

}  // namespace mimbre

#include "analysis/equilibria/path_equations.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "analysis/linear_core.h"
#include "analysis/linear_element.h"
#include "analysis/linear_point.h"
#include "analysis/linear_reduction.h"
#include "compile/element_name.h"
#include "integrate/initial.h"
#include "mimbre/diagnostics.h"
#include "simulation/describe/explain.h"
#include "simulation/start/assembly.h"
#include "spec/force_law.h"

namespace mimbre {

using Eigen::VectorXd;

namespace {

constexpr double named_share_of_motion = 0.05;
constexpr double closed_path_loops = 1e-9;  ///< of the equations' scales

/// What friction, tyres and contacts remember decides where they hold: their equilibria are no curve.
void refuse_memory(const Compiled& m) {
  for (const ElementData& e : m.elements)
    if (linear::needs_linear_element(e) && law_info(e.law).name != "bushing")
      throw InputError(
          {m.spec().file, 0, 0},
          fmt::format("{} remembers how it came to where it is, as friction, stops, contacts and "
                      "tyres do, so that its equilibria are no single path; leave it out for this",
                      element_name(m, e)));
}

}  // namespace

struct PathEquations::Loaded {
  Loaded(const spec::Model& spec, const GrowingLoads& growing, double by)
      : factor(by), model(loaded_by(spec, growing, by)), system(model->compiled()) {}

  /// What the loads and all else do at rest, along the velocity coordinates.
  VectorXd residual(const State& s) {
    const int n = system.velocities();
    const VectorXd zero = VectorXd::Zero(n), none = VectorXd::Zero(system.equations());
    VectorXd r(n);
    system.enter_rest(s.u.data(), s.z.data());
    system.begin_step(s.q.data());
    system.residual(s.time, s.q.data(), zero.data(), zero.data(), none.data(), 0, r.data());
    return r;
  }

  double factor;
  std::shared_ptr<const Model> model;
  relative::RelativeSystem system;
};

PathEquations::PathEquations(const spec::Model& spec, GrowingLoads growing,
                             std::map<std::string, double> inputs)
    : spec_(spec),
      growing_(std::move(growing)),
      inputs_(std::move(inputs)),
      without_(std::make_unique<Loaded>(spec_, growing_, 0)),
      once_(std::make_unique<Loaded>(spec_, growing_, 1)),
      scale_(
          Eigen::Map<const VectorXd>(once_->system.scales().coordinates.data(), once_->system.velocities())) {
  refuse_memory(once_->model->compiled());
}

PathEquations::~PathEquations() = default;

PathEquations::Loaded& PathEquations::loaded(double factor) {
  if (!at_ || at_->factor != factor) at_ = std::make_unique<Loaded>(spec_, growing_, factor);
  return *at_;
}

State PathEquations::start(double factor, std::vector<std::string>& warnings) {
  Loaded& l = loaded(factor);
  const Compiled& m = l.model->compiled();
  State s = assembled_state(m, l.system, inputs_);
  const StaticsStatus status = equilibrium(nullptr, l.system, s);
  if (!status.converged) throw std::runtime_error(explain_imbalance(m, nullptr, status));
  if (const std::string text = explain_instability(m, nullptr, status); !text.empty())
    warnings.push_back(text);
  return s;
}

PathTangent PathEquations::at(State& s, double factor) {
  Loaded& l = loaded(factor);
  const Compiled& m = l.model->compiled();
  linear::commit(m, l.system, s);
  const VectorXd force = l.residual(s);
  const linear::Independent independent(dense_jacobian(l.system, s.time, s.q), l.system.scales());
  linear::Derivatives d;
  linear::LinearCore(m, s, 1).find_stiffness(independent.multipliers(VectorXd(-force)), d);

  PathTangent out;
  out.coordinates = independent.coordinates();
  const Eigen::MatrixXd& N = independent.motions();
  // Along the scales: of y, so that the largest coordinate that each moves moves by its own; and of the
  // forces.
  VectorXd own(N.cols());
  for (Eigen::Index k = 0; k < own.size(); ++k)
    own[k] = 1 / N.col(k).cwiseQuotient(scale_).cwiseAbs().maxCoeff();
  const Eigen::MatrixXd scaled = N * own.asDiagonal();
  out.motions = scale_.cwiseInverse().asDiagonal() * scaled;
  out.force = scaled.transpose() * force;
  out.stiffness = scaled.transpose() * d.residual_q * scaled;
  out.load = scaled.transpose() * (once_->residual(s) - without_->residual(s));
  return out;
}

bool PathEquations::move(State& s, const VectorXd& step) {
  relative::RelativeSystem& system = once_->system;
  const VectorXd by = scale_.cwiseProduct(step);
  VectorXd q(s.q.size());
  system.retract(s.q.data(), by.data(), q.data());
  s.q = q;
  if (system.equations() == 0) return s.q.allFinite();
  system.enter_rest(s.u.data(), s.z.data());
  system.begin_step(s.q.data());
  return close_positions(system, s.time, scale_, s.q) <= closed_path_loops && s.q.allFinite();
}

AtRest PathEquations::sample(State s, double factor) {
  Loaded& l = loaded(factor);
  linear::commit(l.model->compiled(), l.system, s);
  find_multipliers(l.system, s, 1e-9);
  return sample_at_rest(l.model->compiled(), l.system, s);
}

std::string PathEquations::shares(const PathTangent& at, const VectorXd& y) const {
  const VectorXd squares = y.cwiseProduct(y);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(y.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return squares[a] > squares[b]; });
  std::vector<std::string> parts;
  for (const Eigen::Index k : order) {
    if (parts.size() == 3 || squares[k] < named_share_of_motion * squares.sum()) break;
    const int coordinate = at.coordinates[static_cast<std::size_t>(k)];
    parts.push_back(fmt::format("'{}' {:.0f} %",
                                linear::coordinate_label(once_->model->compiled(), coordinate).name,
                                100 * squares[k] / squares.sum()));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace mimbre

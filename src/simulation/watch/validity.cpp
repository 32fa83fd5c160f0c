#include "simulation/watch/validity.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>

#include "math/multiply_add.h"
#include "math/once/decompositions.h"
#include "simulation/watch/mechanism_response.h"
#include "simulation/watch/validity_measures.h"

namespace mimbre {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using namespace validity;

/// Modes whose geometric stiffness is watched: bending twice in each of two planes.
constexpr int most_load_modes = 4;

/// Whether more than one joint holds the body, so that its deflections move other bodies, or are held by
/// them. One that is fixed to the ground, and has no joint to anything else, bends alone.
bool passes_motion_on(const Compiled& m, int body) {
  int joints = 0;
  bool fixed = false, to_others = false;
  for (const spec::Joint& joint : m.spec().joints) {
    const auto body_of = [&](int frame) { return m.frames[m.frame_of_spec[frame]].body; };
    const int a = body_of(joint.frame_a), b = body_of(joint.frame_b);
    if (a != body && b != body) continue;
    ++joints;
    if (a >= 0 && b >= 0) to_others = true;
    if (joint_info(joint.type).velocities == 0) fixed = true;
  }
  return joints > 1 && (to_others || !fixed);
}

void keep(Validity::Peak& peak, double value, double time) {
  if (!(value > peak.value)) return;
  peak.value = value;
  peak.time = time;
}

void keep(Validity::Peak& peak, double value, double time, double limit, double& passed) {
  keep(peak, value, time);
  if (passed < 0 && value > limit) passed = time;
}

}  // namespace

BodyValidity::BodyValidity(const Compiled& m, int index) : body_(index) {
  const BodyData& b = m.bodies[index];
  const spec::Body& spec = m.spec().bodies[b.spec];
  const ReducedBody& body = *spec.flexible;
  worst_.body = spec.name;
  modes_ = body.modes;
  first_amplitude_ = b.q + b.joint_positions;
  first_velocity_ = b.v + b.joint_velocities;
  second_order_ = body.second_order.has_value();
  bars_ = body.triangles.empty();
  piece_ = is_piece(m, index);
  const bool link = !piece_ && passes_motion_on(m, index);
  deflection_limit_ = second_order_
                          ? (link ? validity_limit::deflection_of_second_order_link
                                  : validity_limit::deflection_of_second_order)
                          : (link ? validity_limit::deflection_of_link : validity_limit::deflection);
  functionals_.resize(0, modes_);
  add_points(body);
  add_energies(body);
  if (!second_order_ && !body.lines.empty()) {
    add_lines(body);
    add_loads(m, body);
    if (body.geometric) leave_out_known_loads(*body.geometric);
  }
  values_.setZero(functionals_.rows());
  worst_.deflection.watched = points_.last > points_.first;
  worst_.high_modes.watched = high_energy_.last > high_energy_.first;
  worst_.foreshortening.watched = shortening_.last > shortening_.first;
  worst_.compression.watched = worst_.tension.watched = load_coefficients_.size() > 0;
}

BodyValidity::Range BodyValidity::add_rows(const MatrixXd& rows) {
  const Eigen::Index first = functionals_.rows();
  functionals_.conservativeResize(first + rows.rows(), modes_);
  functionals_.bottomRows(rows.rows()) = rows;
  return {static_cast<int>(first), static_cast<int>(functionals_.rows())};
}

BodyValidity::Range BodyValidity::add_form(const MatrixXd& form) { return add_rows(root(form)); }

void BodyValidity::add_points(const ReducedBody& body) {
  const Points points = points_of(body);
  length_ = extent(points.places);
  if (!(length_ > 0)) return;
  const std::vector<Eigen::Index> chosen = telling_points(points, body.stiffness);
  MatrixXd rows(3 * chosen.size(), modes_);
  for (std::size_t k = 0; k < chosen.size(); ++k)
    rows.middleRows<3>(static_cast<Eigen::Index>(3 * k)) =
        points.shapes.middleRows<3>(3 * chosen[k]) / length_;
  points_ = add_rows(rows);
}

void BodyValidity::add_energies(const ReducedBody& body) {
  const MatrixXd high = high_rows(body);
  if (high.rows() == 0) return;
  energy_ = add_form(body.stiffness);
  high_energy_ = add_rows(high);
}

void BodyValidity::add_lines(const ReducedBody& body) {
  MatrixXd shortening = MatrixXd::Zero(modes_, modes_), stretch = shortening;
  double total = 0;
  for (const Bar& bar : bars_of(body)) {
    const MatrixXd u = difference(body, bar), v = across(bar, u), along = bar.axis.transpose() * u;
    shortening += v.transpose() * v / (2 * bar.length);
    stretch += along.transpose() * along / bar.length;
    total += bar.length;
  }
  if (!(total > 0)) return;
  shortening_ = add_form(shortening / total);
  stretch_ = add_form(stretch / total);
}

void BodyValidity::add_loads(const Compiled& m, const ReducedBody& body) {
  const std::vector<Bar> bars = bars_of(body);
  const Eigenmodes modes = eigenmodes(body);
  load_modes_ = static_cast<int>(std::min<Eigen::Index>(modes.squares.size(), most_load_modes));
  if (bars.empty() || load_modes_ == 0) return;
  const Tree tree = tree_of(body, bars);
  const VectorXd masses = node_masses(body, bars);
  const BodyData& b = m.bodies[body_];
  first_frame_ = b.first_frame;
  last_frame_ = b.last_frame;
  outboard_frame_ = b.outboard_frame;
  const int frames = last_frame_ - first_frame_ + 1;
  load_coefficients_.setZero(load_modes_ * (load_modes_ + 1) / 2, 12 + 3 * frames);
  load_values_.setZero(load_coefficients_.cols());
  stiffening_.setZero(load_coefficients_.rows());

  // ∫ v_i' · v_j' ds over each node's bar and all bars from there to the tangent frame, times their axes:
  // what a force on the node adds to the geometric stiffness.
  const MatrixXd shapes = modes.shapes.leftCols(load_modes_) *
                          modes.squares.head(load_modes_).cwiseSqrt().cwiseInverse().asDiagonal();
  std::vector<MatrixXd> gain(tree.bar.size(), MatrixXd::Zero(load_coefficients_.rows(), 3));
  for (const int node : tree.order) {
    const std::size_t n = static_cast<std::size_t>(node);
    if (tree.bar[n] < 0) continue;
    const Bar& bar = bars[static_cast<std::size_t>(tree.bar[n])];
    const MatrixXd v = across(bar, difference(body, bar) * shapes);
    const MatrixXd square = v.transpose() * v / bar.length;
    const Eigen::Vector3d outward = bar.b == node ? bar.axis : Eigen::Vector3d(-bar.axis);
    gain[n] = gain[static_cast<std::size_t>(tree.parent[n])];
    for (int i = 0, pair = 0; i < load_modes_; ++i)
      for (int j = 0; j <= i; ++j, ++pair) gain[n].row(pair) += square(i, j) * outward.transpose();
    // The node's inertia force: −m (a + B r).
    load_coefficients_.leftCols<3>() -= masses[node] * gain[n];
    for (int row = 0; row < 3; ++row)
      load_coefficients_.middleCols<3>(3 + 3 * row) -=
          masses[node] * gain[n].col(row) * body.nodes.col(node).transpose();
  }
  for (int k = 0; k < frames; ++k) {
    const FrameData& frame = m.frames[k + 1 < frames ? first_frame_ + k : outboard_frame_];
    Eigen::Index node = 0;
    (body.nodes.colwise() - frame.position).colwise().squaredNorm().minCoeff(&node);
    load_coefficients_.middleCols<3>(12 + 3 * k) = gain[static_cast<std::size_t>(node)];
  }
}

void BodyValidity::start_lag(const Compiled& m, const MatrixXd& response, const double* positions,
                             double time) {
  if (load_coefficients_.size() == 0) return;
  const ReducedBody& body = *m.spec().bodies[m.bodies[body_].spec].flexible;
  const Eigenmodes modes = eigenmodes(body);
  lag_.set_modes(body.stiffness, body.damping,
                 modes.shapes * modes.squares.cwiseSqrt().cwiseInverse().asDiagonal(), response);
  lag_.start(positions + first_amplitude_, time);
  worst_.lag.watched = lag_.watched();
}

void BodyValidity::leave_out_known_loads(const GeometricStiffness& known) {
  feels_stress_ = true;
  if (load_coefficients_.size() > 0) load_coefficients_.leftCols<12>().setZero();
  if (known.boundary_loads.rows() > 0) load_coefficients_.resize(0, 0);
}

double BodyValidity::squares(Range range) const {
  return values_.segment(range.first, range.last - range.first).squaredNorm();
}

void BodyValidity::start() {
  for (Validity::Peak* peak : {&worst_.deflection, &worst_.foreshortening, &worst_.compression,
                               &worst_.tension, &worst_.lag, &worst_.held, &worst_.high_modes})
    peak->value = peak->time = 0;
  worst_.axial = 0;
  passed_ = {};
  most_energy_ = most_high_energy_ = 0;
  too_stiff_ = false;
}

void BodyValidity::transfer(StateTransfer& transfer) {
  for (Validity::Peak* peak : {&worst_.deflection, &worst_.foreshortening, &worst_.compression,
                               &worst_.tension, &worst_.lag, &worst_.held, &worst_.high_modes})
    transfer(peak->value, peak->time);
  transfer(worst_.axial, passed_.deflection, passed_.foreshortening, passed_.compression, passed_.tension,
           passed_.lag, passed_.held, passed_.high_modes, most_energy_, most_high_energy_, too_stiff_);
  lag_.transfer(transfer);
}

void BodyValidity::watch(const double* positions, double time) {
  const double* const amplitudes = positions + first_amplitude_;
  values_.setZero();
  for (int c = 0; c < modes_; ++c) {
    const double* const column = functionals_.col(c).data();
    for (Eigen::Index r = 0; r < values_.size(); ++r)
      values_[r] = multiply_add(column[r], amplitudes[c], values_[r]);
  }
  double largest = 0;
  for (int k = points_.first; k < points_.last; k += 3)
    largest = std::max(largest, values_.segment<3>(k).squaredNorm());
  keep(worst_.deflection, std::sqrt(largest), time, deflection_limit_, passed_.deflection);

  const double shortening = squares(shortening_);
  if (shortening > worst_.foreshortening.value) {
    worst_.axial = std::sqrt(squares(stretch_));
    keep(worst_.foreshortening, shortening, time);
    if (passed_.foreshortening < 0 && shortening > std::max(validity_limit::foreshortening, worst_.axial))
      passed_.foreshortening = time;
  }

  if (lag_.watched()) watch_lag(amplitudes, time);

  most_energy_ = std::max(most_energy_, squares(energy_));
  const double high = squares(high_energy_);
  if (high > most_high_energy_) {
    most_high_energy_ = high;
    worst_.high_modes.time = time;
  }
  if (most_energy_ > 0) worst_.high_modes.value = most_high_energy_ / most_energy_;
  if (!(worst_.high_modes.value > validity_limit::high_modes))
    passed_.high_modes = -1;
  else if (passed_.high_modes < 0)
    passed_.high_modes = time;
}

void BodyValidity::watch_lag(const double* amplitudes, double time) {
  lag_.watch(amplitudes, time);
  const double value = lag_.value();
  if (value > worst_.lag.value) worst_.lag.time = time;
  worst_.lag.value = value;
  if (!(value > validity_limit::lag && worst_.deflection.value > validity_limit::lag_from))
    passed_.lag = -1;
  else if (passed_.lag < 0)
    passed_.lag = time;
}

void BodyValidity::watch_held(const HeldStretch::Ratios& ratios, double time) {
  worst_.held.watched = true;
  if (!HeldStretch::exceeds(ratios, worst_.held.value)) return;
  const double exaggeration = HeldStretch::exaggeration(ratios);
  too_stiff_ = exaggeration < 0;
  keep(worst_.held, std::abs(exaggeration), time, validity_limit::held, passed_.held);
}

void BodyValidity::watch_loads(const relative::Workspace<double>& work, double time) {
  if (load_coefficients_.size() == 0) return;
  const auto& motion = work.bodies[body_];
  const Mat3d to_body = motion.rotation.transpose();
  const Vec3d omega = to_body * motion.omega, alpha = to_body * motion.alpha;
  load_values_.head<3>() = to_body * motion.acceleration;
  const Mat3d spin = skew<double>(omega), gradient = skew<double>(alpha) + spin * spin;
  for (int row = 0; row < 3; ++row) load_values_.segment<3>(3 + 3 * row) = gradient.row(row).transpose();
  int at = 12;
  for (int k = first_frame_; k < last_frame_; ++k, at += 3)
    load_values_.segment<3>(at) = to_body * work.wrenches[k].force;
  load_values_.segment<3>(at) = to_body * work.transmitted[body_].force;

  stiffening_.noalias() = load_coefficients_ * load_values_;
  static_assert(most_load_modes == 4);
  Eigen::Matrix4d stiffness = Eigen::Matrix4d::Zero();
  for (int i = 0, pair = 0; i < load_modes_; ++i)
    for (int j = 0; j <= i; ++j, ++pair) stiffness(i, j) = stiffness(j, i) = stiffening_[pair];
  if (lag_.watched()) lag_.stiffen(stiffness);
  const Eigen::Vector4d shares = eigenvalues4(stiffness);
  keep(worst_.compression, -shares[0], time, validity_limit::load, passed_.compression);
  keep(worst_.tension, shares[3], time, validity_limit::load, passed_.tension);
}

const char* BodyValidity::nonlinear() const {
  return piece_          ? "more `substructures`"
         : second_order_ ? "`substructures`"
                         : "`stiffening: foreshortening` or `substructures`";
}

std::string BodyValidity::meaningless() const {
  if (!(worst_.deflection.value > validity_limit::meaningless_deflection)) return {};
  return fmt::format(
      "body '{}' was bent by {:.3g} % of its length (at t = {:.4g} s), far beyond what {} elasticity "
      "describes; "
      "use {}{}, or a part that the forces bend less",
      worst_.body, 100 * worst_.deflection.value, worst_.deflection.time,
      second_order_ ? "second-order" : "linear", nonlinear(), bars_ ? ", `beam: corotational`" : "");
}

std::string BodyValidity::warning() const {
  std::string what, remedy;
  const auto add = [&](const std::string& text, double value, double limit, double time, const char* helps) {
    const std::string size = value > 10 ? "over 1000 %" : fmt::format("{:.3g} %", 100 * value);
    what += fmt::format("{}{} {} (limit {:g} %, from t = {:.4g} s on)", what.empty() ? "" : ", ", text, size,
                        100 * limit, time);
    if (remedy.find(helps) == std::string::npos)
      remedy += (remedy.empty() ? "" : ", and ") + std::string(helps);
  };
  const char* stressed = feels_stress_ ? "`static_modes` along the bars where forces act"
                         : piece_      ? "`stiffening: foreshortening` or more `substructures`"
                                       : nonlinear();
  if (passed_.deflection >= 0)
    add("deflection over length", worst_.deflection.value, deflection_limit_, passed_.deflection,
        nonlinear());
  if (!piece_ && passed_.foreshortening >= 0)
    add("shortening by bending over length", worst_.foreshortening.value, validity_limit::foreshortening,
        passed_.foreshortening, nonlinear());
  if (passed_.tension >= 0)
    add("stiffening by rotation or tension", worst_.tension.value, validity_limit::load, passed_.tension,
        stressed);
  if (passed_.compression >= 0)
    add("compression over buckling load", worst_.compression.value, validity_limit::load, passed_.compression,
        stressed);
  if (!piece_ && passed_.lag >= 0)
    add("error of the deflections, since vibrations are faster or slower under tension or compression, over "
        "their range about",
        worst_.lag.value, validity_limit::lag, passed_.lag, stressed);
  if (passed_.held >= 0)
    add(too_stiff_ ? "deflections too small, since held ends and linear modes press the body, by about"
                   : "deflections too large, since held ends or edges stretch the body as it bends, by about",
        worst_.held.value, validity_limit::held, passed_.held,
        bars_ ? "`stiffening: foreshortening` or `beam: corotational`"
              : "several smaller bodies in its place (of solids between held ends also `mimbre reduce "
                "--geometric-stiffness`)");
  if (!piece_ && passed_.high_modes >= 0)
    add("elastic energy in the highest modes", worst_.high_modes.value, validity_limit::high_modes,
        passed_.high_modes, "more `dynamic_modes`");
  if (what.empty()) return {};
  return fmt::format("body '{}' is beyond {} theory: {}; use {}", worst_.body,
                     second_order_ ? "second-order" : "linear", what, remedy);
}

ValidityMonitor::ValidityMonitor(const Compiled& m) : held_(m) {
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    if (m.bodies[b].modes == 0 || m.flexible[m.bodies[b].flexible].absolute()) continue;
    const auto& held = held_.bodies();
    if (std::find(held.begin(), held.end(), static_cast<int>(b)) != held.end())
      of_held_.push_back(bodies_.size());
    bodies_.emplace_back(m, static_cast<int>(b));
  }
}

void ValidityMonitor::start(const State& state, const State& inputs) {
  for (BodyValidity& b : bodies_) b.start();
  held_.start(state, inputs);
}

void ValidityMonitor::transfer(StateTransfer& transfer) {
  for (BodyValidity& b : bodies_) b.transfer(transfer);
  held_.transfer(transfer);
}

bool ValidityMonitor::watches_loads() const {
  return std::any_of(bodies_.begin(), bodies_.end(),
                     [](const BodyValidity& b) { return b.worst().compression.watched; });
}

void ValidityMonitor::watch(const State& s) {
  for (BodyValidity& b : bodies_) b.watch(s.q.data(), s.time);
  if (of_held_.empty()) return;
  const auto& ratios = held_.find(s.q.data());
  for (std::size_t k = 0; k < ratios.size(); ++k) bodies_[of_held_[k]].watch_held(ratios[k], s.time);
}

void ValidityMonitor::watch_instant(const State& s) {
  watch(s);
  for (BodyValidity& b : bodies_) b.forget_energies();
}

void ValidityMonitor::start_lag(relative::RelativeSystem& system, const State& state) {
  const MatrixXd response = response_at(system, state);
  for (BodyValidity& b : bodies_) {
    const Eigen::Index first = b.first_velocity(), modes = b.modes();
    b.start_lag(system.model(),
                response.size() > 0 ? MatrixXd(response.block(first, first, modes, modes)) : response,
                state.q.data(), state.time);
  }
}

void ValidityMonitor::watch_loads(const relative::Workspace<double>& work, double time) {
  for (BodyValidity& b : bodies_) b.watch_loads(work, time);
}

std::vector<Validity> ValidityMonitor::worst() const {
  std::vector<Validity> all;
  for (const BodyValidity& b : bodies_) all.push_back(b.worst());
  return all;
}

std::vector<std::string> ValidityMonitor::warnings() const {
  std::vector<std::string> all;
  for (const BodyValidity& b : bodies_)
    if (std::string warning = b.warning(); !warning.empty()) all.push_back(std::move(warning));
  return all;
}

std::string ValidityMonitor::meaningless() const {
  const auto farthest =
      std::max_element(bodies_.begin(), bodies_.end(), [](const BodyValidity& a, const BodyValidity& b) {
        return a.worst().deflection.value < b.worst().deflection.value;
      });
  return farthest == bodies_.end() ? std::string() : farthest->meaningless();
}

}  // namespace mimbre

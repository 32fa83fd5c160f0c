#include "simulation/watch/held_stretch.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/relative/system.h"
#include "math/once/decompositions.h"
#include "simulation/watch/validity_measures.h"
#include "spec/output_kind.h"

namespace mimbre {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Deflection over length up to which a state of stress might matter, and the ratio that then does.
constexpr double largest_deflection = 0.2, least_ratio = 0.01;
/// Of the largest in the states' forms: coordinates of bending that stretch it less do not count.
constexpr double negligible_form = 1e-3;
/// Weight of frames' turns, by the distance between them, against their displacements.
constexpr double turn_weight = 0.03;
/// Share of the largest stiffness of the places below which a place does not resist.
constexpr double loose = 1e-9;
/// Square of what a unit motion of the mechanism moves of places that are held: round-off.
constexpr double no_motion = 1e-18;
/// Coordinates of a mechanism that is looked at.
constexpr int most_velocities = 1200;

/// A motion of frames: 3 × modes each.
struct FrameMotion {
  Vector3d position;
  MatrixXd X, X_theta;
};

/// Of the body's frames that joints or forces hold, each once.
std::vector<FrameMotion> held_frames(const Compiled& m, int number) {
  const ReducedBody& body = *m.spec().bodies[m.bodies[number].spec].flexible;
  std::vector<FrameMotion> held;
  const auto add = [&](int frame) {
    if (frame < 0 || m.frames[frame].body != number) return;
    const spec::Frame& s = m.spec().frames[m.frames[frame].spec];
    for (const FrameMotion& known : held)
      if (known.position == s.pose.position) return;
    const MatrixXd none = MatrixXd::Zero(3, body.modes);
    const BodyFrame* f = s.flexible_frame < 0 ? nullptr : &body.frames[s.flexible_frame];
    held.push_back({s.pose.position, f ? MatrixXd(f->X) : none, f ? MatrixXd(f->X_theta) : none});
  };
  for (const spec::Joint& joint : m.spec().joints) {
    if (joint_info(joint.type).velocities == 6) continue;
    add(m.frame_of_spec[joint.frame_a]);
    add(m.frame_of_spec[joint.frame_b]);
  }
  for (const ConstraintData& c : m.constraints)
    for (const ConstraintTerm& term : c.terms) {
      add(term.frame_a);
      add(term.frame_b);
    }
  for (const ElementData& e : m.elements) {
    if (e.measure == Measure::none) continue;
    add(e.frame_a);
    add(e.frame_b);
  }
  return held;
}

/// The rotation nearest to the frames' motion, 3 × modes: by their displacements, and a little by their turns
/// where those leave it open.
MatrixXd nearest_rotation(const std::vector<FrameMotion>& frames, int modes) {
  if (frames.empty()) return MatrixXd::Zero(3, modes);
  Vector3d centre = Vector3d::Zero();
  for (const FrameMotion& f : frames) centre += f.position / static_cast<double>(frames.size());
  double extent = 0;
  for (const FrameMotion& f : frames) extent = std::max(extent, (f.position - centre).norm());
  const double weight = extent > 0 ? std::pow(turn_weight * extent, 2) : 1;
  Matrix3d inertia = Matrix3d::Zero();
  MatrixXd moment = MatrixXd::Zero(3, modes);
  for (const FrameMotion& f : frames) {
    const Matrix3d arm = skew<double>(f.position - centre);
    inertia += weight * Matrix3d::Identity() - arm * arm;
    moment += arm * f.X + weight * f.X_theta;
  }
  return inverse(inertia) * moment;
}

/// With rows of zeros below.
template <int rows>
Eigen::Matrix<double, rows, Eigen::Dynamic> padded(const MatrixXd& matrix) {
  Eigen::Matrix<double, rows, Eigen::Dynamic> out(rows, matrix.cols());
  out.setZero();
  out.topRows(matrix.rows()) = matrix;
  return out;
}

/// Forms ½ zᵀ F z, z = `coordinates` c, by the products c_i c_j with j ≤ i: forms × products.
MatrixXd by_products(const std::vector<MatrixXd>& forms, const MatrixXd& coordinates) {
  const Index count = coordinates.cols();
  MatrixXd out(std::ssize(forms), count * (count + 1) / 2);
  for (Index s = 0; s < out.rows(); ++s) {
    const MatrixXd form = coordinates.transpose() * forms[static_cast<std::size_t>(s)] * coordinates;
    for (Index i = 0, pair = 0; i < count; ++i)
      for (Index j = 0; j <= i; ++j, ++pair) out(s, pair) = i == j ? 0.5 * form(i, i) : form(i, j);
  }
  return out;
}

/// The largest displacement of a point by the amplitudes.
double largest_displacement(const validity::Points& points, const VectorXd& amplitudes) {
  const VectorXd u = points.shapes * amplitudes;
  double most = 0;
  for (Index k = 0; k < points.places.cols(); ++k) most = std::max(most, u.segment<3>(3 * k).norm());
  return most;
}

/// The places that move in the body's own axes; the others are where these are fixed.
std::vector<int> moving_places(const ReducedBody& body) {
  const Stretching& s = *body.stretching;
  std::vector<int> moving;
  for (int place = 0; 6 * place < s.places.cols(); ++place)
    for (std::size_t f = 0; f < body.frames.size(); ++f)
      if (s.place_of_frame[f] == place && !(body.frames[f].X.isZero(0) && body.frames[f].X_theta.isZero(0))) {
        moving.push_back(place);
        break;
      }
  return moving;
}

/// Of all places, by the amplitudes.
MatrixXd place_motions(const ReducedBody& body) {
  MatrixXd motions = MatrixXd::Zero(body.stretching->places.cols(), body.modes);
  for (std::size_t f = 0; f < body.frames.size(); ++f) {
    const Index at = 6 * body.stretching->place_of_frame[f];
    motions.middleRows<3>(at) = body.frames[f].X;
    motions.middleRows<3>(at + 3) = body.frames[f].X_theta;
  }
  return motions;
}

std::vector<Index> motions_of(const std::vector<int>& places) {
  std::vector<Index> motions;
  for (const int place : places)
    for (Index d = 0; d < 6; ++d) motions.push_back(6 * place + d);
  return motions;
}

/// The body with the motions of its places in place of its modes: they move frames, have the places'
/// stiffness and no inertia that anything would ask for.
ReducedBody of_places(const ReducedBody& body, const std::vector<int>& places) {
  const std::vector<Index> motions = motions_of(places);
  const auto modes = static_cast<Index>(motions.size());
  ReducedBody out;
  out.name = body.name;
  out.modes = static_cast<int>(modes);
  out.mode_names.assign(motions.size(), "place");
  out.mass = body.mass;
  out.first_moment = body.first_moment;
  out.second_moment = body.second_moment;
  out.S.setZero(3, modes);
  for (auto& block : out.S_position) block.setZero(3, modes);
  for (auto& row : out.S_modes)
    for (MatrixXd& block : row) block.setZero(modes, modes);
  out.mass_matrix.setIdentity(modes, modes);
  out.stiffness = body.stretching->stiffness(motions, motions);
  out.damping.setZero(modes, modes);
  out.user_from_modal.setZero(modes, modes);  // amplitudes that signals see
  for (std::size_t f = 0; f < body.frames.size(); ++f) {
    BodyFrame frame = body.frames[f];
    frame.X.setZero(3, modes);
    frame.X_theta.setZero(3, modes);
    const auto at = std::find(places.begin(), places.end(), body.stretching->place_of_frame[f]);
    if (at != places.end()) {
      const auto first = 6 * static_cast<Index>(at - places.begin());
      frame.X.middleCols<3>(first).setIdentity();
      frame.X_theta.middleCols<3>(first + 3).setIdentity();
    }
    out.frames.push_back(std::move(frame));
  }
  out.nodes = body.nodes;  // contacts may be with its surface
  out.node_shapes.setZero(3 * body.nodes.cols(), modes);
  out.triangles = body.triangles;
  return out;
}

/// Nobody asks the mechanism with bodies of places for outputs, and what its signals and laws would see of
/// amplitudes, stress or section forces is not there: they see an amplitude, and those are 0 (of_places), or
/// where only sampled signals may see it a momentum, which is 0 at rest.
void forget_recovery(spec::Model& model) {
  model.outputs.clear();
  for (spec::Output& sensor : model.sensors) {
    const OutputInfo& info = output_info(sensor);
    if (info.of != OutputInfo::Of::body) continue;
    if (info.place_sensor) {
      sensor.component = 0;
      continue;
    }
    spec::Output momentum;
    momentum.name = sensor.name;
    momentum.mark = sensor.mark;
    momentum.kind = "linear_momentum";
    sensor = momentum;
  }
}

}  // namespace

/// The mechanism with bodies of places.
struct HeldStretch::Ends {
  std::shared_ptr<const Model> model;
  std::unique_ptr<relative::RelativeSystem> system;
  struct Copied {
    int from = 0, to = 0, count = 0;
  };
  std::vector<Copied> positions;  ///< of the mechanism that is watched, to this one's
  struct Places {
    Index first = 0;   ///< velocity
    MatrixXd motions;  ///< of its moving places, in the scales, by coordinates of unit energy
  };
  std::vector<Places> places;  ///< by watched body
  MatrixXd loads;              ///< velocities × states: Dᵀ
  VectorXd scales;             ///< of the velocity coordinates
  double stiffness = 0;        ///< the largest of the places, in these scales

  Eigen::VectorXd state(const VectorXd& q) const {
    VectorXd out = VectorXd::Zero(system->positions());
    for (const Copied& c : positions) out.segment(c.to, c.count) = q.segment(c.from, c.count);
    return out;
  }
};

HeldStretch::~HeldStretch() = default;
HeldStretch::HeldStretch(HeldStretch&&) noexcept = default;

HeldStretch::HeldStretch(const Compiled& m) {
  std::vector<MatrixXd> places;  // of the states that count, by body
  for (int b = 0; b < static_cast<int>(m.bodies.size()); ++b)
    if (add(m, b, places)) numbers_.push_back(b);
  stretch_.setZero(states_);
  press_.setZero(states_);
  force_.setZero(states_);
  coupling_.setIdentity(states_, states_);
  ratios_.assign(bodies_.size(), Ratios());
  if (!bodies_.empty()) find_held(m, places);
}

bool HeldStretch::add(const Compiled& m, int number, std::vector<MatrixXd>& places) {
  const BodyData& data = m.bodies[number];
  if (data.modes == 0) return false;
  const ReducedBody& body = *m.spec().bodies[data.spec].flexible;
  if (!body.stretching || body.second_order || body.ancf || validity::is_piece(m, number)) return false;
  // The forces of its static modes stretch and stiffen it.
  if (body.geometric && body.geometric->boundary_loads.rows() > 0) return false;
  const validity::Points points = validity::points_of(body);
  const double length = validity::extent(points.places);
  const EigenPairs elastic = symmetric_eigen(body.stiffness);
  Index free = 0;
  const Index all = elastic.values.size();
  while (free < all && !(elastic.values[free] > 1e-12 * elastic.values[all - 1])) ++free;
  if (!(length > 0) || free == all) return false;
  const VectorXd root = elastic.values.tail(all - free).cwiseSqrt();
  const MatrixXd vectors = elastic.vectors.rightCols(all - free),
                 amplitudes = vectors * root.cwiseInverse().asDiagonal();  // by coordinates of unit energy
  MatrixXd whole(body.modes + 3, amplitudes.cols());
  whole << amplitudes, -nearest_rotation(held_frames(m, number), body.modes) * amplitudes;
  const bool turns = !whole.bottomRows<3>().isZero(0);

  Body b;
  b.first_amplitude = data.q + data.joint_positions;
  b.modes = body.modes;
  b.first_state = states_;
  std::vector<MatrixXd> forms, turned;
  std::vector<Index> chosen;
  std::vector<double> strength;
  MatrixXd squares = MatrixXd::Zero(amplitudes.cols(), amplitudes.cols());
  for (std::size_t s = 0; s < body.stretching->forms.size(); ++s) {
    const MatrixXd& own = body.stretching->forms[s];
    const MatrixXd form = amplitudes.transpose() * own.topLeftCorner(body.modes, body.modes) * amplitudes;
    const EigenPairs pairs = symmetric_eigen(form);
    double ratio = 0;
    for (const Index k : {Index{0}, pairs.values.size() - 1}) {
      const double moves = largest_displacement(points, amplitudes * pairs.vectors.col(k));
      if (moves > 0)
        ratio = std::max(ratio, 0.5 * std::pow(pairs.values[k] * largest_deflection * length / moves, 2));
    }
    if (!(ratio > least_ratio)) continue;
    chosen.push_back(static_cast<Index>(s));
    strength.push_back(ratio);
    squares += form * form;
    forms.push_back(form);
    if (!turns) continue;
    turned.push_back(whole.transpose() * own * whole - form);
    squares += turned.back() * turned.back();
  }
  if (forms.empty()) return false;
  const EigenPairs bending = symmetric_eigen(squares);
  Index count = 0;
  const Index last = squares.rows() - 1;
  while (count < std::min<Index>(most_coordinates, squares.rows()) &&
         bending.values[last - count] > negligible_form * negligible_form * bending.values[last])
    ++count;
  const MatrixXd coordinates = bending.vectors.rightCols(count);
  b.unit = amplitudes;
  b.axes = coordinates;
  b.coordinates = static_cast<int>(count);
  b.states = static_cast<int>(forms.size());
  b.bending = padded<most_coordinates>(coordinates.transpose() * root.asDiagonal() * vectors.transpose());
  b.stretch = padded<most_states>(by_products(forms, coordinates));
  if (turns) {
    b.turn = padded<most_states>(by_products(turned, coordinates));
    b.press = padded<most_states>(body.stretching->places(chosen, Eigen::all) * place_motions(body));
  }
  b.compliance.setZero(most_coordinates, count);
  states_ += b.states;
  strength_.conservativeResize(states_);
  strength_.tail(b.states) = Eigen::Map<const VectorXd>(strength.data(), b.states);
  bodies_.push_back(std::move(b));
  places.push_back(body.stretching->places(chosen, Eigen::all));
  return true;
}

void HeldStretch::find_held(const Compiled& m, const std::vector<MatrixXd>& places) {
  std::vector<std::vector<int>> moving;
  spec::Model changed = m.spec();
  bool any = false;
  for (const int number : numbers_) {
    spec::Body& body = changed.bodies[m.bodies[number].spec];
    moving.push_back(moving_places(*body.flexible));
    if (moving.back().empty()) continue;
    any = true;
    body.flexible = std::make_shared<const ReducedBody>(of_places(*body.flexible, moving.back()));
  }
  if (!any) return;
  forget_recovery(changed);
  auto held = std::make_unique<Ends>();
  held->model = Model::compile(std::move(changed));
  const Compiled& h = held->model->compiled();
  bool alike = h.bodies.size() == m.bodies.size() && h.velocities <= most_velocities;
  for (std::size_t b = 0; alike && b < m.bodies.size(); ++b)
    alike = h.bodies[b].spec == m.bodies[b].spec && h.bodies[b].joint_spec == m.bodies[b].joint_spec &&
            h.bodies[b].joint_positions == m.bodies[b].joint_positions;
  if (!alike) {
    numbers_.clear();
    bodies_.clear();
    ratios_.clear();
    return;
  }
  held->system = std::make_unique<relative::RelativeSystem>(h);
  held->places.resize(bodies_.size());
  held->loads.setZero(h.velocities, states_);
  const std::vector<double>& scales = held->system->scales().coordinates;
  held->scales = Eigen::Map<const VectorXd>(scales.data(), h.velocities);
  for (std::size_t b = 0; b < m.bodies.size(); ++b) {
    const BodyData &from = m.bodies[b], &to = h.bodies[b];
    held->positions.push_back({from.q, to.q, from.joint_positions});
    const auto at = std::find(numbers_.begin(), numbers_.end(), static_cast<int>(b));
    if (at == numbers_.end() || moving[static_cast<std::size_t>(at - numbers_.begin())].empty()) {
      held->positions.back().count += from.modes;
      continue;
    }
    const auto k = static_cast<std::size_t>(at - numbers_.begin());
    const ReducedBody& body = *held->model->spec().bodies[to.spec].flexible;
    const int first = to.v + to.joint_velocities;
    held->loads.block(first, bodies_[k].first_state, body.modes, bodies_[k].states) =
        places[k](Eigen::all, motions_of(moving[k])).transpose();
    for (int d = 0; d < body.modes; ++d) held->scales[first + d] = d % 6 < 3 ? h.length_scale : 1;
    const VectorXd s = held->scales.segment(first, body.modes);
    held->stiffness =
        std::max(held->stiffness, body.stiffness.diagonal().cwiseProduct(s.cwiseAbs2()).maxCoeff());
    const MatrixXd motions = place_motions(*m.spec().bodies[from.spec].flexible);
    held->places[k] = {
        first, s.cwiseInverse().asDiagonal() * motions(motions_of(moving[k]), Eigen::all) * bodies_[k].unit};
  }
  held_ = std::move(held);
}

void HeldStretch::start(const State& state, const State& inputs) {
  coupling_.setIdentity(states_, states_);
  for (Body& b : bodies_)
    b.compliance = padded<most_coordinates>(MatrixXd::Identity(b.coordinates, b.coordinates));
  if (held_) find_coupling(state, inputs);
  slack_ = (coupling_.diagonal().array() * strength_.array() <= least_ratio).all();
}

void HeldStretch::find_coupling(const State& state, const State& inputs) {
  relative::RelativeSystem& system = *held_->system;
  const int n = system.velocities();
  const VectorXd q = held_->state(state.q), rest = VectorXd::Zero(n),
                 none = VectorXd::Zero(system.equations());
  VectorXd r(n);
  system.enter(inputs.u.data(), inputs.z.data(), 0);
  system.begin_step(q.data());
  system.residual(state.time, q.data(), rest.data(), rest.data(), none.data(), 0, r.data());
  MatrixXd stiffness(n, n), mass(n, n);
  system.dense_matrix(q.data(), {}, mass.data());
  system.dense_matrix(q.data(), {.stiffness = 1}, stiffness.data());
  stiffness -= mass;
  const VectorXd& s = held_->scales;
  stiffness = (s.asDiagonal() * (0.5 * (stiffness + stiffness.transpose())) * s.asDiagonal()).eval();
  MatrixXd jacobian = MatrixXd::Zero(system.equations(), n);
  for (const JacobianEntry& e : system.jacobian_entries())
    jacobian(e.equation, e.coordinate) += e.value * s[e.coordinate];
  for (Index k = 0; k < jacobian.rows(); ++k)
    if (const double length = jacobian.row(k).norm(); length > 0) jacobian.row(k) /= length;
  // Coordinates that nothing here feels are left out.
  std::vector<Index> felt;
  for (Index k = 0; k < n; ++k)
    if (!jacobian.col(k).isZero(0) || !stiffness.col(k).isZero(0) || !held_->loads.row(k).isZero(0))
      felt.push_back(k);
  const MatrixXd loads = (s.asDiagonal() * held_->loads)(felt, Eigen::all);
  const MatrixXd motions = jacobian.rows() > 0 ? null_space(jacobian(Eigen::all, felt), 1e-9)
                                               : MatrixXd::Identity(std::ssize(felt), std::ssize(felt));
  find_compliance(motions, felt);
  const EigenPairs pairs = symmetric_eigen(motions.transpose() * stiffness(felt, felt) * motions);
  if (!pairs.ok) return;
  const VectorXd compliance = pairs.values.cwiseMax(loose * held_->stiffness).cwiseInverse();
  const MatrixXd work = pairs.vectors.transpose() * (motions.transpose() * loads);
  const EigenPairs left =
      symmetric_eigen(coupling_ - MatrixXd(work.transpose() * compliance.asDiagonal() * work));
  if (!left.ok) return;
  coupling_ = left.vectors * left.values.cwiseMax(0).cwiseMin(1).asDiagonal() * left.vectors.transpose();
}

void HeldStretch::find_compliance(const MatrixXd& motions, const std::vector<Index>& felt) {
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    Body& b = bodies_[k];
    const Ends::Places& places = held_->places[k];
    const Index rows = places.motions.rows();
    if (b.turn.size() == 0 || rows == 0) continue;
    std::vector<Index> own, at;  // rows that are felt, and where among those
    for (Index r = 0; r < rows; ++r) {
      const auto found = std::lower_bound(felt.begin(), felt.end(), places.first + r);
      if (found == felt.end() || *found != places.first + r) continue;
      own.push_back(r);
      at.push_back(found - felt.begin());
    }
    const MatrixXd permitted = motions(at, Eigen::all);
    MatrixXd squares = MatrixXd::Identity(rows, rows);
    squares(own, own) = permitted * permitted.transpose();
    const EigenPairs pairs = symmetric_eigen(squares);
    Index fixed = 0;
    while (pairs.ok && fixed < rows && pairs.values[fixed] < no_motion) ++fixed;
    if (fixed == 0) continue;
    const MatrixXd free = null_space(pairs.vectors.leftCols(fixed).transpose() * places.motions, 1e-9),
                   seen = b.axes.transpose() * free;
    b.compliance = padded<most_coordinates>(seen * seen.transpose());
  }
}

}  // namespace mimbre

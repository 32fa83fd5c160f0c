#include "analysis/modes/mode_shares.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compile/element_name.h"
#include "dynamics/relative/forces.h"
#include "joints/joint_kind.h"
#include "simulation/step/energy.h"

namespace mimbre::linear {

using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr double least_share = 1e-3;  ///< that is listed
constexpr double told = 0.05;         ///< that is put in words
constexpr double blades_move = 0.2;   ///< of the energy: there are waves of the blades
constexpr double one_wave = 0.7;      ///< of the waves: that is what the mode is called by

void sort_shares(std::vector<ModeShare>& shares) {
  std::erase_if(shares, [](const ModeShare& s) { return !(s.share >= least_share); });
  std::stable_sort(shares.begin(), shares.end(),
                   [](const ModeShare& a, const ModeShare& b) { return a.share > b.share; });
}

std::string listed(const std::vector<ModeShare>& shares, std::size_t most) {
  std::string text;
  for (std::size_t k = 0; k < shares.size() && k < most; ++k) {
    if (k > 0 && shares[k].share < told) break;
    const double percent = 100 * shares[k].share;
    text += k > 0 ? ", " : "";
    text += percent < 1 ? fmt::format("{} {:.1g} %", shares[k].name, percent)
                        : fmt::format("{} {:.0f} %", shares[k].name, percent);
  }
  // Of many that share it hardly one says anything.
  if (shares.size() > 1 && shares.front().share < told) {
    double others = 0;
    for (std::size_t k = 1; k < shares.size(); ++k) others += shares[k].share;
    text += fmt::format(" and {} others with {:.3g} %", shares.size() - 1, 100 * others);
  }
  return text;
}

/// Complex vectors by their real parts, and the imaginary ones of those that have such: products with real
/// matrices are made of all at once.
struct Parts {
  MatrixXd columns;
  std::vector<Eigen::Index> real, imaginary;  ///< by vector; -1: none

  explicit Parts(const std::vector<VectorXcd>& vectors) {
    Eigen::Index count = 0;
    for (const VectorXcd& x : vectors) {
      real.push_back(count++);
      imaginary.push_back(x.imag().isZero(0) ? -1 : count++);
    }
    columns.resize(vectors.empty() ? 0 : vectors.front().size(), count);
    for (std::size_t k = 0; k < vectors.size(); ++k) {
      columns.col(real[k]) = vectors[k].real();
      if (imaginary[k] >= 0) columns.col(imaginary[k]) = vectors[k].imag();
    }
  }

  /// A x of each. Columns of zeros at the ends of A take no time.
  std::vector<VectorXcd> times(const Eigen::Ref<const MatrixXd>& A) const {
    Eigen::Index first = 0, end = A.cols();
    while (first < end && A.col(first).isZero(0)) ++first;
    while (end > first && A.col(end - 1).isZero(0)) --end;
    const MatrixXd made = A.middleCols(first, end - first) * columns.middleRows(first, end - first);
    std::vector<VectorXcd> out;
    for (std::size_t k = 0; k < real.size(); ++k) {
      VectorXcd& x = out.emplace_back(made.col(real[k]));
      if (imaginary[k] >= 0) x.imag() = made.col(imaginary[k]);
    }
    return out;
  }
};

}  // namespace

std::string coordinate_words(const Compiled& m, int coordinate) {
  for (const BodyData& b : m.bodies) {
    const int k = coordinate - b.v;
    if (k < 0 || k >= b.size()) continue;
    if (k >= b.joint_velocities)
      return fmt::format("mode {} of '{}'", k - b.joint_velocities + 1,
                         m.spec().bodies[static_cast<std::size_t>(b.spec)].name);
    const std::string& joint = m.spec().joints[static_cast<std::size_t>(b.joint_spec)].name;
    const JointInfo& info = joint_info(b.joint);
    if (info.velocities == 1) return fmt::format("'{}'", joint);
    const bool angle = is_angle(b.joint, k);
    const std::string_view moves = info.moves.empty() ? "xyz" : info.moves;
    const std::size_t place = moves.size() == static_cast<std::size_t>(info.velocities)
                                  ? static_cast<std::size_t>(k)
                                  : static_cast<std::size_t>(k) % moves.size();
    return fmt::format("'{}' {} {}", joint, angle ? "about" : "along", moves[place]);
  }
  return "?";
}

ModeShares::ModeShares(const Linearised& at)
    : at_(at), m_(at.model->compiled()), system_(m_), generalised_(m_.velocities) {
  const State& s = at.state;
  system_.enter_rest(s.u.data(), s.z.data());
  system_.begin_step(s.q.data());
  system_.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
  relative::forces(m_, system_.workspace(), s.time, s.q.data(), s.v.data(), s.a.data(), generalised_.data());
  for (const ElementData& e : m_.elements) {
    const ElementState<double> on = element_state(e, system_.workspace().elements.data());
    stiffness_.emplace_back(on.stiffness, on.stiffness + e.count * e.count);
  }
  blades_ = find_blades(m_);
  for (const Blades& b : blades_) {
    const auto hub = static_cast<std::size_t>(b.hub);
    const Motion<double>& now = system_.workspace().bodies[hub];
    const Mat3d& drawn = m_.spec().bodies[static_cast<std::size_t>(m_.bodies[hub].spec)].pose.rotation;
    hub_spins_.emplace_back(drawn * (now.rotation.transpose() * now.omega));
  }
  double fastest = 0;
  for (const Motion<double>& body : system_.workspace().bodies)
    if (body.omega.norm() > fastest) {
      fastest = body.omega.norm();
      axis_ = body.omega / fastest;
    }
  if (at.turning > 0) axis_ = at.turning_axis;
  still_ = measured_rates(VectorXd::Zero(m_.velocities));  // last, as the system then rests
}

std::vector<double> ModeShares::measured_rates(const VectorXd& v) {
  const State& s = at_.state;
  const VectorXd zero = VectorXd::Zero(m_.velocities);
  system_.kinematics(s.time, s.q.data(), v.data(), zero.data());
  auto& w = system_.workspace();
  relative::measure_elements(m_, w, s.q.data(), v.data(), zero.data());
  std::vector<double> out;
  for (const ElementData& e : m_.elements) {
    const ElementState<double> on = element_state(e, w.elements.data());
    out.insert(out.end(), on.v, on.v + e.count);
  }
  return out;
}

VectorXd ModeShares::body_energies(const VectorXcd& v) {
  const State& s = at_.state;
  const VectorXd zero = VectorXd::Zero(m_.velocities);
  VectorXd energy = VectorXd::Zero(std::ssize(m_.bodies));
  auto& w = system_.workspace();
  for (const VectorXd& part : {VectorXd(v.real()), VectorXd(v.imag())}) {
    if (part.isZero(0)) continue;
    system_.kinematics(s.time, s.q.data(), part.data(), zero.data());
    for (std::size_t i = 0; i < m_.bodies.size(); ++i)
      add_kinetic_energy(m_, w, i, s.q.data(), part.data(), energy[static_cast<Eigen::Index>(i)]);
  }
  return energy;
}

void ModeShares::add_elastic(const VectorXcd& motion, Mode& mode, double all) {
  std::vector<std::vector<double>> parts;
  for (const VectorXd& part : {VectorXd(motion.real()), VectorXd(motion.imag())})
    if (!part.isZero(0)) parts.push_back(measured_rates(part));
  for (std::vector<double>& part : parts)
    for (std::size_t k = 0; k < part.size(); ++k) part[k] -= still_[k];
  double elastic = 0;
  std::size_t first = 0;
  for (std::size_t k = 0; k < m_.elements.size(); ++k) {
    const ElementData& e = m_.elements[k];
    const std::vector<double>& stiffness = stiffness_[k];
    double energy = 0;
    const auto n = static_cast<std::size_t>(e.count);
    for (const std::vector<double>& part : parts)
      for (std::size_t r = 0; r < n; ++r)
        for (std::size_t c = 0; c < n; ++c)
          energy += 0.5 * stiffness[r * n + c] * part[first + r] * part[first + c];
    first += n;
    if (energy == 0) continue;
    elastic += energy;
    mode.elastic.push_back({element_name(m_, e), energy});
  }
  for (const BodyData& b : m_.bodies) {
    if (b.modes == 0) continue;
    const FlexibleData& f = m_.flexible[b.flexible];
    const VectorXcd y = motion.segment(b.v + b.joint_velocities, b.modes);
    double energy = 0;
    for (int r = 0; r < b.modes; ++r)
      for (int c = 0; c < b.modes; ++c) energy += 0.5 * f.stiffness(r, c) * std::real(std::conj(y[r]) * y[c]);
    if (energy == 0) continue;
    elastic += energy;
    mode.elastic.push_back(
        {fmt::format("body '{}'", m_.spec().bodies[static_cast<std::size_t>(b.spec)].name), energy});
  }
  double size = 0;
  for (const ModeShare& s : mode.elastic) size += std::abs(s.share);
  const double whole = std::max(std::abs(all), size);
  mode.gravity = whole > 0 ? (all - elastic) / whole : 0;
  if (!(size > 0)) {
    mode.elastic.clear();
    return;
  }
  for (ModeShare& s : mode.elastic) s.share = std::abs(s.share) / size;
  sort_shares(mode.elastic);
}

/// Velocities and angular velocities (times the length scale) of bodies and of frames on flexible bodies, of
/// the points that lie on the axis.
std::vector<Vec3d> ModeShares::velocities_on_axis(const VectorXd& v) {
  const State& s = at_.state;
  const VectorXd zero = VectorXd::Zero(m_.velocities);
  system_.kinematics(s.time, s.q.data(), v.data(), zero.data());
  std::vector<Vec3d> out;
  const auto add = [&](const Motion<double>& x) {
    const Vec3d off = x.position - at_.turning_place, across = off - axis_ * axis_.dot(off);
    out.emplace_back(x.velocity - x.omega.cross(across));
    out.emplace_back(m_.length_scale * x.omega);
  };
  for (const Motion<double>& body : system_.workspace().bodies) add(body);
  for (int k = 0; k < static_cast<int>(m_.frames.size()); ++k)
    if (m_.frames[k].flexible >= 0)
      add(relative::output_motion(system_, k, s.q.data(), v.data(), zero.data()));
  return out;
}

/// With x + i y of the transverse components, x = Re(X e^{λt}): ½ (X + i Y) e^{λt} + ½ conj(X − i Y) e^{λ̄t}.
ModeShares::Orbits ModeShares::orbits(const VectorXcd& motion) {
  Orbits out;
  if (axis_.isZero(0)) return out;
  const std::vector<Vec3d> still = velocities_on_axis(VectorXd::Zero(m_.velocities)),
                           real = velocities_on_axis(motion.real()), imag = velocities_on_axis(motion.imag());
  const Vec3d first = axis_.unitOrthogonal(), second = axis_.cross(first);
  const std::complex<double> i(0, 1);
  for (std::size_t k = 0; k < still.size(); ++k) {
    const Vec3d a = real[k] - still[k], b = imag[k] - still[k];
    const auto along = [&](const Vec3d& e) { return std::complex<double>(a.dot(e), b.dot(e)); };
    const std::complex<double> x = along(first), y = along(second);
    out.forward += 0.5 * std::norm(x + i * y);
    out.backward += 0.5 * std::norm(x - i * y);
    out.axial += std::norm(along(axis_));
  }
  return out;
}

void ModeShares::find_whirl(const VectorXcd& motion, Mode& mode) {
  mode.fixed = mode.value;
  const Orbits o = orbits(motion);
  const double across = o.forward + o.backward;
  mode.whirl = mode.kind == Mode::Kind::oscillating && across > 0 ? (o.forward - o.backward) / across : 0;
  if (!(at_.turning > 0)) return;
  constexpr double none = 1e-6;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (!(across + o.axial > 0)) {
    // A mode of signals alone is the same from everywhere.
    if (!motion.isZero(0)) mode.fixed = {nan, nan};
  } else if (across <= none * o.axial) {
    mode.whirl = 0;
  } else if (mode.kind != Mode::Kind::oscillating) {
    // Both senses at once: the ground sees Ω.
    if (mode.kind == Mode::Kind::real) mode.fixed = {mode.value.real(), at_.turning};
  } else if (o.backward <= none * across && o.axial <= none * across) {
    mode.fixed = mode.value + std::complex<double>(0, at_.turning);
  } else if (o.forward <= none * across && o.axial <= none * across) {
    const double seen = at_.turning - mode.value.imag();
    mode.fixed = {mode.value.real(), std::abs(seen)};
    mode.whirl = seen >= 0 ? 1 : -1;
  } else {
    mode.fixed = {nan, nan};
  }
}

void ModeShares::find_waves(const VectorXd& energies, Mode& mode) {
  double most = blades_move;
  for (std::size_t k = 0; k < blades_.size(); ++k) {
    double share = 0;
    for (const std::vector<int>& one : blades_[k].coordinates)
      for (const int coordinate : one) share += energies[coordinate];
    if (!(share >= most)) continue;
    most = share;
    mode.blades = blade_waves(blades_[k], mode.motion, system_.scales().coordinates, hub_spins_[k]);
    sort_shares(mode.blades);
  }
}

/// Where the states of force elements, blocks and integrals take part by more than positions and velocities:
/// by whom they belong to, shares of |w̄ₖ xₖ| of all (participation factors: wᴴ x = 1).
std::vector<ModeShare> ModeShares::shares_of_states(const Mode& mode) const {
  const Reduced& r = at_.reduced;
  std::vector<ModeShare> out;
  if (r.states == 0 || mode.left.size() != r.A.rows() || mode.shape.size() != r.A.rows() ||
      mode.kind == Mode::Kind::rigid)
    return out;
  const VectorXd takes_part = mode.left.cwiseProduct(mode.shape.conjugate()).cwiseAbs();
  const double all = takes_part.sum();
  if (!(takes_part.tail(r.states).sum() > 0.5 * all)) return out;
  for (int k = 0; k < r.states; ++k) {
    const Parameter& p = at_.parameters[static_cast<std::size_t>(k)];
    const auto state = static_cast<std::size_t>(r.first_state() + k);
    const std::string name =
        p.kind == Parameter::Kind::element_state
            ? element_name(m_, m_.elements[static_cast<std::size_t>(
                                   at_.elements[static_cast<std::size_t>(p.item)].element)])
            : at_.names.states[state].name;
    const double share = takes_part[r.first_state() + k] / all;
    const auto known =
        std::find_if(out.begin(), out.end(), [&](const ModeShare& s) { return s.name == name; });
    if (known == out.end())
      out.push_back({name, share});
    else
      known->share += share;
  }
  sort_shares(out);
  return out;
}

std::string ModeShares::words(const Mode& mode, const VectorXcd& shape) const {
  std::string text;
  const auto add = [&](const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
  if (mode.kind == Mode::Kind::rigid) add("rigid");
  const bool one = !mode.blades.empty() && mode.blades[0].share >= one_wave;
  if (one) add("blades " + mode.blades[0].name);
  if (const std::vector<ModeShare> states = shares_of_states(mode); !states.empty())
    add("states of " + listed(states, 2));
  if (!mode.coordinates.empty()) add(listed(mode.coordinates, 3));
  if (mode.coordinates.empty() && at_.reduced.states > 0) {
    Eigen::Index largest = 0;
    shape.tail(at_.reduced.states).cwiseAbs().maxCoeff(&largest);
    add(at_.names.states[static_cast<std::size_t>(at_.reduced.first_state() + largest)].name);
  }
  if (mode.kind != Mode::Kind::rigid && !mode.elastic.empty()) add(listed(mode.elastic, 2));
  if (!one && mode.kind == Mode::Kind::oscillating && std::abs(mode.whirl) > 0.2)
    add(mode.whirl > 0 ? "forward whirl" : "backward whirl");
  if (mode.grows) add("grows");
  return text;
}

/// M v, of each part.
VectorXcd ModeShares::momentum(const VectorXcd& v) {
  const State& s = at_.state;
  const VectorXd zero = VectorXd::Zero(m_.velocities), none = VectorXd::Zero(m_.equations);
  VectorXd without(m_.velocities), with(m_.velocities);
  VectorXcd out(m_.velocities);
  const auto inertia = [&](const VectorXd& a, VectorXd& r) {
    system_.residual(s.time, s.q.data(), zero.data(), a.data(), none.data(), 0, r.data());
  };
  inertia(zero, without);
  inertia(v.real(), with);
  out.real() = with - without;
  inertia(v.imag(), with);
  out.imag() = with - without;
  return out;
}

VectorXcd ModeShares::motion_of(const Mode& mode) const {
  const Reduced& r = at_.reduced;
  return Parts({mode.shape}).times(r.position.leftCols(r.A.cols())).front();
}

void ModeShares::see_from_ground(Mode& mode) { find_whirl(motion_of(mode), mode); }

void ModeShares::describe(std::vector<Mode>& modes, const std::vector<char>& mixed) {
  const Reduced& r = at_.reduced;
  const auto states = r.A.cols();
  std::vector<VectorXcd> shapes, moves, positions;
  for (const Mode& mode : modes) {
    shapes.push_back(mode.shape);
    positions.push_back(mode.shape.head(r.coordinates));
  }
  const Parts parts(shapes);
  std::vector<VectorXcd> motions = parts.times(r.position.leftCols(states)),
                         velocities = parts.times(r.velocity.leftCols(states));
  for (std::size_t k = 0; k < modes.size(); ++k) {
    Mode& mode = modes[k];
    mode.motion = std::move(motions[k]);
    // A rigid motion has no velocity of its own, unless it drifts; nor has one that only the turning axes
    // see.
    const bool still = mode.kind == Mode::Kind::rigid ||
                       velocities[k].norm() <= 1e-6 * std::abs(mode.value) * mode.motion.norm();
    moves.push_back(still && mode.motion.norm() > 0 ? mode.motion : std::move(velocities[k]));
  }
  const std::vector<VectorXcd> momenta = Parts(moves).times(at_.derivatives.mass);
  // With rolling, K is not square: no energy goes by it.
  const bool square = r.coordinates == r.speeds;
  const std::vector<VectorXcd> forces =
      square ? Parts(positions).times(r.stiffness) : std::vector<VectorXcd>();
  for (std::size_t k = 0; k < modes.size(); ++k) {
    describe(modes[k], moves[k], momenta[k], square ? 0.5 * std::real(positions[k].dot(forces[k])) : 0,
             mixed[k] != 0);
    if (!square) modes[k].gravity = 0;
  }
}

void ModeShares::describe_motion(Mode& mode, double stiffness_energy, bool mixed) {
  describe(mode, mode.motion, momentum(mode.motion), stiffness_energy, mixed);
}

void ModeShares::describe(Mode& mode, const VectorXcd& moves, const VectorXcd& momentum,
                          double stiffness_energy, bool mixed) {
  VectorXd energy(moves.size());
  for (Eigen::Index k = 0; k < moves.size(); ++k)
    energy[k] = std::abs(std::real(std::conj(moves[k]) * momentum[k]));
  if (const double all = energy.sum(); all > 0) energy /= all;
  for (Eigen::Index k = 0; k < moves.size(); ++k)
    if (energy[k] >= least_share)
      mode.coordinates.push_back({coordinate_words(m_, static_cast<int>(k)), energy[k]});
  sort_shares(mode.coordinates);
  const VectorXd energies = body_energies(moves);
  if (const double sum = energies.cwiseAbs().sum(); sum > 0)
    for (std::size_t k = 0; k < m_.bodies.size(); ++k)
      mode.bodies.push_back({m_.spec().bodies[static_cast<std::size_t>(m_.bodies[k].spec)].name,
                             std::abs(energies[static_cast<Eigen::Index>(k)]) / sum});
  sort_shares(mode.bodies);
  add_elastic(mode.motion, mode, stiffness_energy);
  find_whirl(mode.motion, mode);
  if (!mixed) find_waves(energy, mode);
  mode.text = words(mode, mode.shape);
}

}  // namespace mimbre::linear

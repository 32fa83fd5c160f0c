#include "simulation/step/energy_keeper.h"

#include <algorithm>
#include <array>

#include "dynamics/relative/shift.h"

namespace mimbre {
namespace {

/// A correction takes at most this part of the energy that it works with.
constexpr double largest_share = 0.1;

}  // namespace

EnergyKeeper::EnergyKeeper(const Compiled& model, const std::vector<FreeGroup>& groups)
    : model_(model),
      groups_(groups),
      sets_(floating_sets(model)),
      meter_(model),
      momenta_(groups.size()),
      set_momenta_(sets_.size()),
      rotations_(groups.size()) {}

/// The turn at a share λ: θ = −λ g / 2T, g the gain of energy per angle, T the energy of rotation.
Mat3d EnergyKeeper::turn_of(std::size_t group, double share) const {
  const flight::Rotation<double>& r = rotations_[group];
  if (groups_[group].rigid || !(r.energy > 0)) return Mat3d::Identity();
  return rotation_exp<double>(Vec3d(-share / (2 * r.energy) * r.gain));
}

/// Energy that a correction by λ adds: velocities times 1 − λ/2, turns θ(λ).
double EnergyKeeper::gain(double share) const {
  const double factor = 1 - 0.5 * share;
  double sum = (factor * factor - 1) * inner_;
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    const Mat3d turn = turn_of(k, share);
    sum += flight::rotation_of<double>(turn * momenta_[k].inertia * turn.transpose(), momenta_[k].angular)
               .energy -
           rotations_[k].energy;
  }
  return sum;
}

void EnergyKeeper::end(relative::RelativeSystem& observer, natural::NaturalSystem* natural, const State& s,
                       const EnergyMeter& meter, State& state) {
  meter_ = meter;
  meter_.update(observer, s);
  auto& work = observer.workspace();
  const double excess = meter_.last_input() + state.energy_error;
  const double kinetic = kinetic_energy(model_, work, s.q.data(), s.v.data());
  // With E the energies: minimise Σ E (relative change)², subject to the change of energy.
  double mean = 0, turning = 0;
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    momenta_[k] = relative::momentum<double>(model_, work, groups_[k].bodies, s.q.data(), s.v.data());
    const relative::Momentum& p = momenta_[k];
    rotations_[k] = flight::rotation_of<double>(p.inertia, p.angular);
    mean += 0.5 * p.linear.dot(p.velocity()) + rotations_[k].energy;
    if (!groups_[k].rigid && rotations_[k].energy > 0)
      turning += rotations_[k].gain.squaredNorm() / (2 * rotations_[k].energy);
  }
  for (std::size_t k = 0; k < sets_.size(); ++k) {
    set_momenta_[k] = relative::momentum<double>(model_, work, sets_[k].bodies, s.q.data(), s.v.data());
    const relative::Momentum& p = set_momenta_[k];
    mean += 0.5 * p.linear.dot(p.velocity()) + flight::rotation_of<double>(p.inertia, p.angular).energy;
  }
  inner_ = model_.drives.empty() ? std::max(0.0, kinetic - mean) : 0;
  const double slope = inner_ + turning;
  double share = 0;
  if (slope > 1e-14 * kinetic)
    for (int round = 0; round < 3; ++round)
      share = std::clamp(share + (excess + gain(share)) / slope, -largest_share, largest_share);
  if (inner_ > 0) scale(observer, natural, -0.5 * share, state);
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    if (groups_[k].rigid) continue;
    const relative::Momentum& p = momenta_[k];
    RigidShift shift;
    shift.centre = p.centre;
    shift.velocity = p.velocity();
    shift.turn = turn_of(k, share);
    shift.spin = relative::mean_spin<double>(shift.turn * p.inertia * shift.turn.transpose(),
                                             p.angular - shift.turn * p.angular);
    shift_group(observer, natural, groups_[k], shift, state);
  }
}

/// Velocities relative to the mean motion times 1 + by.
void EnergyKeeper::scale(relative::RelativeSystem& observer, natural::NaturalSystem* natural, double by,
                         State& state) {
  state.v *= 1 + by;
  const auto leave_mean = [&](const relative::Momentum& p, const std::vector<char>& has, const auto& roots) {
    const Vec3d spin = relative::mean_spin<double>(p.inertia, p.angular);
    const Vec3d velocity = p.velocity() - spin.cross(p.centre);  // at the common point
    if (natural)
      natural->add_rigid_motion(has, -by, velocity, spin, observer.workspace().origin, state);
    else
      for (const int root : roots)
        relative::add_rigid_motion(model_, observer.workspace(), root, -by, velocity, spin, state);
  };
  for (std::size_t k = 0; k < groups_.size(); ++k)
    leave_mean(momenta_[k], groups_[k].has, std::array{groups_[k].root});
  for (std::size_t k = 0; k < sets_.size(); ++k) leave_mean(set_momenta_[k], sets_[k].has, sets_[k].roots);
}

}  // namespace mimbre

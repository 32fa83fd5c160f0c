#include "simulation/step/free_flight.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "dynamics/relative/shift.h"
#include "spec/force_law.h"

namespace mimbre {
namespace {

/// Equations without some of inertia's terms keep no momentum, so that there is none to restore.
bool conserves(const Compiled& m, const std::vector<int>& bodies) {
  return std::all_of(bodies.begin(), bodies.end(), [&](int k) {
    const BodyData& b = m.bodies[static_cast<std::size_t>(k)];
    return b.neglected.empty() || b.elastodynamic;
  });
}

/// What ties the trees of bodies to each other and to the ground, besides the joints that they stand on.
struct Ties {
  std::vector<int> root;                   ///< by body
  std::vector<std::pair<int, int>> pairs;  ///< of roots; -1: the ground
  std::vector<char> tied;                  ///< by root: to anything, or it has no floating joint
};

Ties find_ties(const Compiled& m) {
  const int count = static_cast<int>(m.bodies.size());
  Ties t;
  t.root.resize(m.bodies.size());
  t.tied.assign(m.bodies.size(), 0);
  const auto add = [&](int a, int b) {
    if (a == b) return;
    t.pairs.emplace_back(a, b);
    if (a >= 0) t.tied[a] = 1;
    if (b >= 0) t.tied[b] = 1;
  };
  for (int i = 0; i < count; ++i) {
    const BodyData& b = m.bodies[i];
    t.root[i] = b.parent < 0 ? i : t.root[b.parent];
    if (b.parent < 0 && !joint_info(b.joint).free()) add(i, -1);
  }
  const auto root_of = [&](int frame) {
    return frame < 0 || m.frames[frame].body < 0 ? -1 : t.root[m.frames[frame].body];
  };
  const auto tie = [&](int frame_a, int frame_b) { add(root_of(frame_a), root_of(frame_b)); };
  for (const LoopData& l : m.loops) tie(l.frame_a, l.frame_b);
  for (const ConstraintData& c : m.constraints)
    for (const ConstraintTerm& term : c.terms) tie(term.frame_a, term.frame_b);
  for (const ElementData& e : m.elements) {
    // Of a sum the legs act.
    const bool acts = e.leg || (e.measure != Measure::sum && law_info(e.law).list != SpecList::sensors);
    if (e.measure == Measure::none || !acts || e.pooled) continue;
    if (e.body < 0)
      tie(e.frame_a, e.frame_b);
    else if (m.bodies[e.body].parent < 0)
      add(e.body, -1);
  }
  for (const SwarmData& swarm : m.swarms)
    for (const SwarmSphere& sphere : swarm.spheres) tie(swarm.spheres[0].frame, sphere.frame);
  for (const DriveData& d : m.drives)
    if (m.bodies[d.body].parent < 0) add(d.body, -1);
  return t;
}

}  // namespace

std::vector<FloatingSet> floating_sets(const Compiled& m) {
  const Ties ties = find_ties(m);
  // Of each root the lowest one that it is tied to; -1: the ground.
  std::vector<int> lowest(m.bodies.size());
  for (std::size_t i = 0; i < lowest.size(); ++i) lowest[i] = static_cast<int>(i);
  const auto of = [&](int root) { return root < 0 ? -1 : lowest[root]; };
  for (bool changes = true; changes;) {
    changes = false;
    for (const auto& [a, b] : ties.pairs) {
      const int low = std::min(of(a), of(b));
      for (const int root : {a, b})
        if (root >= 0 && lowest[root] != low) {
          lowest[root] = low;
          changes = true;
        }
    }
  }
  std::vector<FloatingSet> sets;
  const int count = static_cast<int>(m.bodies.size());
  for (int first = 0; first < count; ++first) {
    if (ties.root[first] != first || lowest[first] != first || !ties.tied[first]) continue;
    FloatingSet set;
    set.has.assign(m.bodies.size(), 0);
    double mass = 0;
    for (int i = 0; i < count; ++i) {
      if (lowest[ties.root[i]] != first) continue;
      if (ties.root[i] == i) set.roots.push_back(i);
      set.bodies.push_back(i);
      set.has[i] = 1;
      mass += m.bodies[i].mass;
    }
    if (mass > 0 && conserves(m, set.bodies)) sets.push_back(std::move(set));
  }
  return sets;
}

std::vector<FreeGroup> free_groups(const Compiled& m) {
  const int count = static_cast<int>(m.bodies.size());
  const Ties ties = find_ties(m);
  const std::vector<int>& root = ties.root;
  std::vector<FreeGroup> groups;
  for (int i = 0; i < count; ++i) {
    if (root[i] != i || ties.tied[i]) continue;
    FreeGroup g;
    g.root = i;
    g.has.assign(m.bodies.size(), 0);
    g.rigid = true;
    double mass = 0;
    for (int k = 0; k < count; ++k) {
      if (root[k] != i) continue;
      g.bodies.push_back(k);
      g.has[k] = 1;
      mass += m.bodies[k].mass;
      g.rigid = g.rigid && m.bodies[k].modes == 0 && (k == i || m.bodies[k].joint_velocities == 0);
    }
    for (const ElementData& e : m.elements) {
      if (e.measure != Measure::none) continue;
      const int body = m.frames[e.frame_b].body;
      if (body >= 0 && root[body] == i) g.loads.push_back(m.arguments[e.arguments]);
    }
    if (mass > 0 && conserves(m, g.bodies)) groups.push_back(std::move(g));
  }
  return groups;
}

FreeFlight::FreeFlight(const Compiled& model)
    : model_(model), groups_(free_groups(model)), starts_(groups_.size()) {
  for (const FreeGroup& g : groups_) changes_shape_ = changes_shape_ || !g.rigid;
  if (!changes_shape_) return;
  start_q_.setZero(model.positions);
  rates_.setZero(model.velocities);
}

bool FreeFlight::loaded(const FreeGroup& group, const SignalValues<double>& signals) const {
  // What motion decides is known with the forces only.
  return std::any_of(group.loads.begin(), group.loads.end(), [&](int slot) {
    return slot >= model_.signals.first_moving || signals.value[slot] != 0;
  });
}

void FreeFlight::begin(relative::RelativeSystem& observer, const State& s) {
  origin_ = observer.workspace().origin;
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    Start& start = starts_[k];
    start.loaded = loaded(groups_[k], observer.workspace().signals);
    if (start.loaded) continue;
    static_cast<flight::Start<double>&>(start) = flight::start_of<double>(
        relative::momentum<double>(model_, observer.workspace(), groups_[k].bodies, s.q.data(), s.v.data()));
  }
  if (changes_shape_) start_q_ = s.q;
}

void FreeFlight::end(relative::RelativeSystem& observer, natural::NaturalSystem* natural, const State& s,
                     double h, State& state) {
  if (changes_shape_) find_gains(observer, s, h);
  for (std::size_t k = 0; k < groups_.size(); ++k) {
    const Start& start = starts_[k];
    if (start.loaded || loaded(groups_[k], observer.workspace().signals)) continue;
    const relative::Momentum p =
        relative::momentum<double>(model_, observer.workspace(), groups_[k].bodies, s.q.data(), s.v.data());
    const RigidShift shift =
        flight::restoring_shift<double>(start, p, model_.gravity, origin_ - observer.workspace().origin, h);
    shift_group(observer, natural, groups_[k], shift, state);
  }
}

/// What the energies of rotation gain over the step by the change of shape that the step made: the power of
/// the rates that make it, the mean of that at both ends. So nothing is left over when a shape returns, as it
/// were if the velocities were taken, which are those of the positions but for the rule's error.
void FreeFlight::find_gains(relative::RelativeSystem& observer, const State& s, double h) {
  flight::set_rates<double>(model_, start_q_.data(), s.q.data(), s.v.data(), h, rates_.data());
  for (Start& start : starts_) start.gain = 0;
  const auto add_at = [&](double time, const double* q) {
    observer.kinematics(time, q, rates_.data(), s.a.data());
    for (std::size_t k = 0; k < groups_.size(); ++k)
      if (!groups_[k].rigid && !starts_[k].loaded)
        starts_[k].gain +=
            0.5 * h *
            relative::centrifugal_power<double>(
                relative::momentum<double>(model_, observer.workspace(), groups_[k].bodies, q, rates_.data()),
                starts_[k].angular);
  };
  add_at(s.time - h, start_q_.data());
  add_at(s.time, s.q.data());
  observer.kinematics(s.time, s.q.data(), s.v.data(), s.a.data());
}

void shift_group(relative::RelativeSystem& observer, natural::NaturalSystem* natural, const FreeGroup& group,
                 const RigidShift& shift, State& state) {
  if (natural)
    natural->shift(group.has, shift, observer.workspace().origin, state);
  else
    relative::shift_root<double>(observer.model(), observer.workspace(), group.root, shift,
                                 {state.q.data(), state.v.data(), state.a.data(), state.algorithmic.data()});
}

}  // namespace mimbre

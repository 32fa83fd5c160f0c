#include "simulation/step/swarm_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "compile/struck_mass.h"
#include "forces/contact.h"
#include "forces/contact_states.h"
#include "forces/element_ends.h"

namespace mimbre {
namespace {

namespace states = contact_states;

/// Two spheres are near each other where their gap is shorter than this share of the smaller radius and what
/// they come closer by in that many steps.
constexpr double near_share = 0.1, near_steps = 2;

/// Pairs that are held while they are collected, for each place: the nearest of them are kept.
constexpr std::size_t collected_per_place = 2;

std::size_t places(const SwarmData& swarm) { return static_cast<std::size_t>(swarm.last - swarm.first); }

/// Of an impact, π √(m/2k) of two equal masses: with longer steps energies are off, and steps are repeated in
/// parts over and over.
constexpr double most_of_impact = 0.25, advised_of_impact = 0.1;

}  // namespace

std::vector<std::string> swarm_warnings(const Compiled& m, double h) {
  namespace law = forces::contact;
  std::vector<std::string> warnings;
  for (std::size_t k = 0; k < m.swarms.size(); ++k) {
    const SwarmData& swarm = m.swarms[k];
    if (swarm.first == swarm.last) continue;
    const double* numbers = m.numbers.data() + m.elements[swarm.first].numbers;
    const double impact = std::numbers::pi * std::sqrt(struck_mass(m, swarm) / numbers[law::stiffness]);
    if (numbers[law::exponent] != 1 || !(h > most_of_impact * impact)) continue;
    warnings.push_back(fmt::format(
        "contact '{}': an impact of its lightest spheres takes {:.3g} s (π √(m/2k)), the step {:.3g} s; "
        "a swarm's impacts are not followed one by one: take steps of {:.2g} s",
        m.spec().contacts[k].name, impact, h, advised_of_impact * impact));
  }
  return warnings;
}

SwarmSearch::SwarmSearch(const Compiled& m) : model_(m) {
  std::size_t most_places = 0;
  for (const SwarmData& swarm : m.swarms) {
    most_spheres_ = std::max(most_spheres_, swarm.spheres.size());
    most_places = std::max(most_places, places(swarm));
  }
  if (none()) return;
  std::size_t slots = 1;
  while (slots < 2 * most_spheres_) slots *= 2;
  heads_.resize(slots);
  next_.resize(most_spheres_);
  cells_.resize(most_spheres_);
  pairs_.reserve(collected_per_place * most_places + 1);
}

std::size_t SwarmSearch::slot_of(const Cell& cell) const {
  // Large odd numbers spread neighbours over the slots (Teschner et al., Vision, Modeling, Visualization,
  // 2003).
  const auto mixed = static_cast<std::uint64_t>(cell[0]) * 73856093u ^
                     static_cast<std::uint64_t>(cell[1]) * 19349663u ^
                     static_cast<std::uint64_t>(cell[2]) * 83492791u;
  return static_cast<std::size_t>(mixed) & (heads_.size() - 1);
}

void SwarmSearch::keep_nearest(std::size_t count) {
  if (pairs_.size() <= count) return;
  std::nth_element(
      pairs_.begin(), pairs_.begin() + static_cast<std::ptrdiff_t>(count), pairs_.end(),
      [](const Pair& a, const Pair& b) { return a.gap != b.gap ? a.gap < b.gap : a.key < b.key; });
  pairs_.resize(count);
}

void SwarmSearch::collect(const SwarmData& swarm, const relative::Workspace<double>& w, double h) {
  const auto count = static_cast<int>(swarm.spheres.size());
  const auto motion = [&](int k) -> const Motion<double>& { return w.frames[swarm.spheres[k].frame]; };
  Vec3d mean = Vec3d::Zero();
  for (int k = 0; k < count; ++k) mean += motion(k).velocity / count;
  double fastest = 0, largest = 0;
  for (int k = 0; k < count; ++k) {
    fastest = std::max(fastest, (motion(k).velocity - mean).norm());
    largest = std::max(largest, swarm.spheres[k].radius);
  }
  const double falling = near_steps * near_steps * h * h * model_.gravity.norm();
  const double width = (2 + near_share) * largest + 2 * near_steps * h * fastest + falling;
  pairs_.clear();
  std::fill(heads_.begin(), heads_.end(), -1);
  for (int b = 0; b < count; ++b) {
    const Vec3d& place = motion(b).position;
    // What has left all bounds meets nothing.
    if (!((place / width).cwiseAbs().maxCoeff() < 1e15)) continue;
    Cell& cell = cells_[static_cast<std::size_t>(b)];
    for (int i = 0; i < 3; ++i) cell[i] = static_cast<std::int64_t>(std::floor(place[i] / width));
    for (int i = 0; i < 27; ++i) {
      const Cell there{cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1};
      for (int a = heads_[slot_of(there)]; a >= 0; a = next_[static_cast<std::size_t>(a)]) {
        if (cells_[static_cast<std::size_t>(a)] != there) continue;
        const SwarmSphere &on = swarm.spheres[a], &by = swarm.spheres[b];
        if (model_.frames[on.frame].body == model_.frames[by.frame].body) continue;
        const Vec3d d = place - motion(a).position;
        const double distance = d.norm(), gap = distance - on.radius - by.radius;
        const double rate = distance > 0 ? d.dot(motion(b).velocity - motion(a).velocity) / distance : 0;
        const double closer = near_steps * h * (motion(b).velocity - motion(a).velocity).norm() + falling;
        if (gap > closer + near_share * std::min(on.radius, by.radius)) continue;
        pairs_.push_back({static_cast<std::int64_t>(b) * count + a, gap, rate, false});
        if (pairs_.size() > collected_per_place * places(swarm)) keep_nearest(places(swarm));
      }
    }
    int& head = heads_[slot_of(cell)];
    next_[static_cast<std::size_t>(b)] = head;
    head = b;
  }
  keep_nearest(places(swarm));
  std::sort(pairs_.begin(), pairs_.end(), [](const Pair& a, const Pair& b) { return a.key < b.key; });
}

void SwarmSearch::place(const SwarmData& swarm, const relative::Workspace<double>& w, double* all) {
  const auto count = static_cast<std::int64_t>(swarm.spheres.size());
  for (int k = swarm.first; k < swarm.last; ++k) {
    const ElementData& e = model_.elements[k];
    double *own = all + e.states, *pair = own + law_states(e);
    if (pair[0] == 0) continue;
    const std::int64_t key =
        (static_cast<std::int64_t>(pair[1]) - 1) * count + static_cast<std::int64_t>(pair[0]) - 1;
    const auto found = std::lower_bound(pairs_.begin(), pairs_.end(), key,
                                        [](const Pair& p, std::int64_t wanted) { return p.key < wanted; });
    if (found != pairs_.end() && found->key == key)
      found->placed = true;
    else
      std::fill_n(own, e.state_count, 0.0);
  }
  int k = swarm.first;
  for (const Pair& p : pairs_) {
    if (p.placed) continue;
    while (all[model_.elements[k].states + law_states(model_.elements[k])] != 0) ++k;
    const ElementData& e = model_.elements[k];
    double *own = all + e.states, *pair = own + law_states(e);
    const auto a = static_cast<int>(p.key % count), b = static_cast<int>(p.key / count);
    pair[0] = a + 1;
    pair[1] = b + 1;
    const Motion<double>&on = w.frames[swarm.spheres[a].frame], &by = w.frames[swarm.spheres[b].frame];
    Vec3d::Map(own + states::place) = on.rotation.transpose() * (by.position - on.position);
    own[states::gap] = std::max(p.gap, 0.0);
    own[states::speed] = p.rate;
    own[states::impact] = std::abs(p.rate);
  }
}

void SwarmSearch::find(const relative::Workspace<double>& w, double h, double* all) {
  for (const SwarmData& swarm : model_.swarms) {
    if (swarm.spheres.empty()) continue;
    collect(swarm, w, h);
    place(swarm, w, all);
  }
}

}  // namespace mimbre

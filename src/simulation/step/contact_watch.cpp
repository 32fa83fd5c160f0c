#include "simulation/step/contact_watch.h"

#include <algorithm>
#include <cmath>

#include "forces/contact.h"
#include "math/elementary.h"
#include "math/rotation.h"
#include "simulation/step/contact_sweep.h"
#include "simulation/watch/tyre_gap.h"
#include "spec/surface_kind.h"

namespace mimbre {
namespace {

namespace states = contact_states;

/// An impact moves its body, in a step, by at most this share of the depth that it reaches; where it begins
/// or ends, whose instants are not known better than to a step, by the smaller one.
constexpr double share_of_depth = 0.1, share_at_ends = 0.02;

/// How deep an impact of that speed goes: ∫ k e/n (d/e)ⁿ dd = ½ m v².
double reach(const double* p, double mass, double speed) {
  namespace law = forces::contact;
  const double k = p[law::stiffness], n = p[law::exponent], e = p[law::depth];
  return e * mimbre::pow(0.5 * n * (n + 1) * mass * speed * speed / (k * e * e), 1 / (n + 1));
}

bool shows_impact(const double* p, double mass, const double* start, const ElementState<const double>& s,
                  double h, double quiet) {
  const bool touched = start[states::gap] < 0, touches = s.x[0] < 0;
  if (!touched && !touches) return true;
  const double fastest = std::max(std::abs(start[states::speed]), std::abs(s.v[0]));
  if (fastest <= quiet) return true;
  const double speed = touched ? std::max(fastest, start[states::impact]) : std::abs(start[states::speed]);
  const double share = touched == touches ? share_of_depth : share_at_ends;
  return speed * h <= share * reach(p, mass, speed);
}

Vec3d place_in(const double* z) { return {z[states::place], z[states::place + 1], z[states::place + 2]}; }

}  // namespace

double quiet_speed(const Compiled& m, double whole) {
  double quiet = 0.5 * whole * m.gravity.norm();
  for (std::size_t c = 0; c + 1 < m.first_of_contact.size(); ++c) {
    const int first = m.first_of_contact[c];
    if (first == m.first_of_contact[c + 1]) continue;
    quiet = std::max(quiet, m.numbers[m.elements[first].numbers + forces::contact::slow]);
  }
  return quiet;
}

ContactWatch::ContactWatch(const Compiled& m)
    : model_(m),
      contacts_(static_cast<int>(m.spec().contacts.size())),
      own_surfaces_(static_cast<int>(m.spec().surfaces.size())) {
  const int first = m.first_of_contact.front(), last = m.first_of_contact.back();
  const auto tyres = static_cast<std::size_t>(m.first_load - m.first_tyre);
  if (first == last && tyres == 0) return;
  seen_.resize(m.spec().contacts.size() + m.spec().tyres.size());
  if (first == last) return;
  first_state_ = m.elements[first].states;
  int end = first_state_;
  for (int k = first; k < last; ++k) end = std::max(end, m.elements[k].states + m.elements[k].state_count);
  kept_.resize(static_cast<std::size_t>(end - first_state_));
}

void ContactWatch::begin(const double* z, bool keep) {
  before_ = z + first_state_;
  if (!keep) return;
  std::copy_n(before_, kept_.size(), kept_.begin());
  before_ = kept_.data();
}

/// Whether the way of the sphere in the step may have led through the surface.
bool ContactWatch::passes(int element, const double* start, const ElementState<const double>& s,
                          const relative::Workspace<double>& w, double h, double quiet, Seen& seen) const {
  // A step of the rule turns a body that turns by θ by about θ³/12 less; of a bend ½θ²ρ that is its sixth by
  // θ, and more than the error of a parabola through the arc, 4/27 · ⅙ θ³ρ.
  constexpr double of_turn = 1.0 / 12, of_bend = 0.2;
  const ElementData& e = model_.elements[element];
  const ElementEnds ends = ends_of(model_, e, start);
  const Motion<double>&a = w.frames[ends.frame_a], &b = w.frames[ends.frame_b];
  const double before = start[states::gap], after = s.x[0], turned = h * a.omega.norm(),
               spins = turned + h * b.omega.norm(), turn = turned + 0.5 * h * h * a.alpha.norm();
  // Most are far from one another, or hardly move: the way is not longer than this where bodies turn by less
  // than a radian.
  const Vec3d from = place_in(start), to = place_in(s.states);
  const bool touch = before < 0 || after < 0;
  if (spins + turn < 1 && 3 * ((to - from).norm() + h * (b.velocity - a.velocity).norm() +
                               (turn > 0 ? 2 * turn * (from.norm() + to.norm()) : 0)) <=
                              (touch ? short_way * ends.radius : before + after))
    return false;
  const SurfaceData& surface = model_.surfaces[ends.surface];
  const Mat3d axes = a.rotation.transpose();
  SpherePath path{from, to, Vec3d::Zero()};
  if (turned > 0) {
    // With the mean of the angular velocity in the step; that itself is wrong by its change of change.
    path.turn = axes * (h * a.omega - 0.5 * h * h * a.alpha);
    path.from = rotation_exp<double>(Vec3d(-path.turn)) * path.from;
    path.error = (h * h * a.alpha.norm() / 6 + of_turn * turned * turned) * turned * path.from.norm();
    // A ball is the same from all sides.
    if (surface_info(surface.kind).ball) path.turn.setZero();
  }
  path.bend = h * (axes * (b.velocity - a.velocity)) + path.from - path.to;
  path.error += of_bend * path.bend.norm() * spins;
  if (!touch && path.longest() + path.error <= before + after) return false;
  const Passage found = passage(surface, ends.radius, path, before, after, quiet * h);
  if (found == Passage::none) return false;
  if (found == Passage::certain && seen.passes++ == 0)
    seen.passed = {element, ends.frame_a, ends.frame_b, ends.radius};
  return true;
}

namespace {

void sinks(double depth, double limit, const ContactTrouble::Where& where, double& most, double& most_limit,
           ContactTrouble::Where& most_where) {
  if (!(depth > limit) || depth - limit <= most - most_limit) return;
  most = depth;
  most_limit = limit;
  most_where = where;
}

}  // namespace

/// The centre of the sphere is in the solid, of two spheres that of the smaller one in the other.
void ContactWatch::look_for_depth(int element, double gap, Seen& seen) const {
  const ElementData& e = model_.elements[element];
  const ElementEnds ends = ends_of(model_, e, before_ + (e.states - first_state_));
  const bool of_sphere = ends.surface >= own_surfaces_;
  sinks(-gap, of_sphere ? std::min(ends.radius, model_.surfaces[ends.surface].size[0]) : ends.radius,
        {element, ends.frame_a, ends.frame_b, ends.radius}, seen.depth, seen.depth_limit, seen.sank);
}

void ContactWatch::look_under_wheels(const relative::Workspace<double>& w) {
  for (int k = model_.first_tyre; k < model_.first_load; ++k) {
    const ElementData& e = model_.elements[k];
    const double radius = tyre_radius(model_, e);
    Seen& seen = seen_[static_cast<std::size_t>(contacts_ + e.spec)];
    sinks(-tyre_gap(model_, e, element_state(e, w.elements.data())), radius,
          {k, e.frame_a, e.frame_b, radius}, seen.depth, seen.depth_limit, seen.sank);
  }
}

/// Calls f(contact, element, its states at the start, its state now) with all pairs.
template <class F>
void ContactWatch::for_pairs(const relative::Workspace<double>& w, const F& f) const {
  for (int c = 0; c < contacts_; ++c)
    for (int k = model_.first_of_contact[c]; k < model_.first_of_contact[c + 1]; ++k) {
      const ElementData& e = model_.elements[k];
      const double* start = before_ + (e.states - first_state_);
      if (!e.pooled || start[law_states(e)] != 0) f(c, k, start, element_state(e, w.elements.data()));
    }
}

void ContactWatch::look(const relative::Workspace<double>& w, const double* z) {
  begin(z, false);
  std::fill(seen_.begin(), seen_.end(), Seen());
  for_pairs(w, [&](int c, int k, const double*, const ElementState<const double>& s) {
    if (s.x[0] < 0) look_for_depth(k, s.x[0], seen_[static_cast<std::size_t>(c)]);
  });
  look_under_wheels(w);
}

bool ContactWatch::followed(const relative::Workspace<double>& w, double h, double quiet) {
  std::fill(seen_.begin(), seen_.end(), Seen());
  bool all = true;
  for_pairs(w, [&](int c, int k, const double* start, const ElementState<const double>& s) {
    Seen& seen = seen_[static_cast<std::size_t>(c)];
    const ElementData& e = model_.elements[k];
    if (s.x[0] < 0) look_for_depth(k, s.x[0], seen);
    if (passes(k, start, s, w, h, quiet, seen))
      all = false;
    else if (all && model_.swarms[c].spheres.empty())
      all = shows_impact(model_.numbers.data() + e.numbers, e.struck_mass, start, s, h, quiet);
  });
  look_under_wheels(w);
  return all;
}

void ContactWatch::note(double time, ContactLog& log) const {
  for (std::size_t k = 0; k < seen_.size(); ++k) {
    const Seen& seen = seen_[k];
    ContactTrouble& t = log[k];
    if (seen.passes > 0) {
      if (t.passed < 0) {
        t.passed = time;
        t.passed_where = seen.passed;
      }
      t.passes += seen.passes;
    }
    if (!(seen.depth > seen.depth_limit)) continue;
    if (t.sank < 0) t.sank = time;
    if (seen.depth - seen.depth_limit <= t.depth - t.depth_limit) continue;
    t.depth = seen.depth;
    t.depth_limit = seen.depth_limit;
    t.deepest_at = time;
    t.sank_where = seen.sank;
  }
}

}  // namespace mimbre

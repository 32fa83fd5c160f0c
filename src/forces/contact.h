#pragma once
#include <algorithm>
#include <cmath>

#include "compile/slow_speeds.h"
#include "forces/contact_states.h"
#include "forces/element.h"
#include "forces/element_ends.h"
#include "forces/impact.h"
#include "math/elementary.h"
#include "math/restitution.h"

/// A sphere on a surface. Normal force: that of an impact (forces/impact.h) at the depth −x₀. Tangential
/// force: bristles, springs with dampers in two directions, hold the surfaces together until their force
/// reaches the limit μ N; then they slide, and the bristles stay bent: the return to the limit of a perfectly
/// plastic spring (Simo and Hughes, Computational Inelasticity, 1998, 2.3), so that nothing below the limit
/// creeps. Their stiffness does not depend on the normal force: what they store could not be had back
/// otherwise. Rolling and spinning are resisted likewise, by moments up to N times an arm. The tangents leave
/// out what the limits owe to the normal force: that is not symmetric.
namespace mimbre::forces {

namespace contact {
/// Among the law's numbers.
constexpr int stiffness = 0, exponent = 1, depth = 2, restitution = 3, friction = 4, static_ratio = 5,
              stribeck = 6, tangential = 7, settling = 8, rolling = 9, spinning = 10;
/// Behind those given, as of stops.
constexpr int damping = 11, slow = 12;

/// By default what sticks vibrates with this damping ratio, against the least mass that an impact moves.
constexpr double damping_ratio = 0.4;

/// What starts slower than this share of `stribeck` is at rest.
constexpr double still = 1e-7;

template <class T, int n>
struct BristleForce {
  Eigen::Matrix<T, n, 1> bend, force;
  Eigen::Matrix<T, n, n> tangent;
};

/// Bristles that were bent by `bent` and pulled by `pulled`, and are moved on. `bristle_stiffness`,
/// `viscosity`: theirs; step 0: their damper's part of the pull stays.
template <class T, int n>
BristleForce<T, n> bend_bristles(const Eigen::Matrix<T, n, 1>& bent, const Eigen::Matrix<T, n, 1>& pulled,
                                 const Eigen::Matrix<T, n, 1>& moved, const T& bristle_stiffness,
                                 const T& viscosity, double step, const T& limit) {
  using std::sqrt;
  using Vector = Eigen::Matrix<T, n, 1>;
  const bool steps = step > 0;
  const T damped = steps ? T(viscosity / step) : T(0), whole = bristle_stiffness + damped;
  const Vector kept = steps ? Vector(bristle_stiffness * bent) : pulled, trial = kept + whole * moved;
  const T square = trial.squaredNorm();
  // Where the limit is zero nothing holds, not even what is not pulled yet: there is no tangent.
  const auto sliding = square > limit * limit || !(limit > T(0));
  const T size = sqrt(select(square > T(0), square, T(1))), share = select(sliding, T(limit / size), T(1));
  BristleForce<T, n> h;
  h.force = share * trial;
  // Sliding: bristle_stiffness z + damped (z − bent) = force.
  const T some = select(whole > T(0), whole, T(1));
  for (int k = 0; k < n; ++k)
    h.bend[k] = select(sliding, T((h.force[k] - kept[k] + whole * bent[k]) / some), T(bent[k] + moved[k]));
  h.tangent = whole * share * Eigen::Matrix<T, n, n>::Identity();
  const Vector along = trial / size;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      h.tangent(i, j) -= select(sliding, T(whole * share * along[i] * along[j]), T(0));
  return h;
}

template <class T>
Vec3<T> vector_at(const T* p) {
  return {p[0], p[1], p[2]};
}

/// The axes of a contact: tangents and normal, in the surface's.
template <class T>
Mat3<T> axes_of(const ElementState<T>& s) {
  Mat3<T> axes;
  axes.col(0) = vector_at<T>(s.surroundings);
  axes.col(1) = vector_at<T>(s.surroundings + 3);
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

/// A vector of the tangent plane that was, turned into the one that is: its part there, at its old length.
template <class T>
Eigen::Matrix<T, 2, 1> carried(const Mat3<T>& axes, const T* before) {
  using std::sqrt;
  const Vec3<T> old = vector_at<T>(before);
  const Eigen::Matrix<T, 2, 1> part(axes.col(0).dot(old), axes.col(1).dot(old));
  const T square = part.squaredNorm();
  const auto some = square > T(0);
  const T ratio = select(some, T(old.squaredNorm() / select(some, square, T(1))), T(1));
  // Where hardly anything of it lies in the plane, its direction is anyone's guess.
  return sqrt(select(ratio < T(4), ratio, T(4))) * part;
}

/// What slides or turns as it starts has bent the bristles already. `rest`: rate below which it does neither.
template <class T, int n>
void begin(const LawContext<T>& c, const Eigen::Matrix<T, n, 1>& rate, const T& rest, const T& limit,
           const T& bristle_stiffness, Eigen::Matrix<T, n, 1>& bent, Eigen::Matrix<T, n, 1>& pulled) {
  using std::sqrt;
  if (c.step > 0 || !any(bristle_stiffness > T(0))) return;
  const T square = rate.squaredNorm();
  const auto begins = select(c.states[contact_states::gap] < T(0), T(0), square) > rest * rest;
  const T size = sqrt(select(begins, square, T(1)));
  for (int k = 0; k < n; ++k) {
    pulled[k] = select(begins, T(limit * rate[k] / size), pulled[k]);
    bent[k] = select(begins, T(pulled[k] / bristle_stiffness), bent[k]);
  }
}

template <class T>
impact::Push<T> normal_push(const LawContext<T>& c, const ElementState<T>& s) {
  const T* p = c.numbers();
  return impact::push(p[stiffness], p[exponent], p[depth], T(-s.x[0]), T(-s.v[0]),
                      impact::factor(p[damping], c.states[contact_states::impact], p[slow]));
}
}  // namespace contact

template <class T>
void contact_law(const LawContext<T>& c, ElementState<T>& s) {
  using namespace contact;
  using std::abs, mimbre::exp;
  namespace states = contact_states;
  using Vector2 = Eigen::Matrix<T, 2, 1>;
  const int n = s.count;
  for (int k = 0; k < n; ++k) s.force[k] = T(0);
  for (int k = 0; k < n * n; ++k) s.stiffness[k] = s.damping[k] = T(0);
  for (int k = states::bend; k < law_states(c.element); ++k) s.states[k] = T(0);
  const auto touches = s.x[0] < T(0);
  // The speed of the next impact, as long as there is none.
  s.states[states::impact] = select(touches, c.states[states::impact], T(abs(s.v[0])));
  if (!any(touches)) return;
  const T* p = c.numbers();
  const impact::Push<T> push = normal_push(c, s);
  s.force[0] = -push.force;
  s.stiffness[0] = push.along_depth;
  s.damping[0] = push.along_speed;

  const Mat3<T> axes = axes_of(s);
  const T bristle_stiffness = p[tangential] * p[stiffness];
  const T square = s.v[1] * s.v[1] + s.v[2] * s.v[2];
  const T limit = push.force * p[friction] *
                  (T(1) + (p[static_ratio] - T(1)) * exp(T(-square / (p[stribeck] * p[stribeck]))));
  Vector2 bent = carried(axes, c.states + states::bend), pulled = carried(axes, c.states + states::pull);
  const T rest = T(still) * p[stribeck];
  begin<T, 2>(c, Vector2(s.v[1], s.v[2]), rest, limit, bristle_stiffness, bent, pulled);
  const BristleForce<T, 2> bristles =
      bend_bristles<T, 2>(bent, pulled, Vector2(s.x[1], s.x[2]), bristle_stiffness,
                          T(bristle_stiffness * p[settling]), c.step, limit);
  const Vec3<T> bend = axes.template leftCols<2>() * bristles.bend,
                pull = axes.template leftCols<2>() * bristles.force;
  for (int i = 0; i < 2; ++i) {
    s.force[1 + i] = select(touches, bristles.force[i], T(0));
    for (int j = 0; j < 2; ++j)
      s.stiffness[(1 + i) * n + 1 + j] = select(touches, bristles.tangent(i, j), T(0));
  }
  for (int k = 0; k < 3; ++k) {
    s.states[states::bend + k] = select(touches, bend[k], T(0));
    s.states[states::pull + k] = select(touches, pull[k], T(0));
  }
  if (n == 3) return;

  using Vector1 = Eigen::Matrix<T, 1, 1>;
  const Vec3<T> twisted = axes.transpose() * vector_at<T>(c.states + states::twist),
                turned = axes.transpose() * vector_at<T>(c.states + states::moment);
  const T radius(ends_of(c.model, c.element, c.states).radius),
      lever = bristle_stiffness * radius, roll = lever * p[rolling], spin = lever * p[spinning];
  const T most_roll = push.force * p[rolling], most_spin = push.force * p[spinning];
  Vector2 rolled = twisted.template head<2>(), roll_moment = turned.template head<2>();
  Vector1 spun(twisted[2]), spin_moment(turned[2]);
  const T turning_rest = rest / radius;
  begin<T, 2>(c, Vector2(s.v[3], s.v[4]), turning_rest, most_roll, roll, rolled, roll_moment);
  begin<T, 1>(c, Vector1(s.v[5]), turning_rest, most_spin, spin, spun, spin_moment);
  const BristleForce<T, 2> rolls = bend_bristles<T, 2>(rolled, roll_moment, Vector2(s.x[3], s.x[4]), roll,
                                                       T(roll * p[settling]), c.step, most_roll);
  const BristleForce<T, 1> spins =
      bend_bristles<T, 1>(spun, spin_moment, Vector1(s.x[5]), spin, T(spin * p[settling]), c.step, most_spin);
  for (int i = 0; i < 2; ++i) {
    s.force[3 + i] = select(touches, rolls.force[i], T(0));
    for (int j = 0; j < 2; ++j) s.stiffness[(3 + i) * n + 3 + j] = select(touches, rolls.tangent(i, j), T(0));
  }
  s.force[5] = select(touches, spins.force[0], T(0));
  s.stiffness[5 * n + 5] = select(touches, spins.tangent(0, 0), T(0));
  const Vec3<T> twist = axes * Vec3<T>(rolls.bend[0], rolls.bend[1], spins.bend[0]),
                moment = axes * Vec3<T>(rolls.force[0], rolls.force[1], spins.force[0]);
  for (int k = 0; k < 3; ++k) {
    s.states[states::twist + k] = select(touches, twist[k], T(0));
    s.states[states::moment + k] = select(touches, moment[k], T(0));
  }
}

namespace contact {
/// The rotation vector by which a sphere turned from one state to another, which it touches in.
inline Vec3d turn_since(const double* before, const double* now) {
  namespace states = contact_states;
  const double *b = before + states::turn, *n = now + states::turn;
  const Quat<double> back(b[0], -b[1], -b[2], -b[3]), turned(n[0], n[1], n[2], n[3]);
  return quaternion_log(quaternion_product(turned, back));
}
}  // namespace contact

/// Depth and bristles store; what the surfaces slide and turn, the bristles' dampers and the impact's take.
inline void contact_energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
  using namespace contact;
  namespace states = contact_states;
  const double* p = c.numbers();
  const double bristle_stiffness = p[tangential] * p[stiffness],
               lever = bristle_stiffness * ends_of(c.model, c.element, c.states).radius;
  const bool turning = s.count > 3;
  const auto bristles = [&](const double* z, const Mat3d& axes) {
    double stored = 0.5 * bristle_stiffness * vector_at<double>(z + states::bend).squaredNorm();
    if (!turning) return stored;
    const Vec3d twist = axes.transpose() * vector_at<double>(z + states::twist);
    return stored +
           0.5 * lever * (p[rolling] * twist.head<2>().squaredNorm() + p[spinning] * twist[2] * twist[2]);
  };
  const bool touches = s.x[0] < 0, touched = c.states[states::gap] < 0;
  const Mat3d axes = touches ? axes_of<double>(s) : Mat3d(Mat3d::Identity());
  double now = 0;
  if (touches) {
    const impact::Push<double> push = normal_push(c, s);
    now = bristles(s.states, axes);
    e.stored = push.elastic * -s.x[0] / (p[exponent] + 1) + now;
    e.dissipating[0] = push.elastic - push.force;
  }
  if (c.step <= 0) return;
  e.lost = (touched ? bristles(c.states, axes) : 0) - now;
  if (!touches) return;
  for (int k = 1; k < s.count; ++k) e.lost += 0.5 * s.force[k] * s.x[k];
  if (!touched) return;
  // What acted as the step started did so on the contact as it was then.
  const Vec3d since = turn_since(c.states, s.states),
              went =
                  vector_at<double>(s.states + states::place) - vector_at<double>(c.states + states::place),
              pulled = vector_at<double>(c.states + states::pull);
  const double radius = ends_of(c.model, c.element, c.states).radius,
               reach = radius + 0.5 * c.states[states::gap];
  e.lost += 0.5 * pulled.dot(went - reach * since.cross(axes.col(2)));
  if (turning) e.lost += 0.5 * vector_at<double>(c.states + states::moment).dot(since);
}

struct Contact {
  static constexpr std::array<LawNumber, 11> numbers{{
      {.key = "stiffness",
       .unit = "N/m",
       .about = "at 'depth', or anywhere where the exponent is 1",
       .above = 0},
      {.key = "exponent", .about = "of the force over the depth; 1: linear", .otherwise = 1, .least = 1},
      {.key = "depth",
       .unit = "m",
       .about = "at which the stiffness is that",
       .otherwise = by_scales,
       .above = 0},
      {.key = "restitution",
       .about = "coefficient of restitution: ratio of rebound to impact speed",
       .otherwise = 1,
       .least = 0.01,
       .most = 1},
      {.key = "friction",
       .about = "limit of the tangential force, by the normal one",
       .otherwise = 0,
       .least = 0},
      {.key = "static_ratio",
       .about = "of the limit at rest to that in fast sliding",
       .otherwise = 1,
       .least = 1},
      {.key = "stribeck",
       .unit = "m/s",
       .about = "speed over which the limit falls to that in fast sliding",
       .otherwise = by_scales,
       .above = 0},
      {.key = "tangential",
       .about = "tangential presliding stiffness, relative to the normal stiffness",
       .otherwise = 0.7,
       .above = 0},
      {.key = "settling",
       .unit = "s",
       .about = "time constant of the decay of vibrations while sticking",
       .otherwise = by_scales,
       .least = 0},
      {.key = "rolling",
       .unit = "m",
       .about = "arm of the normal force that resists rolling",
       .otherwise = 0,
       .least = 0},
      {.key = "spinning",
       .unit = "m",
       .about = "arm of the normal force that resists turning about it",
       .otherwise = 0,
       .least = 0},
  }};
  /// As of stops.
  static void derived(std::span<const double> n, double, std::vector<double>& behind) {
    behind.insert(behind.end(), {restitution_damping(n[contact::restitution]), 0});
  }
  /// All pairs of a contact share its numbers: that of the least mass settles fastest.
  static void set_scales(const Compiled& m, const ElementData& e, double* p) {
    using namespace contact;
    set_usual_depth(m, e, p[depth]);
    p[slow] = slow_impact(m, e, p[stiffness], p[exponent], p[depth]);
    if (p[stribeck] == by_scales) p[stribeck] = p[slow];
    if (m.spec().contacts[e.spec].numbers[settling] < by_scales) return;
    const double mass = e.struck_mass < by_scales ? e.struck_mass : m.mass_scale;
    p[settling] = std::min(p[settling], 2 * damping_ratio * std::sqrt(mass / (p[tangential] * p[stiffness])));
  }
  static bool resists_turning(std::span<const double> n) {
    return n[contact::rolling] > 0 || n[contact::spinning] > 0;
  }
  static constexpr LawInfo info{.name = "contact",
                                .list = SpecList::contacts,
                                .numbers = numbers,
                                .states = 16,
                                .derived = derived,
                                .set_scales = set_scales,
                                .resists_turning = resists_turning,
                                .turning_states = 22};

  template <class T>
  static void law(const LawContext<T>& c, ElementState<T>& s) {
    contact_law(c, s);
  }
  static void energy(const LawContext<double>& c, const ElementState<double>& s, ElementEnergy& e) {
    contact_energy(c, s, e);
  }
};

}  // namespace mimbre::forces

#include <gtest/gtest.h>

#include <cmath>

#include "compile/triangle_mesh.h"
#include "forces/measure.h"
#include "forces/table.h"
#include "math/restitution.h"
#include "support/random_mechanism.h"

/// What a contact measures and its law, for every kind of surface: rates, energies, tangents, the return to
/// the limit of friction.
namespace mimbre::test::contact_law_test {
namespace {

/// A sphere that touches a surface, in motion, and bristles that are bent.
struct Touching {
  Compiled model;
  ElementData element;
  Motion<double> a, b;
  std::vector<double> before, storage;

  ElementState<double> at(double t, double step) {
    Motion<double> p = a, q = b;
    p.position += t * a.velocity;
    p.rotation = rotation_exp<double>(Vec3d(t * a.omega)) * a.rotation;
    q.position += t * b.velocity;
    q.rotation = rotation_exp<double>(Vec3d(t * b.omega)) * b.rotation;
    ElementState<double> s = element_state(element, storage.data());
    const double none = 0;
    measure(model, element, &p, q, Vec3d(Vec3d::Zero()), &none, before.data(), s, step);
    return s;
  }
  LawContext<double> context(double step) const {
    static const double none = 0;
    return {model, element, 0, &none, before.data(), step};
  }
  void law(ElementState<double>& s, double step) const {
    forces::rows<double>[static_cast<std::size_t>(element.law)].law(context(step), s);
  }
  ElementEnergy energy(const ElementState<double>& s, double step) const {
    ElementEnergy e;
    forces::rows<double>[static_cast<std::size_t>(element.law)].energy(context(step), s, e);
    return e;
  }
  /// The power that the force takes from the motion.
  static double power(const ElementState<double>& s) {
    double sum = 0;
    for (int k = 0; k < s.count; ++k) sum += s.force[k] * s.v[k];
    return sum;
  }
};

SurfaceData surface(int kind) {
  SurfaceData s{kind, Vec3d(0.7, 1.1, 0.5), {}};
  if (kind == find_surface("heights")) {
    Eigen::MatrixXd heights(4, 4);
    for (int k = 0; k < 16; ++k) heights(k / 4, k % 4) = 0.2 * std::sin(1.3 * k);
    s.mesh = height_mesh(heights, {0.5, 0.4});
  }
  if (kind == find_surface("mesh"))
    s.mesh = triangle_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                           {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}});
  return s;
}

/// Deep by a tenth of its radius, at a random place of the surface; `friction` wide enough to stick.
Touching touching(Random& random, int kind, double friction, double exponent, bool turning) {
  Touching t;
  t.model.surfaces.push_back(surface(kind));
  ElementData& e = t.element;
  e.law = find_law("contact");
  e.measure = Measure::contact;
  e.count = turning ? 6 : 3;
  e.surface = 0;
  e.radius = 0.2;
  e.state_count = turning ? law_info(e.law).turning_states : law_info(e.law).states;
  const double arm = turning ? 0.02 : 0;
  for (const double number :
       {4e3, exponent, 1e-2, 0.6, friction, 1.0, 0.01, 0.7, 1e-3, arm, arm, restitution_damping(0.6), 0.01})
    t.model.numbers.push_back(number);
  t.a = {random.rotation(), random.vector(1), random.vector(1),
         random.vector(1),  Vec3d::Zero(),    Vec3d::Zero()};
  t.b = {random.rotation(), random.vector(1), random.vector(1),
         random.vector(1),  Vec3d::Zero(),    Vec3d::Zero()};
  // Moved to where it touches.
  Vec3d place = random.vector(1);
  const Touch<double> found = surfaces::touch(t.model.surfaces[0], place);
  place += (0.9 * e.radius - found.distance) * found.normal;
  t.b.position = t.a.position + t.a.rotation * place;
  t.storage.assign(static_cast<std::size_t>(element_storage(e)), std::nan(""));
  t.before.assign(static_cast<std::size_t>(e.state_count), 0.0);
  return t;
}

constexpr int kinds = static_cast<int>(surfaces::infos.size());

TEST(ContactLaw, RatesAreDerivatives) {
  Random random(11);
  for (int kind = 0; kind < kinds; ++kind)
    for (int round = 0; round < 50; ++round) {
      Touching t = touching(random, kind, 0.5, 1, true);
      ElementState<double> s = t.at(0, 0);
      t.law(s, 0);
      if (!(s.x[0] < 0)) continue;  // in a corner between others
      std::copy(s.states, s.states + t.element.state_count, t.before.begin());
      const double h = 1e-6;
      double up[6], down[6];
      std::copy_n(t.at(h, 0).x, 6, up);
      const Vec3d normal = t.at(h, 0).linear_of(0);
      std::copy_n(t.at(-h, 0).x, 6, down);
      if ((normal - t.at(-h, 0).linear_of(0)).norm() > 1e-3) continue;  // an edge of the inside
      s = t.at(0, 0);
      const Vec3d u = t.b.velocity - t.a.velocity - t.a.omega.cross(t.b.position - t.a.position),
                  w = t.b.omega - t.a.omega;
      for (int k = 0; k < 6; ++k) {
        EXPECT_NEAR(s.v[k], (up[k] - down[k]) / (2 * h), 1e-6) << kind << " " << k;
        EXPECT_NEAR(s.v[k], s.linear_of(k).dot(u) + s.angular_of(k).dot(w), 1e-12);
      }
    }
}

/// Without a step, dampers rest: what the force takes is what is stored, of depth and bristles, along any
/// motion of both bodies.
TEST(ContactLaw, TheGradientOfTheElasticEnergyIsTheForce) {
  Random random(12);
  int seen = 0;
  for (int kind = 0; kind < kinds; ++kind)
    for (int round = 0; round < 50; ++round) {
      const bool turning = round % 2 == 0;
      Touching t = touching(random, kind, 50, round % 3 == 0 ? 1 : 1.5, turning);
      // The damping of the impact aside.
      t.model.numbers[11] = 0;
      ElementState<double> s = t.at(0, 0);
      t.law(s, 0);
      if (!(s.x[0] < 0)) continue;
      std::copy(s.states, s.states + t.element.state_count, t.before.begin());
      const double bristle_stiffness = 0.7 * 4e3;
      const Mat3d axes = forces::contact::axes_of<double>(s);
      const Vec3d bend = axes.leftCols<2>() * random.values(2, 1e-3);
      Vec3d::Map(t.before.data() + contact_states::bend) = bend;
      Vec3d::Map(t.before.data() + contact_states::pull) = bristle_stiffness * bend;
      if (turning) {
        const Vec3d twist = random.vector(1e-3);
        Vec3d::Map(t.before.data() + contact_states::twist) = twist;
        Vec3d::Map(t.before.data() + contact_states::moment) = bristle_stiffness * 0.2 * 0.02 * twist;
      }
      const double h = 1e-6;
      const auto stored = [&](double at) {
        ElementState<double> moved = t.at(at, 0);
        t.law(moved, 0);
        return t.energy(moved, 0).stored;
      };
      const double up = stored(h), down = stored(-h);
      const Vec3d normal = t.at(h, 0).linear_of(0);
      if ((normal - t.at(-h, 0).linear_of(0)).norm() > 1e-3) continue;
      s = t.at(0, 0);
      t.law(s, 0);
      const double power = Touching::power(s);
      EXPECT_NEAR((up - down) / (2 * h), power, 1e-4 * (1 + std::abs(power))) << kind << " " << round;
      ++seen;
    }
  EXPECT_GT(seen, 300);
}

/// Tangents of the force by gap and slips, where nothing is dropped: sticking, and sliding at a steady normal
/// force.
TEST(ContactLaw, TangentsAreDerivatives) {
  Random random(13);
  for (const double friction : {50.0, 1e-3})
    for (int round = 0; round < 50; ++round) {
      Touching t = touching(random, 0, friction, 1.5, true);
      const double step = 1e-3;
      ElementState<double> s = t.at(0, step);
      t.law(s, step);
      std::copy(s.states, s.states + t.element.state_count, t.before.begin());
      s = t.at(step, step);
      t.law(s, step);
      std::vector<double> stiffness(s.stiffness, s.stiffness + 36), damping(s.damping, s.damping + 36);
      const auto force = [&](int k, double dx, double dv) {
        ElementState<double> other = t.at(step, step);
        other.x[k] += dx;
        other.v[k] += dv;
        t.law(other, step);
        return Eigen::Matrix<double, 6, 1>(Eigen::Map<Eigen::Matrix<double, 6, 1>>(other.force));
      };
      for (int k = 0; k < 6; ++k) {
        const double h = 1e-8;
        const Eigen::Matrix<double, 6, 1> by_x = (force(k, h, 0) - force(k, -h, 0)) / (2 * h),
                                          by_v = (force(k, 0, h) - force(k, 0, -h)) / (2 * h);
        for (int r = 0; r < 6; ++r) {
          if (friction < 1 && k == 0 && r > 0) continue;  // what the limit owes to the normal force
          if (r > 2 && k == 0) continue;
          EXPECT_NEAR(stiffness[static_cast<std::size_t>(6 * r + k)], by_x[r], 1e-3 * (1 + std::abs(by_x[r])))
              << r << k;
          if (k > 0 || r > 0) continue;
          EXPECT_NEAR(damping[0], by_v[0], 1e-3 * (1 + std::abs(by_v[0])));
        }
      }
    }
}

/// Over steps of a random walk, whatever the normal force does: friction never pulls more than its limit,
/// never loses less than nothing, and what it takes is stored or lost.
TEST(ContactLaw, FrictionTakesWorkOnly) {
  Random random(14);
  for (int kind : {0, 4}) {
    Touching t = touching(random, kind, 0.4, 1, true);
    t.a.velocity = t.a.omega = t.b.velocity = t.b.omega = Vec3d::Zero();
    const double step = 1e-3;
    double lost = 0, stored = 0;
    for (int k = 0; k < 4000; ++k) {
      ElementState<double> s = t.at(0, step);
      t.law(s, step);
      const ElementEnergy e = t.energy(s, step);
      const double limit = -s.force[0] * 0.4;
      EXPECT_LE(std::hypot(s.force[1], s.force[2]), limit * (1 + 1e-12));
      lost += e.lost;
      stored = e.stored;
      EXPECT_GT(lost, -1e-6);
      std::copy(s.states, s.states + t.element.state_count, t.before.begin());
      const Vec3d n = s.linear_of(0);
      const double wanted = -0.01 + 0.005 * std::sin(0.05 * k) + 0.002 * std::sin(1.7 * k);
      t.b.position += (wanted - s.x[0]) * n + random.vector(2e-4);
      t.b.rotation = rotation_exp<double>(random.vector(1e-3)) * t.b.rotation;
    }
    EXPECT_GT(lost, 0.1);
    EXPECT_GT(stored, 0);
  }
}

}  // namespace
}  // namespace mimbre::test::contact_law_test

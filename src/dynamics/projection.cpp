#include "dynamics/projection.h"

#include <algorithm>

namespace mimbre::projection {
namespace {

/// Four values at once; the fourth of a node's three is the next node's first and never used.
using Four = Eigen::Array4d;
using Eight = Eigen::Array<double, 8, 1>;

auto four(const double* p) { return Eigen::Map<const Four>(p); }
auto eight(const double* p) { return Eigen::Map<const Eight>(p); }
template <class Values>
void store(double* p, const Eigen::ArrayBase<Values>& x) {
  Eigen::Map<Eigen::Array<double, Values::RowsAtCompileTime, 1>> out(p);
  out = x;
}
Four padded(const Vec3d& a) { return {a[0], a[1], a[2], 0}; }
Vec3d front(const Four& a) { return a.head<3>().matrix(); }
std::size_t axis(int i) { return static_cast<std::size_t>(i) + 1; }

/// r̄u + ½ X y and ½ M y.
void deform(const Constants& c, Work& w, const double* y) {
  const double *x = c.shapes.data(), *m = c.masses.data();
  for (int p = 0; p < c.panels; ++p) {
    Eight r = eight(c.undeformed.data() + 8 * p), f = Eight::Zero();
    for (int k = 0; k < c.modes; ++k, x += 8, m += 8) {
      const double half = 0.5 * y[k];
      r += eight(x) * half;
      f += eight(m) * half;
    }
    store(w.place.data() + 8 * p, r);
    store(w.moment.data() + 8 * p, f);
  }
}

/// The same, with velocities and accelerations.
void modal_motion(const Constants& c, Work& w, const double* y, const double* yd, const double* ydd) {
  const double *x = c.shapes.data(), *m = c.masses.data();
  for (int p = 0; p < c.panels; ++p) {
    Eight r = eight(c.undeformed.data() + 8 * p), f = Eight::Zero(), v = f, g = f, a = f, h = f;
    for (int k = 0; k < c.modes; ++k, x += 8, m += 8) {
      const Eight shape = eight(x), mass = eight(m);
      const double half = 0.5 * y[k];
      r += shape * half;
      f += mass * half;
      v += shape * yd[k];
      g += mass * yd[k];
      a += shape * ydd[k];
      h += mass * ydd[k];
    }
    store(w.place.data() + 8 * p, r);
    store(w.moment.data() + 8 * p, f);
    store(w.velocity.data() + 8 * p, v);
    store(w.momentum.data() + 8 * p, g);
    store(w.modal.data() + 8 * p, a);
    store(w.force.data() + 8 * p, h);
  }
}

/// S y, Sθ y.
Vec3d times(const Rows& rows, const double* y) {
  const int s = static_cast<int>(rows.cols());
  Vec3d out = Vec3d::Zero();
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < s; ++k) out[i] += rows(i, k) * y[k];
  return out;
}
/// Adds Sᵀ f, Sθᵀ f.
void add_transposed(const Rows& rows, const Vec3d& f, double* out) {
  const int s = static_cast<int>(rows.cols());
  for (int k = 0; k < s; ++k) out[k] += (rows(0, k) * f[0] + rows(1, k) * f[1]) + rows(2, k) * f[2];
}

Vec3d first_moment(const Constants& c, const double* y) { return c.first_moment + times(c.S, y); }

/// P̄ from Σ_k (r̄u + ½ X y) (½ M y)ᵀ, row by row.
Mat3d second_moment(const Constants& c, const Four* sums) {
  Mat3d half;
  for (int i = 0; i < 3; ++i) half.row(i) = front(sums[i]);
  return c.second_moment + 2 * (half + half.transpose());
}
Mat3d second_moment(const Constants& c, const Work& w) {
  Four sums[3] = {Four::Zero(), Four::Zero(), Four::Zero()};
  const double *r = w.place.data(), *f = w.moment.data();
  for (int k = 0; k < c.nodes; ++k, r += 3, f += 3)
    for (int i = 0; i < 3; ++i) sums[i] += four(f) * r[i];
  return second_moment(c, sums);
}

/// What the nodes add to the forces on the axes.
struct AxisSums {
  Four second[3] = {Four::Zero(), Four::Zero(), Four::Zero()};  ///< see second_moment()
  Four forces[3] = {Four::Zero(), Four::Zero(), Four::Zero()};  ///< S'^i ÿ + 2 spin S'^i ẏ without Sθ
};

/// Leaves in the scratch what Mᵀ and Xᵀ are multiplied with.
AxisSums node_forces(const Constants& c, Work& w, const Base& b, const Mat3d& spin) {
  const Four b1 = padded(b[1]), b2 = padded(b[2]), b3 = padded(b[3]);
  const Four s0 = padded(spin.col(0)), s1 = padded(spin.col(1)), s2 = padded(spin.col(2));
  const auto turned = [&](const double* v) -> Four { return (s0 * v[0] + s1 * v[1]) + s2 * v[2]; };
  AxisSums sums;
  const double *r = w.place.data(), *f = w.moment.data(), *v = w.velocity.data(), *p = w.momentum.data(),
               *a = w.modal.data(), *h = w.force.data();
  for (int k = 0; k < c.nodes; ++k, r += 3, f += 3, v += 3, p += 3, a += 3, h += 3) {
    const Four turned_v = turned(v), turned_p = turned(p);
    const Four force = four(h) + 2 * turned_p, acceleration = four(a) + 2 * turned_v;
    for (int i = 0; i < 3; ++i) {
      sums.second[i] += four(f) * r[i];
      sums.forces[i] += force * r[i] + acceleration * f[i];
    }
    store(w.by_mass.data() + 4 * k, (b1 * r[0] + b2 * r[1]) + (b3 * r[2] + turned_v));
    store(w.by_shape.data() + 4 * k, (b1 * f[0] + b2 * f[1]) + (b3 * f[2] + turned_p));
  }
  return sums;
}

/// Adds what the nodes do on the modes, and ΦᵀM*Φ ÿ.
void modal_forces(const Constants& c, const Work& w, const double* ydd, double* elastic) {
  const double *mass = c.mass_rows.data(), *shape = c.shape_rows.data();
  for (int m = 0; m < c.modes; m += 4) {
    Four x = Four::Zero(), y = x, z = x;
    const double *f = w.by_mass.data(), *g = w.by_shape.data();
    for (int k = 0; k < c.nodes; ++k, mass += 12, shape += 12, f += 4, g += 4) {
      x += four(mass) * f[0] + four(shape) * g[0];
      y += four(mass + 4) * f[1] + four(shape + 4) * g[1];
      z += four(mass + 8) * f[2] + four(shape + 8) * g[2];
    }
    for (int l = 0; l < c.modes; ++l) x += four(c.mass.data() + l * c.stride + m) * ydd[l];  // symmetric
    store(elastic + m, four(elastic + m) + (x + y + z));
  }
}

/// The nine rows S'^i_j at the deformation in w.
void axis_coupling(const Constants& c, const Work& w, double* rows) {
  const int s = c.stride;
  std::fill(rows, rows + 9 * s, 0.0);
  const double *mass = c.mass_rows.data(), *shape = c.shape_rows.data();
  for (int m = 0; m < c.modes; m += 4) {
    const double *r = w.place.data(), *f = w.moment.data();
    Four sum[9];
    for (Four& x : sum) x.setZero();
    for (int k = 0; k < c.nodes; ++k, mass += 12, shape += 12, r += 3, f += 3)
      for (int j = 0; j < 3; ++j) {
        const Four by_mass = four(mass + 4 * j), by_shape = four(shape + 4 * j);
        for (int i = 0; i < 3; ++i) sum[3 * i + j] += by_mass * r[i] + by_shape * f[i];
      }
    for (int i = 0; i < 9; ++i) store(rows + i * s + m, sum[i]);
  }
  for (int k = 0; k < 3; ++k) {  // ½ Sθ × e_i
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double* theta = c.S_theta.data() + k * s;
    for (int m = 0; m < s; ++m) {
      rows[(3 * i + j) * s + m] += 0.5 * theta[m];
      rows[(3 * j + i) * s + m] -= 0.5 * theta[m];
    }
  }
}

}  // namespace

void Work::fit(const Constants& c) {
  const auto grow = [](Values& values, int size) {
    if (values.size() < static_cast<std::size_t>(size)) values.resize(static_cast<std::size_t>(size), 0.0);
  };
  for (Values* values : {&place, &moment, &velocity, &momentum, &modal, &force})
    grow(*values, 8 * c.panels + 8);  // room for reading four at the last node
  for (Values* values : {&by_mass, &by_shape}) grow(*values, 4 * c.nodes);
}

void inertia_forces(const Constants& c, Work& w, const Base& b, const Mat3d& spin, const double* y,
                    const double* yd, const double* ydd, Base& forces, double* elastic) {
  modal_motion(c, w, y, yd, ydd);
  const AxisSums sums = node_forces(c, w, b, spin);
  modal_forces(c, w, ydd, elastic);
  const Vec3d first = first_moment(c, y);
  const Mat3d second = second_moment(c, sums.second);
  const Vec3d turning = 0.5 * times(c.S_theta, yd), turned = 0.5 * times(c.S_theta, ydd);
  forces[0] = c.total_mass * b[0] + times(c.S, ydd) + 2 * spin * times(c.S, yd);
  Vec3d rotation = Vec3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vec3d e = Vec3d::Unit(i);
    forces[0] += first[i] * b[axis(i)];
    forces[axis(i)] = first[i] * b[0] + front(sums.forces[i]) + turned.cross(e) + 2 * spin * turning.cross(e);
    for (int j = 0; j < 3; ++j) forces[axis(i)] += second(i, j) * b[axis(j)];
    rotation += 0.5 * e.cross(b[axis(i)]);
  }
  add_transposed(c.S, b[0], elastic);
  add_transposed(c.S_theta, rotation, elastic);
}

Wrench inertia_wrench(const Constants& c, Work& w, const Vec3d& acc, const Vec3d& omega, const Vec3d& alpha,
                      const double* y, const double* yd, const double* ydd, double* elastic) {
  const Mat3d spin = skew<double>(omega), field = skew<double>(alpha) + spin * spin;
  Base forces;
  inertia_forces(c, w, {acc, field.col(0), field.col(1), field.col(2)}, spin, y, yd, ydd, forces, elastic);
  Wrench out{forces[0], Vec3d::Zero()};
  for (int i = 0; i < 3; ++i) out.moment += Vec3d::Unit(i).cross(forces[axis(i)]);
  return out;
}

Eigen::Matrix4d base_mass(const Constants& c, Work& w, const double* y, double* coupling) {
  deform(c, w, y);
  std::copy(c.S.data(), c.S.data() + 3 * c.stride, coupling);
  axis_coupling(c, w, coupling + 3 * c.stride);
  Eigen::Matrix4d mass;
  mass(0, 0) = c.total_mass;
  mass.block<3, 1>(1, 0) = first_moment(c, y);
  mass.block<1, 3>(0, 1) = mass.block<3, 1>(1, 0).transpose();
  mass.bottomRightCorner<3, 3>() = second_moment(c, w);
  return mass;
}

void rigid_mass(const Constants& c, Work& w, const double* y, Vec3d& first, Mat3d& second,
                double* integrals) {
  deform(c, w, y);
  axis_coupling(c, w, integrals);
  first = first_moment(c, y);
  second = second_moment(c, w);
}

double kinetic_energy(const Constants& c, Work& w, const Base& b, const double* y, const double* yd,
                      double* momenta) {
  // Momenta: the forces when the velocities are taken for accelerations.
  const double* zero = c.zeros.data();
  std::fill(momenta, momenta + c.stride, 0.0);
  Base p;
  inertia_forces(c, w, b, Mat3d::Zero(), y, zero, yd, p, momenta);
  double twice = 0;
  for (std::size_t i = 0; i < 4; ++i) twice += b[i].dot(p[i]);
  for (int k = 0; k < c.modes; ++k) twice += yd[k] * momenta[k];
  return 0.5 * twice;
}

Base rigid_base(const Vec3d& velocity, const Vec3d& omega) {
  return {velocity, omega.cross(Vec3d::UnitX()), omega.cross(Vec3d::UnitY()), omega.cross(Vec3d::UnitZ())};
}

}  // namespace mimbre::projection

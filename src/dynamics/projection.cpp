#include "dynamics/projection.h"

#include <algorithm>

namespace mimbre::projection {
namespace {

/// Four values at once; the fourth of a node's three is the next node's first and never used.
using Four = Eigen::Array4d;
using Eight = Eigen::Array<double, 8, 1>;
using Kind = Constants::Kind;

constexpr int kSums = 36;  // values per node in Constants::sums

auto four(const double* p) { return Eigen::Map<const Four>(p); }
auto eight(const double* p) { return Eigen::Map<const Eight>(p); }
template <class Values>
void store(double* p, const Eigen::ArrayBase<Values>& x) {
  Eigen::Map<Eigen::Array<double, Values::RowsAtCompileTime, 1>> out(p);
  out = x;
}

constexpr int block_size(Kind kind) {
  return kind == Kind::scalar ? 1 : kind == Kind::translations ? 12 : 24;
}

int dofs(const Constants& c) { return (c.rotations ? 6 : 3) * c.nodes; }

/// r̄ = r̄u + X y.
void positions(const Constants& c, Work& w, const double* y) {
  const double* x = c.shapes.data();
  for (int p = 0; p < c.panels; ++p) {
    Eight r = eight(c.undeformed.data() + 8 * p);
    for (int m = 0; m < c.modes; ++m, x += 8) r += eight(x) * y[m];
    store(w.position.data() + 8 * p, r);
  }
}

/// Positions, modal velocities and accelerations of translations and rotations.
void modal_motion(const Constants& c, Work& w, const double* y, const double* yd, const double* ydd) {
  const double* x = c.shapes.data();
  for (int p = 0; p < c.panels; ++p) {
    Eight r = eight(c.undeformed.data() + 8 * p), v = Eight::Zero(), a = Eight::Zero();
    for (int m = 0; m < c.modes; ++m, x += 8) {
      const Eight shape = eight(x);
      r += shape * y[m];
      v += shape * yd[m];
      a += shape * ydd[m];
    }
    store(w.position.data() + 8 * p, r);
    store(w.velocity.data() + 8 * p, v);
    store(w.modal.data() + 8 * p, a);
  }
  for (int p = c.panels; p < c.panels + c.rotation_panels; ++p) {
    Eight v = Eight::Zero(), a = Eight::Zero();
    for (int m = 0; m < c.modes; ++m, x += 8) {
      const Eight shape = eight(x);
      v += shape * yd[m];
      a += shape * ydd[m];
    }
    store(w.velocity.data() + 8 * p, v);
    store(w.modal.data() + 8 * p, a);
  }
}

/// Columns of a matrix or components of a vector, with a fourth value of zero.
Four padded(const Vec3d& a) { return {a[0], a[1], a[2], 0}; }
Vec3d front(const Four& a) { return a.head<3>().matrix(); }

/// The angular velocity in AᵀȦ.
Vec3d turning(const Mat3d& spin) {
  return 0.5 * Vec3d(spin(2, 1) - spin(1, 2), spin(0, 2) - spin(2, 0), spin(1, 0) - spin(0, 1));
}

/// Accelerations of the nodes.
void node_motion(const Constants& c, Work& w, const Base& b, const Mat3d& spin) {
  const Four b0 = padded(b[0]), b1 = padded(b[1]), b2 = padded(b[2]), b3 = padded(b[3]);
  const Four s0 = padded(2 * spin.col(0)), s1 = padded(2 * spin.col(1)), s2 = padded(2 * spin.col(2));
  const int step = c.rotations ? 8 : 4;
  const double *r = w.position.data(), *v = w.velocity.data(), *a = w.modal.data();
  double* out = w.node.data();
  for (int k = 0; k < c.nodes; ++k, r += 3, v += 3, a += 3, out += step)
    store(out,
          ((four(a) + b0) + (b1 * r[0] + b2 * r[1])) + ((b3 * r[2] + s0 * v[0]) + (s1 * v[1] + s2 * v[2])));
  if (!c.rotations) return;
  Vec3d alpha = Vec3d::Zero();
  for (int i = 0; i < 3; ++i) alpha += 0.5 * Vec3d::Unit(i).cross(b[static_cast<std::size_t>(i) + 1]);
  const Four rigid = padded(alpha);
  a = w.modal.data() + 8 * c.panels;
  out = w.node.data() + 4;
  for (int k = 0; k < c.nodes; ++k, a += 3, out += 8) store(out, four(a) + rigid);
}

/// Row k of M* a, translations.
template <Kind kind>
Four node_force(const Constants& c, const double* node, int k) {
  Four f = Four::Zero(), g = Four::Zero();
  const double* block = c.blocks.data() + static_cast<std::ptrdiff_t>(c.row_start[k]) * block_size(kind);
  for (int e = c.row_start[k]; e < c.row_start[k + 1]; ++e, block += block_size(kind)) {
    const double* a = node + (kind == Kind::full ? 8 : 4) * c.column[e];
    if constexpr (kind == Kind::scalar) {
      f += block[0] * four(a);
    } else {
      f += four(block) * a[0] + four(block + 8) * a[2];
      g += four(block + 4) * a[1];
      if constexpr (kind == Kind::full) {
        g += four(block + 12) * a[4] + four(block + 20) * a[6];
        f += four(block + 16) * a[5];
      }
    }
  }
  return f + g;
}

template <Kind kind>
void base_forces(const Constants& c, const Work& w, const Vec3d& omega, Base& forces) {
  Four f0 = Four::Zero(), f1 = f0, f2 = f0, f3 = f0, n = f0, h = f0;
  const double *node = w.node.data(), *r = w.position.data(), *sums = c.sums.data() + 12;
  for (int k = 0; k < c.nodes; ++k, r += 3) {
    const Four f = node_force<kind>(c, node, k);
    f0 += f;
    f1 += f * r[0];
    f2 += f * r[1];
    f3 += f * r[2];
    if constexpr (kind == Kind::full) {  // sums of all nodes' moments and angular momenta
      const double *a = node + 8 * k, *v = w.velocity.data() + 8 * c.panels + 3 * k;
      n += ((four(sums) * a[0] + four(sums + 4) * a[1]) + (four(sums + 8) * a[2] + four(sums + 12) * a[4])) +
           (four(sums + 16) * a[5] + four(sums + 20) * a[6]);
      h += (four(sums + 12) * v[0] + four(sums + 16) * v[1]) + four(sums + 20) * v[2];
      sums += kSums;
    }
  }
  forces = {front(f0), front(f1), front(f2), front(f3)};
  if constexpr (kind == Kind::full) {
    const Vec3d moment = front(n) + omega.cross(c.rotation * omega + front(h));
    for (int i = 0; i < 3; ++i) forces[static_cast<std::size_t>(i) + 1] += 0.5 * moment.cross(Vec3d::Unit(i));
  }
}

/// Adds (M*Φ)ᵀ a.
void modal_forces(const Constants& c, const Work& w, double* elastic) {
  const double* row = c.mass_shapes.data();
  for (int m = 0; m < c.modes; m += 4) {
    Four x = Four::Zero(), y = x, z = x;
    const int step = c.rotations ? 8 : 4;
    const double* a = w.node.data();
    for (int k = 0; k < c.nodes; ++k, row += 12, a += step) {
      x += four(row) * a[0];
      y += four(row + 4) * a[1];
      z += four(row + 8) * a[2];
    }
    if (c.rotations) {
      a = w.node.data() + 4;
      for (int k = 0; k < c.nodes; ++k, row += 12, a += 8) {
        x += four(row) * a[0];
        y += four(row + 4) * a[1];
        z += four(row + 8) * a[2];
      }
    }
    store(elastic + m, four(elastic + m) + (x + y + z));
  }
}

/// The nine rows Σ_k r̄_ki (M*Φ)_kj + ½ (Σ_k (M*Φ)θ_k × e_i)_j at the positions in w.
void axis_coupling(const Constants& c, const Work& w, double* rows) {
  const int s = c.stride;
  std::fill(rows, rows + 9 * s, 0.0);
  for (int m = 0; m < c.modes; m += 4) {
    const double *row = c.mass_shapes.data() + static_cast<std::ptrdiff_t>(m) * dofs(c),
                 *r = w.position.data();
    Four sum[9];
    for (Four& x : sum) x.setZero();
    for (int k = 0; k < c.nodes; ++k, row += 12, r += 3) {
      const Four x = four(row), y = four(row + 4), z = four(row + 8);
      for (int i = 0; i < 3; ++i) {
        sum[3 * i] += x * r[i];
        sum[3 * i + 1] += y * r[i];
        sum[3 * i + 2] += z * r[i];
      }
    }
    for (int i = 0; i < 9; ++i) store(rows + i * s + m, sum[i]);
  }
  if (!c.rotations) return;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double* theta = c.S_theta.data() + k * s;
    for (int m = 0; m < s; ++m) {
      rows[(3 * i + j) * s + m] += 0.5 * theta[m];
      rows[(3 * j + i) * s + m] -= 0.5 * theta[m];
    }
  }
}

/// Σ_kl m_kl r̄_k r̄_lᵀ.
Mat3d scalar_second_moment(const Constants& c, const Work& w) {
  Four sum[3] = {Four::Zero(), Four::Zero(), Four::Zero()};
  for (int k = 0; k < c.nodes; ++k) {
    int e = c.diagonal[k];
    const double* r = w.position.data() + 3 * k;
    Four u = 0.5 * c.blocks[e] * four(r);  // half of the matrix: it is symmetric
    for (++e; e < c.row_start[k + 1]; ++e) u += c.blocks[e] * four(w.position.data() + 3 * c.column[e]);
    for (int i = 0; i < 3; ++i) sum[i] += r[i] * u;
  }
  Mat3d half;
  for (int i = 0; i < 3; ++i) half.row(i) = front(sum[i]);
  return half + half.transpose();
}

/// Σ_kl r̄_k~ᵀ M*_kl^tt r̄_l~.
template <Kind kind>
Mat3d inertia_of_translations(const Constants& c, const Work& w) {
  Four sum[9];
  for (Four& x : sum) x.setZero();
  for (int k = 0; k < c.nodes; ++k) {
    // Column j of M*_kl times e_j × r̄_l, over the half of the matrix right of the diagonal.
    Four v0 = Four::Zero(), v1 = v0, v2 = v0;
    const double* block = c.blocks.data() + static_cast<std::ptrdiff_t>(c.diagonal[k]) * block_size(kind);
    for (int e = c.diagonal[k]; e < c.row_start[k + 1]; ++e, block += block_size(kind)) {
      const double* r = w.position.data() + 3 * c.column[e];
      const Four x = four(block), y = four(block + 4), z = four(block + 8);
      v0 += z * r[1] - y * r[2];
      v1 += x * r[2] - z * r[0];
      v2 += y * r[0] - x * r[1];
      if (e == c.diagonal[k]) {
        v0 *= 0.5;
        v1 *= 0.5;
        v2 *= 0.5;
      }
    }
    const double* r = w.position.data() + 3 * k;
    for (int i = 0; i < 3; ++i) {
      sum[i] += v0 * r[i];
      sum[3 + i] += v1 * r[i];
      sum[6 + i] += v2 * r[i];
    }
  }
  Mat3d half;  // column j: Σ r̄ × v_j
  for (int j = 0; j < 3; ++j)
    for (int a = 0; a < 3; ++a) {
      const int i = (a + 1) % 3, l = (a + 2) % 3;
      half(a, j) = sum[3 * j + i][l] - sum[3 * j + l][i];
    }
  return half + half.transpose();
}

/// Q_ij = Σ_kl r̄_ki M*_kl^tt r̄_lj, nine 3 × 3 blocks of a 9 × 9 matrix.
template <Kind kind>
void axis_mass(const Constants& c, const Work& w, Eigen::Matrix<double, 9, 9>& mass) {
  Four sum[27];  // [i][j][column]
  for (Four& x : sum) x.setZero();
  for (int k = 0; k < c.nodes; ++k) {
    Four u[9];  // [j][column]
    for (Four& x : u) x.setZero();
    const double* block = c.blocks.data() + static_cast<std::ptrdiff_t>(c.diagonal[k]) * block_size(kind);
    for (int e = c.diagonal[k]; e < c.row_start[k + 1]; ++e, block += block_size(kind)) {
      const double* r = w.position.data() + 3 * c.column[e];
      const double half = e == c.diagonal[k] ? 0.5 : 1;
      const Four x = half * four(block), y = half * four(block + 4), z = half * four(block + 8);
      for (int j = 0; j < 3; ++j) {
        u[3 * j] += x * r[j];
        u[3 * j + 1] += y * r[j];
        u[3 * j + 2] += z * r[j];
      }
    }
    const double* r = w.position.data() + 3 * k;
    for (int i = 0; i < 3; ++i)
      for (int x = 0; x < 9; ++x) sum[9 * i + x] += u[x] * r[i];
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int b = 0; b < 3; ++b) mass.block<3, 1>(3 * i, 3 * j + b) = front(sum[9 * i + 3 * j + b]);
  mass += mass.transpose().eval();
}

/// T_i = Σ_k r̄_ki Σ_l M*_kl^tθ.
std::array<Mat3d, 3> translations_of_turns(const Constants& c, const Work& w) {
  Four sum[9];
  for (Four& x : sum) x.setZero();
  const double *sums = c.sums.data() + 12, *r = w.position.data();
  for (int k = 0; k < c.nodes; ++k, sums += kSums, r += 3)
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 3; ++a) sum[3 * i + a] += four(sums + 4 * a) * r[i];
  std::array<Mat3d, 3> T;
  for (int i = 0; i < 3; ++i)
    for (int a = 0; a < 3; ++a) T[static_cast<std::size_t>(i)].row(a) = front(sum[3 * i + a]);
  return T;
}

/// Blocks of the origin and the axes: Σ_kl M*_lk r̄_ki, without rotations.
std::array<Mat3d, 3> origin_mass(const Constants& c, const Work& w) {
  std::array<Mat3d, 3> out{Mat3d::Zero(), Mat3d::Zero(), Mat3d::Zero()};
  if (c.kind == Kind::scalar) {
    Four first = Four::Zero();
    for (int k = 0; k < c.nodes; ++k)
      first += c.sums[static_cast<std::size_t>(k) * kSums] * four(w.position.data() + 3 * k);
    for (int i = 0; i < 3; ++i) out[static_cast<std::size_t>(i)].diagonal().setConstant(first[i]);
    return out;
  }
  Four sum[9];
  for (Four& x : sum) x.setZero();
  const double *sums = c.sums.data(), *r = w.position.data();
  for (int k = 0; k < c.nodes; ++k, sums += kSums, r += 3)
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 3; ++a) sum[3 * i + a] += four(sums + 4 * a) * r[i];
  for (int i = 0; i < 3; ++i)
    for (int a = 0; a < 3; ++a) out[static_cast<std::size_t>(i)].col(a) = front(sum[3 * i + a]);
  return out;
}

}  // namespace

void Work::fit(const Constants& c) {
  const auto grow = [](Values& values, int size) {
    if (values.size() < static_cast<std::size_t>(size)) values.resize(static_cast<std::size_t>(size), 0.0);
  };
  const int size = 8 * (c.panels + c.rotation_panels) + 8;  // room for reading four at the last node
  grow(position, size);
  grow(velocity, size);
  grow(modal, size);
  grow(node, 8 * c.nodes);
}

void inertia_forces(const Constants& c, Work& w, const Base& b, const Mat3d& spin, const double* y,
                    const double* yd, const double* ydd, Base& forces, double* elastic) {
  modal_motion(c, w, y, yd, ydd);
  node_motion(c, w, b, spin);
  const Vec3d omega = turning(spin);
  switch (c.kind) {
    case Kind::scalar:
      base_forces<Kind::scalar>(c, w, omega, forces);
      break;
    case Kind::translations:
      base_forces<Kind::translations>(c, w, omega, forces);
      break;
    case Kind::full:
      base_forces<Kind::full>(c, w, omega, forces);
      break;
  }
  modal_forces(c, w, elastic);
}

Wrench inertia_wrench(const Constants& c, Work& w, const Vec3d& acc, const Vec3d& omega, const Vec3d& alpha,
                      const double* y, const double* yd, const double* ydd, double* elastic) {
  const Mat3d spin = skew<double>(omega), field = skew<double>(alpha) + spin * spin;
  Base forces;
  inertia_forces(c, w, {acc, field.col(0), field.col(1), field.col(2)}, spin, y, yd, ydd, forces, elastic);
  Wrench out{forces[0], Vec3d::Zero()};
  for (int i = 0; i < 3; ++i) out.moment += Vec3d::Unit(i).cross(forces[static_cast<std::size_t>(i) + 1]);
  return out;
}

void base_mass(const Constants& c, Work& w, const double* y, Mat12d& mass, double* coupling) {
  positions(c, w, y);
  std::copy(c.S.data(), c.S.data() + 3 * c.stride, coupling);
  axis_coupling(c, w, coupling + 3 * c.stride);

  Eigen::Matrix<double, 9, 9> axes;
  switch (c.kind) {
    case Kind::scalar: {
      const Mat3d second = scalar_second_moment(c, w);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) axes.block<3, 3>(3 * i, 3 * j) = second(i, j) * Mat3d::Identity();
      break;
    }
    case Kind::translations:
      axis_mass<Kind::translations>(c, w, axes);
      break;
    case Kind::full:
      axis_mass<Kind::full>(c, w, axes);
      break;
  }
  std::array<Mat3d, 3> first = origin_mass(c, w);
  if (c.rotations) {
    const std::array<Mat3d, 3> T = translations_of_turns(c, w);
    std::array<Mat3d, 3> half;  // rotation of all nodes by a base vector
    for (int i = 0; i < 3; ++i) half[static_cast<std::size_t>(i)] = 0.5 * skew<double>(Vec3d::Unit(i));
    for (std::size_t i = 0; i < 3; ++i) {
      first[i] += c.mixed * half[i];
      for (std::size_t j = 0; j < 3; ++j)
        axes.block<3, 3>(3 * static_cast<int>(i), 3 * static_cast<int>(j)) +=
            T[i] * half[j] + half[i].transpose() * T[j].transpose() +
            half[i].transpose() * c.rotation * half[j];
    }
  }
  mass.topLeftCorner<3, 3>() = c.translation;
  for (int i = 0; i < 3; ++i) {
    mass.block<3, 3>(0, 3 + 3 * i) = first[static_cast<std::size_t>(i)];
    mass.block<3, 3>(3 + 3 * i, 0) = first[static_cast<std::size_t>(i)].transpose();
  }
  mass.bottomRightCorner<9, 9>() = axes;
}

void rigid_mass(const Constants& c, Work& w, const double* y, Vec3d& first_moment, Mat3d& second_moment,
                double* integrals) {
  positions(c, w, y);
  axis_coupling(c, w, integrals);
  Four first = Four::Zero();
  for (int k = 0; k < c.nodes; ++k)
    first += c.sums[static_cast<std::size_t>(k) * kSums] * four(w.position.data() + 3 * k);
  // −m̄~ is the block of force and angular velocity.
  first_moment = front(first) + Vec3d(c.mixed(1, 2), c.mixed(2, 0), c.mixed(0, 1));
  if (c.kind == Kind::scalar) {
    second_moment = scalar_second_moment(c, w);
    return;
  }
  Mat3d inertia = c.kind == Kind::full ? inertia_of_translations<Kind::full>(c, w)
                                       : inertia_of_translations<Kind::translations>(c, w);
  if (c.rotations) {
    const std::array<Mat3d, 3> T = translations_of_turns(c, w);
    Mat3d mixed = Mat3d::Zero();  // Σ r̄_k~ Σ_l M*_kl^tθ
    for (int i = 0; i < 3; ++i) mixed += skew<double>(Vec3d::Unit(i)) * T[static_cast<std::size_t>(i)];
    inertia += mixed + mixed.transpose() + c.rotation;
  }
  second_moment = 0.5 * inertia.trace() * Mat3d::Identity() - inertia;
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

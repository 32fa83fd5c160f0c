#include "analysis/modes/blades.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "math/once/general_eigen.h"
#include "math/rotation.h"
#include "mimbre/reduced_body.h"

namespace mimbre::linear {

namespace {

std::complex<double> turned_by(double angle) { return {mimbre::cos(angle), mimbre::sin(angle)}; }

/// Of lengths, masses and directions: the same.
constexpr double copied = 1e-6;

/// A body with its mass in the drawn position, global.
struct Placed {
  double mass = 0;
  Vec3d centre = Vec3d::Zero();
  Mat3d axes = Mat3d::Identity();
  Mat3d inertia = Mat3d::Zero();  ///< of a rigid one, about its centre
};

Placed placed(const spec::Body& body) {
  Placed out;
  out.axes = body.pose.rotation;
  Vec3d centre = body.com;
  if (body.flexible) {
    out.mass = body.flexible->mass;
    centre = out.mass > 0 ? Vec3d(body.flexible->first_moment / out.mass) : Vec3d(Vec3d::Zero());
  } else {
    out.mass = body.mass;
    out.inertia = out.axes * body.inertia * out.axes.transpose();
  }
  out.centre = body.pose.position + out.axes * centre;
  return out;
}

/// Which bodies, with all that they carry, are copies of each other.
class Copies {
 public:
  explicit Copies(const Compiled& m) : m_(m), children_(m.bodies.size()) {
    for (std::size_t k = 0; k < m.bodies.size(); ++k)
      if (m.bodies[k].parent >= 0)
        children_[static_cast<std::size_t>(m.bodies[k].parent)].push_back(static_cast<int>(k));
  }

  const std::vector<int>& children(int body) const { return children_[static_cast<std::size_t>(body)]; }
  Placed placed_body(int body) const { return placed(spec_of(body)); }

  /// Without regard to where they are: bodies of equal masses, joints and modes.
  bool alike(int a, int b) const {
    const BodyData &one = m_.bodies[static_cast<std::size_t>(a)],
                   &two = m_.bodies[static_cast<std::size_t>(b)];
    const Placed x = placed_body(a), y = placed_body(b);
    if (one.joint != two.joint || one.modes != two.modes || one.joint_velocities != two.joint_velocities ||
        std::abs(x.mass - y.mass) > copied * std::abs(x.mass) || children(a).size() != children(b).size())
      return false;
    for (std::size_t k = 0; k < children(a).size(); ++k)
      if (!alike(children(a)[k], children(b)[k])) return false;
    return true;
  }

  /// Whether b is a, turned about the axis through `centre` by D, with its joint.
  bool is_turned(int a, int b, const Vec3d& centre, const Mat3d& D, double length) const {
    const Placed x = placed_body(a), y = placed_body(b);
    if ((centre + D * (x.centre - centre) - y.centre).norm() > copied * length) return false;
    if ((D * x.inertia * D.transpose() - y.inertia).norm() > copied * x.inertia.norm()) return false;
    const BodyData& body = m_.bodies[static_cast<std::size_t>(a)];
    if (body.modes > 0 && (D * x.axes - y.axes).norm() > copied) return false;
    if (!joint_is_turned(a, b, D)) return false;
    if ((centre + D * (joint_place(a) - centre) - joint_place(b)).norm() > copied * length) return false;
    for (std::size_t k = 0; k < children(a).size(); ++k)
      if (!is_turned(children(a)[k], children(b)[k], centre, D, length)) return false;
    return true;
  }

  void add_coordinates(int body, std::vector<int>& to) const {
    const BodyData& b = m_.bodies[static_cast<std::size_t>(body)];
    for (int k = 0; k < b.size(); ++k) to.push_back(b.v + k);
    for (const int child : children(body)) add_coordinates(child, to);
  }

 private:
  const spec::Body& spec_of(int body) const {
    return m_.spec().bodies[static_cast<std::size_t>(m_.bodies[static_cast<std::size_t>(body)].spec)];
  }
  Mat3d joint_axes(int body) const {
    const BodyData& b = m_.bodies[static_cast<std::size_t>(body)];
    const Mat3d carrier = b.parent < 0 ? Mat3d(Mat3d::Identity()) : Mat3d(spec_of(b.parent).pose.rotation);
    return carrier * m_.frames[static_cast<std::size_t>(b.inboard_frame)].rotation;
  }
  Vec3d joint_place(int body) const {
    const BodyData& b = m_.bodies[static_cast<std::size_t>(body)];
    const Vec3d& place = m_.frames[static_cast<std::size_t>(b.inboard_frame)].position;
    if (b.parent < 0) return place;
    const spec::Pose& carrier = spec_of(b.parent).pose;
    return carrier.position + carrier.rotation * place;
  }
  /// The axes of its coordinates, or all where these are not along such.
  bool joint_is_turned(int a, int b, const Mat3d& D) const {
    const BodyData& body = m_.bodies[static_cast<std::size_t>(a)];
    const Mat3d off = D * joint_axes(a) - joint_axes(b);
    for (int k = 0; k < body.joint_velocities; ++k) {
      const int axis = k < 6 ? body.joint_axes[static_cast<std::size_t>(k)] : -1;
      if ((axis < 0 ? off.norm() : off.col(axis).norm()) > copied) return false;
    }
    return true;
  }

  const Compiled& m_;
  std::vector<std::vector<int>> children_;
};

/// Blades around one axis, of bodies that are alike.
bool arrange(const Copies& copies, const std::vector<int>& bodies, Blades& out) {
  const auto n = static_cast<int>(bodies.size());
  std::vector<Vec3d> places;
  Vec3d centre = Vec3d::Zero();
  for (const int body : bodies) {
    places.push_back(copies.placed_body(body).centre);
    centre += places.back() / n;
  }
  const Vec3d first = places[0] - centre;
  const double radius = first.norm();
  Vec3d normal = Vec3d::Zero();
  for (const Vec3d& place : places)
    if (const Vec3d by = first.cross(Vec3d(place - centre)); by.norm() > normal.norm()) normal = by;
  if (!(normal.norm() > 1e-3 * radius * radius)) return false;
  out.axis = normal.normalized();
  const Vec3d x = first / radius, y = out.axis.cross(x);
  std::vector<std::pair<double, int>> order;
  for (int k = 0; k < n; ++k) {
    const Vec3d arm = places[static_cast<std::size_t>(k)] - centre;
    double angle = mimbre::atan2(arm.dot(y), arm.dot(x));
    if (angle < -copied) angle += 2 * std::numbers::pi;
    order.emplace_back(angle, bodies[static_cast<std::size_t>(k)]);
  }
  std::sort(order.begin(), order.end());
  for (int k = 0; k < n; ++k) {
    const auto& [angle, body] = order[static_cast<std::size_t>(k)];
    const double even = 2 * std::numbers::pi * k / n;
    if (std::abs(angle - even) > copied) return false;
    const Mat3d D = rotation_exp(Vec3d(even * out.axis));
    if (!copies.is_turned(order[0].second, body, centre, D, radius)) return false;
    out.angles.push_back(even);
    out.coordinates.emplace_back();
    copies.add_coordinates(body, out.coordinates.back());
  }
  return !out.coordinates[0].empty();
}

/// Of eigenvalues: they are equal.
constexpr double equal = 1e-7;
/// Of a projector: round-off.
constexpr double nothing_left_over = 1e-6;

/// Orthonormal columns of X T, and T; false: the columns depend on each other.
bool orthonormal(Eigen::MatrixXcd& X, Eigen::MatrixXcd& T) {
  T.setIdentity(X.cols(), X.cols());
  for (Eigen::Index k = 0; k < X.cols(); ++k) {
    const double before = X.col(k).norm();
    for (int twice = 0; twice < 2; ++twice)
      for (Eigen::Index j = 0; j < k; ++j) {
        const std::complex<double> part = X.col(j).dot(X.col(k));
        X.col(k) -= part * X.col(j);
        T.col(k) -= part * T.col(j);
      }
    const double length = X.col(k).norm();
    if (!(length > nothing_left_over * before)) return false;
    X.col(k) /= length;
    T.col(k) /= length;
  }
  return true;
}

/// What blades do in motions, along the scales, one blade below the other.
Eigen::MatrixXcd of_blades(const Blades& blades, const Eigen::MatrixXcd& motions,
                           const std::vector<double>& scales) {
  const std::size_t size = blades.coordinates[0].size();
  Eigen::MatrixXcd out(static_cast<Eigen::Index>(blades.coordinates.size() * size), motions.cols());
  for (std::size_t k = 0; k < blades.coordinates.size(); ++k)
    for (std::size_t c = 0; c < size; ++c) {
      const int at = blades.coordinates[k][c];
      out.row(static_cast<Eigen::Index>(k * size + c)) =
          motions.row(at) / scales[static_cast<std::size_t>(at)];
    }
  return out;
}

/// Combinations of the columns of X, what blades do, each of which is one wave; none: there are no such.
Eigen::MatrixXcd waves_of(const Blades& blades, Eigen::MatrixXcd X) {
  const auto n = static_cast<int>(blades.coordinates.size());
  const Eigen::Index count = X.cols(), size = X.rows() / n;
  Eigen::MatrixXcd T, out(count, 0);
  if (!orthonormal(X, T)) return out;
  for (int harmonic = 0; harmonic < n; ++harmonic) {
    Eigen::MatrixXcd amplitude = Eigen::MatrixXcd::Zero(size, count);
    for (int k = 0; k < n; ++k)
      amplitude +=
          turned_by(harmonic * blades.angles[static_cast<std::size_t>(k)]) * X.middleRows(k * size, size);
    // The projector on the wave, where the columns span such waves.
    Eigen::MatrixXcd P = amplitude.adjoint() * amplitude / n;
    for (Eigen::Index found = 0; found < count; ++found) {
      Eigen::Index most = 0;
      if (!(P.colwise().norm().maxCoeff(&most) > 0.5 / std::sqrt(double(count)))) break;
      const Eigen::VectorXcd column = P.col(most).normalized();
      if ((P * column - column).norm() > nothing_left_over) return Eigen::MatrixXcd(count, 0);
      out.conservativeResize(count, out.cols() + 1);
      out.col(out.cols() - 1) = T * column;
      P -= column * (column.adjoint() * P);
    }
    if (P.norm() > nothing_left_over) return Eigen::MatrixXcd(count, 0);
  }
  return out.cols() == count ? out : Eigen::MatrixXcd(count, 0);
}

std::string wave_name(int harmonic, int blades, bool against) {
  if (harmonic == 0) return "collective";
  if (2 * harmonic == blades) return "differential";
  const bool upper = 2 * harmonic > blades;
  const int order = upper ? blades - harmonic : harmonic;
  const std::string way = upper == against ? "forward" : "backward";
  return order == 1 ? way : fmt::format("{} of harmonic {}", way, order);
}

}  // namespace

std::vector<Blades> find_blades(const Compiled& m) {
  std::vector<Blades> out;
  const Copies copies(m);
  for (std::size_t hub = 0; hub < m.bodies.size(); ++hub) {
    std::vector<int> left = copies.children(static_cast<int>(hub));
    while (left.size() >= 3) {
      std::vector<int> bodies, others;
      for (const int body : left) (copies.alike(left[0], body) ? bodies : others).push_back(body);
      Blades found;
      found.hub = static_cast<int>(hub);
      if (bodies.size() >= 3 && arrange(copies, bodies, found)) out.push_back(std::move(found));
      left = std::move(others);
    }
  }
  return out;
}

std::vector<Blades> joined(const std::vector<Blades>& rotors) {
  std::vector<Blades> out = rotors;
  for (std::size_t k = 0; k < rotors.size(); ++k) {
    Blades all = rotors[k];
    for (std::size_t other = k + 1; other < rotors.size(); ++other)
      if (rotors[other].angles.size() == all.angles.size())
        for (std::size_t b = 0; b < all.coordinates.size(); ++b)
          all.coordinates[b].insert(all.coordinates[b].end(), rotors[other].coordinates[b].begin(),
                                    rotors[other].coordinates[b].end());
    if (all.coordinates[0].size() > rotors[k].coordinates[0].size()) out.push_back(std::move(all));
  }
  return out;
}

std::vector<ModeShare> blade_waves(const Blades& blades, const Eigen::VectorXcd& motion,
                                   const std::vector<double>& scales, const Vec3d& turning) {
  const auto n = static_cast<int>(blades.coordinates.size());
  const bool against = turning.dot(blades.axis) < 0;
  std::vector<ModeShare> out;
  double all = 0;
  for (int harmonic = 0; harmonic < n; ++harmonic) {
    double square = 0;
    for (std::size_t c = 0; c < blades.coordinates[0].size(); ++c) {
      std::complex<double> sum = 0;
      for (int k = 0; k < n; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const int at = blades.coordinates[i][c];
        sum += motion[at] / scales[static_cast<std::size_t>(at)] * turned_by(harmonic * blades.angles[i]);
      }
      square += std::norm(sum);
    }
    all += square;
    out.push_back({wave_name(harmonic, n, against), square});
  }
  for (ModeShare& wave : out) wave.share = all > 0 ? wave.share / all : 0;
  return out;
}

std::vector<std::size_t> separate_waves(const std::vector<Blades>& rotors, const Eigen::MatrixXd& position,
                                        const std::vector<double>& scales, std::vector<Mode>& modes,
                                        std::vector<char>& mixed) {
  mixed.assign(modes.size(), 0);
  std::vector<std::size_t> changed;
  if (rotors.empty()) return changed;
  for (std::size_t first = 0, last = 0; first < modes.size(); first = last) {
    const std::complex<double> value = modes[first].value;
    for (last = first + 1; last < modes.size(); ++last)
      if (!(std::abs(modes[last].value - value) <= equal * std::abs(value))) break;
    if (last - first < 2) continue;
    std::fill(mixed.begin() + static_cast<std::ptrdiff_t>(first),
              mixed.begin() + static_cast<std::ptrdiff_t>(last), 1);
    if (modes[first].kind != Mode::Kind::oscillating) continue;
    const auto count = static_cast<Eigen::Index>(last - first);
    Eigen::MatrixXcd shapes(modes[first].shape.size(), count), left(shapes.rows(), count);
    for (Eigen::Index k = 0; k < count; ++k) {
      shapes.col(k) = modes[first + static_cast<std::size_t>(k)].shape;
      left.col(k) = modes[first + static_cast<std::size_t>(k)].left;
    }
    const Eigen::MatrixXcd motions = position.cast<std::complex<double>>() * shapes;
    Eigen::MatrixXcd waves(count, 0);
    for (std::size_t k = 0; k < rotors.size() && waves.cols() != count; ++k)
      waves = waves_of(rotors[k], of_blades(rotors[k], motions, scales));
    if (waves.cols() != count) continue;
    shapes *= waves;
    left *= complex_inverse(waves).adjoint();
    for (Eigen::Index k = 0; k < count; ++k) {
      const std::size_t at = first + static_cast<std::size_t>(k);
      modes[at].shape = shapes.col(k);
      modes[at].left = left.col(k);
      mixed[at] = 0;
      changed.push_back(at);
    }
  }
  return changed;
}

}  // namespace mimbre::linear

#include "analysis/modes/mode_likeness.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "math/once/decompositions.h"
#include "math/once/general_eigen.h"

namespace mimbre::linear {

using Eigen::MatrixXcd;

namespace {

constexpr double same_place = 1e-7;   ///< of the larger eigenvalue: equal ones
constexpr double rigid_change = 0.5;  ///< of a rigid motion, from value to value
constexpr double one_shape = 1e4;  ///< of the products of entries of left and right vectors, whose sum is 1

bool comparable(const Mode& a, const Mode& b) {
  return a.shape.size() == b.shape.size() && a.left.size() == b.left.size();
}

/// Whether the shapes of two modes have become one, where they meet and one begins to grow.
bool meets(const Mode& mode) { return mode.left.cwiseProduct(mode.shape).cwiseAbs().maxCoeff() > one_shape; }

/// λ + i k turn that is nearest to another one.
std::complex<double> nearest_multiple(std::complex<double> value, double turn, std::complex<double> to) {
  if (!(turn > 0)) return value;
  return {value.real(), value.imag() + turn * std::round((to.imag() - value.imag()) / turn)};
}

/// Any combination of rigid motions is one: takes those that go on, where all of them do.
void align_rigid(std::vector<Mode>& modes, const std::vector<Mode>& to) {
  const auto rigid_of = [](const std::vector<Mode>& of) {
    std::vector<std::size_t> out;
    for (std::size_t k = 0; k < of.size(); ++k)
      if (of[k].kind == Mode::Kind::rigid) out.push_back(k);
    return out;
  };
  const std::vector<std::size_t> here = rigid_of(modes), there = rigid_of(to);
  if (here.empty() || here.size() != there.size() || !comparable(modes[here[0]], to[there[0]])) return;
  const auto n = static_cast<Eigen::Index>(here.size());
  const auto columns = [n](const std::vector<Mode>& of, const std::vector<std::size_t>& which,
                           Eigen::VectorXcd Mode::*vector) {
    MatrixXcd out((of[which[0]].*vector).size(), n);
    for (Eigen::Index k = 0; k < n; ++k) out.col(k) = of[which[static_cast<std::size_t>(k)]].*vector;
    return out;
  };
  const MatrixXcd shapes = columns(modes, here, &Mode::shape), motions = columns(modes, here, &Mode::motion),
                  wanted = columns(to, there, &Mode::shape);
  // Entries of one size, whatever their units.
  const Eigen::VectorXd sizes = wanted.cwiseAbs().rowwise().maxCoeff().cwiseMax(
                            shapes.cwiseAbs().rowwise().maxCoeff()),
                        units = sizes.unaryExpr([](double x) { return x > 0 ? 1 / x : 0; });
  const Eigen::MatrixXd given = units.asDiagonal() * shapes.real(),
                        sought = units.asDiagonal() * wanted.real(),
                        by = shortest_solution(given, sought, 1e-12);
  // They change with the parameter. None may be lost.
  for (Eigen::Index k = 0; k < n; ++k)
    if ((given * by.col(k) - sought.col(k)).norm() > rigid_change * sought.col(k).norm()) return;
  for (Eigen::Index k = 0; k < n; ++k) {
    Mode& mode = modes[here[static_cast<std::size_t>(k)]];
    mode.shape = shapes * by.col(k).cast<std::complex<double>>();
    mode.motion = motions * by.col(k).cast<std::complex<double>>();
  }
}

}  // namespace

double alike(const Mode& a, const Mode& b) {
  if (!comparable(a, b)) {
    const std::complex<double> product = a.motion.dot(b.motion);
    return std::abs(product) / (a.motion.norm() * b.motion.norm() + 1e-300);
  }
  const bool rigid = a.kind == Mode::Kind::rigid;
  if (rigid != (b.kind == Mode::Kind::rigid)) return 0;
  if (rigid) return std::abs(a.shape.dot(b.shape)) / (a.shape.norm() * b.shape.norm() + 1e-300);
  const auto with = [&](const Eigen::VectorXcd& shape, const Eigen::VectorXcd& left) {
    return std::sqrt(std::abs(a.left.dot(shape)) * std::abs(left.dot(a.shape)));
  };
  // In axes that turn, λ may go through the real axis: its conjugate is the one that is listed then.
  return std::max(with(b.shape, b.left), with(b.shape.conjugate(), b.left.conjugate()));
}

void go_on_from(const Mode& from, double turn, Mode& to) {
  if (!(turn > 0) || to.kind == Mode::Kind::rigid || !comparable(from, to)) return;
  if (std::abs(from.left.dot(to.shape.conjugate())) > std::abs(from.left.dot(to.shape))) {
    to.value = std::conj(to.value);
    for (Eigen::VectorXcd* x : {&to.shape, &to.left, &to.motion}) *x = x->conjugate().eval();
  }
  to.value = nearest_multiple(to.value, turn, from.value);
  to.fixed = to.value;
  to.frequency = std::abs(to.value) / (2 * std::numbers::pi);
  to.damped = to.value.imag() / (2 * std::numbers::pi);
  to.damping = std::abs(to.value) > 0 ? -to.value.real() / std::abs(to.value) : 0;
}

std::vector<std::vector<std::size_t>> clusters_of(const std::vector<Mode>& modes) {
  std::vector<std::vector<std::size_t>> out;
  std::vector<char> taken(modes.size(), 0);
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (taken[i] || modes[i].kind == Mode::Kind::rigid || meets(modes[i])) continue;
    std::vector<std::size_t> cluster{i};
    for (std::size_t j = i + 1; j < modes.size(); ++j)
      if (!taken[j] && modes[j].kind == modes[i].kind && !meets(modes[j]) &&
          std::abs(modes[j].value - modes[i].value) <= same_place * std::abs(modes[i].value)) {
        cluster.push_back(j);
        taken[j] = 1;
      }
    if (cluster.size() > 1) out.push_back(std::move(cluster));
  }
  return out;
}

void align(std::vector<Mode>& modes, const std::vector<Mode>& to) {
  align_rigid(modes, to);
  for (const std::vector<std::size_t>& cluster : clusters_of(modes)) {
    std::vector<std::pair<double, std::size_t>> nearest;
    for (std::size_t j = 0; j < to.size(); ++j) {
      double in = 0;
      for (const std::size_t i : cluster)
        if (comparable(modes[i], to[j]) && to[j].kind != Mode::Kind::rigid) {
          const double a = alike(modes[i], to[j]);
          in += a * a;
        }
      nearest.emplace_back(in, j);
    }
    const auto n = static_cast<Eigen::Index>(cluster.size());
    if (std::ssize(nearest) < n) continue;
    std::stable_sort(nearest.begin(), nearest.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    if (!(nearest[cluster.size() - 1].first > 0.2)) continue;
    MatrixXcd by(n, n);
    for (Eigen::Index r = 0; r < n; ++r)
      for (Eigen::Index c = 0; c < n; ++c)
        by(r, c) = modes[cluster[static_cast<std::size_t>(r)]].left.dot(
            to[nearest[static_cast<std::size_t>(c)].second].shape);
    const MatrixXcd back = complex_inverse(by);
    if (!back.allFinite() || back.cwiseAbs().maxCoeff() > 1e6) continue;
    std::vector<Mode> turned;
    for (Eigen::Index c = 0; c < n; ++c) {
      Mode mode = modes[cluster[static_cast<std::size_t>(c)]];
      mode.shape.setZero();
      mode.motion.setZero();
      mode.left.setZero();
      for (Eigen::Index r = 0; r < n; ++r) {
        const Mode& of = modes[cluster[static_cast<std::size_t>(r)]];
        mode.shape += by(r, c) * of.shape;
        mode.motion += by(r, c) * of.motion;
        // wᴴ ← B⁻¹ wᴴ.
        mode.left += std::conj(back(c, r)) * of.left;
      }
      const Mode& like = to[nearest[static_cast<std::size_t>(c)].second];
      mode.whirl = like.whirl;
      // Where nothing turns here, the ground sees the same.
      const bool turns = std::any_of(cluster.begin(), cluster.end(),
                                     [&](std::size_t k) { return modes[k].fixed != modes[k].value; });
      if (like.fixed == 0.)
        mode.fixed = like.fixed;
      else
        mode.fixed = turns ? mode.value + (like.fixed - like.value) : mode.value;
      turned.push_back(std::move(mode));
    }
    for (std::size_t k = 0; k < cluster.size(); ++k) modes[cluster[k]] = std::move(turned[k]);
  }
}

}  // namespace mimbre::linear

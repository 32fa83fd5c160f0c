#include "integrate/global_modes/loop_table.h"

#include <cmath>

#include "math/rotation.h"

namespace mimbre::global_modes {

using Eigen::Index;
using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Block = Map<const MatrixXd>;

namespace {

/// Angular velocity in the body by θ̇ = 1 where a quaternion goes along (p, p'), and its derivative by θ:
/// ω = 2 Im(p̄ p')/|p|².
struct Turning {
  Vec3<double> rate, second;
};

Vec3<double> twice_imaginary(const double* p, const double* d) {
  const Vec3<double> a(p[1], p[2], p[3]), b(d[1], d[2], d[3]);
  return 2 * (p[0] * b - d[0] * a - a.cross(b));
}

Turning turning_of(const double* p, const double* first, const double* second) {
  const Map<const Eigen::Vector4d> value(p), rate(first);
  const double square = value.squaredNorm();
  Turning t;
  t.rate = twice_imaginary(p, first) / square;
  t.second = twice_imaginary(p, second) / square - 2 * value.dot(rate) / square * t.rate;
  return t;
}

}  // namespace

std::vector<int> LoopTable::joint_coordinates() const {
  std::vector<int> out = plain;
  for (const int first : rotation)
    for (int k = 0; k < 3; ++k) out.push_back(first + k);
  return out;
}

LoopMotion::LoopMotion(const LoopTable& table) : table_(table), rows_(table.joint_coordinates()) {
  rows_.insert(rows_.end(), table.amplitude.begin(), table.amplitude.end());
  for (VectorXd* x : {&value_, &rate_, &second_}) x->setZero(table.spline.columns());
  delta_.setZero(table.modes);
  Z_.setZero(table.followers(), 1 + table.modes);
  for (VectorXd* x : {&bias_, &turned_, &turn_rate_, &turn_second_, &sums_}) x->setZero(table.followers());
}

void LoopMotion::amplitudes(const double* q, double* delta) const {
  measured(table_.amplitude_position, q, delta);
}

void LoopMotion::amplitude_rates(const double* v, double* delta_dot) const {
  measured(table_.amplitude, v, delta_dot);
}

/// δ of the amplitudes at those places of x.
void LoopMotion::measured(const std::vector<int>& at, const double* x, double* delta) const {
  for (int k = 0; k < table_.modes; ++k) delta[k] = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double* column = table_.measure.col(static_cast<Index>(i)).data();
    for (int k = 0; k < table_.modes; ++k) delta[k] += column[k] * x[at[i]];
  }
}

void LoopMotion::move(double theta, const double* delta, double* q) {
  const LoopTable& t = table_;
  const auto plain = static_cast<Index>(t.plain.size()), rotations = static_cast<Index>(t.rotation.size());
  const Index joints = t.joints(), own = plain + 4 * rotations;
  double turns = 0;
  if (t.turn > 0) turns = std::floor((theta - 0.5 * (t.spline.first() + t.spline.last())) / t.turn + 0.5);
  t.spline.evaluate(theta - turns * t.turn, value_.data(), rate_.data(), second_.data());
  delta_ = Map<const VectorXd>(delta, t.modes);
  // Deflections as the joints see them, with their derivatives by θ.
  const Index modes = t.modes;
  turned_.head(joints).noalias() = Block(value_.data() + own, joints, modes) * delta_;
  turn_rate_.head(joints).noalias() = Block(rate_.data() + own, joints, modes) * delta_;
  turn_second_.head(joints).noalias() = Block(second_.data() + own, joints, modes) * delta_;
  q[t.position] = theta;
  Z_.topRightCorner(joints, modes) = Block(value_.data() + own, joints, modes);
  Z_.col(0).head(plain) = rate_.head(plain) + turn_rate_.head(plain);
  for (Index k = 0; k < plain; ++k)
    q[t.plain_position[static_cast<std::size_t>(k)]] =
        value_[k] + turned_[k] + turns * t.per_turn[static_cast<std::size_t>(k)];
  for (Index k = 0; k < rotations; ++k) {
    const Index at = plain + 3 * k, place = plain + 4 * k;
    const Vec3<double> rho = turned_.segment<3>(at), rho_rate = turn_rate_.segment<3>(at);
    const Turning own_turn = turning_of(value_.data() + place, rate_.data() + place, second_.data() + place);
    const double* p = value_.data() + place;
    Quat<double> turned =
        quaternion_product<double>(Quat<double>(p[0], p[1], p[2], p[3]), quaternion_exp<double>(rho));
    turned /= turned.norm();
    for (int c = 0; c < 4; ++c) q[t.rotation_position[static_cast<std::size_t>(k)] + c] = turned[c];
    Z_.col(0).segment<3>(at) =
        own_turn.rate - rho.cross(own_turn.rate) + rho_rate - 0.5 * rho.cross(rho_rate);
    for (Index m = 0; m < modes; ++m) {
      const Vec3<double> shape = Z_.col(1 + m).segment<3>(at);
      Z_.col(1 + m).segment<3>(at) -= 0.5 * rho.cross(shape);
    }
  }
  const auto amplitudes = static_cast<Index>(t.amplitude.size());
  const Index shapes = own + joints * modes;
  if (t.shapes.size() > 0) {
    Z_.bottomRightCorner(amplitudes, modes) = t.shapes;
  } else {
    Z_.bottomRightCorner(amplitudes, modes) = Block(value_.data() + shapes, amplitudes, modes);
    Z_.col(0).tail(amplitudes).noalias() = Block(rate_.data() + shapes, amplitudes, modes) * delta_;
  }
  for (Index i = 0; i < amplitudes; ++i) {
    double sum = 0;
    for (Index m = 0; m < modes; ++m) sum += Z_(joints + i, 1 + m) * delta_[m];
    q[t.amplitude_position[static_cast<std::size_t>(i)]] = sum;
  }
}

void LoopMotion::velocities(const double* rates, double* v) {
  v[table_.coordinate] = rates[0];
  const Index rows = Z_.rows();
  double* sums = sums_.data();
  for (Index i = 0; i < rows; ++i) sums[i] = 0;
  for (Index m = 0; m < Z_.cols(); ++m) {
    const double* column = Z_.col(m).data();
    for (Index i = 0; i < rows; ++i) sums[i] += column[i] * rates[m];
  }
  for (std::size_t i = 0; i < rows_.size(); ++i) v[rows_[i]] = sums[i];
}

void LoopMotion::accelerations(const double* rates, const double* second, double* a) {
  const LoopTable& t = table_;
  const auto plain = static_cast<Index>(t.plain.size()), rotations = static_cast<Index>(t.rotation.size());
  const Index joints = t.joints(), own = plain + 4 * rotations, modes = t.modes;
  const double w = rates[0];
  const Map<const VectorXd> delta_dot(rates + 1, modes);
  velocities(second, a);
  // Of deflections (2 Ψ' δ̇ + Ψ'' δ θ̇) θ̇, and ζ'' θ̇².
  bias_.head(joints).noalias() = 2 * w * (Block(rate_.data() + own, joints, modes) * delta_dot);
  bias_.head(joints) += w * w * turn_second_.head(joints);
  bias_.head(plain) += w * w * second_.head(plain);
  for (Index k = 0; k < rotations; ++k) {
    const Index at = plain + 3 * k, place = plain + 4 * k;
    const Vec3<double> rho = turned_.segment<3>(at);
    Vec3<double> rho_dot = w * turn_rate_.segment<3>(at);
    for (Index m = 0; m < modes; ++m)
      rho_dot += delta_dot[m] * Map<const Vec3<double>>(value_.data() + own + m * joints + at);
    const Turning own_turn = turning_of(value_.data() + place, rate_.data() + place, second_.data() + place);
    const Vec3<double> rho_second = bias_.segment<3>(at);
    bias_.segment<3>(at) = w * w * (own_turn.second - rho.cross(own_turn.second)) -
                           w * rho_dot.cross(own_turn.rate) + rho_second - 0.5 * rho.cross(rho_second);
  }
  const auto amplitudes = static_cast<Index>(t.amplitude.size());
  if (t.shapes.size() > 0) {
    bias_.tail(amplitudes).setZero();
  } else {
    const Index shapes = own + joints * modes;
    bias_.tail(amplitudes).noalias() = 2 * w * (Block(rate_.data() + shapes, amplitudes, modes) * delta_dot);
    bias_.tail(amplitudes).noalias() += w * w * (Block(second_.data() + shapes, amplitudes, modes) * delta_);
  }
  for (std::size_t i = 0; i < rows_.size(); ++i) a[rows_[i]] += bias_[static_cast<Index>(i)];
}

void LoopMotion::project(const double* r, double* out) {
  for (std::size_t i = 0; i < rows_.size(); ++i) sums_[static_cast<Index>(i)] = r[rows_[i]];
  for (Index m = 0; m < Z_.cols(); ++m) out[m] = Z_.col(m).dot(sums_);
  out[0] += r[table_.coordinate];
}

}  // namespace mimbre::global_modes

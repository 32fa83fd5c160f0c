#include "integrate/global_modes/build_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/random_numbers.h"
#include "math/once/decompositions.h"

namespace mimbre::global_modes {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = CoordinateKinds::Kind;

namespace {

/// Beyond half a turn to either side, so that no end of the splines is used.
constexpr double overlap = 0.2;
/// Of equations that the rigid loop fulfils by others, as they depend on each other.
constexpr double dependent = 1e-7;
/// Of what equations do to deflections, by the scales: less is round-off.
constexpr double resists = 1e-8;
/// Places where loads act, and random states at each.
constexpr int load_places = 9, loads_a_place = 8;
/// Of random states near the given one: displacements, by the scales of the coordinates.
constexpr double nearby = 0.1;
/// Steps in a period that resolve it.
constexpr double steps_a_period = 8;

/// A loop with θ held at one place, linear in deflections: z = G e with D e = 0.
struct FixedLoop {
  MatrixXd follow;    ///< G: other joint coordinates (LoopTable::joint_coordinates()) by amplitudes
  MatrixXd resisted;  ///< D: rows of length by the scales
};

class Builder {
 public:
  Builder(Probe& probe, const Loop& loop, const CoordinateKinds& kinds, const State& state,
          const TableOptions& options)
      : probe_(probe), loop_(loop), kinds_(kinds), state_(state), options_(options) {}

  LoopTable build();

 private:
  int position(int coordinate) const { return kinds_.position[static_cast<std::size_t>(coordinate)]; }
  double theta_of(const VectorXd& q) const { return q[table_.position]; }
  VectorXd place(double theta) const;
  void choose_coordinates();
  void choose_range();
  void set_stiffness();
  FixedLoop fixed_at(const VectorXd& q) const;
  /// What the constraints leave of deflections, without work against the stiffness.
  MatrixXd freed(const FixedLoop& fixed, const MatrixXd& deflections) const;
  MatrixXd random_loads(const VectorXd& q, int number) const;
  MatrixXd eigenmodes(const VectorXd& q, const FixedLoop& fixed) const;
  void choose_modes();
  VectorXd column_at(double theta, const VectorXd* before) const;
  void tabulate(int places);
  double violation_between(int places) const;

  Probe& probe_;
  const Loop& loop_;
  const CoordinateKinds& kinds_;
  const State& state_;
  const TableOptions& options_;
  Path path_;
  Parameter parameter_;
  double first_ = 0, last_ = 0;
  MatrixXd K_, inverse_;  ///< of the amplitudes
  MatrixXd basis_;        ///< amplitudes × modes
  bool constant_ = true;  ///< no equation resists the basis anywhere
  LoopTable table_;
};

VectorXd Builder::place(double theta) const {
  const auto& places = path_.places;
  std::size_t near = parameter_.first;
  for (std::size_t k = parameter_.first; k <= parameter_.last; ++k)
    if (std::abs(theta_of(places[k].q) - theta) < std::abs(theta_of(places[near].q) - theta)) near = k;
  return place_at(probe_, loop_, kinds_, places[near], table_.coordinate, theta);
}

void Builder::choose_coordinates() {
  path_ = follow_loop(probe_, loop_, kinds_, state_.q);
  parameter_ = choose_parameter(path_, loop_, kinds_);
  table_.coordinate = parameter_.coordinate;
  table_.position = position(parameter_.coordinate);
  for (const int k : loop_.rigid) {
    if (k == table_.coordinate) continue;
    if (kinds_.kind[static_cast<std::size_t>(k)] == Kind::plain) {
      table_.plain.push_back(k);
      table_.plain_position.push_back(position(k));
    } else if (table_.rotation.empty() || table_.rotation_position.back() != position(k)) {
      table_.rotation.push_back(k);
      table_.rotation_position.push_back(position(k));
    }
  }
  for (const int k : loop_.amplitudes) {
    table_.amplitude.push_back(k);
    table_.amplitude_position.push_back(position(k));
  }
  table_.per_turn.assign(table_.plain.size(), 0);
}

/// The part of the path that θ describes; all of it where it closes after a turn.
void Builder::choose_range() {
  const double one = theta_of(path_.places[parameter_.first].q),
               two = theta_of(path_.places[parameter_.last].q), here = theta_of(path_.places[path_.start].q);
  first_ = std::min(one, two);
  last_ = std::max(one, two);
  constexpr double turn = 2 * std::numbers::pi;
  const double wide = 0.5 * turn + overlap;
  if (first_ > here - wide || last_ < here + wide) return;
  const VectorXd from = place(here - 0.5 * turn), to = place(here + 0.5 * turn);
  std::vector<double> increase;
  for (const int k : table_.plain_position) {
    const double by = to[k] - from[k], turns = std::round(by / turn);
    if (std::abs(by - turns * turn) > 1e-6) return;
    increase.push_back(turns * turn);
  }
  for (const int k : table_.rotation_position)
    if (std::abs(std::abs(to.segment<4>(k).dot(from.segment<4>(k))) - 1) > 1e-9) return;
  table_.per_turn = std::move(increase);
  table_.turn = turn;
  first_ = here - wide;
  last_ = here + wide;
}

void Builder::set_stiffness() {
  const auto n = static_cast<Index>(table_.amplitude.size());
  K_.setZero(n, n);
  for (Index i = 0; i < n; ++i)
    for (const CoordinateKinds::Body& body : kinds_.bodies) {
      const int row = table_.amplitude[static_cast<std::size_t>(i)] - body.first;
      if (row < 0 || row >= body.stiffness.rows()) continue;
      if (!body.linear)
        throw NoGlobalModes("its body bends nonlinearly, and global modes are linear",
                            table_.amplitude[static_cast<std::size_t>(i)]);
      for (Index j = 0; j < n; ++j) {
        const int column = table_.amplitude[static_cast<std::size_t>(j)] - body.first;
        if (column >= 0 && column < body.stiffness.cols()) K_(i, j) = body.stiffness(row, column);
      }
    }
  if (n == 0) return;
  if (!is_positive_definite(K_))
    throw NoGlobalModes("a deflection of its body has no stiffness", table_.amplitude.front());
  inverse_ = inverse(K_);
}

FixedLoop Builder::fixed_at(const VectorXd& q) const {
  probe_.evaluate(q);
  const std::vector<int> joints = table_.joint_coordinates();
  MatrixXd Jz = probe_.jacobian()(loop_.equations, joints);
  const MatrixXd Je = probe_.jacobian()(loop_.equations, table_.amplitude);
  for (std::size_t k = 0; k < joints.size(); ++k) Jz.col(static_cast<Index>(k)) *= probe_.scale()[joints[k]];
  FixedLoop fixed;
  fixed.follow = joints.empty() ? MatrixXd(0, Je.cols()) : MatrixXd(-shortest_solution(Jz, Je, dependent));
  for (std::size_t k = 0; k < joints.size(); ++k)
    fixed.follow.row(static_cast<Index>(k)) *= probe_.scale()[joints[k]];
  const MatrixXd left = joints.empty() ? MatrixXd(MatrixXd::Identity(Je.rows(), Je.rows()))
                                       : null_space(Jz.transpose(), dependent);
  MatrixXd D = left.transpose() * Je;
  for (Index k = 0; k < D.cols(); ++k)
    D.col(k) *= probe_.scale()[table_.amplitude[static_cast<std::size_t>(k)]];
  const bool any = D.size() > 0 && D.cwiseAbs().maxCoeff() > resists;
  for (Index k = 0; k < D.cols(); ++k)
    D.col(k) /= probe_.scale()[table_.amplitude[static_cast<std::size_t>(k)]];
  fixed.resisted = any ? D : MatrixXd(0, Je.cols());
  return fixed;
}

MatrixXd Builder::freed(const FixedLoop& fixed, const MatrixXd& deflections) const {
  if (fixed.resisted.rows() == 0) return deflections;
  const MatrixXd soft = inverse_ * fixed.resisted.transpose();
  return deflections - soft * shortest_solution(fixed.resisted * soft, fixed.resisted * deflections, resists);
}

/// Loads on the amplitudes, joints included, by random states of the mechanism with the loop at q.
MatrixXd Builder::random_loads(const VectorXd& q, int number) const {
  const System& system = probe_.system();
  const auto n = static_cast<Index>(kinds_.kind.size());
  const double acceleration = std::max(system.scales().acceleration, 1.0), speed = std::sqrt(acceleration);
  const auto random = [&](int load, Index k, int of) {
    return 2 * uniform_at(static_cast<std::uint64_t>(11 + of),
                          static_cast<std::uint64_t>((number * loads_a_place + load) * n + k)) -
           1;
  };
  std::vector<char> inside(static_cast<std::size_t>(n), 0);
  for (const std::vector<int>* list : {&loop_.rigid, &loop_.amplitudes})
    for (const int k : *list) inside[static_cast<std::size_t>(k)] = 1;
  // How the loop goes on.
  const MatrixXd way = null_space(
      probe_.jacobian()(loop_.equations, loop_.rigid) * probe_.scale()(loop_.rigid).asDiagonal(), 1e-4);
  MatrixXd loads(n, loads_a_place);
  for (int load = 0; load < loads_a_place; ++load) {
    VectorXd x = VectorXd::Zero(n), v = x, a = x;
    for (Index k = 0; k < n; ++k) {
      if (inside[static_cast<std::size_t>(k)] || kinds_.kind[static_cast<std::size_t>(k)] == Kind::amplitude)
        continue;
      const double scale = probe_.scale()[k];
      x[k] = nearby * scale * random(load, k, 0);
      v[k] = nearby * speed * scale * random(load, k, 1);
      a[k] = acceleration * scale * random(load, k, 2);
    }
    if (way.cols() == 1)
      for (std::size_t k = 0; k < loop_.rigid.size(); ++k) {
        const int c = loop_.rigid[k];
        const double along = way(static_cast<Index>(k), 0) * probe_.scale()[c];
        v[c] = speed * along * random(load, 0, 3);
        a[c] = acceleration * along * random(load, 0, 4);
      }
    loads.col(load) = -probe_.unloaded_residual(probe_.moved(q, x), v, a);
  }
  return loads;
}

MatrixXd Builder::eigenmodes(const VectorXd& q, const FixedLoop& fixed) const {
  const std::vector<int> joints = table_.joint_coordinates();
  probe_.evaluate(q);
  const MatrixXd& M = probe_.mass();
  const MatrixXd Mz = M(joints, joints), Mc = M(joints, table_.amplitude),
                 Me = M(table_.amplitude, table_.amplitude);
  const MatrixXd cross = fixed.follow.transpose() * Mc,
                 all = fixed.follow.transpose() * Mz * fixed.follow + cross + cross.transpose() + Me;
  const MatrixXd N = fixed.resisted.rows() > 0 ? null_space(fixed.resisted, resists)
                                               : MatrixXd(MatrixXd::Identity(all.rows(), all.rows()));
  const EigenPairs pairs = symmetric_eigen(N.transpose() * K_ * N, N.transpose() * all * N);
  if (!pairs.ok) return MatrixXd(all.rows(), 0);
  const double resolved = 2 * std::numbers::pi / (steps_a_period * options_.step);
  Index count = 0;
  while (count < pairs.values.size() && pairs.values[count] < resolved * resolved) ++count;
  return N * pairs.vectors.leftCols(count);
}

void Builder::choose_modes() {
  const auto n = static_cast<Index>(table_.amplitude.size());
  MatrixXd deflections(n, 0), dynamic(n, 0);
  std::vector<FixedLoop> places;
  for (int k = 0; k < load_places; ++k) {
    const double theta = first_ + (last_ - first_) * (k + 0.5) / load_places;
    const VectorXd q = place(theta);
    FixedLoop fixed = fixed_at(q);
    const MatrixXd inertia = random_loads(q, k), elements = probe_.element_loads(q);
    MatrixXd r(inertia.rows(), inertia.cols() + elements.cols());
    r << inertia, elements;
    const MatrixXd loads = r(table_.amplitude, Eigen::all) +
                           fixed.follow.transpose() * r(table_.joint_coordinates(), Eigen::all);
    const MatrixXd unconstrained = inverse_ * loads;
    MatrixXd bent = freed(fixed, unconstrained);
    // Each by itself, whatever its size; what the equations do not let bend is round-off.
    for (Index c = 0; c < bent.cols(); ++c) {
      const double all = unconstrained.col(c).dot(K_ * unconstrained.col(c)),
                   left = bent.col(c).dot(K_ * bent.col(c));
      bent.col(c) *= left > 1e-16 * all ? 1 / std::sqrt(left) : 0;
    }
    deflections.conservativeResize(n, deflections.cols() + bent.cols());
    deflections.rightCols(bent.cols()) = bent;
    if (k == load_places / 2) dynamic = eigenmodes(q, fixed);
    places.push_back(std::move(fixed));
  }
  // In the metric of the stiffness, K = L Lᵀ.
  const Cholesky factor(K_);
  const auto upper = [&](const MatrixXd& x) { return MatrixXd(factor.lower().transpose() * x); };
  const MatrixXd along = upper(deflections);
  const EigenPairs pairs = symmetric_eigen(along * along.transpose());
  const double enough = options_.accuracy * options_.accuracy * std::max(pairs.values.maxCoeff(), 1e-300);
  MatrixXd kept(n, 0);
  for (Index k = n - 1; k >= 0 && pairs.values[k] > enough; --k) {
    kept.conservativeResize(n, kept.cols() + 1);
    kept.rightCols(1) = pairs.vectors.col(k);
  }
  const MatrixXd others = upper(dynamic);
  for (Index k = 0; k < others.cols(); ++k) {
    VectorXd x = others.col(k).normalized();
    for (int twice = 0; twice < 2; ++twice) x -= kept * (kept.transpose() * x);
    if (!(x.norm() > 1e-3)) continue;
    kept.conservativeResize(n, kept.cols() + 1);
    kept.rightCols(1) = x.normalized();
  }
  basis_ = factor.solve_upper(kept);
  table_.modes = static_cast<int>(basis_.cols());
  table_.measure = basis_.transpose() * K_;
  if (table_.modes == 0) return;
  for (const FixedLoop& fixed : places)
    constant_ = constant_ &&
                (fixed.resisted.rows() == 0 ||
                 (basis_ - freed(fixed, basis_)).cwiseAbs().maxCoeff() < 1e-9 * basis_.cwiseAbs().maxCoeff());
  if (constant_) table_.shapes = basis_;
}

VectorXd Builder::column_at(double theta, const VectorXd* before) const {
  const VectorXd q = place(theta);
  const auto plain = static_cast<Index>(table_.plain.size()),
             rotations = static_cast<Index>(table_.rotation.size());
  const Index own = plain + 4 * rotations, joints = table_.joints(), modes = table_.modes;
  const auto amplitudes = static_cast<Index>(table_.amplitude.size());
  VectorXd out(own + joints * modes + (constant_ ? 0 : amplitudes * modes));
  for (Index k = 0; k < plain; ++k) out[k] = q[table_.plain_position[static_cast<std::size_t>(k)]];
  for (Index k = 0; k < rotations; ++k) {
    Eigen::Vector4d p = q.segment<4>(table_.rotation_position[static_cast<std::size_t>(k)]);
    if (before && p.dot(before->segment<4>(plain + 4 * k)) < 0) p = -p;
    out.segment<4>(plain + 4 * k) = p;
  }
  if (modes == 0) return out;
  const FixedLoop fixed = fixed_at(q);
  MatrixXd shapes = basis_;
  if (!constant_) {
    shapes = freed(fixed, basis_);
    shapes = (shapes * inverse(MatrixXd(table_.measure * shapes))).eval();
    out.tail(amplitudes * modes) = shapes.reshaped();
  }
  out.segment(own, joints * modes) = MatrixXd(fixed.follow * shapes).reshaped();
  return out;
}

void Builder::tabulate(int places) {
  const double spacing = (last_ - first_) / (places - 1);
  MatrixXd values;
  VectorXd column;
  for (int k = 0; k < places; ++k) {
    column = column_at(k == places - 1 ? last_ : first_ + k * spacing, k > 0 ? &column : nullptr);
    if (!column.allFinite())
      throw NoGlobalModes("its table has numbers that are not finite", table_.coordinate);
    if (k == 0) values.resize(column.size(), places);
    values.col(k) = column;
  }
  table_.spline = Spline(values, first_, spacing);
}

/// The largest Φ of the rigid loop half way between the places.
double Builder::violation_between(int places) const {
  LoopMotion motion(table_);
  const VectorXd none = VectorXd::Zero(table_.modes);
  VectorXd q = state_.q;
  double most = 0;
  for (int k = 0; k + 1 < places; ++k) {
    motion.move(first_ + (last_ - first_) * (k + 0.5) / (places - 1), none.data(), q.data());
    most = std::max(most, probe_.violations(q)(loop_.equations).cwiseAbs().maxCoeff());
  }
  return most;
}

LoopTable Builder::build() {
  choose_coordinates();
  choose_range();
  set_stiffness();
  if (!table_.amplitude.empty()) choose_modes();
  for (int places = 33;; places = 2 * places - 1) {
    tabulate(places);
    table_.violation = violation_between(places);
    if (table_.violation < options_.violation || 2 * places - 1 > options_.most_places) break;
  }
  if (table_.violation > options_.most_violation)
    throw NoGlobalModes("between the places of its table its loop is open", table_.coordinate);
  return std::move(table_);
}

}  // namespace

LoopTable build_table(Probe& probe, const Loop& loop, const CoordinateKinds& kinds, const State& state,
                      const TableOptions& options) {
  return Builder(probe, loop, kinds, state, options).build();
}

}  // namespace mimbre::global_modes

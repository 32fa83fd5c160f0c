#include "simulation/start/locking.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "linalg/once/sparse_qr.h"
#include "math/elementary.h"

namespace mimbre {
namespace {

constexpr double dependent_share = 1e-9;  ///< what an equation adds to others, as a share of its length
constexpr double at_all = 1e-7;           ///< speed, of about 1, of what moves

/// A row of the Jacobian that no drive makes, of length 1.
struct Row {
  int equation = 0;
  std::vector<std::pair<int, double>> entries;  ///< coordinate, value
};

std::vector<Row> rows_of(relative::RelativeSystem& system, const State& s) {
  const Compiled& m = system.model();
  const Scales& scales = system.scales();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(m.velocities), none = Eigen::VectorXd::Zero(m.equations);
  Eigen::VectorXd r(m.velocities);
  system.residual(s.time, s.q.data(), rest.data(), rest.data(), none.data(), 0, r.data());
  system.assemble(s.q.data(), {});
  std::map<int, Row> rows;
  for (const JacobianEntry& e : system.jacobian_entries()) {
    Row& row = rows[e.equation];
    row.equation = e.equation;
    row.entries.emplace_back(e.coordinate, e.value * scales.coordinates[e.coordinate]);
  }
  for (const DriveData& d : m.drives) rows.erase(d.equation);
  std::vector<Row> all;
  for (auto& [equation, row] : rows) {
    double square = 0;
    for (const auto& [coordinate, value] : row.entries) square += value * value;
    if (!(square > 0)) continue;
    for (auto& [coordinate, value] : row.entries) value /= std::sqrt(square);
    all.push_back(std::move(row));
  }
  return all;
}

/// A motion of no rule that fulfils the rows, but for those of one constraint: a coordinate that it leaves at
/// rest cannot move.
Eigen::VectorXd some_motion(const Compiled& m, const std::vector<Row>& rows, const ConstraintData* without) {
  Eigen::VectorXd any(m.velocities);
  for (int k = 0; k < m.velocities; ++k) {
    const double x = mimbre::sin(12.9898 * (k + 1)) * 43758.5453;
    any[k] = 0.5 + x - std::floor(x);
  }
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> rates;
  for (const Row& row : rows) {
    if (without && row.equation >= without->first_equation &&
        row.equation < without->first_equation + without->count)
      continue;
    double rate = 0;
    for (const auto& [k, value] : row.entries) {
      entries.emplace_back(k, static_cast<int>(rates.size()), value);
      rate += value * any[k];
    }
    rates.push_back(rate);
  }
  if (rates.empty()) return any;
  linalg::SparseMatrix transposed(m.velocities, std::ssize(rates));
  transposed.setFromTriplets(entries.begin(), entries.end());
  return any - linalg::SparseQr(transposed, dependent_share)
                   .shortest(Eigen::Map<const Eigen::VectorXd>(rates.data(), std::ssize(rates)));
}

}  // namespace

std::vector<std::string> locking_warnings(relative::RelativeSystem& system, const State& s) {
  const Compiled& m = system.model();
  std::vector<const ConstraintData*> couplings;
  for (const ConstraintData& c : m.constraints)
    if (c.of_coordinates) couplings.push_back(&c);
  if (couplings.size() < 2) return {};
  const std::vector<Row> rows = rows_of(system, s);
  const Eigen::VectorXd motion = some_motion(m, rows, nullptr);
  // Velocity coordinates that are at rest, and their joints.
  std::map<int, int> at_rest;
  for (const ConstraintData* c : couplings)
    for (const ConstraintTerm& term : c->terms)
      if (term.body >= 0 && std::abs(motion[term.v]) < at_all) at_rest[term.v] = term.joint_spec;
  if (at_rest.empty()) return {};
  std::map<int, std::vector<std::string>> freed_without;
  for (const ConstraintData* c : couplings) {
    const Eigen::VectorXd freed = some_motion(m, rows, c);
    for (const auto& [k, joint] : at_rest)
      if (std::abs(freed[k]) >= at_all) freed_without[k].push_back(m.spec().constraints[c->spec].name);
  }
  // Joints by the couplings that lock them.
  std::map<std::vector<std::string>, std::vector<std::string>> locked;
  for (const auto& [k, by] : freed_without)
    if (by.size() > 1) locked[by].push_back(m.spec().joints[at_rest[k]].name);
  std::vector<std::string> warnings;
  for (const auto& lock : locked) {
    const std::vector<std::string>&by = lock.first, &joints = lock.second;
    // What others pass on of that is no contradiction of their own.
    const auto holds = [&](const auto& other) {
      return other.first.size() < by.size() &&
             std::all_of(other.first.begin(), other.first.end(), [&](const std::string& name) {
               return std::find(by.begin(), by.end(), name) != by.end();
             });
    };
    if (std::any_of(locked.begin(), locked.end(), holds)) continue;
    warnings.push_back(
        fmt::format("constraints '{}' contradict one another: together they lock joint{} '{}', which each of "
                    "them alone would "
                    "let move; look at their ratios and signs, or leave one out",
                    fmt::join(by, "', '"), joints.size() > 1 ? "s" : "", fmt::join(joints, "', '")));
  }
  return warnings;
}

}  // namespace mimbre

#include "mimbre/buckling.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "analysis/equilibria/growing_loads.h"
#include "math/once/decompositions.h"
#include "mimbre/diagnostics.h"
#include "mimbre/linearise.h"

namespace mimbre {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double first_part = 1e-4;         ///< of the given loads, for the derivative
constexpr double part_of_critical = 1e-2;   ///< likewise, of the least factor
constexpr double unsymmetric = 1e-5;        ///< of K1, as a share
constexpr double nonlinear_warning = 0.05;  ///< of K1
constexpr double no_stiffness = 1e-10;      ///< of the mechanism's largest, relative to the masses
constexpr double no_effect = 1e-10;         ///< of 1/λ, as a share of the largest, by round-off
constexpr double named_share = 0.05;        ///< of the energy

class BucklingSearch {
 public:
  BucklingSearch(const Model& model, const BucklingOptions& options)
      : spec_(model.spec()), options_(options), growing_(growing_loads(spec_, options.loads)) {
    out_.loads = growing_.names;
  }

  Buckling find();

 private:
  LinearModel at(double factor) const;
  /// The stiffness by the coordinates of the unloaded equilibrium.
  MatrixXd stiffness(double factor) const;
  void check_unloaded(const LinearModel& unloaded) const;
  std::string shares(const VectorXd& shape, const MatrixXd& K0) const;

  const spec::Model& spec_;
  const BucklingOptions& options_;
  Buckling out_;
  GrowingLoads growing_;
  IndependentCoordinates independent_;  ///< of the unloaded equilibrium
};

LinearModel BucklingSearch::at(double factor) const {
  LinearOptions options;
  options.point.at = LinearPoint::At::equilibrium;
  options.run.inputs = options_.inputs;
  // Where others are as good as those of the unloaded point, round-off would choose anew at each load.
  options.independent = independent_;
  return linearise(loaded_by(spec_, growing_, factor), options);
}

MatrixXd BucklingSearch::stiffness(double factor) const {
  const LinearModel there = at(factor);
  if (there.coordinates != static_cast<int>(out_.coordinates.size()))
    throw std::runtime_error("buckling: the loads change the number of independent coordinates");
  for (int k = 0; k < there.coordinates; ++k)
    if (there.states[static_cast<std::size_t>(k)].name != out_.coordinates[static_cast<std::size_t>(k)])
      throw std::runtime_error(fmt::format(
          "buckling: with {:.3g} of the loads other coordinates are independent ('{}' in place of "
          "'{}'), so that stiffnesses cannot be compared; start from a position that is less "
          "singular",
          factor, there.states[static_cast<std::size_t>(k)].name,
          out_.coordinates[static_cast<std::size_t>(k)]));
  return there.stiffness;
}

std::string BucklingSearch::shares(const VectorXd& shape, const MatrixXd& K0) const {
  const VectorXd energy = shape.cwiseProduct(K0 * shape);
  std::vector<Eigen::Index> order(static_cast<std::size_t>(energy.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return energy[a] > energy[b]; });
  std::vector<std::string> parts;
  for (const Eigen::Index k : order)
    if (parts.size() < 3 && energy[k] >= named_share * energy.sum())
      parts.push_back(fmt::format("'{}' {:.0f} %", out_.coordinates[static_cast<std::size_t>(k)],
                                  100 * energy[k] / energy.sum()));
  return fmt::format("{}", fmt::join(parts, ", "));
}

void BucklingSearch::check_unloaded(const LinearModel& unloaded) const {
  const MatrixXd K = (unloaded.stiffness + unloaded.stiffness.transpose()) / 2;
  const VectorXd scale = K.diagonal().cwiseAbs().cwiseSqrt();
  Eigen::Index weakest = 0;
  double least = scale.minCoeff(&weakest);
  if (least > 0) {
    const MatrixXd even = scale.cwiseInverse().asDiagonal() * K * scale.cwiseInverse().asDiagonal();
    const EigenPairs pairs = symmetric_eigen(even);
    least = pairs.ok ? pairs.values[0] : 0;
    if (pairs.ok) pairs.vectors.col(0).cwiseAbs().maxCoeff(&weakest);
  }
  if (!(least > no_stiffness))
    throw std::runtime_error(
        fmt::format("buckling: without the growing loads ({}) nothing holds '{}', so that there is no stable "
                    "equilibrium that they could make unstable; hold it by a joint or a spring, or let fewer "
                    "loads grow",
                    fmt::join(out_.loads, ", "), out_.coordinates[static_cast<std::size_t>(weakest)]));
}

Buckling BucklingSearch::find() {
  if (options_.count < 1) throw InputError(Mark{}, "count must be at least 1");
  const LinearModel unloaded = at(0);
  independent_ = unloaded.independent;
  for (int k = 0; k < unloaded.coordinates; ++k)
    out_.coordinates.push_back(unloaded.states[static_cast<std::size_t>(k)].name);
  if (unloaded.coordinates == 0)
    throw std::runtime_error("buckling: the mechanism has no motion, so that nothing can buckle");
  check_unloaded(unloaded);
  const MatrixXd K0 = (unloaded.stiffness + unloaded.stiffness.transpose()) / 2;
  EigenPairs pairs;
  VectorXd inverse;
  double part = first_part;
  for (int round = 0; round < 3; ++round) {
    const MatrixXd ahead = stiffness(part), behind = stiffness(-part);
    const MatrixXd K1 = (ahead - behind) / (2 * part);
    if (!K1.allFinite()) throw std::runtime_error("buckling: the stiffness is not a number");
    if ((K1 - K1.transpose()).norm() > unsymmetric * K1.norm() + 1e-12 * K0.norm() / part)
      throw std::runtime_error(fmt::format(
          "buckling: the loads ({}) have no potential, because they follow what they load: such "
          "equilibria may be lost by flutter, of which linear buckling finds nothing; use `mimbre "
          "modes` at several loads",
          fmt::join(out_.loads, ", ")));
    pairs = symmetric_eigen((K1 + K1.transpose()) / 2, K0);
    if (!pairs.ok) throw std::runtime_error("buckling: the eigenvalues were not found");
    inverse = -pairs.values;
    const double largest = inverse.cwiseAbs().maxCoeff();
    const MatrixXd bent = (ahead + behind) / 2 - K0;
    out_.nonlinear = K1.norm() > 0 ? bent.norm() / (part * K1.norm()) : 0;
    // Round-off of K0 in K1 is not stiffness.
    if (!(largest * part > 1e-9)) {
      inverse.setZero();
      if (part >= 1) break;
      part = std::min(1.0, part * 1e3);
      continue;
    }
    const double wanted = part_of_critical / largest;
    if (part <= 3 * wanted && part >= 0.3 * wanted) break;
    part = wanted;
  }
  const double largest = inverse.cwiseAbs().maxCoeff();
  std::vector<Eigen::Index> order(static_cast<std::size_t>(inverse.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](auto a, auto b) { return std::abs(inverse[a]) > std::abs(inverse[b]); });
  int ahead = 0, back = 0;
  for (const Eigen::Index k : order) {
    if (!(std::abs(inverse[k]) > std::max(no_effect, 1e-6 * part_of_critical) * largest)) break;
    int& count = inverse[k] > 0 ? ahead : back;
    if (count++ >= options_.count) continue;
    const VectorXd shape = std::sqrt(2.0) * pairs.vectors.col(k);
    out_.modes.push_back({1 / inverse[k], shape, shares(shape, K0)});
  }
  if (out_.modes.empty())
    out_.warnings.push_back(fmt::format(
        "the loads ({}) do not change the stiffness, so that nothing buckles; flexible bodies need a "
        "stiffening that contains it, as `stiffening: geometric_stiffness` or `beam: corotational`",
        fmt::join(out_.loads, ", ")));
  if (out_.nonlinear > nonlinear_warning)
    out_.warnings.push_back(fmt::format(
        "at a hundredth of the first factor the stiffness is off its linear part by {:.2g} %: the mechanism "
        "moves before it buckles, and the factors are estimates; follow its equilibria by `mimbre static "
        "--path`",
        100 * out_.nonlinear));
  return out_;
}

}  // namespace

Buckling buckling(const std::shared_ptr<const Model>& model, const BucklingOptions& options) {
  return BucklingSearch(*model, options).find();
}

}  // namespace mimbre

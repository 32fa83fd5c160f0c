#pragma once
#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mimbre/model.h"

namespace mimbre {

struct BucklingOptions {
  /// Loads that grow together; none: all of the model, or its weight where it has none. The others keep their
  /// values.
  std::vector<std::string> loads;
  int count = 3;                         ///< factors that are wanted at most, of each sign
  std::map<std::string, double> inputs;  ///< RunOptions::inputs
};

/// A factor of the loads at which the equilibrium ceases to be stable.
struct BucklingMode {
  double factor = 0;      ///< of the given loads; negative: in the opposite direction
  Eigen::VectorXd shape;  ///< by independent coordinates, of energy 1 J: xᵀ K0 x / 2
  std::string text;       ///< coordinates with their shares of the elastic energy: "'hinge' 100 %"
};

struct Buckling {
  std::vector<std::string> loads;        ///< that grow: names, or "gravity"
  std::vector<std::string> coordinates;  ///< independent ones
  std::vector<BucklingMode> modes;       ///< those nearest to zero first
  /// Change of the tangent stiffness by prebuckling displacements of the second order, as a share of what is
  /// linear in the loads, at a hundredth of the first factor.
  double nonlinear = 0;
  std::vector<std::string> warnings;
};

/// Linear buckling: factors λ with (K0 + λ K1) x = 0, K0 the stiffness of the equilibrium without the growing
/// loads in minimal coordinates, K1 its derivative by their factor there, by central differences of the exact
/// stiffness of two equilibria. Prebuckling rotations count in the first order. Stiffness by loads needs
/// bodies whose stiffening contains it (`geometric_stiffness`, `corotational`, …). Throws InputError for
/// unknown loads, a model without loads and weight, loads over time or by signals that are 0 at the start;
/// std::runtime_error where K0 is not positive definite (something moves without resistance: it is named) and
/// where loads follow a turning body, so that K1 is not symmetric.
Buckling buckling(const std::shared_ptr<const Model>& model, const BucklingOptions& options = {});

}  // namespace mimbre

#pragma once
#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "analysis/equilibria/growing_loads.h"
#include "analysis/equilibria/sample_at_rest.h"
#include "dynamics/relative/system.h"

/// A mechanism at rest under loads times a factor.
namespace mimbre {

/// The equations of equilibrium about a position: g(y, λ), and how it changes. Independent coordinates count
/// by the mechanism's scales, forces by the work along them.
struct PathTangent {
  Eigen::VectorXd force;         ///< f × 1: what is not balanced
  Eigen::MatrixXd stiffness;     ///< f × f: ∂g/∂y
  Eigen::VectorXd load;          ///< f × 1: ∂g/∂λ
  Eigen::MatrixXd motions;       ///< n × f: all velocity coordinates by y, along the scales
  std::vector<int> coordinates;  ///< the independent ones
};

class PathEquations {
 public:
  PathEquations(const spec::Model& spec, GrowingLoads growing, std::map<std::string, double> inputs);
  ~PathEquations();

  /// The equilibrium at the factor. Throws as static_equilibrium() does.
  State start(double factor, std::vector<std::string>& warnings);
  /// What force elements and signals remember becomes that of the state.
  PathTangent at(State& state, double factor);
  /// Along the scales of the velocity coordinates; loops are closed again. False where they do not.
  bool move(State& state, const Eigen::VectorXd& step);
  AtRest sample(State state, double factor);

  /// Independent coordinates with their shares of a motion y: "'hinge' 100 %".
  std::string shares(const PathTangent& at, const Eigen::VectorXd& y) const;

 private:
  struct Loaded;
  Loaded& loaded(double factor);

  const spec::Model& spec_;
  const GrowingLoads growing_;
  const std::map<std::string, double> inputs_;
  std::unique_ptr<Loaded> without_, once_, at_;  ///< factors 0, 1, and the last that was asked for
  Eigen::VectorXd scale_;                        ///< of the velocity coordinates
};

}  // namespace mimbre

#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "analysis/linear_element.h"
#include "dynamics/scales.h"
#include "dynamics/state.h"

/// Exact derivatives of the equations of motion about a point of a motion.
namespace mimbre::linear {

/// What besides positions and velocities the equations of motion depend on.
struct Parameter {
  enum class Kind {
    element_state,  ///< `item`: among the linear elements, `index`: among its states
    block_state,    ///< `item`: block, `index`: of its states
    integral,       ///< `item`: among SignalsData::integrals
    input,          ///< `item`: of the spec
    input_rate,     ///< u̇, where the input moves a drive
    input_second    ///< ü, likewise
  } kind;
  int item = 0, index = 0;
  bool is_state() const { return kind <= Kind::integral; }
};

/// Derivatives at a point, of n velocity coordinates, m equations, p parameters:
///
///     M δa + (∂r/∂q) δ + (∂r/∂v) δv + (∂r/∂p) δp + Φzᵀ δλ = 0,    δ̇ = δv − W δ.
///
/// δ: increments in the tangent space (body axes where there are quaternions), so that W has the angular
/// velocities of those joints. `seen`: what the states' rates depend on, one row for each number.
struct Derivatives {
  Eigen::MatrixXd mass, residual_q, residual_v, residual_p;
  Eigen::MatrixXd jacobian, rate_q;         ///< ∂Φ/∂q, and ∂Φ̇/∂q; ∂Φ̇/∂v is the Jacobian
  Eigen::MatrixXd second_q, second_v;       ///< ∂Φ̈/∂q, ∂Φ̈/∂v
  Eigen::MatrixXd phi_p, rate_p, second_p;  ///< by parameters
  Eigen::MatrixXd seen_q, seen_v, seen_p;
  Eigen::MatrixXd turn;                            ///< W
  Eigen::VectorXd residual, phi_rate, phi_second;  ///< r, Φ̇, Φ̈ at accelerations and multipliers of zero
};

/// The equations of motion in relative coordinates over dual numbers. Elements with states are linear systems
/// (linear_element.h); all blocks have begun, delays must have been replaced.
class LinearCore {
 public:
  /// The state's elements and signals must be committed: nothing has moved since.
  LinearCore(const Compiled& model, const State& state, double pace);
  ~LinearCore();

  const std::vector<LinearElement>& elements() const;
  /// States, then inputs.
  const std::vector<Parameter>& parameters() const;
  /// Rates of the states among the parameters, at the point and by `seen` and by the parameters.
  struct Rates {
    Eigen::VectorXd value;
    Eigen::MatrixXd by_seen, by_parameters;
  };
  Rates rates() const;

  /// ∂r/∂a, Φz, and what is left without accelerations and multipliers.
  void find_mass(Derivatives& out);
  /// The others, at these accelerations and multipliers.
  void find_derivatives(const Eigen::VectorXd& a, const Eigen::VectorXd& multipliers, Derivatives& out);
  /// ∂r/∂q alone, at accelerations of zero and these multipliers.
  void find_stiffness(const Eigen::VectorXd& multipliers, Derivatives& out);

  /// d²Φ/dε² where the mechanism moves by ε x: what equations that repeat others must not have.
  Eigen::VectorXd curvature(const Eigen::VectorXd& x);

  /// Where δ of the motion as a whole goes by: W (see Derivatives).
  static Eigen::MatrixXd turning(const Compiled& model, const Eigen::VectorXd& v);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace mimbre::linear

#pragma once
#include <complex>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mimbre/linearise.h"
#include "mimbre/mode_shapes.h"

/// Modes of a mechanism about a point of its motion, and how they change with a parameter.
namespace mimbre {

/// The part that something has in a mode, 0 to 1.
struct ModeShare {
  std::string name;
  double share = 0;
};

/// One mode: an eigenvalue λ of ẋ = A x with Im λ ≥ 0 (its conjugate is not listed).
struct Mode {
  enum class Kind {
    rigid,  ///< λ = 0: a motion that nothing resists
    real,   ///< decays or grows without turning back
    oscillating
  } kind = Kind::oscillating;
  std::complex<double> value;  ///< λ, 1/s
  double frequency = 0;        ///< |λ|/2π, Hz: undamped
  double damped = 0;           ///< Im λ/2π, Hz
  double damping = 0;          ///< −Re λ/|λ|; 0 of a rigid one
  bool grows = false;          ///< Re λ > 0, by more than round-off
  /// Where coefficients repeat after a period (LinearisedModes::period): e^{λT}; else 0.
  std::complex<double> multiplier = 0;
  /// Right eigenvector, of the largest entry 1 of its motion (along the mechanism's scales), and the left one
  /// wᴴ with wᴴ x = 1 (none of rigid modes: zeros).
  Eigen::VectorXcd shape, left;
  Eigen::VectorXcd motion;  ///< δ: all relative velocity coordinates (LinearisedModes::coordinates)
  /// Shares of the mean kinetic energy, by joint coordinate or modal amplitude, and by body; of the mean
  /// elastic energy by force element and flexible body. Largest first, those below 0.1 % left out.
  std::vector<ModeShare> coordinates, bodies, elastic;
  double gravity =
      0;  ///< share of weight, loads and constraint forces in all stiffness energy; may be negative
  /// Sense in which points of the mechanism circle the axis of its fastest turning: +1 with it (forward
  /// whirl), −1 against it (backward), 0: neither.
  double whirl = 0;
  /// Of mechanisms with three equal blades or more around one axis, of which a fifth of the kinetic energy or
  /// more is: the waves that they are in, largest first: collective, differential, forward and backward (as
  /// seen from the hub, in the sense of its rotation or against it), and harmonics of these. Of the rotor
  /// with most of the energy.
  std::vector<ModeShare> blades;
  /// λ as seen from the ground. Where the whole mechanism turns steadily about one fixed axis with Ω,
  /// coordinates turn with it; a mode whose points circle that axis evenly has λ ± iΩ from the ground, which
  /// `whirl` then refers to, and one along or about the axis has λ. NaN: no single one (Ω shows in two
  /// frequencies, as where the rotor is not round). In all other cases λ itself.
  std::complex<double> fixed = 0;
  /// `fixed` where there is one, else λ.
  std::complex<double> seen() const { return fixed == 0. || fixed != fixed ? value : fixed; }
  std::string text;  ///< the largest shares in words
};

/// How modes are computed.
enum class ModesSolver {
  automatic,  ///< `sparse` where `most` modes of a mechanism at rest with 200 coordinates or more are asked
              ///< for and it is possible; A is then missing
  dense,      ///< all eigenvalues of A
  sparse      ///< the lowest modes of an equilibrium by shift and invert, with sparse matrices
};

struct ModesOptions {
  LinearOptions linear;
  int most = 0;  ///< so many modes, of the lowest frequencies; 0: all
  ModesSolver solver = ModesSolver::automatic;
  bool shapes = false;  ///< fill LinearisedModes::shapes, for pictures
};

struct LinearisedModes {
  /// Without C, D and outputs. The sparse solver leaves out matrices and states, too: there the `shape` of a
  /// mode is its motion in natural coordinates above λ times that, and `left` belongs to it.
  LinearModel model;
  bool sparse = false;  ///< by the sparse solver
  std::vector<LinearName> coordinates;
  std::vector<Mode> modes;  ///< rigid ones first, then by |λ|, from the ground where that is known
  /// T, s, where the coefficients vary along a steady motion and repeat after T; 0: they are constant, or
  /// vary otherwise. λ are then Floquet's exponents, whose imaginary parts are known but for multiples of
  /// 2π/T: those given are the ones that the motion has on average. Shapes are those at the point.
  double period = 0;
  /// How many eigenvalues are zero: rigid motions, and drifts along them (a free body has six of each), which
  /// are no modes of their own. −1: not counted, as by the sparse solver.
  int zeros = -1;
  double turning = 0;  ///< Ω, rad/s, where the whole mechanism turns about one fixed axis (Mode::fixed); or 0
  std::optional<MechanismShapes> shapes;  ///< the modes by body (ModesOptions::shapes)
  double cpu_seconds = 0;
};

/// Throws as linearise() does; std::runtime_error where the sparse solver is asked for and not possible:
/// force elements or signals have states, the point is no equilibrium, or its iteration does not converge.
LinearisedModes find_modes(std::shared_ptr<const Model> model, const ModesOptions& options = {});

}  // namespace mimbre

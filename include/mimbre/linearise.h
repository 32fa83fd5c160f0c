#pragma once
#include <Eigen/Core>
#include <complex>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mimbre/method.h"
#include "mimbre/model.h"

/// Linear models of a mechanism about a point of its motion (docs/linear-analyses.md).
namespace mimbre {

/// Where a model is linearised.
struct LinearPoint {
  enum class At {
    automatic,    ///< the equilibrium where there is one; else steady motion; else the start
    start,        ///< as a run begins
    time,         ///< the state of a run at `time`
    equilibrium,  ///< at rest, with all forces in balance
    steady,  ///< the velocities of the start, positions in which they are steady: no relative acceleration
    trim     ///< steady driving (LinearOptions::trim), sought from the start, which needs velocities
  } at = At::automatic;
  double time = 0;  ///< s
};

/// Steady driving of what moves on a floating joint: straight on, or around a circle. As many conditions of
/// speed and turn as inputs to find.
struct TrimConditions {
  std::string body;  ///< whose speed it is; empty: the first one on a floating joint to the ground
  std::optional<double>
      speed;  ///< of its origin along the plane across gravity, m/s; none: that of the start
  /// One of these at most; none: the turn follows from the inputs. To the left positive.
  std::optional<double> lateral_acceleration;  ///< yaw rate times speed, m/s²
  std::optional<double> yaw_rate;              ///< rad/s
  std::optional<double> radius;                ///< speed over yaw rate, m
  std::vector<std::string> find;               ///< inputs whose values are sought, each once; others stay
};

/// Steady driving that was found.
struct DrivingState {
  Eigen::VectorXd positions, velocities, element_states;  ///< relative coordinates
  std::map<std::string, double> inputs;                   ///< all that were given or found
  double speed = 0, yaw_rate = 0;                         ///< m/s; rad/s, to the left
};

/// Numbers of the velocity coordinates that are independent of each other at a point, of positions and of
/// velocities (with rolling fewer).
struct IndependentCoordinates {
  std::vector<int> positions, velocities;
};

struct LinearOptions {
  LinearPoint point;
  TrimConditions trim;  ///< of the point `trim`
  /// Steady driving of a model with the same coordinates, under conditions that differ a little: the search
  /// begins there, and at the start of the model only where that leads nowhere.
  std::shared_ptr<const DrivingState> trim_near;
  /// The independent coordinates to use where the others follow from them, such as those of another point;
  /// none, or where they do not: those that are best at the point.
  IndependentCoordinates independent;
  /// Inputs; and of a run to a time its method. The linear model is always that of relative coordinates with
  /// inertia by shape integrals.
  RunOptions run;
  /// Delays become rational functions of this order n: Padé's approximation of degrees n − 1 over n. 1 to 8.
  int delay_order = 4;
};

/// A state, a coordinate, an input or an output.
struct LinearName {
  std::string name;
  std::string unit;
};

/// A mechanism about a point, in minimal coordinates: the independent velocity coordinates y (in the axes of
/// the body for rotations of joints with quaternions), their velocities s, and states z of force elements,
/// blocks and integrals of signals, x = (y, s, z):
///
///     ẋ = A x + B u,   o = C x + D u.
///
/// Of the motion alone M ÿ + (C + G) ẏ + K y = 0: `mass`, `damping` (with gyroscopic terms), `stiffness`
/// (with those of loads, prestress and constraint forces, and circulatory terms). Units: SI, radians.
/// Constraints on velocities (rolling) leave fewer velocities s than coordinates y; then
/// M ṡ + (C + G) s + K y = 0 with K speeds × coordinates.
struct LinearModel {
  std::string title;
  std::string point;  ///< in words: "equilibrium", "start", "steady motion", "t = 0.3 s"
  double time = 0;    ///< s
  Eigen::MatrixXd A, B, C, D;
  Eigen::MatrixXd mass, damping, stiffness;  ///< f × f
  std::vector<LinearName> states, inputs, outputs;
  std::vector<double> input_values, output_values;  ///< at the point
  int coordinates = 0;                              ///< f: the first f states are y
  int speeds = 0;     ///< so many states behind them are s: f, but with rolling fewer
  int redundant = 0;  ///< constraint equations that repeat others

  /// How far the point is from an equilibrium: the largest rate of a relative coordinate by its scale, 1/s,
  /// and which; 0: it is at rest.
  double speed = 0;
  std::string fastest;
  /// How far it is from steady motion: the largest relative acceleration, as a share of those at play (that
  /// of gravity over the mechanism's size, or the largest), and which coordinate has it.
  double unsteady = 0, acceleration = 0;  ///< acceleration: m/s² or rad/s²
  std::string accelerated;
  /// By how much A varies along the motion, of its largest entry: 0 where its coefficients are constant. Not
  /// looked for (0) where the point is at rest or not steady.
  double varies = 0;
  std::shared_ptr<const DrivingState> driving;  ///< of the point `trim`; else none
  IndependentCoordinates independent;           ///< y and s, by number of the velocity coordinate
  std::vector<std::string> notes;     ///< what was done with delays, sampled blocks, laws of the user
  std::vector<std::string> warnings;  ///< no equilibrium, coefficients that vary, …
};

/// The linear model of a model. Outputs are those of the model. Throws InputError where the model cannot be
/// put at the point (loops do not close, no such input), std::runtime_error where the point is not found, is
/// a singular position, or a motion has no mass: the message names it.
LinearModel linearise(std::shared_ptr<const Model> model, const LinearOptions& options = {});

/// Frequency response C (iω − A)⁻¹ B + D: outputs × inputs, at ω in rad/s.
Eigen::MatrixXcd frequency_response(const LinearModel& model, double omega);

/// Writes A, B, C, D, mass, damping and stiffness, names and the point to a file: .h5, .mat (version 5, which
/// MATLAB, Octave and SciPy read) or .json by its ending, with the responses at `frequencies`, Hz, if any.
/// Throws UsageError for another ending, std::runtime_error when it cannot be written.
void write_linear_model(const LinearModel& model, const std::string& path,
                        const std::vector<double>& frequencies = {});

/// The texts that write_linear_model() writes to a .json file.
std::string linear_model_json(const LinearModel& model, const std::vector<double>& frequencies = {});

}  // namespace mimbre

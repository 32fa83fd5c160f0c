#pragma once
#include <memory>
#include <string>

#include "analysis/linear_reduction.h"
#include "dynamics/relative/system.h"
#include "mimbre/linearise.h"

/// A model at a point, with everything that linear analyses need of it.
namespace mimbre::linear {

/// Three velocity coordinates from `first` on, in axes that turn: T with Ṫ = [rate]× T, T = I at the point.
struct TurnedVector {
  int first = 0;
  Vec3d rate = Vec3d::Zero();  ///< rad/s
};

/// How the warning begins that coefficients vary.
constexpr const char* varying = "the coefficients vary along the motion";

/// A linearised model; `model` is the given one, with delays replaced where it has any.
struct Linearised {
  std::shared_ptr<const Model> model;
  State state;  ///< relative coordinates; consistent accelerations and multipliers; signals committed
  Derivatives derivatives;
  std::vector<int> independent;  ///< coordinates y
  std::vector<int> moving;       ///< velocities s: the same, but with rolling fewer
  Reduced reduced;
  std::vector<LinearElement> elements;
  std::vector<Parameter> parameters;
  Eigen::VectorXd state_rates;  ///< of the states among the parameters
  LinearModel names;            ///< everything but the matrices
  /// Where the whole mechanism turns steadily about one fixed axis: its angular speed, and the axis.
  double turning = 0;
  Vec3d turning_axis = Vec3d::UnitX(), turning_place = Vec3d::Zero();
  /// Of steady driving: the yaw rate, the vertical, and the relative accelerations of that motion.
  bool trimmed = false;
  double yaw_rate = 0;
  Vec3d up = Vec3d::UnitZ();
  Eigen::VectorXd steady_accelerations;
  /// Axes in which the coefficients are constant along the motion (linear_turning.h); none: as they are.
  std::vector<TurnedVector> axes;
};

/// Throws as linearise() does.
Linearised linearise_at(std::shared_ptr<const Model> model, const LinearOptions& options);
/// Its two parts: the point, with model, state and names.point; and the matrices there.
Linearised locate(std::shared_ptr<const Model> model, const LinearOptions& options);
Linearised linearise_located(Linearised at);

/// The linear equations at out.state, whose accelerations and multipliers become the consistent ones.
/// Independent coordinates and velocities that are given stay; with `where_good` only where the others follow
/// from them. Its elements and signals must be committed.
void linearise_state(const Compiled& model, const relative::RelativeSystem& system, Linearised& out,
                     bool where_good = false);
/// Along a steady motion: the same equations a time later, in the same coordinates.
Linearised linearised_later(const Compiled& model, const relative::RelativeSystem& system,
                            const Linearised& at, double time);
/// What force elements and signals remember is that of the state.
void commit(const Compiled& model, relative::RelativeSystem& system, State& state);

/// What a velocity coordinate is called: the joint's name, with its number where it has several, or a body's
/// mode.
LinearName coordinate_label(const Compiled& model, int coordinate);

/// Replaces continuous delays by rational functions; the same model where there are none.
std::shared_ptr<const Model> without_delays(std::shared_ptr<const Model> model, int order,
                                            std::vector<std::string>& notes);

}  // namespace mimbre::linear

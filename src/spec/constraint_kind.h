#pragma once
#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mimbre/spec.h"
#include "spec/number_key.h"

/// The description of a kind of constraints: everything but its equations. Each kind is one file of
/// src/constraints, which owns both; constraints/table.h lists them.
namespace mimbre {

struct ConstraintData;

struct ConstraintInfo {
  using Faults = std::vector<std::string>;
  using Axes = std::pair<Eigen::Matrix3d, Eigen::Matrix3d>;

  std::string_view name;  ///< of its type in model files, and in spec::Constraint::type
  int equations = 1;
  unsigned lengths = 0;  ///< bit k: equation k is a length (m), otherwise an angle (rad); of coordinates it
                         ///< is what they are
  /// Bit k: equation k is one of velocities alone (it cannot be integrated): its value is its rate times
  /// EquationContext::rate_time.
  unsigned rates = 0;
  bool force = false, moment = false;  ///< that it may exert on its frames
  int states = 0;                      ///< that it remembers; of coordinates as many more as count turns
  bool of_coordinates = false;         ///< of a sum of joints' coordinates; else of two frames

  // Keys in the model file besides `type`, `between` and `at`, or of coordinates `terms`.
  std::span<const LawNumber> numbers = {};
  unsigned handed = 0;       ///< bit k: number k changes its sign in a mirrored part
  int axes = 0;              ///< 1: `axis`, of both frames; 2: also `axis2`, of the second
  bool second_axis = false;  ///< which has to be given; else it is that of the first
  bool aligned = false;      ///< both frames have the same axes in the assembled position: those of a frame
                             ///< that is named beside a body, else the global ones
  bool two_places = false;   ///< `at` has a place for each frame; else they meet at one
  bool curve = false;        ///< `points`, `closed`
  bool on_road = false;      ///< `road`, and `on`, of the second frame; the first is the ground's

  /// Global axes of both frames by unit vectors along `axis` and `axis2`; none: they are the z axes.
  Axes (*frame_axes)(const Eigen::Vector3d& first, const Eigen::Vector3d& second) = nullptr;
  /// The fault of these directions; empty: none.
  std::string_view (*axes_fault)(const Eigen::Vector3d& first, const Eigen::Vector3d& second) = nullptr;
  /// Sets numbers that are not given, which are NaN, by both places in the assembled position. None: all
  /// have to be given.
  void (*complete)(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                   std::vector<double>& numbers) = nullptr;
  /// Faults of what is given that nothing else finds.
  void (*check)(const spec::Constraint&, Faults&) = nullptr;

  /// Sets constants of the step. None: they are the numbers.
  void (*compile)(const spec::Constraint&, ConstraintData&) = nullptr;
  /// States at the start, by b's origin in a's axes in the assembled position. None: 0.
  void (*start)(const ConstraintData&, const Eigen::Vector3d& apart, double* states) = nullptr;
};

/// All of them, in the order of ConstraintData::kind.
std::span<const ConstraintInfo* const> all_constraints();
const ConstraintInfo& constraint_info(int kind);
/// -1: there is none of that name.
int find_constraint(std::string_view name);

/// Axes of its frames by directions.
ConstraintInfo::Axes constraint_axes(const ConstraintInfo& info, const Eigen::Vector3d& first,
                                     const Eigen::Vector3d& second);

}  // namespace mimbre

#pragma once
#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "mimbre/spec.h"

/// The parts of check_spec, one for each kind of items, and what they share.
namespace mimbre::checks {

/// Something of the spec that is being checked: how messages call it, and where they go.
class CheckedItem {
 public:
  /// `number`: its place in the list of its kind, for what has no name.
  CheckedItem(std::vector<Diagnostic>& errors, const char* kind, const std::string& name, const Mark& mark,
              std::size_t number)
      : errors_(errors),
        mark_(mark),
        called_(name.empty() ? fmt::format("{} {} (without a name)", kind, number)
                             : fmt::format("{} '{}'", kind, name)) {}
  /// The model itself.
  CheckedItem(std::vector<Diagnostic>& errors, const char* called, const Mark& mark)
      : errors_(errors), mark_(mark), called_(called) {}

  void error(const std::string& message) const {
    errors_.push_back({mark_, fmt::format("{}: {}", called_, message)});
  }

  // Each returns whether all is well, and records an error otherwise.
  bool finite(const std::string& what, double value) const {
    if (std::isfinite(value)) return true;
    error(fmt::format("{} is {}; it must be a finite number", what, value));
    return false;
  }
  template <class Derived>
  bool finite(const std::string& what, const Eigen::DenseBase<Derived>& values) const {
    if (values.derived().allFinite()) return true;
    error(fmt::format("{} has an entry that is not finite", what));
    return false;
  }
  bool positive(const std::string& what, double value) const {
    if (!finite(what, value)) return false;
    if (value > 0) return true;
    error(fmt::format("{} is {}; it must be positive", what, value));
    return false;
  }
  bool not_negative(const std::string& what, double value) const {
    if (!finite(what, value)) return false;
    if (value >= 0) return true;
    error(fmt::format("{} is {}; it must be 0 or more", what, value));
    return false;
  }
  /// The number of one of `count` items called `kind` (in the plural); `least` -1 where there may be none.
  bool index(const std::string& what, int value, std::size_t count, const char* kind, int least = 0) const {
    if (value >= least && value < static_cast<long long>(count)) return true;
    error(fmt::format("{} is {}, but the model has {} {}{}", what, value, count, kind,
                      count > 0 ? fmt::format(" (0 to {})", count - 1) : ""));
    return false;
  }
  /// From `first` to `last`, of something else than the model.
  bool between(const std::string& what, int value, int first, int last) const {
    if (value >= first && value <= last) return true;
    error(fmt::format("{} is {}; it must be from {} to {}", what, value, first, last));
    return false;
  }
  /// One of the `count` enumerators of an enumeration that counts from 0.
  template <class Enumeration>
  bool enumerator(const std::string& what, Enumeration value, int count) const {
    const int number = static_cast<int>(value);
    if (number >= 0 && number < count) return true;
    error(fmt::format("{} is {}, which is none of its {} choices", what, number, count));
    return false;
  }
  /// A place, and axes that are a rotation.
  void pose(const spec::Pose& pose) const;

 private:
  std::vector<Diagnostic>& errors_;
  const Mark& mark_;
  std::string called_;
};

/// Where a frame of the spec lies in the assembled position; its body must exist.
inline Eigen::Vector3d assembled_place(const spec::Model& model, const spec::Frame& frame) {
  if (frame.body < 0) return frame.pose.position;
  const spec::Pose& body = model.bodies[static_cast<std::size_t>(frame.body)].pose;
  return body.position + body.rotation * frame.pose.position;
}

/// Whether the frame exists and its body does: what is wrong there is reported elsewhere.
inline bool sound_frame(const spec::Model& model, int frame) {
  if (frame < 0 || frame >= static_cast<int>(model.frames.size())) return false;
  const int body = model.frames[static_cast<std::size_t>(frame)].body;
  return body >= spec::ground && body < static_cast<int>(model.bodies.size());
}

/// Of a formula and its arguments; `own`: variables of the law itself, which come first.
void check_law(const spec::Model& model, const CheckedItem& item, const spec::Law& law, std::size_t own);
/// Whether a joint of the type has the coordinate, and as a plain number that drives, springs and couplings
/// may act on; records an error, led by `what`, otherwise.
bool check_coordinate(const CheckedItem& item, const char* what, spec::JointType type, int coordinate);

// One for each kind of items.
void check_names(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_bodies(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_frames(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_joints(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_springs(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_loads(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_roads(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_tyres(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_inputs(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_signals(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_blocks(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_events(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_surfaces(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_contacts(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_elements(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_constraints(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_outputs(const spec::Model& model, std::vector<Diagnostic>& errors);
void check_simulation(const spec::Model& model, std::vector<Diagnostic>& errors);

}  // namespace mimbre::checks

#pragma once
#include <span>
#include <string>
#include <string_view>

#include "mimbre/spec.h"

/// The description of a kind of output: each is one file of src/outputs, or shares one with those that are
/// evaluated alike; outputs/table.h lists them.
namespace mimbre {

struct ChannelInfo;
struct Compiled;
struct JointInfo;
struct SensorData;
struct SensorPlaces;
class OutputView;
namespace checks {
class CheckedItem;
}

struct OutputInfo {
  using Words = std::span<const char* const>;
  enum class Of { frame, joint, body, bodies, spring, tyre, contact, element, signal, input };
  /// What of a state must be evaluated for it; each includes those before.
  enum class Needs { motion, forces, reactions };
  /// Where on a body it is: a node of its surface (none: the extreme of all), a section of its bars.
  enum class Place { none, surface, section };

  std::string_view name;  ///< in spec::Output::kind, and its key in the model file
  Of of;
  bool in_files = true;

  // Its components, by number: words; a joint's coordinates; a body's modes.
  Words words = {};
  int otherwise = -1;                        ///< the component where none is given; −1: one has to be
  int (*count)(const JointInfo&) = nullptr;  ///< of a joint: how many there are
  std::string_view without = {};             ///< what is said of a joint that has none
  bool modes = false;

  // What else it takes.
  Place place = Place::none;
  bool along = false;      ///< a direction; where there are words, in place of a component
  bool reference = false;  ///< the frame that sees it; it counts from where the model is drawn, by its offset
  bool offset = false, own_axes = false, about = false;

  /// The kind that measures the same in the axes of another body's frame.
  std::string_view seen_from_elsewhere = {};

  Needs needs = Needs::motion;

  /// Faults that nothing else finds.
  void (*check)(const spec::Model&, const checks::CheckedItem&, const spec::Output&) = nullptr;
  /// Unit, meaning, and what says the same as a value.
  ChannelInfo (*describe)(const Compiled&, const spec::Output&);
  /// Allocates nothing.
  double (*value)(const OutputView&, const spec::Output&);
  /// Where signals see it within a step. None: they may not, as forces or accelerations decide it at the same
  /// instant.
  void (*place_sensor)(const SensorPlaces&, const spec::Output&, SensorData&) = nullptr;

  constexpr bool has_component() const { return !words.empty() || count || modes; }
};

/// All of them, in the order of SensorData::kind.
std::span<const OutputInfo* const> all_outputs();
/// -1: there is none of that name.
int find_output(std::string_view name);
/// Of a spec that has been checked.
const OutputInfo& output_info(const spec::Output& output);

inline constexpr const char* axis_words[] = {"x", "y", "z"};

}  // namespace mimbre

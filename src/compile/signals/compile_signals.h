#pragma once
#include <functional>

#include "compile/compiled.h"

/// The part of compile() that numbers what a step sees of time, inputs and sensors.
namespace mimbre {

/// Gives every input, signal, load, drive and road over time its slot, and puts signals into the order in
/// which they need each other. Throws InputError for feedback without state or delay, and for signals where
/// they cannot be used.
void plan_signals(Compiled& c);

/// After plan_signals(): the spec's sensors that are seen within a step, and so need their frames.
std::vector<int> seen_within_a_step(const Compiled& c);
/// Whether the sensor sees the motion of its frames.
bool is_of_frame(const spec::Output& sensor);

int slot_of(const Compiled& c, const spec::Source& source);
/// A law without variables of its own, to be evaluated at instants.
SignalsData::Seen seen_of(const Compiled& c, const spec::Law& law);
int load_slot(const Compiled& c, int load);
int drive_slot(const Compiled& c, int joint, int drive);
void place_roads(Compiled& c);

/// Adds a law's formula; -1 where it has none. Adds an argument; its place.
int add_formula(Compiled& c, const spec::Law& law);
int add_argument(Compiled& c, int slot);

/// Where sensors find what they see, after frames and elements.
struct SensorPlaces {
  const Compiled& compiled;
  const std::function<int(ElementData)>& add_element;
  const std::function<ElementData(int joint, int coordinate)>& on_coordinate;

  /// The element that measures a joint's coordinate: one of the model's, or a new one that only measures.
  int of_coordinate(int joint, int coordinate) const;
};

/// After frames and elements. Coordinates and lengths that no element measures get one that only measures, by
/// `add_element`, of `on_coordinate` for a joint's coordinate.
void place_sensors(Compiled& c, const std::function<int(ElementData)>& add_element,
                   const std::function<ElementData(int joint, int coordinate)>& on_coordinate);

}  // namespace mimbre

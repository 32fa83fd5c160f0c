#pragma once
#include <string>
#include <vector>

#include "mimbre/generate.h"
#include "mimbre/spec.h"

/// Where on the model the variables of an FMU belong: to which joint, frame, tyre, ….
namespace mimbre::portable {

/// A part of the model to which variables belong.
struct ModelPlace {
  std::string name;     ///< "joint.crank"; empty: none
  std::string kind;     ///< "joint"
  std::string meaning;  ///< "joint 'crank'"
};

/// What an output shows of its part of the model.
struct OutputMeaning {
  ModelPlace of;
  std::string quantity;   ///< "velocity"; unique in its place only where it belongs to a vector
  std::string component;  ///< of a vector: "x"; empty: it belongs to none
  int number = 0;         ///< of that component
  int components = 0;     ///< of that vector
};
/// Of each output of the code, in their order.
std::vector<OutputMeaning> output_places(const GeneratedCode& code, const spec::Model& model);

/// All components of a vector.
struct OutputVector {
  ModelPlace of;
  std::string quantity;
  std::vector<int> outputs;  ///< of the code, by number, in the order of the components
  /// What the names of the outputs have in common: "tip" of tip.x, tip.y and tip.z. Empty: nothing.
  std::string stem;
  std::string meaning;  ///< "angular velocity of frame 'tip' in its own axes"
};
/// Those of which the code has all components.
std::vector<OutputVector> output_vectors(const GeneratedCode& code, const std::vector<OutputMeaning>& places);

/// Of each input of the model the part on which alone it acts, by way of signals or at once; no name: it acts
/// on several, or on none.
std::vector<ModelPlace> input_places(const spec::Model& model);

}  // namespace mimbre::portable

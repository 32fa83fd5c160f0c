#pragma once
#include <memory>
#include <vector>

#include "compile/compiled.h"
#include "dynamics/system.h"
#include "mimbre/method.h"
#include "portable/program.h"

namespace mimbre::portable {

/// An output that the code has.
struct RecordedOutput {
  std::string name, unit, meaning;
};

/// A force element whose tangent is exchanged in the matrix when it changes at once.
struct MarkedElement {
  int element = -1, size = 1;  ///< components
  int tangent = 0;             ///< where its size² numbers begin among the tangents
  bool contact = false;        ///< rows are made anew where it did not touch
  double small = 0;            ///< changes of its mark that ask for a new matrix
};

/// Of what flies freely: numbers that it keeps from the start of a step, and numbers of its root that are
/// corrected at the end.
inline constexpr int flight_kept = 11, flight_moved = 7 + 3 * 6;

/// The floating joint of what flies freely: where its coordinates begin.
struct RecordedFlight {
  int q, v;
  bool rigid;  ///< it does not change its shape
};

/// A continuous state besides positions and velocities: number `at` of what signals remember (held), or of
/// what force elements remember.
struct RememberedState {
  bool held = false;
  int at = 0;
  std::string meaning;
};

/// A model as phases of operations, and what the integrator has to know of it.
struct RecordedModel {
  Program program;
  std::vector<JacobianEntry> jacobian;  ///< of the equations, in the order of Memory::jacobian
  std::vector<MarkedElement> marked;
  std::vector<RecordedOutput> outputs;
  std::vector<std::string> left_out;    ///< outputs that it has not, with the reason
  std::vector<RememberedState> states;  ///< of an instant, in the order of Memory::state_rate
  std::vector<JacobianEntry> mass;      ///< likewise, rows and columns in the order of Memory::mass
  std::string without_variations;       ///< why directional derivatives are not known; empty: they are
  bool senses = false;                  ///< signals see the motion
  bool blocks = false;                  ///< signals remember
  bool remembers = false;               ///< commit is needed
  bool rests = false;                   ///< laws at rest are others than in a step
  bool sticks = false;                  ///< an element heeds `holds`
  bool jumps = false;                   ///< laws remember signals where these jump
  bool loads = false;                   ///< of inertia that stiffen bodies
  std::vector<RecordedFlight> flights;
  std::vector<int> delays;  ///< blocks whose lists are kept by hand
  std::vector<int> circle;  ///< slots of what blocks make that close loops of signals
};

/// Runs the kernels of a step of `step` seconds once. `varies`: also how outputs vary with inputs and the
/// time while the motion does not. Throws NotRecordable.
std::unique_ptr<RecordedModel> record_model(const Compiled& model, const MatrixWeights& weights,
                                            const std::vector<double>& penalty, double step,
                                            const std::vector<double>& small_marks, bool varies);

/// The same of what an instant takes alone, without a step: equations, forces, mass, outputs, and the rates
/// of what is remembered. Throws NotRecordable.
std::unique_ptr<RecordedModel> record_instant(const Compiled& model);

}  // namespace mimbre::portable

#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mimbre/modes.h"

namespace mimbre {

/// The modes of a family of models, by the value of its parameter: those of linear models with the same
/// states.
using ModesAt = std::function<LinearisedModes(double)>;

/// The same by a solver that is given.
using ModesBy = std::function<LinearisedModes(double, ModesSolver)>;

/// Modes of a family at values that are asked for one after the other. Steady driving (LinearPoint::At::trim)
/// is sought from that of the nearest value that is known: a condition or a parameter may then differ more
/// from the start of the model than the search would go at once, and where there are several such motions
/// they are those that go on. All have the independent coordinates of the first one, as far as they are
/// independent: shapes can then be compared.
class NeighbouringModes {
 public:
  /// As find_modes(), of the model at this value of its condition or parameter.
  LinearisedModes find(double value, std::shared_ptr<const Model> model, ModesOptions options);

 private:
  std::map<double, std::shared_ptr<const DrivingState>> driving_;
  IndependentCoordinates independent_;
};

struct CampbellOptions {
  std::string parameter;  ///< its name, for people
  /// So many of the lowest modes are followed; 0: all that there are. `modes` should then give some more
  /// (with_neighbours()), among which those are found again that cross the highest ones.
  int most = 0;
  double rad_per_second = 1;         ///< one unit of the parameter as a speed, rad/s; 0: it is no speed
  std::vector<double> orders = {1};  ///< of the speed, whose crossings are critical
  int most_evaluations = 20000;      ///< of the modes, with those between the values
};

/// A mode over the parameter. Two real modes that meet are one oscillating pair from there on, until it
/// parts: then the branch of one of them has the λ of the pair, and that of the other one its conjugate. A
/// mode that parts for the first time had its second half from the beginning. Where a real mode becomes a
/// drift along a rigid motion, as the speed of a vehicle that nothing holds, its λ is 0.
struct ModeBranch {
  std::string name;                          ///< what it consists of where it is first seen
  std::vector<std::complex<double>> values;  ///< λ, 1/s, by value of the parameter; NaN where it is not there
  std::vector<double> whirl;                 ///< Mode::whirl, likewise
  std::vector<int> half_of;                  ///< the branch with the other half of the pair, whose λ is the
                                             ///< conjugate of the one here; −1: it is no such half
};

struct CampbellDiagram {
  std::string parameter;
  std::vector<double> values;
  std::vector<ModeBranch> branches;
  /// Where the damped frequency of a mode is an order of the speed.
  struct Critical {
    int branch = 0;
    double value = 0, order = 1, frequency = 0;  ///< of the parameter; rad/s
  };
  std::vector<Critical> criticals;
  /// Where a mode begins to grow (`grows`) or ceases to, with its frequency there.
  struct Onset {
    int branch = 0;
    double value = 0, frequency = 0;  ///< of the parameter; rad/s
    bool grows = true;
  };
  std::vector<Onset> onsets;
  /// Where two real modes meet and are a pair behind it, or a pair parts (`parts`).
  struct Meeting {
    int first = 0, second = 0;   ///< branches: that of the pair, and that of its other half
    double value = 0, real = 0;  ///< of the parameter; λ there, 1/s
    bool parts = false;
  };
  std::vector<Meeting> meetings;
  int evaluations = 0;
  std::vector<std::string> warnings;  ///< where modes could not be distinguished, and those of the points
};

/// Follows the modes over the values (at least two, in order) by their shapes: between two values mode i goes
/// on as j where |wᵢᴴ xⱼ| |wⱼᴴ xᵢ|, w and x left and right eigenvectors, is near 1 and all others are small.
/// Where it is not so, values between them are taken, as many as it needs: crossings and veerings are
/// followed through. Two real modes that meet are found by the plane that they have in common with the pair,
/// and the place by (λ₁ − λ₂)², which is smooth there. Rigid motions have one eigenvalue: they go on as a
/// group, in their order. Among equal eigenvalues shapes are those that go on. Criticals and onsets are found
/// between values to 1e-6, meetings to 1e-5. A mode that grows only between two values is found where the
/// damping of three values points to it, and where modes meet. Values are those of the ground; of a rotor
/// that is not round, whose modes have two frequencies there, all are those of axes that turn with it, and a
/// warning states so. Throws std::invalid_argument, and what `modes` throws: a std::runtime_error with the
/// value.
CampbellDiagram campbell(const ModesAt& modes, const std::vector<double>& values,
                         const CampbellOptions& options = {});

/// How many modes to ask for where `most` are followed; 0: all.
int with_neighbours(int most);

/// One solver for all values from the first to the last, whose modes have vectors of one kind: `asked`, or,
/// if that is automatic, `sparse` where it is what find_modes() chooses at both.
ModesSolver one_solver(const ModesBy& modes, double first, double last, ModesSolver asked);

}  // namespace mimbre

#pragma once
#include <string>
#include <vector>

#include "dynamics/state_transfer.h"
#include "simulation/step/mechanism.h"

namespace mimbre {

/// Watches bodies that turn about any axis, on a floating or a spherical joint, for turning too far in a
/// step. The limits are where a step misses half a per cent of its turn, found with free asymmetric tops
/// against steps 32 times shorter (docs/theory.md). A wheel on its axle is not watched: a turn about one axis
/// is exact in relative coordinates, whatever the step.
namespace spin_limit {
/// Relative coordinates err by the change of the rotation alone: a step h misses about ¹⁄₁₄ h² |ω̇| of its
/// turn, where ω̇ = J⁻¹ (ω × J ω) is what the body's inertia does to it without any moment. About a principal
/// axis it is zero, and the turn exact.
constexpr double change = 0.07;
/// Natural coordinates err by every turn, rad a step: 0.13 (h ω)² of it, and 0.02 (h ω)² about a fixed point.
constexpr double natural_floating = 0.2, natural_spherical = 0.5;
}  // namespace spin_limit

class SpinWatch {
 public:
  explicit SpinWatch(const Compiled& model);
  bool none() const { return bodies_.empty(); }
  void start();
  /// After every accepted step of `length` seconds, kinematics evaluated. Neither allocates nor throws.
  void watch(Mechanism& mechanism, double length);
  void transfer(StateTransfer& transfer);
  std::vector<std::string> warnings(const Compiled& model) const;

 private:
  struct Watched {
    int body = -1;
    std::vector<int> carried;             ///< the body and all after it, which turn with it
    double first = -1;                    ///< s, when it turned too far first; negative: never
    double excess = 1;                    ///< the measure over its limit, the largest
    double turn = 0, step = 0, time = 0;  ///< then: rad, s, s
    double enough = 0;                    ///< s, the step that would do
    bool natural = false;                 ///< seen in natural coordinates
  };
  std::vector<Watched> bodies_;
};

}  // namespace mimbre

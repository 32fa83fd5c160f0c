#pragma once
#include <string>
#include <vector>

#include "compile/compiled.h"
#include "dynamics/state_transfer.h"

namespace mimbre {

/// Looks for winches whose signal asks for less cable than the law gives them (forces/cable.h). Allocates
/// only when made.
class WinchWatch {
 public:
  explicit WinchWatch(const Compiled& model);
  void start();
  /// After every accepted step: of the states of force elements.
  void watch(const double* states, double time);
  void transfer(StateTransfer& transfer);
  std::vector<std::string> warnings() const;

 private:
  struct Winch {
    int element, rest;  ///< rest: its state
    double least;       ///< m
    double from;        ///< s: when it was first cut off; −1: never
  };
  const Compiled& model_;
  std::vector<Winch> winches_;
};

}  // namespace mimbre

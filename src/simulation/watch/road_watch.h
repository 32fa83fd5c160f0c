#pragma once
#include <array>
#include <string>
#include <vector>

#include "compile/compiled.h"
#include "dynamics/relative/workspace.h"
#include "dynamics/state_transfer.h"

namespace mimbre {

/// Looks for tyres that stand beside or beyond a road from a file, where its height is assumed to go on
/// level. Allocates only when made.
class RoadWatch {
 public:
  explicit RoadWatch(const Compiled& model);
  void start();
  /// After every accepted step.
  void watch(const relative::Workspace<double>& work, double time);
  void transfer(StateTransfer& transfer);
  std::vector<std::string> warnings() const;

 private:
  struct Watched {
    int element;
    double from = -1;            ///< s: when it first stood there; −1: never
    std::array<double, 2> at{};  ///< global x and y then, m
  };
  const Compiled& model_;
  std::vector<Watched> watched_;
};

}  // namespace mimbre

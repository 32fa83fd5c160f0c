#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "dynamics/relative/workspace.h"

namespace mimbre {

/// A warning for each swarm whose lightest spheres strike one another in less than four steps of h seconds,
/// of those whose impacts take the same time at any speed (exponent 1).
std::vector<std::string> swarm_warnings(const Compiled& model, double h);

/// Finds the spheres of swarms that can meet within a step, by a grid of cells as wide as the largest of them
/// with the way that they make. A pair keeps its place, and with it what it remembers, as long as they stay
/// near each other. The pairs depend on the state alone. Allocates only when made.
class SwarmSearch {
 public:
  explicit SwarmSearch(const Compiled& model);
  bool none() const { return most_spheres_ == 0; }
  /// Puts pairs into the states of their elements, `states`, before a step of h seconds from where the frames
  /// are.
  void find(const relative::Workspace<double>& work, double h, double* states);

 private:
  struct Pair {
    std::int64_t key;  ///< second sphere, then first
    double gap, rate;
    bool placed;
  };
  using Cell = std::array<std::int64_t, 3>;

  void collect(const SwarmData& swarm, const relative::Workspace<double>& work, double h);
  void keep_nearest(std::size_t count);
  void place(const SwarmData& swarm, const relative::Workspace<double>& work, double* states);
  std::size_t slot_of(const Cell& cell) const;

  const Compiled& model_;
  std::size_t most_spheres_ = 0;
  std::vector<Pair> pairs_;
  std::vector<Cell> cells_;        ///< by sphere
  std::vector<int> heads_, next_;  ///< of the lists of spheres whose cells share a slot
};

}  // namespace mimbre

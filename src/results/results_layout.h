#pragma once

/// Names shared by what writes and what reads a results file (docs/results-format.md).
namespace mimbre::results_layout {

constexpr char format[] = "mimbre-results-2";
constexpr char format_stem[] = "mimbre-results-";  ///< of all versions
constexpr int numbers_per_shape = 16;              ///< kind, size 3, position 3, rotation 9 by rows
constexpr int numbers_per_pose = 12;               ///< position 3, rotation 9 by rows
constexpr int numbers_per_section = 7;             ///< N, Vy, Vz, T, My, Mz, von Mises

}  // namespace mimbre::results_layout

#pragma once
#include <complex>
#include <cstddef>
#include <optional>
#include <vector>

#include "mimbre/modes.h"

/// Which modes at one value of a parameter go on as which at another.
namespace mimbre::linear {

/// Two real modes of one value that are one oscillating pair at the other: the eigenvalues meet between them.
struct Meeting {
  int slow = 0, fast = 0;  ///< the real modes: the larger λ first
  int pair = 0;
};

/// Modes at one value.
struct ModeSet {
  const std::vector<Mode>& modes;
  int zeros = -1;  ///< LinearisedModes::zeros
};

struct Matching {
  /// Of each mode of b the one of a that goes on as it; −1: none. The first of two real modes of a that meet
  /// goes on as the pair, a pair that parts as the first of the two.
  std::vector<int> pair;
  std::vector<Meeting> meet;  ///< real modes of a, pair of b
  std::vector<Meeting> part;  ///< pair of a, real modes of b
  /// A real mode of a that is a drift of the rigid motions of b, with λ = 0, or the reverse; −1: none.
  int stops = -1, starts = -1;
  bool certain = false;  ///< of all that are followed
};

/// `most`: the first so many are followed. Rigid motions have one λ and belong together: where there are as
/// many, they go on in their order (see align()).
Matching match_modes(const ModeSet& a, const ModeSet& b, std::size_t most);

/// The two eigenvalues of a meeting, at one value: (λ₁ − λ₂)² is smooth through it, positive of real modes.
struct MeetingValues {
  double difference_squared = 0;
  double mean = 0;  ///< of the real parts
};
MeetingValues of_pair(const Mode& pair);
MeetingValues of_two(const Mode& first, const Mode& second);

/// Whether two decaying or growing modes are so nearly one that their vectors are round-off.
bool have_met(const Mode& mode);

/// Whether an eigenvalue is real but for round-off, as equal real eigenvalues come out.
bool is_nearly_real(std::complex<double> value);

/// Makes two real modes of each pair whose λ is nearly real:
/// Re x and Im x, with the left vectors 2 Re w and 2 Im w.
void part_nearly_real(std::vector<Mode>& modes);

/// Those of the modes whose space is that of the pair: a pair or two real ones. Nothing: none is alike.
std::optional<MeetingValues> meeting_values(const Mode& pair, const std::vector<Mode>& modes);

}  // namespace mimbre::linear

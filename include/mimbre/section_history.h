#pragma once
#include <string>
#include <vector>

#include "mimbre/results.h"

/// Forces, moments and stress in the sections of bars over a run, where its outputs recorded them.
namespace mimbre {

/// The smallest and the largest value over a run, and when: the first time of equal ones.
struct Extremes {
  double least = 0, least_time = 0;  ///< N, N m or Pa; s
  double most = 0, most_time = 0;
};

/// Of a channel. Instants at which it is not a number are passed over; NaN where there is no other.
Extremes extremes(const Results& results, int channel);

/// Writes CSV, one line for each section and instant: body, bar, element, end, along (m), t (s), N, Vy, Vz,
/// T, My, Mz, von_mises (N, N m, Pa); what was not recorded is left empty. `bodies`: only these; empty: all.
/// Throws std::runtime_error where the file cannot be written; an older one stands until the new one is
/// whole.
void write_section_loads(const Results& results, const std::vector<std::string>& bodies,
                         const std::string& path);

/// Likewise one line for each section and component that was recorded: body, bar, element, end, along,
/// component, min, min_time, max, max_time.
void write_section_envelopes(const Results& results, const std::vector<std::string>& bodies,
                             const std::string& path);

/// Whether a section belongs to one of the bodies; `bodies`: as above.
bool is_of(const Results& results, const RecordedSection& section, const std::vector<std::string>& bodies);

}  // namespace mimbre

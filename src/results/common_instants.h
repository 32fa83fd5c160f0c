#pragma once
#include <vector>

#include "mimbre/results.h"

namespace mimbre::results {

/// Where an instant lies in a series: between instants `left` and `left + 1`, at `part` of the way.
struct Place {
  Eigen::Index left = 0;
  double part = 0;
};

/// A channel between the instants of its run: by the cubic through four of them where that is smooth, else by
/// the parabola or line that bends less; and about by how much that may be off at most.
struct Between {
  double value = 0, error = 0;
};
Between interpolate(const Results& run, Eigen::Index channel, Place place);

/// On what two runs are compared: the instants of the coarser one within the time that they share.
struct CommonInstants {
  std::vector<double> time;
  std::vector<Place> in_a, in_b;  ///< one per instant
};

/// Empty when the runs share no time. Throws InputError when a run holds no instant or its times do not
/// ascend.
CommonInstants common_instants(const Results& a, const Results& b);

/// How far channel `of_b` of b is from channel `of_a` of a; `instants` are not empty.
ChannelDifference channel_difference(const Results& a, Eigen::Index of_a, const Results& b, Eigen::Index of_b,
                                     const CommonInstants& instants);

}  // namespace mimbre::results

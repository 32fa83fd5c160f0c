#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "mimbre/diagnostics.h"
#include "results/common_instants.h"

namespace mimbre {

namespace results {
namespace {

Place place_of(const Eigen::VectorXd& time, double t) {
  const double* const after = std::upper_bound(time.data(), time.data() + time.size(), t);
  const Eigen::Index last = std::max<Eigen::Index>(time.size() - 2, 0);
  const Eigen::Index left = std::clamp<Eigen::Index>(after - time.data() - 1, 0, last);
  if (time.size() < 2) return {0, 0};
  const double interval = time[left + 1] - time[left];
  return {left, interval > 0 ? std::clamp((t - time[left]) / interval, 0.0, 1.0) : 0.0};
}

/// Two values that are both not a number, or the same infinity, agree; one alone is a difference that nothing
/// hides.
double distance(double a, double b) {
  const bool same = a == b || (std::isnan(a) && std::isnan(b));
  return same ? 0 : std::abs(a - b);
}

std::vector<double> instants_between(const Eigen::VectorXd& time, double start, double end) {
  std::vector<double> result;
  for (const double t : time)
    if (t >= start && t <= end) result.push_back(t);
  return result;
}

void check_time(const Results& results, const char* which) {
  if (results.time.size() == 0)
    throw InputError(Mark{}, std::string("the ") + which + " results hold no instant");
  if (!std::is_sorted(results.time.begin(), results.time.end()))
    throw InputError(Mark{}, std::string("the times of the ") + which + " results do not ascend");
}

}  // namespace

double interpolate(const Eigen::MatrixXd& channels, Eigen::Index channel, Place place) {
  const double from = channels(place.left, channel);
  // At an instant of the series its value counts alone, whatever stands beside it.
  if (place.part == 0) return from;
  const double to = channels(place.left + 1, channel);
  return place.part == 1 ? to : from + place.part * (to - from);
}

CommonInstants common_instants(const Results& a, const Results& b) {
  check_time(a, "first");
  check_time(b, "second");
  const double longest = std::max(std::abs(a.time[a.time.size() - 1]), std::abs(b.time[b.time.size() - 1]));
  // Times are sums of steps; two runs that end together may differ by rounding.
  const double rounding = 1e-9 * longest;
  const double start = std::max(a.time[0], b.time[0]) - rounding;
  const double end = std::min(a.time[a.time.size() - 1], b.time[b.time.size() - 1]) + rounding;
  if (start > end) return {};
  std::vector<double> of_a = instants_between(a.time, start, end),
                      of_b = instants_between(b.time, start, end);
  // The coarser grid, but not one without any instant in the common range.
  const bool use_a = !of_a.empty() && (of_b.empty() || of_a.size() <= of_b.size());
  CommonInstants common;
  common.time = std::move(use_a ? of_a : of_b);
  for (const double t : common.time) {
    common.in_a.push_back(place_of(a.time, t));
    common.in_b.push_back(place_of(b.time, t));
  }
  return common;
}

ChannelDifference channel_difference(const Results& a, Eigen::Index of_a, const Results& b, Eigen::Index of_b,
                                     const CommonInstants& instants) {
  ChannelDifference result;
  result.name = a.header.channels[static_cast<std::size_t>(of_a)].name;
  for (const double value : a.channels.col(of_a))
    if (!std::isnan(value)) result.amplitude = std::max(result.amplitude, std::abs(value));
  double sum = 0;
  for (std::size_t k = 0; k < instants.time.size(); ++k) {
    const double value_a = interpolate(a.channels, of_a, instants.in_a[k]);
    const double value_b = interpolate(b.channels, of_b, instants.in_b[k]);
    const double difference = distance(value_a, value_b);
    sum += difference;
    // Once it is not a number it stays so: the comparison below is false then.
    const bool larger =
        std::isnan(difference) ? !std::isnan(result.max_difference) : difference > result.max_difference;
    if (k == 0 || larger) {
      result.max_difference = difference;
      result.at_time = instants.time[k];
    }
  }
  result.mean_difference = sum / static_cast<double>(instants.time.size());
  return result;
}

}  // namespace results

std::vector<ChannelDifference> compare(const Results& a, const Results& b) {
  const results::CommonInstants instants = results::common_instants(a, b);
  if (instants.time.empty()) throw InputError(Mark{}, "the two results have no time in common");
  std::unordered_map<std::string, Eigen::Index> channel_of_b;
  for (std::size_t i = 0; i < b.header.channels.size(); ++i)
    channel_of_b.emplace(b.header.channels[i].name, static_cast<Eigen::Index>(i));

  std::vector<ChannelDifference> differences;
  for (std::size_t i = 0; i < a.header.channels.size(); ++i) {
    const auto in_b = channel_of_b.find(a.header.channels[i].name);
    if (in_b == channel_of_b.end()) continue;
    // A position and a speed of the same name have no difference.
    if (a.header.channels[i].unit != b.header.channels[static_cast<std::size_t>(in_b->second)].unit) continue;
    differences.push_back(
        results::channel_difference(a, static_cast<Eigen::Index>(i), b, in_b->second, instants));
  }
  return differences;
}

}  // namespace mimbre

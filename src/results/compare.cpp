#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
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
  const double part = interval > 0 ? std::clamp((t - time[left]) / interval, 0.0, 1.0) : 0.0;
  // Times are sums of steps: an instant of both may differ by rounding.
  constexpr double rounding = 1e-9;
  return {left, part < rounding ? 0 : part > 1 - rounding ? 1 : part};
}

/// The second divided difference around instant k; nothing where that is an end, or is not finite.
std::optional<double> bend(const Results& run, Eigen::Index channel, Eigen::Index k) {
  if (k < 1 || k + 1 >= run.time.size()) return {};
  const auto slope = [&](Eigen::Index i) {
    return (run.channels(i + 1, channel) - run.channels(i, channel)) / (run.time[i + 1] - run.time[i]);
  };
  const double b = (slope(k) - slope(k - 1)) / (run.time[k + 1] - run.time[k - 1]);
  if (!std::isfinite(b)) return {};
  return b;
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

/// Newton's form: with h the interval, u the part of it, and b the second divided differences around its
/// ends, the parabola with the instant before is y = line − u (1 − u) h² b₀, that with the one behind the
/// same with b₁. The cubic is their mean, weighted by where the instant lies between the outer two. Where
/// they disagree, as beside a jump, the one with the smaller bend does not see it (essentially
/// non-oscillatory interpolation, Harten et al. 1987). A smooth cubic is off by 3/64 h² δ²b at most, δ²b the
/// second differences of b; h² δ²b has room for a kink.
Between interpolate(const Results& run, Eigen::Index channel, Place place) {
  const Eigen::Index i = place.left, n = run.time.size();
  const double from = run.channels(i, channel);
  // At an instant of the series its value counts alone, whatever stands beside it.
  if (place.part == 0) return {from, 0};
  const double to = run.channels(i + 1, channel);
  if (place.part == 1) return {to, 0};
  const double rise = to - from, line = from + place.part * rise;
  if (!std::isfinite(line)) return {line, 0};
  std::optional<double> first = bend(run, channel, i), second = bend(run, channel, i + 1);
  if (!first && !second) return {line, std::abs(rise)};
  // At the ends of the series the bend goes on in a straight line.
  const auto beyond = [](double near, std::optional<double> next) { return next ? 2 * near - *next : near; };
  if (!first) first = beyond(*second, bend(run, channel, i + 2));
  if (!second) second = beyond(*first, bend(run, channel, i - 1));
  const double start = run.time[i], end = run.time[i + 1], h = end - start, u = place.part;
  const double most = std::max(std::abs(*first), std::abs(*second)),
               least = std::min(std::abs(*first), std::abs(*second));
  const bool smooth = (*first * *second > 0 && most <= 2 * least) ||
                      0.25 * h * h * std::abs(*first - *second) <= std::abs(rise) / 64;
  const double before = i > 0 ? run.time[i - 1] : start - h, behind = i + 2 < n ? run.time[i + 2] : end + h;
  const double weight = (start + u * h - before) / (behind - before);
  const double bent = smooth                                 ? (1 - weight) * *first + weight * *second
                      : std::abs(*first) < std::abs(*second) ? *first
                                                             : *second;
  const double off = -u * (1 - u) * h * h * bent, rough = std::abs(rise) + 3 * std::abs(off);
  if (!smooth) return {line + off, rough};
  std::array<double, 4> near{};
  std::size_t count = 0;
  const Eigen::Index lowest = std::clamp<Eigen::Index>(i - 1, 1, std::max<Eigen::Index>(1, n - 5));
  for (Eigen::Index k = lowest; k < lowest + 4 && k + 1 < n; ++k) {
    const auto b = bend(run, channel, k);
    if (!b) return {line + off, rough};
    near[count++] = *b;
  }
  double change = count < 2 ? *first : count == 2 ? near[1] - near[0] : near[0] - 2 * near[1] + near[2];
  if (count == 4) change = std::max(std::abs(change), std::abs(near[1] - 2 * near[2] + near[3]));
  return {line + off, std::min(rough, h * h * std::abs(change))};
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
    const Between value_a = interpolate(a, of_a, instants.in_a[k]);
    const Between value_b = interpolate(b, of_b, instants.in_b[k]);
    const double difference = distance(value_a.value, value_b.value);
    result.interpolation_error = std::max(result.interpolation_error, value_a.error + value_b.error);
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

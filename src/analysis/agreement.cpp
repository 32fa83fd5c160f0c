#include "mimbre/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

namespace mimbre {
namespace {

constexpr double agreed = 0.01;      ///< of the scale
constexpr double least_fall = 2;     ///< of a difference that falls with the step; of second order: 4
constexpr double round_off = 1e-9;   ///< of the scale: no order can be seen in what is smaller
constexpr double of_unit = 1e-4;     ///< least scale, of the largest range of the unit
constexpr double of_largest = 1e-6;  ///< least scale, of the channel's largest value

/// Two values that are both not a number, or the same infinity, agree.
double distance(double a, double b) {
  const bool same = a == b || (std::isnan(a) && std::isnan(b));
  return same ? 0 : std::abs(a - b);
}

/// Orders what is not a number as the largest.
bool larger(double a, double b) { return std::isnan(a) ? !std::isnan(b) : a > b; }

/// What finite values sweep.
struct Sweep {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  void add(double value) {
    if (!std::isfinite(value)) return;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  double range() const { return most >= least ? most - least : 0; }
  double largest() const { return most >= least ? std::max(std::abs(least), std::abs(most)) : 0; }
};

double relative(double difference, double scale) { return difference == 0 ? 0 : difference / scale; }

std::optional<double> fall(double whole, double half) {
  if (!(whole > round_off) || !(half > round_off)) return {};
  return whole / half;
}

/// What each run makes of its own: not the motion, but the error of its integration.
bool own(const std::string& channel) {
  return channel.starts_with("solver.") || channel == "energy.numerical";
}

std::string percent(double part) { return fmt::format("{:.2g} %", 100 * part); }

std::string where(const Apart& d) {
  return fmt::format("'{}', {:.3g} {} at t = {:.6g} s", d.name, d.max_difference, d.unit, d.time);
}

}  // namespace

std::vector<Apart> differences(const Series& a, const Series& b) {
  const std::size_t instants = std::min(a.time.size(), b.time.size());
  std::unordered_map<std::string, Eigen::Index> channel_of_b;
  for (std::size_t c = 0; c < b.info.size(); ++c)
    channel_of_b.emplace(b.info[c].name, static_cast<Eigen::Index>(c));
  std::vector<Apart> result;
  std::vector<double> largest;
  std::map<std::string, double> range_of_unit;
  for (std::size_t c = 0; c < a.info.size(); ++c) {
    const auto in_b = channel_of_b.find(a.info[c].name);
    if (in_b == channel_of_b.end() || own(a.info[c].name)) continue;
    const auto in_a = static_cast<Eigen::Index>(c);
    Apart d;
    d.name = a.info[c].name;
    d.unit = a.info[c].unit;
    Sweep sweep;
    double squares = 0;
    for (std::size_t k = 0; k < instants; ++k) {
      const double of_a = a.channels[k][in_a], of_b = b.channels[k][in_b->second];
      const double apart = distance(of_a, of_b);
      sweep.add(of_a);
      sweep.add(of_b);
      squares += apart * apart;
      if (k > 0 && !larger(apart, d.max_difference)) continue;
      d.max_difference = apart;
      d.time = a.time[k];
    }
    if (instants > 0) d.rms_difference = std::sqrt(squares / static_cast<double>(instants));
    d.range = sweep.range();
    double& range = range_of_unit[d.unit];
    range = std::max(range, d.range);
    largest.push_back(sweep.largest());
    result.push_back(std::move(d));
  }
  for (std::size_t c = 0; c < result.size(); ++c) {
    Apart& d = result[c];
    d.scale = std::max({d.range, of_unit * range_of_unit[d.unit], of_largest * largest[c]});
    d.relative_difference = relative(d.max_difference, d.scale);
  }
  return result;
}

std::optional<double> Refined::ratio() const {
  if (!half) return {};
  return fall(whole.relative_difference, half->relative_difference);
}

bool Refined::agrees() const {
  if (finest().relative_difference <= agreed) return true;
  if (!half) return false;
  return ratio().value_or(0) >= least_fall ||
         fall(relative(whole.rms_difference, whole.scale), relative(half->rms_difference, half->scale))
                 .value_or(0) >= least_fall;
}

Agreement agreement(const std::vector<Apart>& whole, const std::vector<Apart>& half) {
  Agreement result;
  double squares_whole = 0, squares_half = 0;
  for (std::size_t c = 0; c < whole.size(); ++c) {
    Refined channel{whole[c], half.empty() ? std::nullopt : std::optional(half[c])};
    result.agree = result.agree && channel.agrees();
    squares_whole += std::pow(relative(whole[c].rms_difference, whole[c].scale), 2);
    if (channel.half) squares_half += std::pow(relative(half[c].rms_difference, half[c].scale), 2);
    result.channels.push_back(std::move(channel));
  }
  const auto count = static_cast<double>(std::max<std::size_t>(whole.size(), 1));
  if (!half.empty()) result.ratio = fall(std::sqrt(squares_whole / count), std::sqrt(squares_half / count));
  std::stable_sort(result.channels.begin(), result.channels.end(), [](const Refined& a, const Refined& b) {
    return larger(a.finest().relative_difference, b.finest().relative_difference);
  });
  return result;
}

std::string verdict(const Agreement& agreement) {
  if (agreement.channels.empty()) return "There is no channel to compare.";
  const Apart& worst = agreement.channels.front().finest();
  const bool halved = agreement.channels.front().half.has_value();
  const char* const step = halved ? " with half the step" : "";
  if (!agreement.agree) {
    const auto wrong = std::find_if(agreement.channels.begin(), agreement.channels.end(),
                                    [](const Refined& c) { return !c.agrees(); });
    const Apart& d = wrong->finest();
    std::string text =
        std::isnan(d.relative_difference)
            ? fmt::format("The formulations disagree: one of them gives no number for '{}' at t = {:.6g} s.",
                          d.name, d.time)
            : fmt::format("The formulations disagree by {} of the range{} ({}).",
                          percent(d.relative_difference), step, where(d));
    if (const auto ratio = wrong->ratio())
      text += fmt::format(
          "\nHalf the step makes this difference {}, where two methods of second order for the same "
          "equations "
          "would make it 4 times smaller: the step is far too long, or one formulation is wrong; a shorter "
          "one (--step) tells which.",
          *ratio >= 1 ? fmt::format("only {:.3g} times smaller", *ratio)
                      : fmt::format("{:.3g} times larger", 1 / *ratio));
    else if (!halved)
      text += "\nWithout the runs with half the step it is not known whether the difference falls with it.";
    return text;
  }
  std::string text;
  if (worst.relative_difference == 0)
    text = "The formulations give the same numbers in every channel.";
  else if (worst.relative_difference <= agreed)
    text = fmt::format("The formulations agree to {} of the range{}; the worst channel is {}.",
                       percent(worst.relative_difference), step, where(worst));
  else
    text = fmt::format(
        "The formulations come together as the step gets shorter: half of it leaves {} of the range; the "
        "worst "
        "channel is {}.",
        percent(worst.relative_difference), where(worst));
  if (!halved) return text;
  if (!agreement.ratio)
    text +=
        "\nWhat is left is round-off and the tolerance of the iterations, which no shorter step makes "
        "smaller.";
  else if (*agreement.ratio >= least_fall)
    text += fmt::format(
        "\nHalf the step makes the mean difference of all channels {:.3g} times smaller (second order: 4 "
        "times): "
        "both solve the same equations, and what separates them is the length of the step.",
        *agreement.ratio);
  else
    text += fmt::format(
        "\nHalf the step makes the mean difference of all channels {:.3g} times smaller, and not 4 times "
        "(second "
        "order): it is small, but not the step alone decides it (impacts, the tolerance of the iterations).",
        *agreement.ratio);
  return text;
}

}  // namespace mimbre

#include "mimbre/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <unordered_map>

namespace mimbre {
namespace {

constexpr double agreed = 0.01;          ///< of the scale
constexpr double least_fall = 2;         ///< of a difference that falls with the step; of second order: 4
constexpr double least_step_fall = 1.5;  ///< of what half the step changes; after impacts, of first order: 2
constexpr double largest_error = 0.25;   ///< mean of what half the step may change, of the scale
constexpr double large_error = 0.05;     ///< likewise; what is larger falls as an error of the step does ...
constexpr double most_step_fall = 16;    ///< ... and not by more than this (of second order: 4), as what only
                                         ///< the longer step did: another branch, an impact missed
constexpr double round_off = 1e-9;       ///< of the scale: no order can be seen in what is smaller
constexpr double of_unit = 1e-4;         ///< least scale, of the largest range of the unit
constexpr double of_largest = 1e-6;      ///< least scale, of the channel's largest value
// Where zero means something:
constexpr double of_own = 0.1;          ///< least scale, of the channel's largest value
constexpr double of_play = 1e-3;        ///< least scale, of the largest value of the unit
constexpr double of_energy = 1e-2;      ///< least scale of moments, and of forces times the largest length
constexpr double of_gravity = 9.81e-3;  ///< least scale at rest, of accelerations, m/s²
/// Least scale of lengths, of the mechanism's, and of angles: 1 % of it is to what a start closes its loops.
constexpr double of_start = 1e-7;
constexpr std::size_t named_channels = 5;

/// Two values that are both not a number, or the same infinity, agree.
double distance(double a, double b, ChannelInfo::Alike alike) {
  if (a == b || (std::isnan(a) && std::isnan(b))) return 0;
  if (alike == ChannelInfo::Alike::turns) return std::abs(std::remainder(a - b, 2 * std::numbers::pi));
  if (alike == ChannelInfo::Alike::sign) return std::min(std::abs(a - b), std::abs(a + b));
  return std::abs(a - b);
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

/// The channel's zero is no matter of choice.
bool has_zero(const std::string& name, const std::string& unit) {
  return unit != "m" && unit != "rad" && unit != "1" && name != "energy.gravitational";
}

/// What a channel counts: quaternions are angles, halved.
std::string kind(const ChannelInfo& info) {
  return info.alike == ChannelInfo::Alike::sign ? "rad" : info.unit;
}

/// Lengths and angles that are the tolerance of the start's closing and equilibrium.
double scale_at_start(const std::string& unit, double length) {
  if (unit == "m") return of_start * length;
  return unit == "rad" ? of_start : 0;
}

/// What gravity does in a step, and its thousandth: the iterations do not see what is smaller by far.
double scale_at_rest(const std::string& unit, double step) {
  if (step > 0 && (unit == "m" || unit == "rad")) return of_gravity * step * step;
  if (step > 0 && (unit == "m/s" || unit == "rad/s")) return of_gravity * step;
  return unit == "m/s²" || unit == "rad/s²" ? of_gravity : 0;
}

/// The root mean square, of the scale.
double mean(const Apart& d) { return relative(d.rms_difference, d.scale); }

/// By how much a difference falls, the largest or the mean square's root, whichever falls more.
double best_fall(const Apart& from, const Apart& to) {
  return std::max(fall(from.relative_difference, to.relative_difference).value_or(0),
                  fall(mean(from), mean(to)).value_or(0));
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
  const double step = std::max(a.step, b.step);
  const std::size_t instants = std::min(a.time.size(), b.time.size());
  std::unordered_map<std::string, Eigen::Index> channel_of_b;
  for (std::size_t c = 0; c < b.info.size(); ++c)
    channel_of_b.emplace(b.info[c].name, static_cast<Eigen::Index>(c));
  std::vector<Apart> result;
  std::vector<std::string> kinds;
  std::vector<double> largest;
  double height_energy = 0, energy = 0, length = 0;

  std::map<std::string, double> range_of_unit, largest_of_unit;
  for (std::size_t c = 0; c < a.info.size(); ++c) {
    const auto in_b = channel_of_b.find(a.info[c].name);
    if (in_b == channel_of_b.end() || own(a.info[c].name) || !a.info[c].determined) continue;
    const auto in_a = static_cast<Eigen::Index>(c);
    Apart d;
    d.name = a.info[c].name;
    d.unit = a.info[c].unit;
    Sweep sweep;
    double squares = 0;
    for (std::size_t k = 0; k < instants; ++k) {
      const double of_a = a.channels[k][in_a], of_b = b.channels[k][in_b->second];
      const double apart = distance(of_a, of_b, a.info[c].alike);
      sweep.add(of_a);
      sweep.add(of_b);
      squares += apart * apart;
      if (k > 0 && !larger(apart, d.max_difference)) continue;
      d.max_difference = apart;
      d.time = a.time[k];
    }
    if (instants > 0) d.rms_difference = std::sqrt(squares / static_cast<double>(instants));
    d.range = sweep.range();
    kinds.push_back(kind(a.info[c]));
    double& range = range_of_unit[kinds.back()];
    range = std::max(range, d.range);
    largest.push_back(sweep.largest());
    if (d.name == "energy.gravitational") height_energy = sweep.largest();
    if (d.unit == "J") energy = std::max(energy, has_zero(d.name, d.unit) ? sweep.largest() : d.range);
    if (d.unit == "m") length = std::max(length, sweep.largest());

    if (has_zero(d.name, d.unit)) {
      double& most = largest_of_unit[d.unit];
      most = std::max(most, sweep.largest());
    }
    result.push_back(std::move(d));
  }
  for (std::size_t c = 0; c < result.size(); ++c) {
    Apart& d = result[c];
    d.scale = std::max({d.range, scale_at_rest(kinds[c], step),
                        scale_at_start(kinds[c], std::max(a.length, b.length)),
                        of_unit * range_of_unit[kinds[c]], of_largest * largest[c]});
    if (d.unit == "J") d.scale = std::max(d.scale, of_largest * height_energy);
    // What a joint transmits in directions in which it need not.
    if (d.unit == "N m") d.scale = std::max(d.scale, of_energy * energy);
    if (d.unit == "N" && length > 0) d.scale = std::max(d.scale, of_energy * energy / length);

    if (has_zero(d.name, d.unit))
      d.scale = std::max({d.scale, of_own * largest[c], of_play * largest_of_unit[d.unit]});
    d.relative_difference = relative(d.max_difference, d.scale);
  }
  return result;
}

std::optional<double> Refined::ratio() const {
  if (!half) return {};
  return quarter ? fall(half->relative_difference, quarter->relative_difference)
                 : fall(whole.relative_difference, half->relative_difference);
}

double Refined::step_error() const {
  double most = 0;
  for (const auto& change : step)
    if (change && larger(mean(*change), most)) most = mean(*change);
  return most;
}

bool Refined::together() const {
  if (finest().relative_difference <= agreed) return true;
  if (!half) return false;
  if (!quarter) return best_fall(whole, *half) >= least_fall;
  return best_fall(*half, *quarter) >= least_fall || best_fall(whole, *quarter) >= least_fall * least_fall;
}

bool Refined::settled() const {
  for (std::size_t f = 0; f < step.size(); ++f) {
    if (!step[f] || mean(*step[f]) <= agreed) continue;
    if (!(mean(*step[f]) <= largest_error)) return false;
    // Where a quarter of the step was not made, there was a worse fault to report.
    if (!half_step[f]) continue;
    if (mean(*half_step[f]) > agreed && best_fall(*step[f], *half_step[f]) < least_step_fall) return false;
    if (mean(*step[f]) > large_error && mean(*step[f]) > most_step_fall * mean(*half_step[f])) return false;
  }
  return true;
}

bool Refined::undecided() const {
  if (!half || quarter) return false;
  return finest().relative_difference > agreed || step_error() > agreed;
}

bool Agreement::undecided() const {
  return std::all_of(channels.begin(), channels.end(), [](const Refined& c) { return c.settled(); }) &&
         std::any_of(channels.begin(), channels.end(), [](const Refined& c) { return c.undecided(); });
}

Agreement agreement(const std::vector<Apart>& whole, const std::vector<Apart>& half) {
  Comparison comparison;
  comparison.whole = whole;
  comparison.half = half;
  return agreement(comparison);
}

Agreement agreement(const Comparison& given) {
  Agreement result;
  const auto at = [](const std::vector<Apart>& all, std::size_t c) {
    return all.empty() ? std::nullopt : std::optional(all[c]);
  };
  const auto mean_of_all = [](const std::vector<Apart>& all) {
    double squares = 0;
    for (const Apart& d : all) squares += std::pow(mean(d), 2);
    return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(all.size(), 1)));
  };
  for (std::size_t c = 0; c < given.whole.size(); ++c) {
    Refined channel{given.whole[c], at(given.half, c), at(given.quarter, c), {}, {}};
    for (std::size_t f = 0; f < channel.step.size(); ++f) {
      channel.step[f] = at(given.step[f], c);
      channel.half_step[f] = at(given.half_step[f], c);
    }
    result.agree = result.agree && channel.agrees();
    result.channels.push_back(std::move(channel));
  }
  if (!given.half.empty())
    result.ratio = given.quarter.empty() ? fall(mean_of_all(given.whole), mean_of_all(given.half))
                                         : fall(mean_of_all(given.half), mean_of_all(given.quarter));
  std::stable_sort(result.channels.begin(), result.channels.end(), [](const Refined& a, const Refined& b) {
    if (a.agrees() != b.agrees()) return b.agrees();
    return larger(a.finest().relative_difference, b.finest().relative_difference);
  });
  return result;
}

namespace {

/// "'a', 'b' and 3 more"
std::string names(const std::vector<const Refined*>& channels) {
  std::string text;
  const std::size_t count = std::min(named_channels, channels.size());
  for (std::size_t k = 0; k < count; ++k)
    text += fmt::format("{}'{}'", k == 0 ? "" : ", ", channels[k]->whole.name);
  if (count < channels.size()) text += fmt::format(" and {} more", channels.size() - count);
  return text;
}

/// What a shorter step does to the difference of the formulations.
std::string not_together(const Refined& channel, const char* step) {
  const Apart& d = channel.finest();
  std::string text =
      std::isnan(d.relative_difference)
          ? fmt::format("The formulations disagree: one of them gives no number for '{}' at t = {:.6g} s.",
                        d.name, d.time)
          : fmt::format("The formulations disagree by {} of the range{} ({}).",
                        percent(d.relative_difference), step, where(d));
  if (const auto ratio = channel.ratio())
    text += fmt::format(
        "\nHalf the step makes this difference {}, where two methods of second order for the same equations "
        "would make it 4 times smaller: the step is far too long, or one formulation is wrong; a shorter one "
        "(--step) shows which.",
        *ratio >= 1 ? fmt::format("only {:.3g} times smaller", *ratio)
                    : fmt::format("{:.3g} times larger", 1 / *ratio));
  else if (!channel.half)
    text += "\nWithout the runs with half the step it is not known whether the difference falls with it.";
  return text;
}

/// What a shorter step does to each formulation.
std::string not_settled(const Refined& channel) {
  const Apart* worst = nullptr;
  for (const auto& change : channel.step)
    if (change && (!worst || larger(mean(*change), mean(*worst)))) worst = &*change;
  return fmt::format(
      "The step is too long to trust, in one formulation or both: half of it changes '{}' by {} of the range "
      "(root mean square; at most by {:.3g} {}, at t = {:.6g} s){}.\nTake a shorter step (--step), until "
      "halving it changes little; where "
      "no step does, the motion itself is not determined by the model (a singular position, chaos).",
      worst->name, percent(mean(*worst)), worst->max_difference, worst->unit, worst->time,
      channel.half_step[0] ? ", and a quarter of it does not follow" : "");
}

}  // namespace

std::string verdict(const Agreement& agreement) {
  if (agreement.channels.empty()) return "There is no channel to compare.";
  const Apart& worst = agreement.channels.front().finest();
  const bool halved = agreement.channels.front().half.has_value();
  const char* const step = agreement.channels.front().quarter ? " with a quarter of the step"
                           : halved                           ? " with half the step"
                                                              : "";
  if (!agreement.agree) {
    std::vector<const Refined*> wrong;
    for (const Refined& c : agreement.channels)
      if (!c.agrees()) wrong.push_back(&c);
    const Refined& first = *wrong.front();
    std::string text = first.together() ? not_settled(first) : not_together(first, step);
    if (wrong.size() > 1) text += fmt::format("\n{} channels do not agree: {}.", wrong.size(), names(wrong));
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
        "The formulations come together as the step gets shorter: {} of it leaves {} of the range; the worst "
        "channel is {}.",
        agreement.channels.front().quarter ? "a quarter" : "half", percent(worst.relative_difference),
        where(worst));
  if (!halved) return text;
  if (!agreement.ratio)
    text +=
        "\nThe remaining difference is round-off and the tolerance of the iterations, which a shorter step "
        "does not reduce.";
  else if (*agreement.ratio >= least_fall)
    text += fmt::format(
        "\nHalf the step makes the mean difference of all channels {:.3g} times smaller (second order: 4 "
        "times): "
        "both solve the same equations, and what separates them is the length of the step.",
        *agreement.ratio);
  else
    text += fmt::format(
        "\nHalf the step makes the mean difference of all channels {:.3g} times smaller, and not 4 times "
        "(second order): it is small, but the step is not its only cause (impacts, the tolerance of the "
        "iterations).",
        *agreement.ratio);
  return text;
}

}  // namespace mimbre

#include "mimbre/campbell.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "analysis/modes/mode_likeness.h"
#include "analysis/modes/mode_matching.h"
#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

using Eigen::MatrixXd;
using linear::alike;

constexpr double closest = 1. / 65536;  ///< of the step of the values: how closely crossings are looked at
constexpr int deepest = 26;             ///< halvings between two values
constexpr double no_growth = 1e-9;      ///< of the largest eigenvalue: round-off
constexpr double no_exponent = 1e-7;    ///< of 1/T: that of multipliers
/// Of the value: a line through two places around the one looked for, of which one is so near, is exact.
constexpr double near_enough = 1e-6;
/// Of the speed: how far from the one at which a mode stands still in axes that turn it is looked at: λ²
/// passes zero there, of which round-off takes the root.
constexpr double apart_from_standing = 1e-4;
constexpr int most_rounds = 60;
/// Of the value: how exactly the places are found where real modes meet.
constexpr double meeting_place = 1e-5;
/// Of the way that two eigenvalues go relative to each other: modes that stay so far apart do not veer.
constexpr double far_apart = 0.25;

/// The modes at one value, and the branch that each belongs to.
struct Stand {
  double value = 0;
  std::vector<Mode> modes;
  std::vector<int> branch;  ///< of each mode
  std::vector<int> half;    ///< of each mode the branch of the other half of its pair; -1: it has none
  std::vector<int> drifts;  ///< branches of modes that are drifts here, λ = 0
  int zeros = -1;           ///< LinearisedModes::zeros
  double turn = 0;          ///< 2π/T where λ are known but for multiples of it; 0: they are known
  bool turning = false;     ///< the whole turns: LinearisedModes::turning
};

/// A mode at one value, and a function of it that is sought to be zero.
struct Sought {
  double value = 0;
  Mode mode;
  double f = 0;
};

using SoughtSamples = std::vector<std::pair<double, double>>;  ///< places and f there

/// Where f is zero: by the parabola of the place over f through the last three, or the line through the last
/// two.
double zero_of(const SoughtSamples& all) {
  const auto& [x1, f1] = all[all.size() - 2];
  const auto& [x2, f2] = all.back();
  if (f1 == f2) return std::numeric_limits<double>::quiet_NaN();
  const double line = x2 - f2 * (x2 - x1) / (f2 - f1);
  if (all.size() < 3) return line;
  const auto& [x0, f0] = all[all.size() - 3];
  const double bend = ((x1 - x0) / (f1 - f0) - (x2 - x1) / (f2 - f1)) / (f0 - f2),
               curve = line + bend * f1 * f2;
  return std::abs(curve - line) <= 0.5 * std::abs(line - x2) ? curve : line;
}

/// Whether the ground sees one frequency.
bool seen_from_ground(const Mode& mode) { return mode.fixed == mode.fixed; }

/// 1 or −1: circles the axis about which the whole turns evenly, with it or against it; 0: moves along or
/// about it; 2: else.
int sense_of(const Mode& mode) {
  if (!seen_from_ground(mode) || mode.kind != Mode::Kind::oscillating) return 2;
  return mode.whirl > 0.5 ? 1 : mode.whirl < -0.5 ? -1 : 0;
}

/// The sign says which of two modes is the faster one. Modes that circle in different senses never mix: 0.
double before_or_behind(const Mode& a, const Mode& b, bool turning) {
  if (turning && sense_of(a) != 2 && sense_of(b) != 2)
    return sense_of(a) == sense_of(b) ? a.seen().imag() - b.seen().imag() : 0;
  return a.value.imag() - b.value.imag();
}

class Tracking {
 public:
  Tracking(const ModesAt& modes, const CampbellOptions& options)
      : modes_(modes),
        options_(options),
        most_(options.most > 0 ? static_cast<std::size_t>(options.most) : std::string::npos) {}

  CampbellDiagram run(const std::vector<double>& values) {
    out_.parameter = options_.parameter;
    out_.values = values;
    Stand at = evaluate(values.front());
    const double range = values.back() - values.front();
    // Equal eigenvalues at the beginning take the shapes that they have right behind it.
    if (!linear::clusters_of(at.modes).empty())
      linear::align(at.modes, evaluate(values.front() + 1e-4 * range).modes);
    for (const Mode& mode : at.modes) at.branch.push_back(open(mode));
    at.half.assign(at.modes.size(), -1);
    record(0, at);
    begin(at);
    for (std::size_t k = 1; k < values.size(); ++k) {
      step_ = values[k] - values[k - 1];
      at = follow(std::move(at), evaluate(values[k]), 0);
      record(k, at);
    }
    for (std::size_t b = 0; b < out_.branches.size(); ++b) {
      out_.branches[b].values.resize(values.size(), nowhere());
      out_.branches[b].whirl.resize(values.size(), 0);
      out_.branches[b].half_of.resize(values.size(), -1);
    }
    if (two_frequencies_) show_turning_axes();
    leave_out_neighbours();
    number_names();
    sort_found();
    return std::move(out_);
  }

 private:
  static std::complex<double> nowhere() {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan};
  }

  LinearisedModes modes_at(double value) const {
    try {
      return modes_(value);
    } catch (const InputError&) {
      throw;
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(fmt::format("{} = {:.6g}: {}", options_.parameter, value, error.what()));
    }
  }

  Stand evaluate_once(double value) {
    ++out_.evaluations;
    LinearisedModes found = modes_at(value);
    for (const std::string& warning : found.model.warnings) warn(warning);
    Stand out;
    out.value = value;
    out.modes = std::move(found.modes);
    if (found.period == 0 && found.turning == 0) linear::part_nearly_real(out.modes);
    out.zeros = found.zeros;
    out.turn = found.period > 0 ? 2 * std::numbers::pi / found.period : 0;
    out.turning = found.turning > 0;
    return out;
  }

  /// Modes that stand still; in axes that turn at a critical speed, and else where λ passes zero.
  static std::ptrdiff_t standing(const Stand& s) {
    return std::count_if(s.modes.begin(), s.modes.end(), [&](const Mode& m) {
      return s.turning ? m.kind != Mode::Kind::oscillating : m.kind == Mode::Kind::rigid;
    });
  }

  /// Where a mode stands still that does not do so beside it, it cannot be told from a rigid motion: it is
  /// taken a little beside that value.
  Stand evaluate(double value) {
    Stand at = evaluate_once(value);
    const std::ptrdiff_t now = standing(at), usual = standing_ < 0 ? now - 1 : standing_;
    const double size = std::max(std::abs(value), std::abs(step_));
    if (now > 0 && now > usual)
      for (const double beside : {1e-7, 1e-6, 1e-5}) {
        Stand next = evaluate_once(value + beside * size);
        if (standing(next) > usual) continue;
        at = std::move(next);
        break;
      }
    // Where real modes meet they have one vector.
    const auto met = [](const Stand& s) {
      return s.turn == 0 && !s.turning && std::any_of(s.modes.begin(), s.modes.end(), linear::have_met);
    };
    if (met(at))
      for (const double beside : {1e-9, 1e-8, 1e-7}) {
        Stand next = evaluate_once(value + beside * size);
        if (met(next)) continue;
        at = std::move(next);
        break;
      }
    standing_ = standing(at);
    return at;
  }

  /// Warnings that differ in their numbers alone are one.
  void warn(const std::string& text) {
    const auto words = [](const std::string& t) {
      std::string out;
      char last = ' ';
      for (const char c : t) {
        const bool digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
        const bool of_number = digit || c == '.' || c == '-' || c == '+' || (c == 'e' && last == '0');
        if (!of_number) out += c;
        last = digit || (c == '.' && last == '0') ? '0' : c;
      }
      return out;
    };
    if (std::none_of(out_.warnings.begin(), out_.warnings.end(),
                     [&](const std::string& w) { return words(w) == words(text); }) &&
        out_.warnings.size() < 20)
      out_.warnings.push_back(text);
  }

  int open(const Mode& mode) {
    out_.branches.push_back({mode.text, {}, {}, {}});
    followed_.push_back(false);
    turning_.emplace_back();
    return static_cast<int>(out_.branches.size()) - 1;
  }

  /// Of a rotor that is not round: the ground sees two frequencies of a mode, so that all are listed as in
  /// the axes that turn with it.
  void show_turning_axes() {
    for (std::size_t b = 0; b < out_.branches.size(); ++b) {
      turning_[b].resize(out_.values.size(), nowhere());
      out_.branches[b].values = turning_[b];
    }
    out_.criticals.clear();
    warn(
        "modes of a rotor that is not round have two frequencies from the ground: listed are those in axes "
        "that turn with it, in which a mode stands still (0 rad/s) at a critical speed; critical speeds are "
        "not sought");
  }

  /// Branches that are nowhere among the lowest.
  void leave_out_neighbours() {
    std::vector<int> now(out_.branches.size(), -1);
    int kept = 0;
    for (std::size_t b = 0; b < out_.branches.size(); ++b)
      if (followed_[b]) {
        now[b] = kept;
        std::swap(out_.branches[static_cast<std::size_t>(kept++)], out_.branches[b]);
      }
    out_.branches.resize(static_cast<std::size_t>(kept));
    const auto rename = [&](auto& found) {
      for (auto& one : found) one.branch = now[static_cast<std::size_t>(one.branch)];
      std::erase_if(found, [](const auto& one) { return one.branch < 0; });
    };
    rename(out_.criticals);
    rename(out_.onsets);
    const auto renamed = [&](int& branch) {
      branch = branch < 0 ? -1 : now[static_cast<std::size_t>(branch)];
    };
    for (ModeBranch& branch : out_.branches)
      std::for_each(branch.half_of.begin(), branch.half_of.end(), renamed);
    for (CampbellDiagram::Meeting& meeting : out_.meetings) {
      renamed(meeting.first);
      renamed(meeting.second);
    }
    std::erase_if(out_.meetings,
                  [](const CampbellDiagram::Meeting& m) { return m.first < 0 || m.second < 0; });
  }

  void record(std::size_t k, const Stand& at) {
    recorded_ = k + 1;
    for (std::size_t i = 0; i < at.modes.size(); ++i) {
      ModeBranch& b = out_.branches[static_cast<std::size_t>(at.branch[i])];
      b.values.resize(k + 1, nowhere());
      b.whirl.resize(k + 1, 0);
      b.values[k] = at.modes[i].seen();
      b.whirl[k] = at.modes[i].whirl;
      std::vector<std::complex<double>>& turning = turning_[static_cast<std::size_t>(at.branch[i])];
      turning.resize(k + 1, nowhere());
      turning[k] = at.modes[i].value;
      two_frequencies_ = two_frequencies_ || (at.turning && at.modes[i].kind == Mode::Kind::oscillating &&
                                              !seen_from_ground(at.modes[i]));
      if (b.name.empty()) b.name = at.modes[i].text;
      if (i < most_) followed_[static_cast<std::size_t>(at.branch[i])] = true;
      if (const int half = at.half[i]; half >= 0) {
        put(k, half, std::conj(at.modes[i].seen()), at.branch[i]);
        if (i < most_) followed_[static_cast<std::size_t>(half)] = true;
      }
    }
    for (const int branch : at.drifts) put(k, branch, 0, -1);
  }

  /// λ of a branch without a mode of its own. Such branches are those of constant coefficients.
  void put(std::size_t k, int branch, std::complex<double> value, int half_of) {
    ModeBranch& b = out_.branches[static_cast<std::size_t>(branch)];
    b.values.resize(k + 1, nowhere());
    b.whirl.resize(k + 1, 0);
    b.half_of.resize(k + 1, -1);
    b.values[k] = value;
    b.half_of[k] = half_of;
    std::vector<std::complex<double>>& turning = turning_[static_cast<std::size_t>(branch)];
    turning.resize(k + 1, nowhere());
    turning[k] = value;
  }

  /// A branch of a mode that is seen for the first time as one of two, or as no drift any longer: it had the
  /// conjugate of the pair's values so far, or zeros.
  int open_late(const Mode& mode, int pair) {
    const int branch = open(mode);
    for (std::size_t k = 0; k < recorded_; ++k) {
      const auto value = pair < 0 ? std::complex<double>(0) : [&] {
        const auto& values = out_.branches[static_cast<std::size_t>(pair)].values;
        return k < values.size() && values[k].imag() > 0 ? std::conj(values[k]) : nowhere();
      }();
      put(k, branch, value, std::isfinite(value.real()) ? pair : -1);
    }
    return branch;
  }

  /// By the differences of two eigenvalues at both values: modes of which one is damped more throughout
  /// exchange their shapes only by a coupling as large, which then shows at the values.
  static bool may_veer(std::complex<double> before, std::complex<double> after) {
    const std::complex<double> way = after - before;
    const double share = std::clamp(-std::real(std::conj(way) * before) / std::norm(way), 0.0, 1.0);
    return std::abs(before + share * way) <= far_apart * std::abs(way);
  }

  /// Where two modes, one of which is followed, exchange their order between the values, by straight lines.
  std::optional<double> crossing(const Stand& a, const Stand& b, const std::vector<int>& pair) const {
    const bool turning = a.turning && b.turning;
    for (std::size_t i = 0; i < pair.size(); ++i)
      for (std::size_t j = 0; j < std::min(i, most_); ++j) {
        if (pair[i] < 0 || pair[j] < 0) continue;
        const Mode &first = a.modes[static_cast<std::size_t>(pair[i])],
                   &second = a.modes[static_cast<std::size_t>(pair[j])];
        const double before = before_or_behind(first, second, turning),
                     after = before_or_behind(b.modes[i], b.modes[j], turning);
        if (before * after < 0 && may_veer(first.value - second.value, b.modes[i].value - b.modes[j].value))
          return a.value + (b.value - a.value) * before / (before - after);
      }
    return std::nullopt;
  }

  Stand follow(Stand from, Stand to, int depth) {
    linear::align(to.modes, from.modes);
    linear::Matching matching = linear::match_modes({from.modes, from.zeros}, {to.modes, to.zeros}, most_);
    std::vector<int>& pair = matching.pair;
    const bool certain = matching.certain;
    for (std::size_t j = 0; j < to.modes.size(); ++j)
      if (pair[j] >= 0)
        linear::go_on_from(from.modes[static_cast<std::size_t>(pair[j])], to.turn, to.modes[j]);
    const double width = to.value - from.value, share = width / step_;
    if (depth < deepest && out_.evaluations < options_.most_evaluations) {
      // A crossing may be a veering narrower than the interval: it is looked at more closely, where it is.
      if (const std::optional<double> cross = crossing(from, to, pair);
          certain && cross && share > 1.01 * closest)
        return follow_around(*cross, step_ * std::max(share * share / 16, closest / 2), std::move(from),
                             std::move(to), depth);
      // Modes that come together on the real axis part there for good: no halving makes that smooth.
      if (!certain && (from.modes.size() == to.modes.size() || depth < 8))
        return follow_around(0.5 * (from.value + to.value), 0, std::move(from), std::move(to), depth);
    }
    if (!certain) {
      growing_goes_on(from, to, pair);
      if (from.modes.size() == to.modes.size())
        warn(fmt::format("near {} = {:.6g} modes could not be distinguished for certain", options_.parameter,
                         to.value));
    }
    assign_branches(from, matching, to);
    look_between(from, to, matching);
    before_ = std::move(from);
    return to;
  }

  void assign_branches(const Stand& from, const linear::Matching& matching, Stand& to) {
    to.branch.assign(to.modes.size(), -1);
    to.half.assign(to.modes.size(), -1);
    to.drifts = from.drifts;
    for (std::size_t j = 0; j < to.modes.size(); ++j)
      if (const int i = matching.pair[j]; i >= 0) {
        to.branch[j] = from.branch[static_cast<std::size_t>(i)];
        if (to.modes[j].kind == Mode::Kind::oscillating) to.half[j] = from.half[static_cast<std::size_t>(i)];
      }
    for (const linear::Meeting& m : matching.meet)
      to.half[static_cast<std::size_t>(m.pair)] = from.branch[static_cast<std::size_t>(m.fast)];
    for (const linear::Meeting& m : matching.part) {
      const auto pair = static_cast<std::size_t>(m.pair), fast = static_cast<std::size_t>(m.fast);
      to.branch[fast] = from.half[pair] >= 0 ? from.half[pair] : open_late(to.modes[fast], from.branch[pair]);
    }
    if (matching.stops >= 0) to.drifts.push_back(from.branch[static_cast<std::size_t>(matching.stops)]);
    if (matching.starts >= 0) {
      int& branch = to.branch[static_cast<std::size_t>(matching.starts)];
      branch = to.drifts.empty() ? open_late(to.modes[static_cast<std::size_t>(matching.starts)], -1)
                                 : to.drifts.back();
      if (!to.drifts.empty()) to.drifts.pop_back();
    }
    for (std::size_t j = 0; j < to.modes.size(); ++j)
      if (to.branch[j] < 0) to.branch[j] = open(to.modes[j]);
  }

  /// Where two modes meet their shapes are one: the one that grows goes on as the one that does.
  static void growing_goes_on(const Stand& from, const Stand& to, std::vector<int>& pair) {
    const double none = largest_round_off(from, to);
    const auto grew = [&](std::size_t j) {
      return pair[j] >= 0 && from.modes[static_cast<std::size_t>(pair[j])].value.real() > none;
    };
    for (std::size_t j = 0; j < pair.size(); ++j) {
      if (!grew(j) || to.modes[j].value.real() > none) continue;
      for (std::size_t k = 0; k < pair.size(); ++k)
        if (!grew(k) && to.modes[k].value.real() > none &&
            alike(from.modes[static_cast<std::size_t>(pair[j])], to.modes[k]) > 0.3) {
          std::swap(pair[j], pair[k]);
          break;
        }
    }
  }

  /// In parts: up to a place, so far around it, and from there on.
  Stand follow_around(double place, double around, Stand from, Stand to, int depth) {
    const double first = place - around, second = place + around, end = to.value;
    if (first > from.value) {
      Stand next = evaluate(first);
      from = follow(std::move(from), std::move(next), depth + 1);
    }
    if (around > 0 && second < end) {
      Stand next = evaluate(second);
      from = follow(std::move(from), std::move(next), depth + 1);
    }
    return follow(std::move(from), std::move(to), depth + 1);
  }

  void number_names() {
    for (std::size_t i = 0; i < out_.branches.size(); ++i) {
      int same = 1;
      for (std::size_t j = 0; j < i; ++j) same += out_.branches[j].name == out_.branches[i].name ? 1 : 0;
      if (same > 1) out_.branches[i].name += fmt::format(" ({})", same);
    }
  }

  void begin(const Stand& at) {
    oscillated_.resize(out_.branches.size());
    for (std::size_t i = 0; i < at.modes.size(); ++i) keep(at.value, at.modes[i], at.branch[i]);
  }

  /// Where the mode has a frequency.
  void keep(double value, const Mode& mode, int branch) {
    if (options_.rad_per_second > 0 && mode.kind == Mode::Kind::oscillating && mode.seen().imag() > 0)
      oscillated_[static_cast<std::size_t>(branch)] = Sought{value, mode};
  }

  /// Criticals, onsets and meetings between two values, of which no more are needed to follow the modes.
  void look_between(const Stand& from, const Stand& to, const linear::Matching& matching) {
    const std::vector<int>& pair = matching.pair;
    oscillated_.resize(out_.branches.size());
    // Real modes that meet, which all decay or all grow, and drifts.
    std::vector<char> known_from(from.modes.size(), 0), known(to.modes.size(), 0);
    for (const linear::Meeting& m : matching.meet) {
      known[static_cast<std::size_t>(m.pair)] = known_from[static_cast<std::size_t>(m.slow)] =
          known_from[static_cast<std::size_t>(m.fast)] = 1;
      find_meeting(from, to, m, false);
    }
    for (const linear::Meeting& m : matching.part) {
      known_from[static_cast<std::size_t>(m.pair)] = known[static_cast<std::size_t>(m.slow)] =
          known[static_cast<std::size_t>(m.fast)] = 1;
      find_meeting(from, to, m, true);
      oscillated_[static_cast<std::size_t>(from.branch[static_cast<std::size_t>(m.pair)])].reset();
    }
    if (matching.stops >= 0) known_from[static_cast<std::size_t>(matching.stops)] = 1;
    if (matching.starts >= 0) known[static_cast<std::size_t>(matching.starts)] = 1;
    for (std::size_t j = 0; j < to.modes.size(); ++j) {
      if (options_.rad_per_second > 0) look_for_criticals(to.value, to.modes[j], to.branch[j], to.turning);
      keep(to.value, to.modes[j], to.branch[j]);
    }
    const double none = largest_round_off(from, to);
    std::vector<char> goes_on(from.modes.size(), 0);
    for (std::size_t j = 0; j < to.modes.size(); ++j) {
      if (known[j] != 0) continue;
      int i = pair[j];
      if (i >= 0) goes_on[static_cast<std::size_t>(i)] = 1;
      // One of two into which a mode parts.
      if (i < 0) i = nearest_to(to.modes[j], from.modes);
      if (i < 0) continue;
      const Mode& before = from.modes[static_cast<std::size_t>(i)];
      look_for_onset(from.value, before, to.value, to.modes[j], to.branch[j], none);
      if (pair[j] >= 0)
        look_for_dip(from.value, before, from.branch[static_cast<std::size_t>(i)], to, j, none);
    }
    for (std::size_t i = 0; i < from.modes.size(); ++i)
      if (const int j = goes_on[i] != 0 || known_from[i] != 0 ? -1 : nearest_to(from.modes[i], to.modes);
          j >= 0)
        look_for_onset(from.value, from.modes[i], to.value, to.modes[static_cast<std::size_t>(j)],
                       from.branch[i], none);
  }

  /// By secants or parabolas over (λ₁ − λ₂)².
  void find_meeting(const Stand& from, const Stand& to, const linear::Meeting& m, bool parts) {
    const Stand &two = parts ? to : from, &one = parts ? from : to;
    const auto mode_of = [](const Stand& s, int k) -> const Mode& {
      return s.modes[static_cast<std::size_t>(k)];
    };
    const Mode& pair = mode_of(one, m.pair);
    const linear::MeetingValues apart = linear::of_two(mode_of(two, m.slow), mode_of(two, m.fast)),
                                joined = linear::of_pair(pair);
    SoughtSamples samples{{two.value, apart.difference_squared}, {one.value, joined.difference_squared}};
    double low = from.value, high = to.value, place = one.value, real = joined.mean;
    for (int round = 0; round < most_rounds && out_.evaluations < options_.most_evaluations; ++round) {
      const double size = std::max(std::abs(low), std::abs(high)), before = place;
      place = zero_of(samples);
      if (!(place > low && place < high)) place = 0.5 * (low + high);
      if (std::abs(place - before) <= meeting_place * size || high - low <= meeting_place * size) break;
      const std::optional<linear::MeetingValues> there =
          linear::meeting_values(pair, evaluate_once(place).modes);
      if (!there) {
        place = 0.5 * (low + high);
        warn(fmt::format("two modes meet between {} = {:.6g} and {:.6g}", options_.parameter, low, high));
        break;
      }
      real = there->mean;
      samples.emplace_back(place, there->difference_squared);
      ((there->difference_squared > 0) == parts ? high : low) = place;
    }
    out_.meetings.push_back(
        {one.branch[static_cast<std::size_t>(m.pair)],
         parts ? to.branch[static_cast<std::size_t>(m.fast)] : from.branch[static_cast<std::size_t>(m.fast)],
         place, real, parts});
  }

  static int nearest_to(const Mode& mode, const std::vector<Mode>& modes) {
    int nearest = -1;
    double best = 0.3;
    for (std::size_t k = 0; k < modes.size(); ++k)
      if (const double how = alike(mode, modes[k]); how > best) {
        best = how;
        nearest = static_cast<int>(k);
      }
    return nearest;
  }

  static double largest_round_off(const Stand& a, const Stand& b) {
    double largest = 0;
    for (const Stand* stand : {&a, &b})
      for (const Mode& mode : stand->modes) largest = std::max(largest, std::abs(mode.value));
    return std::max(no_growth * largest, no_exponent * std::max(a.turn, b.turn) / (2 * std::numbers::pi));
  }

  /// The mode at a value that goes on from one or comes to be the other, the one with the largest `prefer` of
  /// those that are nearly as alike.
  template <class Prefer>
  std::optional<Mode> mode_between(double value, const Mode& low, const Mode& high, double share,
                                   const Prefer& prefer) {
    Stand there = evaluate(value);
    std::vector<double> how;
    double best = 0;
    for (const Mode& mode : there.modes) {
      how.push_back(std::max(alike(low, mode), alike(high, mode)));
      best = std::max(best, how.back());
    }
    if (best < 0.5) return std::nullopt;
    std::size_t chosen = there.modes.size();
    for (std::size_t k = 0; k < how.size(); ++k)
      if (how[k] > 0.5 * best &&
          (chosen == how.size() || prefer(how[k], there.modes[k]) > prefer(how[chosen], there.modes[chosen])))
        chosen = k;
    Mode mode = std::move(there.modes[chosen]);
    linear::go_on_from(share < 0.5 ? low : high, there.turn, mode);
    return mode;
  }

  /// Between two places with f of different signs the one where it is zero: by a curve through the last
  /// places, or by halves where f is none. The places become those next to it. `apart`: a share of the value,
  /// within which of the place sought f is not exact.
  template <class F, class Prefer>
  double zero_between(Sought& low, Sought& high, bool by_halves, double apart, const F& f,
                      const Prefer& prefer) {
    low.f = f(low.mode, low.value);
    high.f = f(high.mode, high.value);
    const bool rises = high.f > low.f;
    SoughtSamples samples{{low.value, low.f}, {high.value, high.f}};
    if (std::abs(low.f) < std::abs(high.f)) std::swap(samples[0], samples[1]);
    double place = samples[1].first, off = apart;
    bool found = false;
    for (int round = 0; round < most_rounds && out_.evaluations < options_.most_evaluations; ++round) {
      const double width = high.value - low.value, size = std::max(std::abs(low.value), std::abs(high.value)),
                   before = apart > 0 ? place : samples.back().first;
      place = by_halves ? low.value + 0.5 * width : zero_of(samples);
      if (!(place >= low.value - 10 * apart * size && place <= high.value + 10 * apart * size))
        place = low.value + 0.5 * width;
      found = width <= 1e-3 * near_enough * size ||
              (!by_halves && std::abs(place - before) <= near_enough * size && (apart == 0 || round >= 3));
      if (found) break;
      std::optional<Sought> here;
      const double towards = high.value - place > place - low.value ? 1 : -1;
      // Where λ cannot be told there, a little beside it.
      for (const double share : {0., 1e-4, 1e-3, 1e-2, 1e-1}) {
        const double beside = place + towards * (share * width + off * size);
        std::optional<Mode> mode =
            mode_between(beside, low.mode, high.mode, (beside - low.value) / width, prefer);
        if (mode) here = Sought{beside, *mode, f(*mode, beside)};
        if (here && std::isfinite(here->f)) break;
        here.reset();
      }
      if (!here) break;
      off *= 2;
      samples.emplace_back(here->value, here->f);
      if (here->value > low.value && here->value < high.value) ((here->f > 0) == rises ? high : low) = *here;
    }
    if (!found && high.value - low.value > near_enough * std::abs(place))
      warn(fmt::format("what is found at {} = {:.6g} is known only to lie between {:.6g} and {:.6g}",
                       options_.parameter, place, low.value, high.value));
    return place;
  }

  void look_for_criticals(double value, const Mode& mode, int branch, bool turning) {
    const std::optional<Sought>& last = oscillated_[static_cast<std::size_t>(branch)];
    if (!last || mode.kind != Mode::Kind::oscillating || !(mode.seen().imag() > 0)) return;
    // Those seen from the ground and those in axes that turn are no one function.
    const bool ground = seen_from_ground(mode);
    if (seen_from_ground(last->mode) != ground) return;
    for (const double order : options_.orders) {
      const auto f = [&](const Mode& m, double at) {
        if (seen_from_ground(m) != ground || m.kind != Mode::Kind::oscillating)
          return std::numeric_limits<double>::quiet_NaN();
        return m.seen().imag() - order * options_.rad_per_second * std::abs(at);
      };
      if ((f(last->mode, last->value) > 0) == (f(mode, value) > 0)) continue;
      Sought low = *last, high{value, mode};
      const double place = zero_between(low, high, false, turning && ground ? apart_from_standing : 0, f,
                                        [](double how, const Mode&) { return how; });
      out_.criticals.push_back({branch, place, order, order * options_.rad_per_second * std::abs(place)});
    }
  }

  /// `none`: growth that is round-off.
  void look_for_onset(double from, const Mode& first, double to, const Mode& second, int branch,
                      double none) {
    const double a = first.value.real(), b = second.value.real();
    const bool grew = a > none, grows = b > none;
    if (grew == grows) return;
    Sought low{from, first}, high{to, second};
    // Without damping modes grow all at once, by the square root of the distance.
    const bool neutral = std::min(std::abs(a), std::abs(b)) <= 10 * none;
    const double offset = neutral ? none : 0;
    const double place = zero_between(
        low, high, neutral, 0, [&](const Mode& m, double) { return m.value.real() - offset; },
        [](double, const Mode& m) { return m.value.real(); });
    const Mode& growing = grows ? high.mode : low.mode;
    for (const CampbellDiagram::Onset& o : out_.onsets)
      if (o.branch == branch && o.grows == grows &&
          std::abs(o.value - place) <= near_enough * std::abs(place))
        return;
    double frequency = growing.seen().imag();
    // Next to an onset without damping only the one that grows is a straight line.
    if (!neutral && high.value > low.value)
      frequency += (grows ? place - high.value : place - low.value) / (high.value - low.value) *
                   (high.mode.seen().imag() - low.mode.seen().imag());
    out_.onsets.push_back({branch, place, std::abs(frequency), grows});
  }

  /// A mode that is damped least between three values, and nearly not: whether it grows for a while.
  void look_for_dip(double middle, const Mode& mode, int branch, const Stand& to, std::size_t j,
                    double none) {
    const auto at = std::find(before_.branch.begin(), before_.branch.end(), branch);
    if (at == before_.branch.end()) return;
    const Mode &first = before_.modes[static_cast<std::size_t>(at - before_.branch.begin())],
               &third = to.modes[j];
    const auto growth = [](const Mode& m) { return m.value.real(); };
    const auto [least, most] = std::minmax({growth(first), growth(mode), growth(third)});
    // Nothing is damped, or a value of the three shows that it grows.
    if (most > none || most - least <= 10 * none) return;
    Sought a{before_.value, first, growth(first)}, b{middle, mode, growth(mode)},
        c{to.value, third, growth(third)};
    for (int round = 0; round < 4; ++round) {
      // The top of the parabola through them.
      const double left = (b.f - a.f) / (b.value - a.value), right = (c.f - b.f) / (c.value - b.value),
                   bend = (right - left) / (c.value - a.value),
                   top = 0.5 * (a.value + b.value) - left / (2 * bend),
                   height = b.f - bend * (top - b.value) * (top - b.value),
                   highest = std::max({a.f, b.f, c.f});
      if (!(bend < 0 && top > a.value && top < c.value) || !(height > 0.5 * std::min(highest, 0.)) ||
          std::abs(top - b.value) <= 1e-6 * (c.value - a.value))
        return;
      const bool behind = top > b.value;
      const std::optional<Mode> there =
          mode_between(top, behind ? b.mode : a.mode, behind ? c.mode : b.mode, behind ? 0 : 1,
                       [&](double, const Mode& m) { return growth(m); });
      if (!there) return;
      if (growth(*there) > none) {
        const Sought &low = behind ? b : a, &high = behind ? c : b;
        look_for_onset(low.value, low.mode, top, *there, branch, none);
        look_for_onset(top, *there, high.value, high.mode, branch, none);
        return;
      }
      if (!(growth(*there) > highest)) return;
      (behind ? a : c) = std::move(b);
      b = Sought{top, *there, growth(*there)};
    }
  }

  void sort_found() {
    const auto first = [](const auto& a, const auto& b) { return a.value < b.value; };
    std::stable_sort(out_.criticals.begin(), out_.criticals.end(), first);
    std::stable_sort(out_.onsets.begin(), out_.onsets.end(), first);
    std::stable_sort(out_.meetings.begin(), out_.meetings.end(), first);
  }
  const ModesAt& modes_;
  const CampbellOptions& options_;
  const std::size_t most_;                                  ///< of the modes at one value, in their order
  std::vector<bool> followed_;                              ///< by branch: it is somewhere among them
  std::vector<std::vector<std::complex<double>>> turning_;  ///< by branch: λ in axes that turn, by value
  bool two_frequencies_ = false;                            ///< from the ground, of some mode
  std::size_t recorded_ = 0;                                ///< values
  double step_ = 0;                                         ///< of the values, where it is now
  std::ptrdiff_t standing_ = -1;                            ///< at the last value; −1: not known
  Stand before_;                                            ///< the one before the interval that is looked at
  std::vector<std::optional<Sought>> oscillated_;           ///< by branch: where it last did
  CampbellDiagram out_;
};

}  // namespace

CampbellDiagram campbell(const ModesAt& modes, const std::vector<double>& values,
                         const CampbellOptions& options) {
  if (values.size() < 2 ||
      !std::is_sorted(values.begin(), values.end(), [](double a, double b) { return a <= b; }) ||
      !std::isfinite(values.front()) || !std::isfinite(values.back()))
    throw std::invalid_argument(
        "campbell: two or more finite values, each larger than the one before, are needed");
  return Tracking(modes, options).run(values);
}

LinearisedModes NeighbouringModes::find(double value, std::shared_ptr<const Model> model,
                                        ModesOptions options) {
  if (options.linear.point.at == LinearPoint::At::trim && !driving_.empty()) {
    auto nearest = driving_.lower_bound(value);
    if (nearest == driving_.end() ||
        (nearest != driving_.begin() && value - std::prev(nearest)->first < nearest->first - value))
      --nearest;
    options.linear.trim_near = nearest->second;
  }
  options.linear.independent = independent_;
  LinearisedModes found = find_modes(std::move(model), options);
  if (independent_.velocities.empty()) independent_ = found.model.independent;
  if (found.model.driving) driving_[value] = found.model.driving;
  return found;
}

int with_neighbours(int most) { return most > 0 ? most + std::max(4, most / 5) : 0; }

ModesSolver one_solver(const ModesBy& modes, double first, double last, ModesSolver asked) {
  if (asked != ModesSolver::automatic) return asked;
  const bool sparse = modes(first, asked).sparse && modes(last, asked).sparse;
  return sparse ? ModesSolver::sparse : ModesSolver::dense;
}

}  // namespace mimbre

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
#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

using Eigen::MatrixXd;
using linear::alike;

constexpr double sure = 0.85;           ///< how alike the shapes of one mode are from value to value
constexpr double other = 0.4;           ///< and those of two at most
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

/// The modes at one value, and the branch that each belongs to.
struct Stand {
  double value = 0;
  std::vector<Mode> modes;
  std::vector<int> branch;  ///< of each mode
  double turn = 0;          ///< 2π/T where λ are known but for multiples of it; 0: they are known
  bool turning = false;     ///< the whole turns: LinearisedModes::turning
};

/// A mode at one value, and a function of it that is sought to be zero.
struct Place {
  double value = 0;
  Mode mode;
  double f = 0;
};

using Samples = std::vector<std::pair<double, double>>;  ///< places and f there

/// Where f is zero: by the parabola of the place over f through the last three, or the line through the last
/// two.
double zero_of(const Samples& all) {
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
    return {value,
            std::move(found.modes),
            {},
            found.period > 0 ? 2 * std::numbers::pi / found.period : 0,
            found.turning > 0};
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
    out_.branches.push_back({mode.text, {}, {}});
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
  }

  void record(std::size_t k, const Stand& at) {
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
    }
  }

  /// Pairs of modes; −1: none. False where it is not sure for those that are followed.
  bool match(const Stand& a, const Stand& b, std::vector<int>& pair) const {
    const auto n = static_cast<Eigen::Index>(a.modes.size()), m = static_cast<Eigen::Index>(b.modes.size());
    MatrixXd score(n, m);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < m; ++j)
        score(i, j) = alike(a.modes[static_cast<std::size_t>(i)], b.modes[static_cast<std::size_t>(j)]);
    pair.assign(static_cast<std::size_t>(m), -1);
    const auto followed = [this](Eigen::Index k) { return static_cast<std::size_t>(k) < most_; };
    bool good = n == m || options_.most > 0;
    std::size_t sure_of_a = 0, sure_of_b = 0;
    MatrixXd left = score;
    // The best pair first.
    for (Eigen::Index k = 0; k < std::min(n, m); ++k) {
      Eigen::Index i = 0, j = 0;
      const double best = left.maxCoeff(&i, &j);
      if (best < 0.3) break;
      double second = 0;
      for (Eigen::Index c = 0; c < m; ++c)
        if (c != j) second = std::max(second, score(i, c));
      for (Eigen::Index r = 0; r < n; ++r)
        if (r != i) second = std::max(second, score(r, j));
      const bool is_sure = best >= sure && second <= other;
      good = good && (is_sure || (!followed(i) && !followed(j)));
      sure_of_a += is_sure && followed(i) ? 1 : 0;
      sure_of_b += is_sure && followed(j) ? 1 : 0;
      pair[static_cast<std::size_t>(j)] = static_cast<int>(i);
      left.row(i).setConstant(-1);
      left.col(j).setConstant(-1);
    }
    return good && sure_of_a == std::min(most_, a.modes.size()) &&
           sure_of_b == std::min(most_, b.modes.size());
  }

  /// Where two modes, one of which is followed, exchange their order between the values, by straight lines.
  std::optional<double> crossing(const Stand& a, const Stand& b, const std::vector<int>& pair) const {
    const bool turning = a.turning && b.turning;
    for (std::size_t i = 0; i < pair.size(); ++i)
      for (std::size_t j = 0; j < std::min(i, most_); ++j) {
        if (pair[i] < 0 || pair[j] < 0) continue;
        const double before = before_or_behind(a.modes[static_cast<std::size_t>(pair[i])],
                                               a.modes[static_cast<std::size_t>(pair[j])], turning),
                     after = before_or_behind(b.modes[i], b.modes[j], turning);
        if (before * after < 0) return a.value + (b.value - a.value) * before / (before - after);
      }
    return std::nullopt;
  }

  Stand follow(Stand from, Stand to, int depth) {
    linear::align(to.modes, from.modes);
    std::vector<int> pair;
    const bool certain = match(from, to, pair);
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
    to.branch.clear();
    for (std::size_t j = 0; j < to.modes.size(); ++j)
      to.branch.push_back(pair[j] >= 0 ? from.branch[static_cast<std::size_t>(pair[j])] : open(to.modes[j]));
    look_between(from, to, pair);
    before_ = std::move(from);
    return to;
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
      oscillated_[static_cast<std::size_t>(branch)] = Place{value, mode};
  }

  /// Criticals and onsets between two values, of which no more are needed to follow the modes.
  void look_between(const Stand& from, const Stand& to, const std::vector<int>& pair) {
    oscillated_.resize(out_.branches.size());
    for (std::size_t j = 0; j < to.modes.size(); ++j) {
      if (options_.rad_per_second > 0) look_for_criticals(to.value, to.modes[j], to.branch[j], to.turning);
      keep(to.value, to.modes[j], to.branch[j]);
    }
    const double none = largest_round_off(from, to);
    std::vector<char> goes_on(from.modes.size(), 0);
    for (std::size_t j = 0; j < to.modes.size(); ++j) {
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
      if (const int j = goes_on[i] != 0 ? -1 : nearest_to(from.modes[i], to.modes); j >= 0)
        look_for_onset(from.value, from.modes[i], to.value, to.modes[static_cast<std::size_t>(j)],
                       from.branch[i], none);
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
  double zero_between(Place& low, Place& high, bool by_halves, double apart, const F& f,
                      const Prefer& prefer) {
    low.f = f(low.mode, low.value);
    high.f = f(high.mode, high.value);
    const bool rises = high.f > low.f;
    Samples samples{{low.value, low.f}, {high.value, high.f}};
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
      std::optional<Place> here;
      const double towards = high.value - place > place - low.value ? 1 : -1;
      // Where λ cannot be told there, a little beside it.
      for (const double share : {0., 1e-4, 1e-3, 1e-2, 1e-1}) {
        const double beside = place + towards * (share * width + off * size);
        std::optional<Mode> mode =
            mode_between(beside, low.mode, high.mode, (beside - low.value) / width, prefer);
        if (mode) here = Place{beside, *mode, f(*mode, beside)};
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
    const std::optional<Place>& last = oscillated_[static_cast<std::size_t>(branch)];
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
      Place low = *last, high{value, mode};
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
    Place low{from, first}, high{to, second};
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
    Place a{before_.value, first, growth(first)}, b{middle, mode, growth(mode)},
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
        const Place &low = behind ? b : a, &high = behind ? c : b;
        look_for_onset(low.value, low.mode, top, *there, branch, none);
        look_for_onset(top, *there, high.value, high.mode, branch, none);
        return;
      }
      if (!(growth(*there) > highest)) return;
      (behind ? a : c) = std::move(b);
      b = Place{top, *there, growth(*there)};
    }
  }

  void sort_found() {
    const auto first = [](const auto& a, const auto& b) { return a.value < b.value; };
    std::stable_sort(out_.criticals.begin(), out_.criticals.end(), first);
    std::stable_sort(out_.onsets.begin(), out_.onsets.end(), first);
  }
  const ModesAt& modes_;
  const CampbellOptions& options_;
  const std::size_t most_;                                  ///< of the modes at one value, in their order
  std::vector<bool> followed_;                              ///< by branch: it is somewhere among them
  std::vector<std::vector<std::complex<double>>> turning_;  ///< by branch: λ in axes that turn, by value
  bool two_frequencies_ = false;                            ///< from the ground, of some mode
  double step_ = 0;                                         ///< of the values, where it is now
  std::ptrdiff_t standing_ = -1;                            ///< at the last value; −1: not known
  Stand before_;                                            ///< the one before the interval that is looked at
  std::vector<std::optional<Place>> oscillated_;            ///< by branch: where it last did
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
  LinearisedModes found = find_modes(std::move(model), options);
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

#include "mimbre/campbell.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "math/once/general_eigen.h"

namespace mimbre {
namespace {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;

constexpr double sure = 0.85;        ///< how alike the shapes of one mode are from value to value
constexpr double other = 0.4;        ///< and those of two at most
constexpr double same_place = 1e-7;  ///< of the larger eigenvalue: equal ones
constexpr int closest = 16;          ///< halvings where two modes cross
constexpr int deepest = 26;          ///< halvings between two values
/// Of a function between two values: its share at one side of that at the other, and halvings then.
constexpr double nearly_zero = 1e-3;
constexpr int halvings = 30;

/// The modes at one value, in the order of the branches; -1: a branch that is not there.
struct Stand {
  double value = 0;
  std::vector<Mode> modes;
  std::vector<int> branch;  ///< of each mode
  double turn = 0;          ///< 2π/T where λ are known but for multiples of it; 0: they are known
};

bool comparable(const Mode& a, const Mode& b) {
  return a.shape.size() == b.shape.size() && a.left.size() == b.left.size();
}

/// 1: the same shape; 0: another one.
double alike(const Mode& a, const Mode& b) {
  if (!comparable(a, b)) {
    const std::complex<double> product = a.motion.dot(b.motion);
    return std::abs(product) / (a.motion.norm() * b.motion.norm() + 1e-300);
  }
  const bool rigid = a.kind == Mode::Kind::rigid;
  if (rigid != (b.kind == Mode::Kind::rigid)) return 0;
  if (rigid) return std::abs(a.shape.dot(b.shape)) / (a.shape.norm() * b.shape.norm() + 1e-300);
  const auto with = [&](const Eigen::VectorXcd& shape, const Eigen::VectorXcd& left) {
    return std::sqrt(std::abs(a.left.dot(shape)) * std::abs(left.dot(a.shape)));
  };
  // In axes that turn, λ may go through the real axis: its conjugate is the one that is listed then.
  return std::max(with(b.shape, b.left), with(b.shape.conjugate(), b.left.conjugate()));
}

/// λ + i k turn that is nearest to another one.
std::complex<double> nearest_multiple(std::complex<double> value, double turn, std::complex<double> to) {
  if (!(turn > 0)) return value;
  return {value.real(), value.imag() + turn * std::round((to.imag() - value.imag()) / turn)};
}

/// Of exponents that are known but for multiples the one that goes on from a mode, or that of the conjugate.
void go_on_from(const Mode& from, double turn, Mode& to) {
  if (!(turn > 0) || to.kind == Mode::Kind::rigid || !comparable(from, to)) return;
  if (std::abs(from.left.dot(to.shape.conjugate())) > std::abs(from.left.dot(to.shape))) {
    to.value = std::conj(to.value);
    for (Eigen::VectorXcd* x : {&to.shape, &to.left, &to.motion}) *x = x->conjugate().eval();
  }
  to.value = nearest_multiple(to.value, turn, from.value);
  to.fixed = to.value;
  to.frequency = std::abs(to.value) / (2 * std::numbers::pi);
  to.damped = to.value.imag() / (2 * std::numbers::pi);
  to.damping = std::abs(to.value) > 0 ? -to.value.real() / std::abs(to.value) : 0;
}

/// Modes of equal eigenvalues, which have no shapes of their own.
std::vector<std::vector<std::size_t>> clusters_of(const std::vector<Mode>& modes) {
  std::vector<std::vector<std::size_t>> out;
  std::vector<char> taken(modes.size(), 0);
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (taken[i] || modes[i].kind == Mode::Kind::rigid) continue;
    std::vector<std::size_t> cluster{i};
    for (std::size_t j = i + 1; j < modes.size(); ++j)
      if (!taken[j] && modes[j].kind == modes[i].kind &&
          std::abs(modes[j].value - modes[i].value) <= same_place * std::abs(modes[i].value)) {
        cluster.push_back(j);
        taken[j] = 1;
      }
    if (cluster.size() > 1) out.push_back(std::move(cluster));
  }
  return out;
}

/// Gives modes of equal eigenvalues the shapes that are nearest to those of `to`: X ← X (L Y), for the
/// vectors Y of `to` that lie most in their space.
void align(std::vector<Mode>& modes, const std::vector<Mode>& to) {
  for (const std::vector<std::size_t>& cluster : clusters_of(modes)) {
    std::vector<std::pair<double, std::size_t>> nearest;
    for (std::size_t j = 0; j < to.size(); ++j) {
      double in = 0;
      for (const std::size_t i : cluster)
        if (comparable(modes[i], to[j]) && to[j].kind != Mode::Kind::rigid) {
          const double a = alike(modes[i], to[j]);
          in += a * a;
        }
      nearest.emplace_back(in, j);
    }
    const auto n = static_cast<Eigen::Index>(cluster.size());
    if (std::ssize(nearest) < n) continue;
    std::stable_sort(nearest.begin(), nearest.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    if (!(nearest[cluster.size() - 1].first > 0.2)) continue;
    MatrixXcd by(n, n);
    for (Eigen::Index r = 0; r < n; ++r)
      for (Eigen::Index c = 0; c < n; ++c)
        by(r, c) = modes[cluster[static_cast<std::size_t>(r)]].left.dot(
            to[nearest[static_cast<std::size_t>(c)].second].shape);
    const MatrixXcd back = complex_inverse(by);
    if (!back.allFinite() || back.cwiseAbs().maxCoeff() > 1e6) continue;
    std::vector<Mode> turned;
    for (Eigen::Index c = 0; c < n; ++c) {
      Mode mode = modes[cluster[static_cast<std::size_t>(c)]];
      mode.shape.setZero();
      mode.motion.setZero();
      mode.left.setZero();
      for (Eigen::Index r = 0; r < n; ++r) {
        const Mode& of = modes[cluster[static_cast<std::size_t>(r)]];
        mode.shape += by(r, c) * of.shape;
        mode.motion += by(r, c) * of.motion;
        // wᴴ ← B⁻¹ wᴴ.
        mode.left += std::conj(back(c, r)) * of.left;
      }
      const Mode& like = to[nearest[static_cast<std::size_t>(c)].second];
      mode.whirl = like.whirl;
      // Where nothing turns here, the ground sees the same.
      const bool turns = std::any_of(cluster.begin(), cluster.end(),
                                     [&](std::size_t k) { return modes[k].fixed != modes[k].value; });
      if (like.fixed == 0.)
        mode.fixed = like.fixed;
      else
        mode.fixed = turns ? mode.value + (like.fixed - like.value) : mode.value;
      turned.push_back(std::move(mode));
    }
    for (std::size_t k = 0; k < cluster.size(); ++k) modes[cluster[k]] = std::move(turned[k]);
  }
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
    if (!clusters_of(at.modes).empty()) align(at.modes, evaluate(values.front() + 1e-4 * range).modes);
    for (const Mode& mode : at.modes) at.branch.push_back(open(mode));
    record(0, at);
    for (std::size_t k = 1; k < values.size(); ++k) {
      Stand next = evaluate(values[k]);
      at = follow(std::move(at), std::move(next), 0);
      record(k, at);
    }
    for (std::size_t b = 0; b < out_.branches.size(); ++b) {
      out_.branches[b].values.resize(values.size(), nowhere());
      out_.branches[b].whirl.resize(values.size(), 0);
    }
    leave_out_neighbours();
    number_names();
    find_criticals();
    find_onsets();
    return std::move(out_);
  }

 private:
  static std::complex<double> nowhere() {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan};
  }

  Stand evaluate(double value) {
    ++out_.evaluations;
    LinearisedModes found = modes_(value);
    for (const std::string& warning : found.model.warnings)
      if (std::find(out_.warnings.begin(), out_.warnings.end(), warning) == out_.warnings.end() &&
          out_.warnings.size() < 20)
        out_.warnings.push_back(warning);
    return {value, std::move(found.modes), {}, found.period > 0 ? 2 * std::numbers::pi / found.period : 0};
  }

  int open(const Mode& mode) {
    out_.branches.push_back({mode.text, {}, {}});
    followed_.push_back(false);
    return static_cast<int>(out_.branches.size()) - 1;
  }

  /// Branches that are nowhere among the lowest.
  void leave_out_neighbours() {
    std::size_t kept = 0;
    for (std::size_t b = 0; b < out_.branches.size(); ++b)
      if (followed_[b]) std::swap(out_.branches[kept++], out_.branches[b]);
    out_.branches.resize(kept);
  }

  void record(std::size_t k, const Stand& at) {
    for (std::size_t i = 0; i < at.modes.size(); ++i) {
      ModeBranch& b = out_.branches[static_cast<std::size_t>(at.branch[i])];
      b.values.resize(k + 1, nowhere());
      b.whirl.resize(k + 1, 0);
      b.values[k] = at.modes[i].seen();
      b.whirl[k] = at.modes[i].whirl;
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

  /// Whether two oscillating modes, one of which is followed, exchange their order between the values.
  bool crosses(const Stand& a, const Stand& b, const std::vector<int>& pair) const {
    for (std::size_t i = 0; i < pair.size(); ++i)
      for (std::size_t j = 0; j < std::min(i, most_); ++j) {
        if (pair[i] < 0 || pair[j] < 0) continue;
        const double before = a.modes[static_cast<std::size_t>(pair[i])].value.imag() -
                              a.modes[static_cast<std::size_t>(pair[j])].value.imag(),
                     after = b.modes[i].value.imag() - b.modes[j].value.imag();
        if (before * after < 0) return true;
      }
    return false;
  }

  Stand follow(Stand from, Stand to, int depth) {
    align(to.modes, from.modes);
    std::vector<int> pair;
    const bool certain = match(from, to, pair);
    for (std::size_t j = 0; j < to.modes.size(); ++j)
      if (pair[j] >= 0) go_on_from(from.modes[static_cast<std::size_t>(pair[j])], to.turn, to.modes[j]);
    // A crossing may be a veering narrower than the interval: it is looked at more closely.
    const bool good = certain && !(depth < closest && crosses(from, to, pair));
    if (!good && depth < deepest && out_.evaluations < options_.most_evaluations) {
      Stand middle = evaluate(0.5 * (from.value + to.value));
      // Modes that come together on the real axis part there for good: no halving makes that smooth.
      if (from.modes.size() == to.modes.size() || depth < 8) {
        middle = follow(std::move(from), std::move(middle), depth + 1);
        return follow(std::move(middle), std::move(to), depth + 1);
      }
    }
    if (!certain && from.modes.size() == to.modes.size())
      out_.warnings.push_back(fmt::format("near {} = {:.6g} modes could not be distinguished for certain",
                                          options_.parameter, to.value));
    to.branch.clear();
    for (std::size_t j = 0; j < to.modes.size(); ++j)
      to.branch.push_back(pair[j] >= 0 ? from.branch[static_cast<std::size_t>(pair[j])] : open(to.modes[j]));
    return to;
  }

  void number_names() {
    for (std::size_t i = 0; i < out_.branches.size(); ++i) {
      int same = 1;
      for (std::size_t j = 0; j < i; ++j) same += out_.branches[j].name == out_.branches[i].name ? 1 : 0;
      if (same > 1) out_.branches[i].name += fmt::format(" ({})", same);
    }
  }

  /// Where f(λ, value) of a branch passes zero between two values. λ is found anew where f would if it were
  /// straight between them, or half way where f is nearly zero at one side: without damping modes grow all at
  /// once, by the square root of the distance.
  template <class F>
  double crossing(std::size_t branch, std::size_t k, const F& f) {
    double low = out_.values[k - 1], high = out_.values[k];
    std::complex<double> of_low = out_.branches[branch].values[k - 1],
                         of_high = out_.branches[branch].values[k];
    double place = low;
    for (int round = 0, straight = 0; round < halvings && straight < 6; ++round) {
      const double a = f(of_low, low), b = f(of_high, high);
      const bool flat =
          std::min(std::abs(a), std::abs(b)) <= nearly_zero * std::max(std::abs(a), std::abs(b));
      straight += flat ? 0 : 1;
      place = flat ? 0.5 * (low + high) : low - a * (high - low) / (b - a);
      if (!(place > low && place < high) || high - low < 1e-9 * std::abs(high)) break;
      // The mode there that lies nearest to a straight line.
      const double share = (place - low) / (high - low);
      const std::complex<double> expected = of_low + share * (of_high - of_low);
      const Stand there = evaluate(place);
      std::complex<double> nearest = expected;
      double least = std::numeric_limits<double>::infinity();
      for (const Mode& mode : there.modes)
        for (const std::complex<double>& value : {mode.seen(), std::conj(mode.seen())}) {
          const std::complex<double> here = nearest_multiple(value, there.turn, expected);
          if (const double off = std::abs(here - expected); off < least) {
            least = off;
            nearest = here;
          }
          if (!(there.turn > 0)) break;
        }
      if (f(nearest, place) == 0) break;
      if ((f(nearest, place) > 0) == (a > 0)) {
        low = place;
        of_low = nearest;
      } else {
        high = place;
        of_high = nearest;
      }
    }
    return place;
  }

  void find_criticals() {
    if (!(options_.rad_per_second > 0)) return;
    for (const double order : options_.orders)
      for (std::size_t b = 0; b < out_.branches.size(); ++b) {
        const auto f = [&](const std::complex<double>& value, double at) {
          return value.imag() - order * options_.rad_per_second * std::abs(at);
        };
        for (std::size_t k = 1; k < out_.values.size(); ++k) {
          const auto &before = out_.branches[b].values[k - 1], &now = out_.branches[b].values[k];
          if (!(before.imag() > 0) || !(now.imag() > 0)) continue;
          const double a = f(before, out_.values[k - 1]), c = f(now, out_.values[k]);
          if ((a > 0) == (c > 0)) continue;
          const double place = crossing(b, k, f);
          out_.criticals.push_back(
              {static_cast<int>(b), place, order, order * options_.rad_per_second * std::abs(place)});
        }
      }
    std::stable_sort(out_.criticals.begin(), out_.criticals.end(),
                     [](const auto& a, const auto& b) { return a.value < b.value; });
  }

  void find_onsets() {
    double largest = 0;
    for (const ModeBranch& b : out_.branches)
      for (const auto& value : b.values)
        if (std::isfinite(std::abs(value))) largest = std::max(largest, std::abs(value));
    for (std::size_t b = 0; b < out_.branches.size(); ++b)
      for (std::size_t k = 1; k < out_.values.size(); ++k) {
        const auto &before = out_.branches[b].values[k - 1], &now = out_.branches[b].values[k];
        if (!std::isfinite(std::abs(before)) || !std::isfinite(std::abs(now))) continue;
        // By more than round-off.
        const double none = 1e-9 * largest;
        const bool grew = before.real() > none, grows = now.real() > none;
        if (grew == grows) continue;
        const auto f = [&](const std::complex<double>& value, double) {
          return value.real() - (std::abs(before.real()) <= none ? 0.5 * none : 0);
        };
        const double place = crossing(b, k, f);
        out_.onsets.push_back({static_cast<int>(b), place, now.imag(), grows});
      }
    std::stable_sort(out_.onsets.begin(), out_.onsets.end(),
                     [](const auto& a, const auto& b) { return a.value < b.value; });
  }

  const ModesAt& modes_;
  const CampbellOptions& options_;
  const std::size_t most_;      ///< of the modes at one value, in their order
  std::vector<bool> followed_;  ///< by branch: it is somewhere among them
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

int with_neighbours(int most) { return most > 0 ? most + std::max(4, most / 5) : 0; }

ModesSolver one_solver(const ModesBy& modes, double first, double last, ModesSolver asked) {
  if (asked != ModesSolver::automatic) return asked;
  const bool sparse = modes(first, asked).sparse && modes(last, asked).sparse;
  return sparse ? ModesSolver::sparse : ModesSolver::dense;
}

}  // namespace mimbre

#include "analysis/modes/mode_matching.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/modes/mode_likeness.h"

namespace mimbre::linear {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double sure = 0.85;         ///< how alike the shapes of one mode are from value to value
constexpr double other = 0.4;         ///< and those of two at most
constexpr double similar = 0.3;       ///< of modes that may belong together
constexpr double nearly_real = 1e-6;  ///< of an eigenvalue: the imaginary part of one that is real
constexpr double one_root = 1e-4;     ///< of an eigenvalue: the imaginary part where it is nearly double
constexpr double one_vector = 1e6;  ///< of the products of entries of left and right vectors, whose sum is 1
constexpr double no_decay = 1e-9;   ///< of the largest eigenvalue: round-off

using Kind = Mode::Kind;

/// Right and left vectors of a real invariant subspace of two dimensions, with Wᴴ X = 1.
struct Plane {
  std::array<Eigen::VectorXcd, 2> right, left;
};

Plane plane_of_pair(const Mode& m) { return {{m.shape, m.shape.conjugate()}, {m.left, m.left.conjugate()}}; }
Plane plane_of_two(const Mode& a, const Mode& b) { return {{a.shape, b.shape}, {a.left, b.left}}; }

/// 1: the same plane, in both directions; less, to 0: another one. With the projectors P and Q on them it is
/// by the two eigenvalues of P Q P that are not zero, so that it does not depend on the vectors that span
/// them and is smooth where two eigenvalues meet, whose vectors become one.
double alike_planes(const Plane& a, const Plane& b) {
  Eigen::Matrix2cd there, back;
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 2; ++j) {
      there(static_cast<Index>(i), static_cast<Index>(j)) = a.left[i].dot(b.right[j]);
      back(static_cast<Index>(i), static_cast<Index>(j)) = b.left[i].dot(a.right[j]);
    }
  const Eigen::Matrix2cd both = there * back;
  const std::complex<double> half = 0.5 * both.trace(), root = std::sqrt(half * half - both.determinant());
  const double off = std::max(std::abs(half + root - 1.0), std::abs(half - root - 1.0));
  return off < 2 ? 1 - 0.5 * off : 0;
}

bool have_left(const Mode& a, const Mode& b) {
  return a.left.size() == b.left.size() && a.shape.size() == b.shape.size() && a.left.size() > 0;
}

bool is_real(const Mode& m) { return m.kind == Kind::real; }
bool is_pair(const Mode& m) { return m.kind == Kind::oscillating; }

double largest_value(const ModeSet& a, const ModeSet& b) {
  double largest = 0;
  for (const ModeSet* set : {&a, &b})
    for (const Mode& m : set->modes) largest = std::max(largest, std::abs(m.value));
  return largest;
}

class Matcher {
 public:
  Matcher(const ModeSet& a, const ModeSet& b, std::size_t most)
      : a_(a),
        b_(b),
        most_(most),
        none_(no_decay * largest_value(a, b)),
        score_(std::ssize(a.modes), std::ssize(b.modes)),
        taken_a_(a.modes.size(), 0),
        taken_b_(b.modes.size(), 0),
        sure_a_(a.modes.size(), 0),
        sure_b_(b.modes.size(), 0) {
    for (Index i = 0; i < score_.rows(); ++i)
      for (Index j = 0; j < score_.cols(); ++j) score_(i, j) = alike(of_a(i), of_b(j));
    out_.pair.assign(b.modes.size(), -1);
  }

  Matching run() {
    match_rigid();
    match_meetings();
    match_single();
    match_drift();
    const auto followed_are = [&](const std::vector<char>& flags) {
      const std::size_t n = std::min(most_, flags.size());
      return std::all_of(flags.begin(), flags.begin() + static_cast<std::ptrdiff_t>(n),
                         [](char c) { return c != 0; });
    };
    out_.certain = followed_are(sure_a_) && followed_are(sure_b_);
    return std::move(out_);
  }

 private:
  const Mode& of_a(Index i) const { return a_.modes[static_cast<std::size_t>(i)]; }
  const Mode& of_b(Index j) const { return b_.modes[static_cast<std::size_t>(j)]; }

  void take(Index i, Index j, bool is_sure) {
    out_.pair[static_cast<std::size_t>(j)] = static_cast<int>(i);
    take_a(i, is_sure);
    take_b(j, is_sure);
  }
  void take_a(Index i, bool is_sure) {
    taken_a_[static_cast<std::size_t>(i)] = 1;
    sure_a_[static_cast<std::size_t>(i)] = is_sure ? 1 : 0;
  }
  void take_b(Index j, bool is_sure) {
    taken_b_[static_cast<std::size_t>(j)] = 1;
    sure_b_[static_cast<std::size_t>(j)] = is_sure ? 1 : 0;
  }

  static std::vector<Index> of_kind(const ModeSet& set, Kind kind) {
    std::vector<Index> out;
    for (std::size_t k = 0; k < set.modes.size(); ++k)
      if (set.modes[k].kind == kind) out.push_back(static_cast<Index>(k));
    return out;
  }

  void match_rigid() {
    const std::vector<Index> here = of_kind(a_, Kind::rigid), there = of_kind(b_, Kind::rigid);
    if (here.size() != there.size()) return;
    for (std::size_t k = 0; k < here.size(); ++k) take(here[k], there[k], true);
  }

  /// Of modes that all decay, or all grow: where growth begins both are looked at closely.
  bool one_sense(const Mode& first, const Mode& second, const Mode& pair) const {
    const auto [least, most] = std::minmax({first.value.real(), second.value.real(), pair.value.real()});
    return most < -none_ || least > none_;
  }

  struct Candidate {
    Meeting meeting;
    double how = 0;
    bool meets = true;
  };

  /// `meets`: the real ones are those of a.
  void add_candidates(bool meets, std::vector<Candidate>& out) const {
    const ModeSet &two = meets ? a_ : b_, &one = meets ? b_ : a_;
    const std::vector<Index> reals = of_kind(two, Kind::real);
    for (const Index p : of_kind(one, Kind::oscillating))
      for (std::size_t s = 0; s < reals.size(); ++s)
        for (std::size_t f = 0; f < s; ++f) {
          const auto how = [&](Index r) { return meets ? score_(r, p) : score_(p, r); };
          if (how(reals[s]) < similar || how(reals[f]) < similar) continue;
          const Mode &pair = one.modes[static_cast<std::size_t>(p)],
                     &first = two.modes[static_cast<std::size_t>(reals[f])],
                     &second = two.modes[static_cast<std::size_t>(reals[s])];
          if (!have_left(first, pair) || !one_sense(first, second, pair)) continue;
          const double planes = alike_planes(plane_of_pair(pair), plane_of_two(first, second));
          if (planes < sure) continue;
          const bool in_order = first.value.real() >= second.value.real();
          out.push_back({{static_cast<int>(in_order ? reals[f] : reals[s]),
                          static_cast<int>(in_order ? reals[s] : reals[f]), static_cast<int>(p)},
                         planes,
                         meets});
        }
  }

  void match_meetings() {
    std::vector<Candidate> all;
    add_candidates(true, all);
    add_candidates(false, all);
    std::stable_sort(all.begin(), all.end(),
                     [](const Candidate& x, const Candidate& y) { return x.how > y.how; });
    for (const Candidate& c : all) {
      const std::vector<char>&two = c.meets ? taken_a_ : taken_b_, &one = c.meets ? taken_b_ : taken_a_;
      if (two[static_cast<std::size_t>(c.meeting.slow)] != 0 ||
          two[static_cast<std::size_t>(c.meeting.fast)] != 0 ||
          one[static_cast<std::size_t>(c.meeting.pair)] != 0)
        continue;
      if (c.meets) {
        take(c.meeting.slow, c.meeting.pair, true);
        take_a(c.meeting.fast, true);
        out_.meet.push_back(c.meeting);
      } else {
        take(c.meeting.pair, c.meeting.slow, true);
        take_b(c.meeting.fast, true);
        out_.part.push_back(c.meeting);
      }
    }
  }

  /// How alike two modes are that may be one: the vectors of a pair near a meeting turn within their plane.
  double one_mode(Index i, Index j) const {
    const Mode &a = of_a(i), &b = of_b(j);
    const double how = score_(i, j);
    if (how >= sure || !is_pair(a) || !is_pair(b) || !have_left(a, b)) return how;
    return std::max(how, alike_planes(plane_of_pair(a), plane_of_pair(b)));
  }

  /// The best pair first.
  void match_single() {
    MatrixXd left = score_;
    for (Index i = 0; i < left.rows(); ++i)
      if (taken_a_[static_cast<std::size_t>(i)] != 0) left.row(i).setConstant(-1);
    for (Index j = 0; j < left.cols(); ++j)
      if (taken_b_[static_cast<std::size_t>(j)] != 0) left.col(j).setConstant(-1);
    const MatrixXd all = left;
    for (Index k = 0; k < std::min(left.rows(), left.cols()); ++k) {
      Index i = 0, j = 0;
      if (left.maxCoeff(&i, &j) < similar) break;
      double second = 0;
      for (Index c = 0; c < all.cols(); ++c)
        if (c != j) second = std::max(second, all(i, c));
      for (Index r = 0; r < all.rows(); ++r)
        if (r != i) second = std::max(second, all(r, j));
      take(i, j, second <= other && one_mode(i, j) >= sure);
      left.row(i).setConstant(-1);
      left.col(j).setConstant(-1);
    }
  }

  /// A speed that nothing holds any longer is no mode of its own: it belongs to the rigid motion along it.
  void match_drift() {
    if (a_.zeros < 0 || b_.zeros < 0 || std::abs(a_.zeros - b_.zeros) != 1) return;
    const bool stops = b_.zeros > a_.zeros;
    const ModeSet& more = stops ? a_ : b_;
    const std::vector<char>&taken = stops ? taken_a_ : taken_b_, &others = stops ? taken_b_ : taken_a_;
    if (std::count(taken.begin(), taken.end(), 0) != 1 || std::count(others.begin(), others.end(), 0) != 0)
      return;
    const auto at = std::find(taken.begin(), taken.end(), 0) - taken.begin();
    if (!is_real(more.modes[static_cast<std::size_t>(at)])) return;
    (stops ? out_.stops : out_.starts) = static_cast<int>(at);
    if (stops)
      take_a(at, true);
    else
      take_b(at, true);
  }

  const ModeSet &a_, &b_;
  std::size_t most_;
  double none_;
  MatrixXd score_;
  std::vector<char> taken_a_, taken_b_, sure_a_, sure_b_;
  Matching out_;
};

}  // namespace

Matching match_modes(const ModeSet& a, const ModeSet& b, std::size_t most) {
  return Matcher(a, b, most).run();
}

bool have_met(const Mode& mode) {
  return (is_real(mode) ||
          (is_pair(mode) && std::abs(mode.value.imag()) < one_root * std::abs(mode.value))) &&
         mode.left.size() == mode.shape.size() && mode.left.size() > 0 &&
         !(mode.left.cwiseProduct(mode.shape.conjugate()).cwiseAbs().maxCoeff() < one_vector &&
           mode.left.norm() > 0);
}

bool is_nearly_real(std::complex<double> value) {
  return std::abs(value.imag()) <= nearly_real * std::abs(value);
}

void part_nearly_real(std::vector<Mode>& modes) {
  std::vector<Mode> out;
  for (Mode& mode : modes) {
    if (!is_pair(mode) || mode.left.size() != mode.shape.size() || mode.fixed != mode.value ||
        !is_nearly_real(mode.value)) {
      out.push_back(std::move(mode));
      continue;
    }
    for (const bool imaginary : {false, true}) {
      Mode one = mode;
      const auto part = [&](const Eigen::VectorXcd& x) {
        Eigen::VectorXcd out_of = Eigen::VectorXcd::Zero(x.size());
        if (imaginary)
          out_of.real() = x.imag();
        else
          out_of.real() = x.real();
        return out_of;
      };
      one.kind = Kind::real;
      one.value = one.fixed = mode.value.real();
      one.damped = one.whirl = 0;
      one.shape = part(mode.shape);
      one.motion = part(mode.motion);
      one.left = 2 * part(mode.left);
      out.push_back(std::move(one));
    }
  }
  modes = std::move(out);
}

MeetingValues of_pair(const Mode& pair) {
  return {-4 * pair.value.imag() * pair.value.imag(), pair.value.real()};
}

MeetingValues of_two(const Mode& first, const Mode& second) {
  const double difference = first.value.real() - second.value.real();
  return {difference * difference, 0.5 * (first.value.real() + second.value.real())};
}

std::optional<MeetingValues> meeting_values(const Mode& pair, const std::vector<Mode>& modes) {
  const Plane plane = plane_of_pair(pair);
  double best = 0.5;
  std::optional<MeetingValues> out;
  const auto consider = [&](const Plane& other_plane, const MeetingValues& values) {
    const double how = alike_planes(plane, other_plane);
    if (how <= best) return;
    best = how;
    out = values;
  };
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (!have_left(pair, modes[i])) continue;
    if (is_pair(modes[i])) consider(plane_of_pair(modes[i]), of_pair(modes[i]));
    if (!is_real(modes[i])) continue;
    for (std::size_t j = 0; j < i; ++j)
      if (is_real(modes[j])) consider(plane_of_two(modes[i], modes[j]), of_two(modes[i], modes[j]));
  }
  return out;
}

}  // namespace mimbre::linear

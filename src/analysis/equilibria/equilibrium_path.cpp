#include "mimbre/equilibrium_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "analysis/equilibria/path_equations.h"
#include "base/cpu_time.h"
#include "math/once/decompositions.h"
#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Arc length counts coordinates by their scales and factors by their range. Of steps: the first, the longest
// (of any coordinate, and of the factor), the shortest.
constexpr double first_length = 0.02, longest_length = 0.1, shortest_length = 1e-7;
// Corrections that end the iterations: at once, or where they do not get smaller any more.
constexpr double corrected = 1e-11, nearly_corrected = 1e-8;
constexpr int most_corrections = 12, few_corrections = 3;
constexpr double furthest_correction = 0.5;  ///< beyond, the step was too long
// Tangents at the ends of a step: less like one another than this, and it is repeated; more, and the next is
// longer.
constexpr double least_likeness = 0.9, good_likeness = 0.995;
constexpr double longer = 1.5;
constexpr double round_off_of_pivots = 1e-12;
constexpr double no_resistance = 1e-10;  ///< of the stiffness, by the largest
constexpr double worked_on = 1e-4;  ///< of the loads: they work on a motion, which is then that of a limit
constexpr double unsymmetric_path = 1e-6;  ///< of the stiffness
constexpr double exact_crossing = 1e-9;    ///< of the step in which an eigenvalue changes its sign
constexpr int most_halvings = 40;
constexpr double far_away = 10;  ///< ranges of the factor before the first: the path goes on for ever

/// An equilibrium, with everything that the next step needs.
struct PathPlace {
  State state;
  double factor = 0;
  PathTangent tangent;
  VectorXd eigenvalues;  ///< of the stiffness, ascending
  MatrixXd vectors;      ///< likewise; empty where the stiffness is not symmetric
  bool symmetric = true;
  int unstable() const { return static_cast<int>((eigenvalues.array() < 0).count()); }
};

/// A direction of the path, of length one: along all scaled coordinates, and of the factor by its range.
struct PathDirection {
  VectorXd motion;
  double factor = 0;
  double length() const { return std::sqrt(motion.squaredNorm() + factor * factor); }
  double largest() const {
    return std::max(motion.size() == 0 ? 0 : motion.cwiseAbs().maxCoeff(), std::abs(factor));
  }
  double along(const PathDirection& other) const { return motion.dot(other.motion) + factor * other.factor; }
};

/// Where an eigenvalue of the stiffness vanishes between two places.
struct PathCrossing {
  PathPlace place;
  VectorXd along;  ///< the independent motion without stiffness
  bool limit = false;
};

class PathSearch {
 public:
  PathSearch(const Model& model, const EquilibriumPathOptions& options)
      : options_(options),
        range_(options.to - options.from),
        equations_(model.spec(), growing_loads(model.spec(), options.loads), options.inputs) {
    out_.loads = growing_loads(model.spec(), options.loads).names;
  }

  EquilibriumPath find();

 private:
  struct Leaving {
    PathCrossing crossing;
    int branch;
  };

  bool look(PathPlace& place);
  static bool find_eigenvalues(PathPlace& place);
  static VectorXd solved(const MatrixXd& A, const VectorXd& b);
  std::optional<PathPlace> corrected_from(State state, double factor, const PathDirection& across,
                                          int* corrections = nullptr);
  std::optional<PathPlace> ahead(const PathPlace& from, const PathDirection& along, double length,
                                 int* corrections = nullptr);
  std::optional<PathPlace> at_factor(const PathPlace& near, double factor);
  std::optional<PathDirection> direction(const PathPlace& at, const PathDirection& like);
  std::optional<PathCrossing> crossing(const PathPlace& from, const PathPlace& to, const PathDirection& along,
                                       double length, Eigen::Index eigenvalue);
  void check_held(const PathPlace& first) const;
  void add(PathBranch& branch, const PathPlace& place);
  void follow(std::size_t branch, PathPlace place, PathDirection along);
  bool take_crossings(std::size_t branch, const PathPlace& from, const PathPlace& to,
                      const PathDirection& along, double length);
  void leave(const Leaving& leaving);

  const EquilibriumPathOptions& options_;
  const double range_;
  PathEquations equations_;
  EquilibriumPath out_;
  std::vector<Leaving> bifurcations_;
  int points_ = 0;
};

/// The equations at the place; false where they are not finite.
bool PathSearch::look(PathPlace& place) {
  place.tangent = equations_.at(place.state, place.factor);
  const PathTangent& t = place.tangent;
  return t.stiffness.allFinite() && t.force.allFinite() && t.load.allFinite();
}

/// What the stiffness there says.
bool PathSearch::find_eigenvalues(PathPlace& place) {
  const MatrixXd& K = place.tangent.stiffness;
  place.symmetric = (K - K.transpose()).norm() <= unsymmetric_path * K.norm();
  if (place.symmetric) {
    EigenPairs pairs = symmetric_eigen((K + K.transpose()) / 2);
    if (!pairs.ok) return false;
    place.eigenvalues = std::move(pairs.values);
    place.vectors = std::move(pairs.vectors);
  } else {
    // Real ones alone change the sign of the determinant.
    const Eigen::VectorXcd values = mimbre::eigenvalues(K);
    std::vector<double> real;
    for (const std::complex<double>& x : values)
      if (x.imag() == 0) real.push_back(x.real());
    std::sort(real.begin(), real.end());
    place.eigenvalues = Eigen::Map<const VectorXd>(real.data(), std::ssize(real));
    place.vectors.resize(0, 0);
  }
  return true;
}

/// Where several paths cross the shortest of all solutions.
VectorXd PathSearch::solved(const MatrixXd& A, const VectorXd& b) {
  VectorXd x = solve(A, b);
  if (!x.allFinite() && A.allFinite()) x = shortest_solution(A, b, round_off_of_pivots);
  return x;
}

/// The equilibrium in the plane across a direction through this state.
std::optional<PathPlace> PathSearch::corrected_from(State state, double factor, const PathDirection& across,
                                                    int* corrections) {
  PathPlace place{std::move(state), factor, {}, {}, {}, true};
  double before = std::numeric_limits<double>::infinity();
  for (int k = 0; k < most_corrections; ++k) {
    if (!look(place)) return {};
    const PathTangent& t = place.tangent;
    const Eigen::Index f = t.force.size();
    const double strength = std::max(t.stiffness.cwiseAbs().maxCoeff(), 1e-300);
    MatrixXd A = MatrixXd::Zero(f + 1, f + 1);
    VectorXd b = VectorXd::Zero(f + 1);
    A.topLeftCorner(f, f) = t.stiffness / strength;
    A.topRightCorner(f, 1) = t.load * (range_ / strength);
    A.bottomLeftCorner(1, f) = (t.motions.transpose() * across.motion).transpose();
    A(f, f) = across.factor;
    b.head(f) = -t.force / strength;
    const VectorXd x = solved(A, b);
    if (!x.allFinite()) return {};
    const PathDirection step{t.motions * x.head(f), x[f]};
    const double size = step.largest();
    if (size > furthest_correction) return {};
    if (!equations_.move(place.state, step.motion)) return {};
    place.factor += step.factor * range_;
    const bool stays = size > before / 2;
    if (size <= corrected || (size <= nearly_corrected && stays)) {
      if (corrections) *corrections = k + 1;
      // The last position but one is as near.
      return find_eigenvalues(place) ? std::optional(std::move(place)) : std::nullopt;
    }
    before = size;
  }
  return {};
}

std::optional<PathPlace> PathSearch::ahead(const PathPlace& from, const PathDirection& along, double length,
                                           int* corrections) {
  State state = from.state;
  if (!equations_.move(state, length * along.motion)) return {};
  return corrected_from(std::move(state), from.factor + length * along.factor * range_, along, corrections);
}

std::optional<PathPlace> PathSearch::at_factor(const PathPlace& near, double factor) {
  return corrected_from(near.state, factor, {VectorXd::Zero(near.tangent.motions.rows()), 1});
}

/// The path's tangent, on the side of `like`.
std::optional<PathDirection> PathSearch::direction(const PathPlace& at, const PathDirection& like) {
  const PathTangent& t = at.tangent;
  const Eigen::Index f = t.force.size();
  const double strength = std::max(t.stiffness.cwiseAbs().maxCoeff(), 1e-300);
  MatrixXd A = MatrixXd::Zero(f + 1, f + 1);
  A.topLeftCorner(f, f) = t.stiffness / strength;
  A.topRightCorner(f, 1) = t.load * (range_ / strength);
  A.bottomLeftCorner(1, f) = (t.motions.transpose() * like.motion).transpose();
  A(f, f) = like.factor;
  const VectorXd x = solved(A, VectorXd::Unit(f + 1, f));
  if (!x.allFinite()) return {};
  PathDirection out{t.motions * x.head(f), x[f]};
  const double length = out.length();
  if (!(length > 0) || !std::isfinite(length)) return {};
  out.motion /= length;
  out.factor /= length;
  return out;
}

/// By regula falsi (Illinois) with an eigenvalue of a symmetric stiffness, by halving with the number of
/// negative ones otherwise.
std::optional<PathCrossing> PathSearch::crossing(const PathPlace& from, const PathPlace& to,
                                                 const PathDirection& along, double length,
                                                 Eigen::Index eigenvalue) {
  const auto value = [&](const PathPlace& place) {
    if (place.symmetric && eigenvalue < place.eigenvalues.size()) return place.eigenvalues[eigenvalue];
    return place.unstable() > eigenvalue ? -1.0 : 1.0;
  };
  double low = 0, high = 1, f_low = value(from), f_high = value(to);
  PathPlace nearest = std::abs(f_low) < std::abs(f_high) ? from : to;
  for (int k = 0; k < most_halvings && high - low > exact_crossing; ++k) {
    const bool by_halves = !from.symmetric || k % 4 == 3;
    double part = by_halves ? (low + high) / 2 : (low * f_high - high * f_low) / (f_high - f_low);
    part = std::clamp(part, low + 0.01 * (high - low), high - 0.01 * (high - low));
    std::optional<PathPlace> between = ahead(from, along, part * length);
    if (!between) return {};
    const double f = value(*between);
    nearest = std::move(*between);
    if (f == 0) break;
    if ((f < 0) == (f_low < 0)) {
      low = part;
      f_low = f;
      f_high /= 2;
    } else {
      high = part;
      f_high = f;
      f_low /= 2;
    }
  }
  PathCrossing out;
  const PathTangent& t = nearest.tangent;
  if (nearest.symmetric && eigenvalue < nearest.vectors.cols()) {
    out.along = nearest.vectors.col(eigenvalue);
    out.limit = std::abs(out.along.dot(t.load)) > worked_on * t.load.norm();
  } else {
    // The shortest image, and of what no combination of forces is changed, by inverse iteration.
    const Eigen::Index f = t.force.size();
    VectorXd left = VectorXd::Ones(f);
    out.along = VectorXd::Ones(f);
    const MatrixXd back = t.stiffness.transpose();
    for (int k = 0; k < 4; ++k) {
      out.along = solve(t.stiffness, out.along.normalized());
      left = solve(back, left.normalized());
    }
    if (!out.along.allFinite() || !left.allFinite()) return {};
    out.along.normalize();
    out.limit = std::abs(left.normalized().dot(t.load)) > worked_on * t.load.norm();
  }
  out.place = std::move(nearest);
  return out;
}

void PathSearch::check_held(const PathPlace& first) const {
  const double largest = first.eigenvalues.cwiseAbs().maxCoeff();
  for (Eigen::Index k = 0; k < first.eigenvalues.size(); ++k)
    if (!(std::abs(first.eigenvalues[k]) > no_resistance * largest))
      throw std::runtime_error(fmt::format(
          "equilibrium path: at a factor of {:.4g} nothing holds the mechanism along {}, so that its "
          "equilibrium is not one point; hold it by a joint or a spring, or begin with another factor",
          first.factor,
          first.symmetric ? equations_.shares(first.tangent, first.vectors.col(k)) : "some motion"));
}

void PathSearch::add(PathBranch& branch, const PathPlace& place) {
  AtRest at_rest = equations_.sample(place.state, place.factor);
  if (out_.channels.empty()) {
    out_.channels = at_rest.channels;
    out_.output_count = at_rest.output_count;
    for (const std::string& text : at_rest.warnings) out_.warnings.push_back(text);
  }
  branch.points.push_back({place.factor, at_rest.values, place.unstable(), PathPoint::Kind::regular, {}});
  ++points_;
  if (options_.progress) options_.progress(place.factor, points_);
}

/// Points where eigenvalues change their signs between two places, in their order. False where one was not
/// found.
bool PathSearch::take_crossings(std::size_t at, const PathPlace& from, const PathPlace& to,
                                const PathDirection& along, double length) {
  const int least = std::min(from.unstable(), to.unstable()), most = std::max(from.unstable(), to.unstable());
  std::vector<PathCrossing> found;
  for (int k = least; k < most; ++k) {
    std::optional<PathCrossing> one = crossing(from, to, along, length, k);
    if (!one) return false;
    found.push_back(std::move(*one));
  }
  // Sequence along the path.
  const double sense = to.factor >= from.factor ? 1 : -1;
  std::stable_sort(found.begin(), found.end(), [&](const PathCrossing& a, const PathCrossing& b) {
    return sense * a.place.factor < sense * b.place.factor;
  });
  for (PathCrossing& one : found) {
    add(out_.branches[at], one.place);
    PathPoint& point = out_.branches[at].points.back();
    point.unstable = from.unstable();
    point.kind = one.limit ? PathPoint::Kind::limit : PathPoint::Kind::bifurcation;
    point.moving = equations_.shares(one.place.tangent, one.along);
    if (!one.limit) bifurcations_.push_back({std::move(one), static_cast<int>(at)});
  }
  return true;
}

/// Equilibria from the place on, which is already on the branch.
void PathSearch::follow(std::size_t at, PathPlace place, PathDirection along) {
  const auto end = [&](std::string text) { out_.branches[at].end = std::move(text); };
  const double sense = range_ > 0 ? 1 : -1;
  double length = first_length;
  while (std::ssize(out_.branches[at].points) < options_.most_points) {
    const std::optional<PathDirection> tangent = direction(place, along);
    if (!tangent) return end("the path has no single direction there");
    length = std::min(length, longest_length / tangent->largest());
    std::optional<PathPlace> next;
    PathDirection onward;
    int corrections = 0;
    for (;; length /= 2) {
      if (length < shortest_length) return end("no equilibrium was found further on");
      next = ahead(place, *tangent, length, &corrections);
      if (!next) continue;
      const std::optional<PathDirection> turned = direction(*next, *tangent);
      if (!turned || turned->along(*tangent) < least_likeness) continue;
      onward = *turned;
      break;
    }
    const bool arrives =
        sense * (next->factor - options_.to) >= 0 && sense * (place.factor - options_.to) < 0;
    if (arrives) {
      std::optional<PathPlace> last = at_factor(*next, options_.to);
      if (last) next = std::move(last);
    }
    // The last step to a given factor is no longer than this one.
    if (!take_crossings(at, place, *next, *tangent, length))
      out_.warnings.push_back(
          fmt::format("between factors of {:.6g} and {:.6g} the number of unstable directions changes, and "
                      "the point where "
                      "was not found",
                      place.factor, next->factor));
    add(out_.branches[at], *next);
    if (arrives) return end("");
    if (sense * (next->factor - options_.from) < -far_away * std::abs(range_))
      return end("the factor moves away from the last one");
    if (corrections <= few_corrections && onward.along(*tangent) > good_likeness) length *= longer;
    place = std::move(*next);
    along = std::move(onward);
  }
  end(fmt::format("{} points are enough", options_.most_points));
}

/// Both branches of a bifurcation.
void PathSearch::leave(const Leaving& leaving) {
  const PathCrossing& from = leaving.crossing;
  PathDirection side{from.place.tangent.motions * from.along, 0};
  side.motion /= side.length();
  for (const int sense : {1, -1}) {
    PathDirection along{sense * side.motion, 0};
    std::optional<PathPlace> first;
    double length = first_length;
    for (int k = 0; k < 8 && !first; ++k, length /= 2) first = ahead(from.place, along, length);
    PathBranch branch;
    branch.parent = leaving.branch;
    branch.leaves_at = from.place.factor;
    branch.sense = sense;
    out_.branches.push_back(std::move(branch));
    const std::size_t at = out_.branches.size() - 1;
    add(out_.branches[at], from.place);
    out_.branches[at].points.back().kind = PathPoint::Kind::bifurcation;
    out_.branches[at].points.back().moving = equations_.shares(from.place.tangent, from.along);
    if (!first) {
      out_.branches[at].end = "no equilibrium was found beside the bifurcation";
      continue;
    }
    add(out_.branches[at], *first);
    along.factor = (first->factor - from.place.factor) / (range_ * length);
    const double whole = along.length();
    along.motion /= whole;
    along.factor /= whole;
    follow(at, std::move(*first), std::move(along));
  }
}

EquilibriumPath PathSearch::find() {
  const double start = thread_cpu_seconds();
  if (!std::isfinite(range_) || range_ == 0)
    throw InputError(Mark{}, fmt::format("factors from {} to {} are no range", options_.from, options_.to));
  if (options_.most_points < 2) throw InputError(Mark{}, "at least 2 points of a path are needed");
  PathPlace first{equations_.start(options_.from, out_.warnings), options_.from, {}, {}, {}, true};
  if (!look(first) || !find_eigenvalues(first))
    throw std::runtime_error("equilibrium path: the stiffness is not a number");
  if (first.tangent.force.size() == 0)
    throw std::runtime_error("equilibrium path: the mechanism has no motion, so that nothing gives way");
  check_held(first);
  if (std::optional<PathPlace> better = at_factor(first, options_.from)) first = std::move(*better);
  out_.branches.emplace_back();
  add(out_.branches[0], first);
  const PathDirection onward{VectorXd::Zero(first.tangent.motions.rows()), 1};
  follow(0, std::move(first), onward);
  for (int k = 0; k < options_.bifurcations && k < std::ssize(bifurcations_); ++k) {
    const Leaving leaving = bifurcations_[static_cast<std::size_t>(k)];
    leave(leaving);
  }
  out_.cpu_seconds = thread_cpu_seconds() - start;
  return std::move(out_);
}

}  // namespace

EquilibriumPath equilibrium_path(const std::shared_ptr<const Model>& model,
                                 const EquilibriumPathOptions& options) {
  return PathSearch(*model, options).find();
}

}  // namespace mimbre

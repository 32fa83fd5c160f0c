#include "mimbre/equilibrium_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "analysis/equilibria/path_equations.h"
#include "analysis/equilibria/path_place.h"
#include "base/cpu_time.h"
#include "math/once/decompositions.h"
#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

using Eigen::VectorXd;

// Arc length counts coordinates by their scales and factors by their range. Of steps: the first, the longest
// (of any coordinate, and of the factor), the shortest, and that from which on a path may have a corner, as
// where a stop is reached.
constexpr double first_length = 0.02, longest_length = 0.1, shortest_length = 1e-7, corner_length = 1e-4;
// Corrections of a step, of its length, all together: beyond, it may have come to another path.
constexpr double reach = 0.5;
// Tangents at the ends of a step: less like one another than this, and it is repeated; more, and the next is
// longer.
constexpr double least_likeness = 0.9, good_likeness = 0.995;
constexpr double longer = 1.5;
constexpr int few_corrections = 3;
constexpr double exact_crossing = 1e-10;   ///< of the step in which an eigenvalue changes its sign
constexpr double vanishes = 1e-9;          ///< an eigenvalue, where its size was about 1
constexpr double nearly_vanishes = 1e-5;   ///< likewise: otherwise the stiffness jumps there
constexpr double not_neutral = 1e-3;       ///< likewise, at the start of a step
constexpr double same_factor = 1e-6;       ///< of two crossings, by the range
constexpr double same_direction = 0.9999;  ///< of a branch and its parent
constexpr int most_halvings = 60, most_failures = 6;
constexpr double far_away = 10;  ///< ranges of the factor before the first: the path goes on for ever

/// Where the number of unstable directions changes, in a step.
struct PathCrossing {
  PathPlace place;
  double part = 0;  ///< of the step
  VectorXd along;   ///< the independent motion without stiffness
  PathPoint::Kind kind = PathPoint::Kind::regular;
  int unstable = 0;  ///< the lesser of both sides
};

/// One step of a path.
struct PathStep {
  PathPlace from;
  PathDirection along;
  double length = 0;
  PathPlace to;
  PathDirection onward;  ///< the tangent at its end
  int corrections = 0;
};

class PathSearch {
 public:
  PathSearch(const Model& model, const EquilibriumPathOptions& options)
      : options_(options),
        range_(options.to - options.from),
        sense_(range_ > 0 ? 1 : -1),
        growing_(growing_loads(model.spec(), options.loads)),
        equations_(model.spec(), growing_, options.inputs),
        places_(equations_, range_) {
    out_.loads = growing_.names;
  }

  EquilibriumPath find();

 private:
  struct Leaving {
    PathCrossing crossing;
    int branch;
    PathDirection parent;
  };

  bool beyond(double factor) const { return sense_ * (factor - options_.to) >= 0; }
  std::optional<PathStep> step(const PathPlace& from, const PathDirection& along, double& length,
                               std::string& why);
  std::optional<PathCrossing> crossing(const PathStep& s, int number);
  void judge(const PathStep& s, int number, PathCrossing& found);
  PathPoint::Kind kind_of_last(const PathStep& s, const PathPlace& last, VectorXd& along);
  std::vector<PathCrossing> crossings(const PathStep& s);
  std::optional<PathPlace> arrival(const PathStep& s, double before, double after);
  void check_held(const PathPlace& first) const;
  PathPoint& add(std::size_t branch, const PathPlace& place, int unstable);
  void add_crossing(std::size_t branch, const PathStep& s, const PathCrossing& found);
  bool take(std::size_t branch, const PathStep& s);
  void follow(std::size_t branch, PathPlace place, PathDirection along);
  void leave(const Leaving& leaving);

  const EquilibriumPathOptions& options_;
  const double range_, sense_;
  const GrowingLoads growing_;
  PathEquations equations_;
  PathPlaces places_;
  EquilibriumPath out_;
  std::vector<Leaving> bifurcations_;
  int points_ = 0;
  bool warned_of_symmetry_ = false;
};

void PathSearch::check_held(const PathPlace& first) const {
  const VectorXd loose = places_.without_stiffness(first);
  if (loose.size() == 0) return;
  throw std::runtime_error(fmt::format(
      "equilibrium path: at a factor of {:.4g} nothing holds the mechanism along {}, so that its equilibrium "
      "is not one point; hold it by a joint or a spring, or begin with another factor",
      first.factor, equations_.shares(first.tangent, loose)));
}

PathPoint& PathSearch::add(std::size_t branch, const PathPlace& place, int unstable) {
  AtRest at_rest = equations_.sample(place.state, place.factor);
  if (out_.channels.empty()) {
    out_.channels = at_rest.channels;
    out_.output_count = at_rest.output_count;
    for (const std::string& text : at_rest.warnings) out_.warnings.push_back(text);
  }
  if (!place.symmetric && !warned_of_symmetry_) {
    warned_of_symmetry_ = true;
    out_.warnings.push_back(
        fmt::format("at a factor of {:.6g} the stiffness is not symmetric, because the loads have no "
                    "potential: unstable directions are then eigenvalues with a negative real part, and "
                    "flutter is not found; use `mimbre modes`",
                    place.factor));
  }
  std::vector<PathPoint>& points = out_.branches[branch].points;
  points.push_back({place.factor, at_rest.values, unstable, PathPoint::Kind::regular, {}});
  ++points_;
  if (options_.progress) options_.progress(place.factor, points_);
  return points.back();
}

/// The next equilibrium along the tangent; shorter where corrections lead far, the tangent turns, or the
/// factor turns back without a change of stability.
std::optional<PathStep> PathSearch::step(const PathPlace& from, const PathDirection& along, double& length,
                                         std::string& why) {
  std::optional<PathDirection> tangent = places_.direction(from, along);
  if (!tangent) {
    why = "the path has no single direction there";
    return {};
  }
  length = std::min(length, longest_length / tangent->largest());
  why = "no equilibrium was found further on";
  for (; length >= shortest_length; length /= 2) {
    int corrections = 0;
    std::optional<PathPlace> next = places_.ahead(from, *tangent, length, reach, &corrections);
    if (!next) continue;
    std::optional<PathDirection> onward = places_.direction(*next, *tangent);
    if (!onward) continue;
    if (length > corner_length) {
      if (onward->along(*tangent) < least_likeness) continue;
      if (onward->factor * tangent->factor < 0 && next->unstable == from.unstable) continue;
    }
    return PathStep{from, *tangent, length, std::move(*next), std::move(*onward), corrections};
  }
  return {};
}

/// Where `number` directions with negative stiffness become one more, or fewer: by regula falsi (Illinois)
/// with that eigenvalue, by halving otherwise.
std::optional<PathCrossing> PathSearch::crossing(const PathStep& s, int number) {
  const auto is_more = [&](const PathPlace& place) { return place.negative > number; };
  const bool more = is_more(s.from);
  const auto value = [&](const PathPlace& place) {
    const bool known = place.symmetric && number < place.eigenvalues.size();
    return known ? place.eigenvalues[number] : is_more(place) ? -1. : 1.;
  };
  double low = 0, high = 1, at_low = value(s.from), at_high = value(s.to);
  PathCrossing found;
  found.place = std::abs(at_low) < std::abs(at_high) ? s.from : s.to;
  found.part = std::abs(at_low) < std::abs(at_high) ? 0 : 1;
  int failures = 0;
  for (int k = 0; k < most_halvings && high - low > exact_crossing; ++k) {
    const bool halves = !s.from.symmetric || k % 4 == 3 || !(at_low * at_high < 0);
    double part = halves ? (low + high) / 2 : (low * at_high - high * at_low) / (at_high - at_low);
    part = std::clamp(part, low + 0.01 * (high - low), high - 0.01 * (high - low));
    std::optional<PathPlace> between = places_.ahead(s.from, s.along, part * s.length, 1);
    if (!between) {
      // Beside it there may be one.
      if (++failures > most_failures) break;
      part = low + (0.3 + 0.1 * failures) * (high - low);
      between = places_.ahead(s.from, s.along, part * s.length, 1);
      if (!between) continue;
    }
    const double f = value(*between);
    const bool same = is_more(*between) == more;
    found.place = std::move(*between);
    found.part = part;
    if (std::abs(f) < vanishes) break;
    if (same) {
      low = part;
      at_low = f;
      at_high /= 2;
    } else {
      high = part;
      at_high = f;
      at_low /= 2;
    }
  }
  if (failures > most_failures && high - low > 1e-3) return {};
  found.unstable = std::min(s.from.unstable, s.to.unstable);
  judge(s, number, found);
  return found;
}

/// Which kind of point it is. Beside a limit the loads work on the motion that has no stiffness.
void PathSearch::judge(const PathStep& s, int number, PathCrossing& found) {
  const auto [along, left, size] = places_.motion(found.place, number);
  found.along = along;
  if (along.size() == 0) return;
  if (size > nearly_vanishes) {
    // The stiffness jumps. At a corner the factor may turn back.
    if (s.along.factor * s.onward.factor < 0) found.kind = PathPoint::Kind::limit;
    return;
  }
  found.kind = places_.works(found.place, left) ? PathPoint::Kind::limit : PathPoint::Kind::bifurcation;
}

std::vector<PathCrossing> PathSearch::crossings(const PathStep& s) {
  std::vector<PathCrossing> found;
  const int least = std::min(s.from.negative, s.to.negative), most = std::max(s.from.negative, s.to.negative);
  // What is not symmetric changes the sign of its determinant with an odd number alone.
  const bool symmetric = s.from.symmetric && s.to.symmetric;
  for (int k = least; k < (symmetric ? most : least + (most - least) % 2); ++k) {
    std::optional<PathCrossing> one = crossing(s, k);
    if (one && one->kind != PathPoint::Kind::regular) found.push_back(std::move(*one));
    if (!one)
      out_.warnings.push_back(
          fmt::format("between factors of {:.6g} and {:.6g} the number of unstable directions changes, and "
                      "the point where it does so was not found",
                      s.from.factor, s.to.factor));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const PathCrossing& a, const PathCrossing& b) { return a.part < b.part; });
  const int change = s.to.unstable > s.from.unstable ? 1 : -1;
  int now = s.from.unstable;
  for (PathCrossing& one : found) {
    one.unstable = std::max(0, std::min(now, now + change));
    now += change;
  }
  for (std::size_t k = 1; k < found.size(); ++k)
    if (found[k].kind == PathPoint::Kind::bifurcation &&
        std::abs(found[k].place.factor - found[k - 1].place.factor) < same_factor * std::abs(range_))
      out_.warnings.push_back(
          fmt::format("at a factor of {:.6g} several motions lose their stiffness at once: there may be more "
                      "branches than those along each of them",
                      found[k].place.factor));
  return found;
}

/// The equilibrium with the last factor, between two parts of a step on both sides of it.
std::optional<PathPlace> PathSearch::arrival(const PathStep& s, double before, double after) {
  PathPlace nearest = s.to;
  for (int k = 0; k < 8; ++k) {
    const double part = (before + after) / 2;
    std::optional<PathPlace> between = places_.ahead(s.from, s.along, part * s.length, 1);
    if (!between) break;
    nearest = std::move(*between);
    (beyond(nearest.factor) ? after : before) = part;
  }
  return places_.at_factor(nearest, options_.to, reach);
}

/// The last point may be a limit or a bifurcation itself, whose eigenvalue does not change its sign before.
PathPoint::Kind PathSearch::kind_of_last(const PathStep& s, const PathPlace& last, VectorXd& along) {
  for (int k = 0; k < last.eigenvalues.size() && k < s.from.eigenvalues.size(); ++k) {
    if (std::abs(last.eigenvalues[k]) > nearly_vanishes || std::abs(s.from.eigenvalues[k]) < not_neutral)
      continue;
    const auto [motion, left, size] = places_.motion(last, k);
    along = motion;
    return places_.works(last, left) ? PathPoint::Kind::limit : PathPoint::Kind::bifurcation;
  }
  return PathPoint::Kind::regular;
}

void PathSearch::add_crossing(std::size_t branch, const PathStep& s, const PathCrossing& found) {
  PathPoint& point = add(branch, found.place, found.unstable);
  point.kind = found.kind;
  point.moving = equations_.shares(found.place.tangent, found.along);
  if (found.kind == PathPoint::Kind::bifurcation)
    bifurcations_.push_back({found, static_cast<int>(branch), s.along});
}

/// Adds the points of a step; true where it arrives at the last factor.
bool PathSearch::take(std::size_t branch, const PathStep& s) {
  double part = 0, factor = s.from.factor;
  const auto passes = [&](double next) { return beyond(next) && !beyond(factor); };
  const auto arrive = [&](double after) {
    const std::optional<PathPlace> last = arrival(s, part, after);
    if (!last) return false;
    VectorXd along;
    const PathPoint::Kind kind = kind_of_last(s, *last, along);
    PathPoint& point = add(branch, *last, last->unstable);
    point.kind = kind;
    if (kind != PathPoint::Kind::regular) point.moving = equations_.shares(last->tangent, along);
    return true;
  };
  for (const PathCrossing& one : crossings(s)) {
    if (passes(one.place.factor) && arrive(one.part)) return true;
    add_crossing(branch, s, one);
    part = one.part;
    factor = one.place.factor;
  }
  if (passes(s.to.factor) && arrive(1)) return true;
  add(branch, s.to, s.to.unstable);
  return false;
}

/// Equilibria from the place on, which is already on the branch.
void PathSearch::follow(std::size_t at, PathPlace place, PathDirection along) {
  const auto end = [&](std::string text) { out_.branches[at].end = std::move(text); };
  double length = first_length;
  while (std::ssize(out_.branches[at].points) < options_.most_points) {
    std::string why;
    std::optional<PathStep> next = step(place, along, length, why);
    if (!next) return end(why);
    if (take(at, *next)) return end("");
    if (sense_ * (next->to.factor - options_.from) < -far_away * std::abs(range_))
      return end("the factor moves away from the last one");
    if (next->corrections <= few_corrections && next->onward.along(next->along) > good_likeness)
      length *= longer;
    place = std::move(next->to);
    along = std::move(next->onward);
  }
  end(fmt::format("{} points are enough", options_.most_points));
}

/// Both branches of a bifurcation.
void PathSearch::leave(const Leaving& leaving) {
  const PathCrossing& from = leaving.crossing;
  const std::optional<PathDirection> parent = places_.direction(from.place, leaving.parent);
  for (const int sense : {1, -1}) {
    PathDirection along{sense * (from.place.tangent.motions * from.along), 0};
    along.motion /= along.length();
    std::optional<PathPlace> first;
    double length = first_length;
    for (int k = 0; k < 10; ++k, length /= 2) {
      first = places_.ahead(from.place, along, length, reach);
      if (first && (!beyond(first->factor) || beyond(from.place.factor))) break;
    }
    out_.branches.push_back({leaving.branch, from.place.factor, sense, {}, {}});
    const std::size_t at = out_.branches.size() - 1;
    PathPoint& point = add(at, from.place, from.unstable);
    point.kind = PathPoint::Kind::bifurcation;
    point.moving = equations_.shares(from.place.tangent, from.along);
    if (first) {
      along.factor = (first->factor - from.place.factor) / (range_ * length);
      const double whole = along.length();
      along.motion /= whole;
      along.factor /= whole;
      if (parent && std::abs(along.along(*parent)) > same_direction) first.reset();
    }
    if (!first) {
      out_.branches[at].end = "no equilibrium was found beside the bifurcation";
      continue;
    }
    if (beyond(first->factor)) {
      if (const std::optional<PathPlace> last = places_.at_factor(*first, options_.to, reach))
        add(at, *last, last->unstable);
      continue;
    }
    add(at, *first, first->unstable);
    follow(at, std::move(*first), std::move(along));
  }
}

EquilibriumPath PathSearch::find() {
  const double start = thread_cpu_seconds();
  if (!std::isfinite(range_) || range_ == 0)
    throw InputError(Mark{}, fmt::format("factors from {} to {} are no range", options_.from, options_.to));
  if (options_.most_points < 2) throw InputError(Mark{}, "at least 2 points of a path are needed");
  PathPlace first;
  first.state = equations_.start(options_.from, out_.warnings);
  first.factor = options_.from;
  if (!places_.look(first)) throw std::runtime_error("equilibrium path: the stiffness is not a number");
  if (first.tangent.force.size() == 0)
    throw std::runtime_error("equilibrium path: the mechanism has no motion, so that nothing gives way");
  places_.measure(first);
  if (!places_.judge(first)) throw std::runtime_error("equilibrium path: no eigenvalues were found");
  check_held(first);
  if (std::optional<PathPlace> better = places_.at_factor(first, options_.from, 1))
    first = std::move(*better);
  out_.branches.emplace_back();
  add(0, first, first.unstable);
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

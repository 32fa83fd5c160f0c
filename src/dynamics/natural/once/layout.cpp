#include "dynamics/natural/once/layout.h"

#include "forces/measure.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "compile/find_scales.h"
#include "joints/joint_kind.h"
#include "math/once/decompositions.h"

namespace mimbre::natural {
namespace {

/// Sum of variables times constants, ordered by variable.
using Combination = std::vector<std::pair<int, double>>;

/// Shares of what is compared, points by the model's length scale: what differs by less is the same, but for
/// how exactly a joint's sides are given; what is less is round-off.
constexpr double alike = 1e-9, round_off = 1e-12;

/// A body that is fixed in this many variables at most; joints that would exceed it get equations instead.
constexpr int most_variables = 10;

/// Points of a body that are nearer to each other than this, in typical lengths of the model, are taken to
/// be at one place up to round-off: only one of them may be among the points that fix the body.
constexpr double shortest = 1e-3;

/// A point (1, p) or vector (0, d) of a body in homogeneous coordinates.
Eigen::Vector4d homogeneous(bool point, const Vec3d& place) {
  return {point ? 1.0 : 0.0, place[0], place[1], place[2]};
}

/// One of the four points and vectors that fix a body.
struct Slot {
  bool point = false;
  Vec3d place = Vec3d::Zero();  ///< in body axes
  Combination sum;
};

/// Orthonormal basis of the directions that a body's slots fix: from the first point to the others, vectors.
std::vector<Vec3d> directions(const std::vector<Slot>& slots) {
  std::vector<Vec3d> basis;
  const auto reference = std::find_if(slots.begin(), slots.end(), [](const Slot& s) { return s.point; });
  for (auto s = slots.begin(); s != slots.end(); ++s) {
    if (s == reference) continue;
    Vec3d d = s->point ? Vec3d(s->place - reference->place) : s->place;
    for (const Vec3d& b : basis) d -= b.dot(d) * b;
    basis.push_back(d.normalized());
  }
  return basis;
}

/// Joint frames of one body, on one side of a joint.
struct Side {
  int joint = -1;            ///< spec index
  int own = -1, other = -1;  ///< frames
};

class Builder {
 public:
  Builder(const Compiled& model, Layout& layout) : m_(model), l_(layout), resistances_(model) {}

  void run() {
    if (!m_.bodies.empty()) l_.origin = m_.spec().bodies[m_.bodies.front().spec].pose.position;
    find_sides();
    l_.bodies.resize(m_.bodies.size());
    slots_.resize(m_.bodies.size());
    for (int b = 0; b < count(); ++b) define(b);
    number();
    joints();
    coordinates();
    forces();
    equations();
    frames_in_use();
    matrix();
    place_constants();
  }

 private:
  int count() const { return static_cast<int>(m_.bodies.size()); }

  /// Both frames of every joint that joins something, by body.
  void find_sides() {
    sides_.resize(m_.bodies.size());
    const auto add = [&](int joint) {
      const spec::Joint& j = m_.spec().joints[joint];
      if (joint_info(j.type).equations == 0) return;
      const int a = m_.frame_of_spec[j.frame_a], b = m_.frame_of_spec[j.frame_b];
      if (m_.frames[a].body >= 0) sides_[m_.frames[a].body].push_back({joint, a, b});
      if (m_.frames[b].body >= 0) sides_[m_.frames[b].body].push_back({joint, b, a});
    };
    for (const BodyData& b : m_.bodies) add(b.joint_spec);
    for (const LoopData& loop : m_.loops) add(loop.joint_spec);
  }

  // --- Points and vectors -------------------------------------------------------------------------------

  /// Which point and axes of both frames of a joint coincide.
  struct Coincidence {
    bool point = false;
    bool axis[3] = {false, false, false};
  };
  Coincidence coincidence(int joint) const {
    const JointInfo& info = joint_info(m_.spec().joints[joint].type);
    int distances = 0, angles = 0, angles_of[3] = {0, 0, 0};
    for (int k = 0; k < info.equations; ++k)
      if (info.closure[k].kind == LoopClosure::Kind::distance)
        ++distances;
      else
        ++angles, ++angles_of[info.closure[k].axis_b];
    Coincidence c;
    c.point = distances == 3;
    // An axis of b at right angles to two of a is the third; three angles fix all axes.
    for (int axis = 0; axis < 3; ++axis) c.axis[axis] = angles == 3 || angles_of[axis] == 2;
    return c;
  }

  /// The size of what is neither small nor large of a point or a vector, and of a variable.
  double size_of_value(bool point) const { return point ? m_.length_scale : 1; }
  double size_of_variable(int variable) const {
    return size_of_value(variable >= 0 ? l_.variables[variable].point : constants_[-1 - variable].point);
  }

  /// x − y of points or vectors, without the terms that cancel.
  Combination difference(const Combination& x, const Combination& y, bool point) const {
    Combination terms = x, sum;
    for (const auto& [variable, factor] : y) terms.push_back({variable, -factor});
    std::sort(terms.begin(), terms.end());
    for (const auto& [variable, factor] : terms)
      if (!sum.empty() && sum.back().first == variable)
        sum.back().second += factor;
      else
        sum.push_back({variable, factor});
    std::erase_if(sum, [&](const auto& term) {
      return std::abs(term.second) * size_of_variable(term.first) < alike * size_of_value(point);
    });
    return sum;
  }

  /// A constant point or vector, made once.
  Combination constant(bool point, const Vec3d& place) {
    // Those near it are near along a direction, too, by which they are ordered.
    const double along = Vec3d(0.48, -0.6, 0.64).dot(place), reach = round_off * size_of_value(point);
    std::multimap<double, int>& ordered = constants_along_[point];
    int first = static_cast<int>(constants_.size());
    for (auto k = ordered.lower_bound(along - 8 * reach); k != ordered.end() && k->first <= along + 8 * reach;
         ++k)
      if ((constants_[k->second].place - place).norm() < reach) first = std::min(first, k->second);
    if (first == std::ssize(constants_)) {
      constants_.push_back({point, -1, place});
      ordered.emplace(along, first);
    }
    return {{-1 - first, 1.0}};
  }

  /// A point or vector of a frame that no mode moves, by the variables of its body.
  Combination of_frame(int frame, bool point, int axis) {
    const FrameData& f = m_.frames[frame];
    const Vec3d place = point ? f.position : Vec3d(f.rotation.col(axis));
    if (f.body < 0) return constant(point, point ? Vec3d(place - l_.origin) : place);
    const Body& b = l_.bodies[f.body];
    const Eigen::RowVectorXd sum = homogeneous(point, place).transpose() * b.base;
    Combination c;
    Vec3d value = Vec3d::Zero();
    bool is_constant = true;
    for (std::size_t k = 0; k < b.variables.size(); ++k) {
      const double x = sum[static_cast<Eigen::Index>(k)];
      if (std::abs(x) * size_of_variable(b.variables[k]) < round_off * size_of_value(point)) continue;
      c.push_back({b.variables[k], std::abs(x - 1) < round_off ? 1.0 : x});
      if (b.variables[k] >= 0)
        is_constant = false;
      else
        value += x * constants_[-1 - b.variables[k]].place;
    }
    std::sort(c.begin(), c.end());
    return is_constant && c.size() > 1 ? constant(point, value) : c;
  }

  bool rigid(int frame) const { return m_.frames[frame].flexible < 0; }

  double size_of(int body) const {
    double size = 0;
    for (const Side& s : sides_[body])
      for (const Side& t : sides_[body])
        size = std::max(size, (m_.frames[s.own].position - m_.frames[t.own].position).norm());
    return size;
  }

  /// Adds a slot if it is independent of the others; `sum` empty: a new variable.
  bool add_slot(int body, bool point, const Vec3d& place, std::optional<Combination> sum) {
    std::vector<Slot>& slots = slots_[body];
    if (slots.size() == 4) return false;
    const auto reference = std::find_if(slots.begin(), slots.end(), [](const Slot& s) { return s.point; });
    const bool first_point = point && reference == slots.end();
    if (!first_point) {
      const std::vector<Vec3d> basis = directions(slots);
      if (basis.size() == 3) return false;
      Vec3d d = point ? Vec3d(place - reference->place) : place;
      const double length = d.norm();
      // Short or nearly dependent ones make the body's frame a badly conditioned combination.
      if (point && !(length > std::max(0.3 * size_of(body), shortest * m_.length_scale))) return false;
      for (const Vec3d& b : basis) d -= b.dot(d) * b;
      if (!(d.norm() > 0.3 * length)) return false;
    }
    if (sum) {
      std::vector<int> used;
      for (const Slot& s : slots)
        for (const auto& [variable, factor] : s.sum) used.push_back(variable);
      for (const auto& [variable, factor] : *sum) used.push_back(variable);
      std::sort(used.begin(), used.end());
      used.erase(std::unique(used.begin(), used.end()), used.end());
      if (static_cast<int>(used.size()) > most_variables - (4 - static_cast<int>(slots.size()))) return false;
    } else {
      l_.variables.push_back({point, body, place});
      sum = Combination{{static_cast<int>(l_.variables.size()) - 1, 1.0}};
    }
    slots.push_back({point, place, *sum});
    return true;
  }

  /// Chooses the four points and vectors of a body: those it shares with bodies that are defined already (and
  /// the ground), then those that bodies to come will share, then its own.
  void define(int body) {
    const auto share = [&](bool defined) {
      for (const bool point : {true, false})
        for (const Side& s : sides_[body]) {
          const int other = m_.frames[s.other].body;
          const bool other_defined = other < body;
          if (other_defined != defined || other == body || !rigid(s.own) || !rigid(s.other)) continue;
          const Coincidence c = coincidence(s.joint);
          const FrameData& f = m_.frames[s.own];
          const auto item = [&](int axis) {
            return defined ? std::optional(of_frame(s.other, point, axis)) : std::nullopt;
          };
          if (point && c.point) add_slot(body, true, f.position, item(0));
          for (int axis = 2; !point && axis >= 0; --axis)
            if (c.axis[axis]) add_slot(body, false, f.rotation.col(axis), item(axis));
        }
    };
    share(true);
    share(false);
    std::vector<Slot>& slots = slots_[body];
    if (std::none_of(slots.begin(), slots.end(), [](const Slot& s) { return s.point; }))
      add_slot(body, true, Vec3d::Zero(), std::nullopt);
    // The rest: unit vectors at right angles to what there is, as far as possible along the body's axes.
    while (slots.size() < 4) {
      const std::vector<Vec3d> basis = directions(slots);
      Vec3d best = Vec3d::Zero();
      for (int axis = 0; axis < 3; ++axis) {
        Vec3d d = Vec3d::Unit(axis);
        for (const Vec3d& b : basis) d -= b.dot(d) * b;
        if (d.norm() > best.norm() + 1e-9) best = d;
      }
      add_slot(body, false, best.normalized(), std::nullopt);
    }
    express(body);
  }

  /// [r0 u v w] as a combination of the variables in the slots, and the equations of rigidity.
  void express(int body) {
    Body& b = l_.bodies[body];
    const std::vector<Slot>& slots = slots_[body];
    Eigen::Matrix4d h;
    for (int k = 0; k < 4; ++k) {
      h.col(k) = homogeneous(slots[k].point, slots[k].place);
      for (const auto& [variable, factor] : slots[k].sum) b.variables.push_back(variable);
    }
    std::sort(b.variables.begin(), b.variables.end(), [](int x, int y) {  // unknown ones first
      return (x < 0) != (y < 0) ? x >= 0 : x < y;
    });
    b.variables.erase(std::unique(b.variables.begin(), b.variables.end()), b.variables.end());
    bodies_of_.resize(l_.variables.size());
    for (const int variable : b.variables)
      if (variable >= 0) bodies_of_[variable].push_back(body);
    b.inertia = resistances_.of(body).inertia;
    b.unknown = static_cast<int>(
        std::count_if(b.variables.begin(), b.variables.end(), [](int variable) { return variable >= 0; }));
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(4, static_cast<Eigen::Index>(b.variables.size()));
    for (int k = 0; k < 4; ++k)
      for (const auto& [variable, factor] : slots[k].sum)
        sums(k, std::find(b.variables.begin(), b.variables.end(), variable) - b.variables.begin()) = factor;
    b.base = h.inverse().transpose() * sums;
    for (Eigen::Index k = 0; k < b.base.cols(); ++k)
      for (Eigen::Index r = 0; r < 4; ++r)
        if (std::abs(b.base(r, k)) * size_of_variable(b.variables[static_cast<std::size_t>(k)]) <
            1e-2 * round_off * size_of_value(r == 0))
          b.base(r, k) = 0;

    // Directions: from the first point to the others, and the vectors.
    int reference = 0, direction = 0;
    while (!slots[reference].point) ++reference;
    Combination vectors[3];
    for (int k = 0; k < 4; ++k) {
      if (k == reference) continue;
      const Vec3d d = slots[k].point ? Vec3d(slots[k].place - slots[reference].place) : slots[k].place;
      b.directions.col(direction) = d.normalized();
      b.lengths[direction] = slots[k].point ? d.norm() : m_.length_scale;
      vectors[direction++] =
          slots[k].point ? difference(slots[k].sum, slots[reference].sum, true) : slots[k].sum;
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j)
        if (!implied(body, vectors[i], vectors[j])) b.rigidity.push_back({i, j});
  }

  /// Whether one body defined before, or the ground, carries both vectors: their product is its affair.
  bool implied(int body, const Combination& x, const Combination& y) const {
    if (carries(-1, x) && carries(-1, y)) return true;
    // A body carries a vector only if it has all of its unknown variables.
    const auto unknown = [](const Combination& vector) {
      return std::find_if(vector.begin(), vector.end(), [](const auto& term) { return term.first >= 0; });
    };
    const auto of_x = unknown(x), of_y = unknown(y);
    if (of_x == x.end() && of_y == y.end()) return false;
    const std::vector<int>& others = bodies_of_[of_x == x.end() ? of_y->first : of_x->first];
    return std::any_of(others.begin(), others.end(),
                       [&](int other) { return other < body && carries(other, x) && carries(other, y); });
  }

  /// Whether a vector is constant in a body's axes (-1: the ground), whatever the unknowns are. That the body
  /// has all its variables is not enough: of those that it has only in a sum it does not fix each.
  bool carries(int body, const Combination& vector) const {
    if (body < 0)
      return std::all_of(vector.begin(), vector.end(), [](const auto& term) { return term.first < 0; });
    // The vector as a combination of u, v, w: the same factors of unknowns, the same sum of constants.
    const Body& b = l_.bodies[body];
    Eigen::MatrixX3d axes = Eigen::MatrixX3d::Zero(b.unknown + 3, 3);
    Eigen::VectorXd wanted = Eigen::VectorXd::Zero(b.unknown + 3);
    for (std::size_t k = 0; k < b.variables.size(); ++k) {
      const auto factors = b.base.col(static_cast<Eigen::Index>(k)).tail<3>().transpose();
      if (b.variables[k] >= 0)
        axes.row(static_cast<Eigen::Index>(k)) = size_of_variable(b.variables[k]) * factors;
      else
        axes.bottomRows<3>() += constants_[-1 - b.variables[k]].place * factors;
    }
    for (const auto& [variable, factor] : vector) {
      if (variable < 0) {
        wanted.tail<3>() += factor * constants_[-1 - variable].place;
        continue;
      }
      const auto last = b.variables.begin() + b.unknown;
      const auto found = std::find(b.variables.begin(), last, variable);
      if (found == last) return false;
      wanted[found - b.variables.begin()] = size_of_variable(variable) * factor;
    }
    const Vec3d place = shortest_solution(axes, wanted);
    return (axes * place - wanted).norm() <= alike * wanted.norm();
  }

  /// Modal amplitudes behind the variables; stencils of the bodies.
  void number() {
    l_.unknown_variables = static_cast<int>(l_.variables.size());
    l_.unknowns = 3 * l_.unknown_variables;
    for (int k = 0; k < count(); ++k) {
      const BodyData& data = m_.bodies[k];
      Body& b = l_.bodies[k];
      b.q = l_.unknowns;
      l_.unknowns += data.modes;
      if (data.modes > 0) {
        b.amplitudes = l_.amplitude_storage;
        l_.amplitude_storage += m_.flexible[data.flexible].stride;
      }
      b.mass(0, 0) = data.mass;
      b.mass.block<3, 1>(1, 0) = data.first_moment;
      b.mass.block<1, 3>(0, 1) = data.first_moment.transpose();
      b.mass.bottomRightCorner<3, 3>() = data.second_moment;
      b.variable_mass = b.base.leftCols(b.unknown).transpose() * b.mass * b.base.leftCols(b.unknown);
      for (int v = 0; v < b.unknown; ++v)
        for (int c = 0; c < 3; ++c) b.stencil.columns.push_back(3 * b.variables[v] + c);
      for (int i = 0; i < data.modes; ++i) b.stencil.columns.push_back(b.q + i);
      b.stencil.stride = pad(b.stencil.size());
      b.jacobian = add_jacobian(b.stencil, static_cast<int>(b.rigidity.size()));
    }
    l_.positions = l_.unknowns;
  }

  /// Constants follow the unknown variables.
  void place_constants() {
    l_.variables.insert(l_.variables.end(), constants_.begin(), constants_.end());
    for (Body& b : l_.bodies)
      for (int& variable : b.variables)
        if (variable < 0) variable = l_.unknown_variables - 1 - variable;
  }

  // --- Joints and forces --------------------------------------------------------------------------------

  int add_jacobian(const Stencil& stencil, int rows) {
    const int offset = l_.jacobian_storage;
    l_.jacobian_storage += rows * stencil.stride;
    return offset;
  }

  void add_columns(int body, std::vector<int>& columns) const {
    if (body < 0) return;
    const std::vector<int>& own = l_.bodies[body].stencil.columns;
    columns.insert(columns.end(), own.begin(), own.end());
  }
  /// What the stencil is when it has all its columns.
  static void close(Stencil& stencil) {
    std::vector<int>& columns = stencil.columns;
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    stencil.stride = pad(stencil.size());
  }
  std::vector<int> places_in(const Stencil& stencil, int body) const {
    std::vector<int> places;
    if (body < 0) return places;
    for (int column : l_.bodies[body].stencil.columns)
      places.push_back(
          static_cast<int>(std::lower_bound(stencil.columns.begin(), stencil.columns.end(), column) -
                           stencil.columns.begin()));
    return places;
  }

  Link make_link(int frame_a, int frame_b, int rows) {
    Link link;
    link.body_a = frame_a < 0 ? -1 : m_.frames[frame_a].body;
    link.body_b = m_.frames[frame_b].body;
    for (int body : {link.body_a, link.body_b}) add_columns(body, link.stencil.columns);
    close(link.stencil);
    link.columns_a = places_in(link.stencil, link.body_a);
    link.columns_b = places_in(link.stencil, link.body_b);
    link.jacobian = add_jacobian(link.stencil, rows);
    return link;
  }

  /// Of a sum, over the columns of all of its legs, whose links are there.
  Link make_sum(const ElementData& e) {
    Link link;
    std::vector<int>& columns = link.stencil.columns;
    for (const Leg& leg : e.legs) {
      const std::vector<int>& of = l_.elements[leg.element].stencil.columns;
      columns.insert(columns.end(), of.begin(), of.end());
    }
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    for (const Leg& leg : e.legs) {
      std::vector<int>& places = link.legs.emplace_back();
      for (const int column : l_.elements[leg.element].stencil.columns)
        places.push_back(
            static_cast<int>(std::lower_bound(columns.begin(), columns.end(), column) - columns.begin()));
    }
    link.stencil.stride = pad(link.stencil.size());
    link.jacobian = add_jacobian(link.stencil, 1);
    return link;
  }

  ConstraintLink make_link(const ConstraintData& constraint) {
    ConstraintLink link;
    for (const ConstraintTerm& t : constraint.terms)
      for (const int frame : {t.frame_a, t.frame_b}) add_columns(m_.frames[frame].body, link.stencil.columns);
    close(link.stencil);
    for (const ConstraintTerm& t : constraint.terms) {
      const int a = m_.frames[t.frame_a].body, b = m_.frames[t.frame_b].body;
      link.terms.push_back({a, b, places_in(link.stencil, a), places_in(link.stencil, b)});
    }
    link.jacobian = add_jacobian(link.stencil, constraint.count);
    return link;
  }

  void joints() {
    const auto add = [&](int spec) {
      const spec::Joint& j = m_.spec().joints[spec];
      const JointInfo& info = joint_info(j.type);
      Joint joint;
      joint.spec = spec;
      joint.frame_a = m_.frame_of_spec[j.frame_a];
      joint.frame_b = m_.frame_of_spec[j.frame_b];
      const auto shared = [&](bool point, int axis) {
        return coincide(joint.frame_a, joint.frame_b, point, axis);
      };
      const bool shared_point = shared(true, 0);
      const bool shared_axis[3] = {shared(false, 0), shared(false, 1), shared(false, 2)};
      const double mass = m_.mass_scale, angle = m_.length_scale * m_.length_scale;
      const BodyResistance least =
          resistances_.least(m_.frames[joint.frame_a].body, m_.frames[joint.frame_b].body);
      const auto equation = [&](const JointEquation& e) {
        for (int k = 0; k < e.count(); ++k)
          joint.scale[joint.count++] =
              (e.kind == JointEquation::Kind::angle ? penalty_scale(mass * angle, least.inertia)
                                                    : penalty_scale(mass, least.mass)) /
              mass;
        joint.equations.push_back(e);
      };
      int distances = 0;
      for (int k = 0; k < info.equations; ++k)
        distances += info.closure[k].kind == LoopClosure::Kind::distance;
      if (distances == 3 && !shared_point) equation({JointEquation::Kind::coincidence, 0, 0});
      for (int k = 0; k < info.equations; ++k) {
        const LoopClosure& e = info.closure[k];
        if (e.kind == LoopClosure::Kind::distance) {
          if (distances < 3 && !shared_point) equation({JointEquation::Kind::distance, e.axis_a, 0});
        } else if (!shared_axis[e.axis_a] && !shared_axis[e.axis_b]) {
          equation({JointEquation::Kind::angle, e.axis_a, e.axis_b});
        }
      }
      if (joint.count == 0) return;
      joint.link = make_link(joint.frame_a, joint.frame_b, joint.count);
      l_.joints.push_back(std::move(joint));
    };
    for (const BodyData& b : m_.bodies) add(b.joint_spec);
    for (const LoopData& loop : m_.loops) add(loop.joint_spec);
  }

  /// Whether both frames of a joint have the same point or axis, whatever the unknowns are.
  bool coincide(int frame_a, int frame_b, bool point, int axis) {
    if (!rigid(frame_a) || !rigid(frame_b)) return false;
    Vec3d constants = Vec3d::Zero();
    for (const auto& [variable, factor] :
         difference(of_frame(frame_a, point, axis), of_frame(frame_b, point, axis), point)) {
      if (variable >= 0) return false;
      constants += factor * constants_[-1 - variable].place;
    }
    return constants.norm() < alike * size_of_value(point);
  }

  void coordinates() {
    for (int b = 0; b < count(); ++b) {
      const BodyData& body = m_.bodies[b];
      const spec::Joint& j = m_.spec().joints[body.joint_spec];
      l_.joint_coordinates.push_back(
          {b, m_.frame_of_spec[j.frame_a], m_.frame_of_spec[j.frame_b], l_.positions});
      l_.positions += body.joint_positions;
    }
  }

  void forces() {
    std::vector<int> widest(m_.swarms.size(), 0);
    for (std::size_t k = 0; k < m_.swarms.size(); ++k) {
      std::vector<Link>& spheres = l_.spheres.emplace_back();
      for (const SwarmSphere& sphere : m_.swarms[k].spheres) {
        spheres.push_back(make_link(-1, sphere.frame, 0));
        widest[k] = std::max(widest[k], spheres.back().stencil.stride);
      }
    }
    for (const ElementData& e : m_.elements) {
      if (e.measure != Measure::sum && !e.pooled) {
        l_.elements.push_back(make_link(e.frame_a, e.frame_b, e.count));
        continue;
      }
      l_.elements.emplace_back();
      if (!e.pooled) continue;
      l_.elements.back().jacobian = l_.jacobian_storage;
      l_.jacobian_storage += 2 * e.count * widest[e.spec];
    }
    for (const int k : m_.sums) l_.elements[k] = make_sum(m_.elements[k]);
    const auto on_joint = [&](int body) {
      const JointCoordinate& c = l_.joint_coordinates[body];
      return make_link(c.frame_a, c.frame_b, 1);
    };
    for (const DriveData& d : m_.drives) l_.drives.push_back(on_joint(d.body));
    for (const ConstraintData& c : m_.constraints) l_.constraints.push_back(make_link(c));
  }

  void equations() {
    for (Body& b : l_.bodies) {
      b.first_equation = l_.equations;
      l_.equations += static_cast<int>(b.rigidity.size());
    }
    for (Joint& j : l_.joints) {
      j.first_equation = l_.equations;
      l_.equations += j.count;
    }
    l_.first_drive = l_.equations;
    l_.equations += static_cast<int>(l_.drives.size());
    for (std::size_t k = 0; k < l_.constraints.size(); ++k) {
      l_.constraints[k].first_equation = l_.equations;
      l_.equations += m_.constraints[k].count;
    }
  }

  void frames_in_use() {
    l_.frame_use.assign(m_.frames.size(), 0);
    const auto use = [&](int frame, char how) { l_.frame_use[frame] = std::max(l_.frame_use[frame], how); };
    for (const Joint& j : l_.joints) use(j.frame_a, 2), use(j.frame_b, 2);
    for (const ElementData& e : m_.elements) {
      if (e.measure == Measure::sum || e.pooled) continue;
      const char how = needs_axes(e.measure) ? 2 : 1;
      use(e.frame_b, how);
      if (e.frame_a >= 0) use(e.frame_a, how);
    }
    for (const SwarmData& swarm : m_.swarms)
      for (const SwarmSphere& sphere : swarm.spheres) use(sphere.frame, 2);
    for (const SensorData& s : m_.sensors)
      for (const int frame : {s.frame, s.reference})
        if (frame >= 0) use(frame, 2);
    const auto joint = [&](int body) {
      use(l_.joint_coordinates[body].frame_a, 2), use(l_.joint_coordinates[body].frame_b, 2);
    };
    for (const DriveData& d : m_.drives) joint(d.body);
    for (const ConstraintData& c : m_.constraints)
      for (const ConstraintTerm& t : c.terms) use(t.frame_a, 2), use(t.frame_b, 2);
    for (int f = m_.dynamic_frames; f < static_cast<int>(m_.frames.size()); ++f)
      if (l_.frame_use[f] > 0 && m_.frames[f].body >= 0) l_.late_frames.push_back(f);
  }

  // --- Matrix -------------------------------------------------------------------------------------------

  void matrix() {
    linalg::BlockPattern pattern;
    std::vector<int> block_of(l_.unknowns), within(l_.unknowns);
    const auto add_block = [&](int first, int size) {
      for (int k = 0; k < size; ++k) {
        block_of[first + k] = static_cast<int>(pattern.sizes.size());
        within[first + k] = k;
      }
      pattern.sizes.push_back(size);
    };
    for (int k = 0; k < l_.unknown_variables; ++k) add_block(3 * k, 3);
    for (int b = 0; b < count(); ++b)
      if (m_.bodies[b].modes > 0) add_block(l_.bodies[b].q, m_.bodies[b].modes);
    const auto for_stencils = [&](const auto& f) {
      for (Body& b : l_.bodies) f(b.stencil);
      for (Joint& j : l_.joints) f(j.link.stencil);
      for (std::size_t k = 0; k < l_.elements.size(); ++k)
        if (m_.elements[k].measure != Measure::none) f(l_.elements[k].stencil);
      for (std::vector<Link>& spheres : l_.spheres)
        for (Link& link : spheres) f(link.stencil);
      for (Link& link : l_.drives) f(link.stencil);
      for (ConstraintLink& link : l_.constraints) f(link.stencil);
    };
    for_stencils([&](const Stencil& s) {
      for (int c : s.columns)
        for (int d : s.columns) pattern.couplings.push_back({block_of[c], block_of[d]});
    });
    std::sort(pattern.couplings.begin(), pattern.couplings.end());
    pattern.couplings.erase(std::unique(pattern.couplings.begin(), pattern.couplings.end()),
                            pattern.couplings.end());
    l_.symbolic = std::make_shared<const linalg::BlockSymbolic>(pattern);
    for_stencils([&](Stencil& s) {
      l_.widest = std::max(l_.widest, s.stride);
      for (int r = 0; r < s.size(); ++r)
        for (int c = 0; c <= r; ++c) {
          const int i = s.columns[r], j = s.columns[c];
          const linalg::BlockPlace p = l_.symbolic->place(block_of[i], block_of[j]);
          s.targets.push_back(p.offset + within[i] * p.row_stride + within[j] * p.col_stride);
        }
    });
  }

  const Compiled& m_;
  Layout& l_;
  BodyResistances resistances_;
  std::vector<std::vector<Side>> sides_;           // by body
  std::vector<std::vector<Slot>> slots_;           // by body
  std::vector<Variable> constants_;                // numbered -1, -2, … until all are known
  std::multimap<double, int> constants_along_[2];  // vectors and points among these, by a direction
  std::vector<std::vector<int>> bodies_of_;        // that have an unknown variable, in their order
};

}  // namespace

Layout::Layout(const Compiled& model) { Builder(model, *this).run(); }

}  // namespace mimbre::natural

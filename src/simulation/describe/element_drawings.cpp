#include "simulation/describe/element_drawings.h"

#include <fmt/format.h>

#include <algorithm>

#include "joints/joint_kind.h"
#include "math/rotation.h"
#include "math/space_curve.h"
#include "spec/constraint_kind.h"
#include "spec/force_law.h"

namespace mimbre {
namespace {

const char* spring_kind(bool elastic, bool damping) {
  if (elastic && damping) return "spring damper";
  if (elastic) return "spring";
  return damping ? "damper" : "actuator";
}

/// About or along which of its axes a joint moves in this coordinate.
char moving_axis(spec::JointType type, int coordinate) {
  return joint_info(type).moves[static_cast<std::size_t>(coordinate)];
}

/// "torsional spring about z", "sliding spring damper along x"
std::string joint_spring_kind(spec::JointType type, int coordinate, bool elastic, bool damping) {
  const bool turns = is_angle(type, coordinate);
  return fmt::format("{} {} {} {}", turns ? "torsional" : "sliding", spring_kind(elastic, damping),
                     turns ? "about" : "along", moving_axis(type, coordinate));
}

/// The points of a curve as it is drawn: an open one as far as its points go, a closed one all around.
Eigen::Matrix3Xd drawn_curve(const spec::Constraint& c) {
  const SpaceCurve curve = space_curve(c.points, c.closed);
  const Eigen::Index count = std::min<Eigen::Index>(16 * static_cast<Eigen::Index>(c.points.size()), 2000);
  Eigen::Matrix3Xd points(3, count + 1);
  CurvePoint<double> at;
  for (Eigen::Index k = 0; k <= count; ++k) {
    curve_point(curve, curve.length * static_cast<double>(k) / static_cast<double>(count), at);
    points.col(k) = at.value[0];
  }
  return points;
}

/// "motor about z": of a law on a joint's coordinate.
std::string joint_law_kind(const LawInfo& law, spec::JointType type, int coordinate) {
  return fmt::format("{} {} {}", law.drawn_at_joint, is_angle(type, coordinate) ? "about" : "along",
                     moving_axis(type, coordinate));
}

class Collector {
 public:
  Collector(const Compiled& model, const std::vector<BodyDrawing>& bodies)
      : model_(model), bodies_(bodies), place_(model.spec().frames.size(), -1) {}

  void add(const std::string& name, const std::string& kind, int frame_a, int frame_b, double size = 0) {
    const int a = frame(frame_a), b = frame(frame_b);
    drawn.elements.push_back({name, kind, a, b, size, {}});
  }

  /// Between the first of some joints and each of the others.
  template <class Terms>
  void add_coupling(const std::string& name, const std::string& kind, const Terms& terms) {
    const auto place = [&](std::size_t k) {
      return model_.spec().joints[static_cast<std::size_t>(terms[k].joint)].frame_b;
    };
    for (std::size_t k = 1; k < terms.size(); ++k)
      if (terms[k].joint != terms[0].joint) add(name, kind, place(0), place(k));
  }

  ElementDrawings drawn;

 private:
  /// A frame is drawn once, however many elements it has.
  int frame(int of_spec) {
    if (of_spec < 0) return -1;
    int& place = place_[static_cast<std::size_t>(of_spec)];
    if (place >= 0) return place;
    place = static_cast<int>(drawn.frames.size());
    const spec::Frame& f = model_.spec().frames[of_spec];
    const FrameData& data = model_.frames[model_.frame_of_spec[of_spec]];
    const int modes = f.body == spec::ground ? 0 : bodies_[static_cast<std::size_t>(f.body)].modes;
    FrameDrawing drawing{f.name, f.body, f.pose, Eigen::MatrixXd::Zero(6, modes)};
    // The model's rows may be padded beyond the modes.
    const auto fill = [&](int row, const auto& shapes) {
      const Eigen::Index count = std::min<Eigen::Index>(modes, shapes.cols());
      drawing.motion.block(row, 0, 3, count) = shapes.leftCols(count);
    };
    if (data.flexible >= 0) fill(0, data.X.matrix());
    if (data.flexible >= 0 && data.turns) {
      // Of beams by absolute nodal coordinates the change of slope: it turns by along × that.
      const bool slope = data.turn == FrameTurn::slope || data.turn == FrameTurn::direction;
      fill(3, slope ? Eigen::MatrixXd(skew<double>(data.along) * data.X_theta.matrix())
                    : Eigen::MatrixXd(data.X_theta.matrix()));
    }
    drawn.frames.push_back(std::move(drawing));
    return place;
  }

  const Compiled& model_;
  const std::vector<BodyDrawing>& bodies_;
  std::vector<int> place_;  ///< frame of the spec → frame drawn
};

/// Where a force element acts; what turns or pushes two frames along an axis has no place of its own.
void add_element(const spec::Model& model, const spec::Element& e, Collector& all) {
  using On = spec::Element::On;
  const LawInfo& law = law_info(find_law(e.law));
  switch (e.on) {
    case On::line:
      return all.add(e.name, std::string(law.drawn_along), e.frame_a, e.frame_b);
    case On::path:
      for (std::size_t k = 1; k < e.path.size(); ++k) all.add(e.name, "actuator", e.path[k - 1], e.path[k]);
      return;
    case On::coordinate: {
      const spec::Joint& joint = model.joints[static_cast<std::size_t>(e.joint)];
      return all.add(e.name, joint_law_kind(law, joint.type, e.coordinate), joint.frame_a, joint.frame_b);
    }
    case On::coordinates:
      return all.add_coupling(e.name, "coupling spring", e.terms);
    case On::frames:
      return all.add(e.name, "bushing", e.frame_a, e.frame_b);
    case On::velocity:
      return all.add(e.name, "drag", e.frame_b, -1);
    case On::axis:
      return;
  }
}

}  // namespace

ElementDrawings element_drawings(const Compiled& model, const std::vector<BodyDrawing>& bodies) {
  Collector all(model, bodies);
  for (const spec::Joint& joint : model.spec().joints)
    all.add(joint.name, std::string(joint_info(joint.type).name), joint.frame_a, joint.frame_b);
  for (const spec::Spring& spring : model.spec().springs)
    all.add(spring.name, spring_kind(!spring.elastic.is_zero(), !spring.damping.is_zero()), spring.frame_a,
            spring.frame_b);
  for (const spec::Joint& joint : model.spec().joints)
    for (const spec::JointSpring& spring : joint.springs) {
      const bool elastic = !spring.elastic.is_zero(), damping = !spring.damping.is_zero();
      if (elastic || damping)
        all.add(joint.name, joint_spring_kind(joint.type, spring.coordinate, elastic, damping), joint.frame_a,
                joint.frame_b);
    }
  for (const spec::Element& e : model.spec().elements) add_element(model.spec(), e, all);
  for (const spec::Constraint& c : model.spec().constraints) {
    const ConstraintInfo& info = constraint_info(find_constraint(c.type));
    if (info.of_coordinates)
      all.add_coupling(c.name, c.type, c.terms);
    else if (!info.on_road)  // the wheel on the road is seen by itself
      all.add(c.name, c.type, c.frame_a, c.frame_b);
    if (info.curve) all.drawn.elements.back().curve = drawn_curve(c);
  }
  for (const spec::Load& load : model.spec().loads) all.add(load.name, "load", load.frame, -1);
  for (const spec::Tyre& tyre : model.spec().tyres) {
    const bool moves = model.spec().roads[tyre.road].over == spec::Road::Over::time;
    all.add(tyre.name, moves ? "tyre on rig" : "tyre", tyre.frame, -1, tyre.radius);
  }
  return std::move(all.drawn);
}

}  // namespace mimbre

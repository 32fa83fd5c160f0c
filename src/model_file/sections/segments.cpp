#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "fe/elements/beam_element.h"
#include "model_file/text/builder.h"
#include "spec/output_kind.h"

/// Finite segments (Huston 1981; Wittbrodt, Adamiec-Wójcik, Wojciech 2006): bars become rigid segments, one
/// at each node of the mesh, that reach to the middles of the elements there, and each element becomes a
/// joint with springs at its middle. In the relative motion of an element's halves its stiffness is diagonal:
/// EA/L, 12 EI/(L³ (1 + Φ)) across, GJ/L, EI/L. With turning alone the elements neither stretch nor shear.
namespace mimbre::model_file {
namespace {

/// A rigid segment: the halves of the elements at one node.
struct Segment {
  int node = -1;
  int body = -1;                                     ///< of the model
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< of its frame, in the axes of the whole
  double mass = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();   ///< ∫ r dm from its origin
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about its origin
  std::vector<std::array<Eigen::Vector3d, 2>> lines;
};

Eigen::Matrix3d of_points(double mass, const Eigen::Vector3d& r) {
  return mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
}

/// Half an element, from its end (0 or 1) to its middle.
void add_half(Segment& segment, const fe::BeamElement& element, const fe::ElementGeometry& at, int end) {
  const double half = 0.5 * at.length, density = element.material.density,
               mass = density * element.section.area * half;
  const Eigen::Vector3d x = at.axes.col(0), middle = at.start + half * x - segment.origin,
                        tip = middle + (end == 0 ? -half : half) * x, centre = 0.5 * (middle + tip);
  // Rigid bodies have the inertia of their sections, whatever the theory of the bar.
  Eigen::Vector3d turning(fe::polar_inertia(element), density * element.section.Iy,
                          density * element.section.Iz);
  turning *= half;
  turning.tail<2>().array() += mass * half * half / 12;
  segment.mass += mass;
  segment.moment += mass * centre;
  segment.inertia += at.axes * turning.asDiagonal() * at.axes.transpose() + of_points(mass, centre);
  segment.lines.push_back({tip, middle});
}

/// Bodies, joints and springs of one whole as they are added to the model.
class SegmentAssembly {
 public:
  SegmentAssembly(Builder& builder, int body)
      : builder_(builder),
        body_(body),
        whole_(*builder.bodies[static_cast<std::size_t>(body)].description),
        segments_(static_cast<std::size_t>(whole_.mesh.nodes.cols())) {}

  bool make() {
    if (whole_.options.clamped_nodes.size() != 1)
      return fail(fmt::format("segments need bars that are clamped at one node; here {} are",
                              whole_.options.clamped_nodes.size()));
    frames_ = static_cast<int>(builder_.model.frames.size());
    outputs_frame_ = builder_.frame_names.index.at(first().name);
    const int root = whole_.options.clamped_nodes.front();
    segment(root).node = root;
    segment(root).body = body_;
    add_elements(root);
    for (const Segment& s : segments_)
      if (s.node < 0)
        return fail("some bars are not connected with the clamped node; bars of segments must hang together");
    for (const Segment& s : segments_) set_inertia(s);
    move_frames();
    return move_outputs();
  }

 private:
  spec::Body& first() { return builder_.model.bodies[static_cast<std::size_t>(body_)]; }
  Segment& segment(int node) { return segments_[static_cast<std::size_t>(node)]; }
  bool fail(const std::string& message) {
    builder_.errors.add(whole_.mark, fmt::format("{}: {}", whole_.what, message));
    return false;
  }

  /// From the root outwards; what closes a loop comes when both its nodes are known.
  void add_elements(int root) {
    const int count = static_cast<int>(whole_.mesh.elements.size());
    std::vector<bool> done(static_cast<std::size_t>(count), false);
    std::vector<int> reached{root};
    for (std::size_t next = 0; next < reached.size(); ++next)
      for (int e = 0; e < count; ++e) {
        const fe::BeamElement& element = whole_.mesh.elements[static_cast<std::size_t>(e)];
        const int side = element.nodes[0] == reached[next] ? 0 : element.nodes[1] == reached[next] ? 1 : -1;
        if (side < 0 || done[static_cast<std::size_t>(e)]) continue;
        done[static_cast<std::size_t>(e)] = true;
        const int other = element.nodes[static_cast<std::size_t>(1 - side)];
        const bool is_new = segment(other).node < 0;
        if (is_new) {
          add_segment(other);
          reached.push_back(other);
        }
        const fe::ElementGeometry at = fe::element_geometry(whole_.mesh, e);
        for (int end = 0; end < 2; ++end)
          add_half(segment(element.nodes[static_cast<std::size_t>(end)]), element, at, end);
        connect(element, at, reached[next], other, is_new);
      }
  }

  void add_segment(int node) {
    Segment& s = segment(node);
    s.node = node;
    s.origin = whole_.mesh.nodes.col(node);
    s.body = static_cast<int>(builder_.model.bodies.size());
    spec::Body added;
    added.name = fmt::format("{}.{}", first().name, ++added_ + 1);
    added.mark = first().mark;
    added.pose = {first().pose.position + first().pose.rotation * s.origin, first().pose.rotation};
    builder_.claim(builder_.body_names, builder_.parts.front(), added.name, added.mark, s.body);
    builder_.model.bodies.push_back(std::move(added));
    builder_.bodies.emplace_back();
  }

  int add_frame(const std::string& name, const Segment& s, const spec::Pose& pose) {
    const int frame = builder_.add_frame({name, first().mark, s.body, pose, -1});
    builder_.claim(builder_.frame_names, builder_.parts.front(), name, first().mark, frame);
    return frame;
  }

  /// The joint and the springs at an element's middle.
  void connect(const fe::BeamElement& element, const fe::ElementGeometry& at, int from, int to,
               bool in_tree) {
    const std::string name = fmt::format("{}.{}", first().name, ++joints_);
    const Eigen::Vector3d middle = at.start + 0.5 * at.length * at.axes.col(0);
    Eigen::Matrix3d axes = at.axes;
    const bool planar = !whole_.normal.isZero(0), stretches = whole_.kind == BeamKind::stretching_segments;
    if (planar) {  // whose joints turn about z
      axes.col(2) = whole_.normal;
      axes.col(1) = axes.col(2).cross(axes.col(0));
    }
    spec::Joint joint;
    joint.name = name + ".joint";
    joint.mark = first().mark;
    if (planar)
      joint.type = stretches ? spec::JointType::planar : spec::JointType::revolute;
    else
      joint.type = stretches ? spec::JointType::floating : spec::JointType::spherical;
    joint.frame_a = add_frame(joint.name + ".a", segment(from), {middle - segment(from).origin, axes});
    joint.frame_b = add_frame(joint.name + ".b", segment(to), {middle - segment(to).origin, axes});
    joint.elastic = true;
    joint.cut = in_tree ? spec::Joint::Cut::never : spec::Joint::Cut::always;
    add_springs(name + ".springs", element, at, axes, joint, stretches);
    // A joint that is free in everything closes no loop.
    const bool free = joint.type == spec::JointType::floating;
    if (!in_tree && free) return;
    builder_.claim(builder_.joint_names, builder_.parts.front(), joint.name, joint.mark,
                   static_cast<int>(builder_.model.joints.size()));
    builder_.model.joints.push_back(std::move(joint));
  }

  void add_springs(const std::string& name, const fe::BeamElement& element, const fe::ElementGeometry& at,
                   const Eigen::Matrix3d& axes, const spec::Joint& joint, bool stretches) {
    const double L = at.length;
    const auto stiffness = fe::element_stiffness(element, L);
    const fe::ShearRatio shear = fe::shear_ratio(element, L);
    const double E = element.material.young, Iy = element.section.Iy, Iz = element.section.Iz;
    Eigen::Matrix<double, 6, 6> K = Eigen::Matrix<double, 6, 6>::Zero();
    if (stretches)
      K.diagonal().head<3>() << stiffness(0, 0), 12 * E * Iz / (L * L * L * (1 + shear.xy)),
          12 * E * Iy / (L * L * L * (1 + shear.xz));
    K.diagonal().tail<3>() << stiffness(3, 3), E * Iy / L, E * Iz / L;
    // From the element's axes to the joint's.
    Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = axes.transpose() * at.axes;
    K = turn * K * turn.transpose();
    spec::Element springs;
    springs.name = name;
    springs.mark = first().mark;
    springs.law = "bushing";
    springs.on = spec::Element::On::frames;
    springs.frame_a = joint.frame_a;
    springs.frame_b = joint.frame_b;
    for (const double factor : {1.0, whole_.options.stiffness_damping})
      for (int r = 0; r < 6; ++r)
        for (int c = 0; c < 6; ++c) springs.numbers.push_back(0.5 * factor * (K(r, c) + K(c, r)));
    Names& names = builder_.element_names["bushings"];
    builder_.claim(names, builder_.parts.front(), name, springs.mark,
                   static_cast<int>(builder_.model.elements.size()));
    builder_.model.elements.push_back(std::move(springs));
  }

  void set_inertia(const Segment& s) {
    spec::Body& body = builder_.model.bodies[static_cast<std::size_t>(s.body)];
    body.mass = s.mass;
    body.com = s.moment / s.mass;
    body.inertia = s.inertia - of_points(s.mass, body.com);
    body.lines = s.lines;
    BodyInfo& info = builder_.bodies[static_cast<std::size_t>(s.body)];
    info.flexible = false;
    info.description.reset();
  }

  /// Frames at nodes go to the segment of the node.
  void move_frames() {
    for (int f = 0; f < frames_; ++f) {
      spec::Frame& frame = builder_.model.frames[static_cast<std::size_t>(f)];
      if (frame.body != body_ || frame.flexible_frame < 0) continue;
      const Segment& s = segment(whole_.frames[static_cast<std::size_t>(frame.flexible_frame)].node);
      frame.body = s.body;
      frame.pose.position -= s.origin;
      frame.flexible_frame = -1;
    }
  }

  /// The mass is that of all segments; deflections are seen from the frame of the whole.
  bool move_outputs() {
    for (spec::Output& output : builder_.model.outputs) {
      const OutputInfo& kind = output_info(output);
      if (kind.modes && output.item == body_) {
        builder_.errors.add(output.mark,
                            fmt::format("output '{}': body '{}' is made of rigid segments and has "
                                        "no modal amplitudes; take the displacement of a node",
                                        output.name, first().name));
        return false;
      }
      if (std::find(output.bodies.begin(), output.bodies.end(), body_) != output.bodies.end())
        for (const Segment& s : segments_)
          if (s.body != body_) output.bodies.push_back(s.body);
      if (kind.seen_from_elsewhere.empty() || output.item < 0) continue;
      const spec::Frame& frame = builder_.model.frames[static_cast<std::size_t>(output.item)];
      const auto found = std::find_if(segments_.begin(), segments_.end(),
                                      [&](const Segment& s) { return s.body == frame.body; });
      if (found == segments_.end()) continue;
      output.kind = kind.seen_from_elsewhere;
      output.reference = outputs_frame_;
      output.offset = -output.direction.dot(found->origin + frame.pose.position);
    }
    return true;
  }

  Builder& builder_;
  int body_;
  FlexibleDescription whole_;
  std::vector<Segment> segments_;  ///< by node
  int frames_ = 0, outputs_frame_ = -1;
  int added_ = 0, joints_ = 0;
};

}  // namespace

void segment_bodies(Builder& builder) {
  const std::size_t count = builder.bodies.size();
  for (std::size_t k = 0; k < count; ++k) {
    const auto& description = builder.bodies[k].description;
    if (!description || !builder.bodies[k].flexible || !description->in_segments()) continue;
    try {
      SegmentAssembly(builder, static_cast<int>(k)).make();
    } catch (const std::invalid_argument& error) {
      builder.errors.add(builder.model.bodies[k].mark, error.what());
    }
  }
}

}  // namespace mimbre::model_file

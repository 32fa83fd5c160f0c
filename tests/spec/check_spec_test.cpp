#include "spec/check/check_spec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "joints/joint_kind.h"
#include "mimbre/reduced_body.h"
#include "mimbre/simulation.h"
#include "mimbre/surface_mesh.h"
#include "support/models.h"
#include "support/random_mechanism.h"

/// Good specs are spoilt in every way that is known, and at random.
namespace mimbre::test::check_spec_test {
namespace {

using Kind = std::string;
using spec::JointType;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

void add_output(spec::Model& m, const Kind& kind, int item, int component = 0) {
  spec::Output o;
  o.name = "output " + std::to_string(m.outputs.size());
  o.kind = kind;
  o.item = item;
  o.component = component;
  if (kind == "deflection" || kind == "displacement") o.direction = Vec3d::UnitX();
  if (kind == "displacement") o.reference = 0;
  m.outputs.push_back(o);
}

/// An input, signals of time, input and motion, an actuator for each way to act, a torsion spring that a
/// signal makes softer, a bushing with a branch.
void add_signals(spec::Model& m) {
  using spec::Source;
  m.inputs.push_back({"input", {}, "N", 0.5, 0, 1});
  m.sensors.push_back(m.outputs.front());
  m.sensors.back().name = "sensor";
  m.signals.push_back(
      {"of time",
       {},
       "",
       {Formula::expression("3*t + u", {"t", "u"}), {{Source::Kind::time}, {Source::Kind::input, 0}}}});
  m.signals.push_back({"of motion",
                       {},
                       "",
                       {Formula::expression("0.1*x + u", {"x", "u"}),
                        {{Source::Kind::sensor, 0}, {Source::Kind::signal, 0}}}});
  spec::Element e;
  e.law = "actuator";
  e.frame_a = m.springs[0].frame_a;
  e.frame_b = m.springs[0].frame_b;
  e.arguments = {{Source::Kind::signal, 1}};
  for (const auto on : {spec::Element::On::line, spec::Element::On::axis, spec::Element::On::coordinate}) {
    e.name = "actuator " + std::to_string(m.elements.size());
    e.on = on;
    if (on == spec::Element::On::coordinate) {
      for (std::size_t k = 0; k < m.joints.size() && e.joint < 0; ++k)
        if (joint_info(m.joints[k].type).quaternion < 0 && joint_info(m.joints[k].type).velocities > 0)
          e.joint = static_cast<int>(k);
      if (e.joint < 0) continue;
    }
    m.elements.push_back(e);
  }
  if (const int joint = e.joint; joint >= 0) {
    e = {};
    e.name = "torsion spring";
    e.law = "torsion_spring";
    e.on = spec::Element::On::coordinates;
    e.terms = {{joint, 0, 0.5}};
    e.functions = {Function::linear(10), Function{}};
    e.general = {Formula::expression("-u*x", {"x", "v", "u"}), {{Source::Kind::signal, 0}}};
    m.elements.push_back(e);
  }
  e = {};
  e.name = "bushing";
  e.law = "bushing";
  e.on = spec::Element::On::frames;
  e.frame_a = m.springs[0].frame_a;
  e.frame_b = m.springs[0].frame_b;
  e.numbers.assign(72, 0.0);
  for (std::size_t k = 0; k < 6; ++k) e.numbers[7 * k] = 10;
  e.branches.push_back({Eigen::Matrix<double, 6, 6>::Identity(), 0.1});
  m.elements.push_back(e);
}

/// A mechanism with something of everything.
spec::Model good_spec(unsigned seed) {
  RandomOptions options;
  options.bodies = 4;
  options.loops = static_cast<int>(seed % 2);
  options.springs = options.damping = options.tyres = options.loads = true;
  options.drives = seed % 3 == 0;
  spec::Model m = random_mechanism(seed, options).model->spec();
  for (const char* kind : {"position", "velocity", "acceleration", "roll", "pitch", "yaw", "deflection",
                           "displacement", "angular_velocity"})
    add_output(m, kind, 1);
  for (std::size_t k = 0; k < m.joints.size(); ++k) {
    add_output(m, "joint_force", static_cast<int>(k), 5);
    if (joint_info(m.joints[k].type).velocities > 0) add_output(m, "joint_velocity", static_cast<int>(k));
  }
  for (std::size_t k = 0; k < m.bodies.size(); ++k)
    if (m.bodies[k].flexible) add_output(m, "modal_amplitude", static_cast<int>(k), 1);
  for (const char* kind : {"centre_of_mass", "linear_momentum", "angular_momentum"})
    add_output(m, kind, -1, 2);
  m.outputs.back().bodies = {0, 2};
  add_output(m, "spring_force", 0);
  add_output(m, "spring_length", 2);
  add_output(m, "tyre_force", 1);
  m.bodies[0].shapes.push_back({spec::Shape::Kind::box, {}, {1, 1, 1}});
  m.bodies[1].lines.push_back({Vec3d::Zero(), Vec3d::UnitX()});
  add_signals(m);
  return m;
}

std::string message_of(const spec::Model& model) {
  try {
    check_spec(model);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

/// What a mistake must be called in its message; nothing where the model has nothing to spoil in this way.
using Called = std::optional<std::string>;

struct Mistake {
  const char* name;
  std::function<Called(spec::Model&, Random&)> make;
  const char* says;  ///< a part of the message
};

void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.name; }

template <class Items>
auto* any(Items& items, Random& random) {
  return &items[static_cast<std::size_t>(random.index(static_cast<int>(items.size())))];
}
template <class Items, class Which>
auto* any(Items& items, Random& random, Which&& which) {
  std::vector<decltype(&items[0])> fitting;
  for (auto& item : items)
    if (which(item)) fitting.push_back(&item);
  return fitting.empty() ? nullptr : *any(fitting, random);
}

std::string called(const char* kind, const std::string& name) {
  return std::string(kind) + " '" + name + "'";
}

bool rigid(const spec::Body& b) { return !b.flexible; }
bool flexible(const spec::Body& b) { return b.flexible != nullptr; }

/// A mistake in any item of a list.
template <class Items, class Spoil>
Mistake in(const char* name, const char* kind, Items spec::Model::*list, const char* says, Spoil spoil) {
  return {name,
          [=](spec::Model& m, Random& random) -> Called {
            auto* item = any(m.*list, random);
            spoil(*item, m, random);
            return called(kind, item->name);
          },
          says};
}
template <class Items, class Which, class Spoil>
Mistake in(const char* name, const char* kind, Items spec::Model::*list, Which which, const char* says,
           Spoil spoil) {
  return {name,
          [=](spec::Model& m, Random& random) -> Called {
            auto* item = any(m.*list, random, which);
            if (!item) return {};
            spoil(*item, m, random);
            return called(kind, item->name);
          },
          says};
}
template <class Spoil>
Mistake in_reduced(const char* name, const char* says, Spoil spoil) {
  return in(name, "body", &spec::Model::bodies, flexible, says,
            [=](spec::Body& b, spec::Model& m, Random& random) {
              auto spoilt = std::make_shared<ReducedBody>(*b.flexible);
              spoil(*spoilt, random);
              for (spec::Body& other : m.bodies)  // the first that has it is the one that is named
                if (&other != &b && other.flexible == b.flexible)
                  other.flexible = std::make_shared<const ReducedBody>(*b.flexible);
              b.flexible = spoilt;
            });
}
template <class Spoil>
Mistake in_simulation(const char* name, const char* says, Spoil spoil) {
  return {name,
          [=](spec::Model& m, Random&) -> Called {
            spoil(m.simulation);
            return "simulation";
          },
          says};
}
auto of_kind(std::set<Kind> kinds) {
  return [=](const spec::Output& o) { return kinds.contains(o.kind); };
}

spec::Drive drive(int coordinate, Function law = Function::constant(0)) {
  return {coordinate, std::move(law), spec::Drive::Of::position};
}

double bad_number(Random& random) {
  return random.chance(0.5) ? nan : random.chance(0.5) ? infinity : -infinity;
}
int bad_index(Random& random) {
  return random.chance(0.5) ? -2 - random.index(1000) : 1000 + random.index(1 << 30);
}

const std::vector<Mistake>& mistakes() {
  using M = spec::Model;
  using B = spec::Body;
  using F = spec::Frame;
  using J = spec::Joint;
  using O = spec::Output;
  using S = spec::Simulation;
  using R = ReducedBody;
  // clang-format off
  static const std::vector<Mistake> all{
      // Names.
      {"body without a name", [](M& m, Random&) -> Called { m.bodies[1].name.clear(); return "body 1"; }, "has no name"},
      {"two frames of one name",
       [](M& m, Random&) -> Called { return called("frame", m.frames[3].name = m.frames[1].name); }, "another frame"},
      {"two bodies of one name",
       [](M& m, Random&) -> Called { return called("body", m.bodies[3].name = m.bodies[1].name); }, "rename"},
      {"two joints of one name",
       [](M& m, Random&) -> Called { return called("joint", m.joints[2].name = m.joints[1].name); }, "rename"},
      {"two outputs of one name",
       [](M& m, Random&) -> Called { return called("output", m.outputs[2].name = m.outputs[0].name); }, "rename"},
      {"two springs of one name",
       [](M& m, Random&) -> Called { return called("spring", m.springs[2].name = m.springs[0].name); }, "rename"},
      {"load without a name", [](M& m, Random&) -> Called { m.loads[2].name.clear(); return "load 2"; }, "has no name"},
      in("output with a comma", "output", &M::outputs, "column", [](O& o, M&, Random&) { o.name += ", x"; }),
      // Bodies.
      in("body's place", "body", &M::bodies, "finite", [](B& b, M&, Random& r) { b.pose.position[1] = bad_number(r); }),
      in("body's axes", "body", &M::bodies, "finite", [](B& b, M&, Random& r) { b.pose.rotation(0, 1) = bad_number(r); }),
      in("body's axes stretched", "body", &M::bodies, "no rotation", [](B& b, M&, Random&) { b.pose.rotation *= 1.001; }),
      in("body's axes left-handed", "body", &M::bodies, "left-handed", [](B& b, M&, Random&) { b.pose.rotation.col(2) *= -1; }),
      in("mass below 0", "body", &M::bodies, rigid, "0 or more", [](B& b, M&, Random& r) { b.mass = -r.number(1e-9, 5); }),
      in("mass no number", "body", &M::bodies, rigid, "finite", [](B& b, M&, Random& r) { b.mass = bad_number(r); }),
      in("mass 0 with inertia", "body", &M::bodies, rigid, "make both 0", [](B& b, M&, Random&) { b.mass = 0; }),
      in("com", "body", &M::bodies, rigid, "com", [](B& b, M&, Random& r) { b.com[2] = bad_number(r); }),
      in("inertia no number", "body", &M::bodies, rigid, "inertia", [](B& b, M&, Random& r) { b.inertia(1, 1) = bad_number(r); }),
      in("inertia not symmetric", "body", &M::bodies, rigid, "symmetric", [](B& b, M&, Random&) { b.inertia(0, 1) += 0.01; }),
      in("inertia negative", "body", &M::bodies, rigid, "positive definite", [](B& b, M&, Random&) { b.inertia *= -1; }),
      in("triangle inequality", "body", &M::bodies, rigid, "triangle",
         [](B& b, M& m, Random&) {
           b.inertia = Vec3d(1, 1, 2.1).asDiagonal();
           for (J& j : m.joints) j.apart = true;  // nothing is known of how the body turns
         }),
      in("shape without size", "body", &M::bodies, "size of a shape", [](B& b, M&, Random&) { b.shapes.push_back({}); }),
      in("shape of no kind", "body", &M::bodies, "kind of a shape",
         [](B& b, M&, Random&) { b.shapes.push_back({static_cast<spec::Shape::Kind>(9), {}, {1, 1, 1}}); }),
      in("mesh of no size", "body", &M::bodies, "size of a shape is 0",
         [](B& b, M&, Random&) { b.shapes.push_back({spec::Shape::Kind::mesh, {}, {1, 0, 1}}); }),
      in("mesh that is not there", "body", &M::bodies, "has none",
         [](B& b, M&, Random&) { b.shapes.push_back({spec::Shape::Kind::mesh, {}, {1, 1, -1}}); }),
      in("mesh with a vertex missing", "body", &M::bodies, "ends at vertex 3",
         [](B& b, M&, Random&) {
           b.shapes.push_back({spec::Shape::Kind::mesh, {}, {1, 1, 1}});
           b.shapes.back().mesh = std::make_shared<const SurfaceMesh>(
               SurfaceMesh{Eigen::Matrix3Xd::Identity(3, 3), {{0, 1, 3}}});
         }),
      in("line", "body", &M::bodies, "line",
         [](B& b, M&, Random& r) { b.lines.push_back({Vec3d::Zero(), Vec3d(0, bad_number(r), 0)}); }),
      // Reduced bodies.
      in_reduced("modes", "reduced body", [](R& b, Random& r) { b.modes += r.chance(0.5) ? 1 : -100; }),
      in_reduced("S", "S", [](R& b, Random&) { b.S.resize(3, 1); }),
      in_reduced("S_modes", "S_modes", [](R& b, Random&) { b.S_modes[1][2](0, 0) = nan; }),
      in_reduced("mass matrix", "mass_matrix", [](R& b, Random&) { b.mass_matrix *= -1; }),
      in_reduced("stiffness", "stiffness", [](R& b, Random&) { b.stiffness(0, 1) += 1e3 * b.stiffness.cwiseAbs().maxCoeff(); }),
      in_reduced("damping", "damping", [](R& b, Random& r) { b.damping(0, 0) = bad_number(r); }),
      in_reduced("mass", "mass", [](R& b, Random&) { b.mass = 0; }),
      in_reduced("node's modes", "X", [](R& b, Random&) { b.frames[1].X.resize(3, 0); }),
      in_reduced("line of no nodes", "line", [](R& b, Random&) { b.lines.push_back({0, 1 << 20}); }),
      in_reduced("user_from_modal", "user_from_modal", [](R& b, Random&) { b.user_from_modal.resize(0, 0); }),
      in_reduced("boundary rotation", "boundary_rotation",
         [](R& b, Random&) { b.boundary_rotation = static_cast<BoundaryRotation>(7); }),
      in_reduced("beam", "beam", [](R& b, Random&) {
        b.ancf.emplace();
        b.ancf->elements.emplace_back();
      }),
      // Frames.
      in("frame's body", "frame", &M::frames, "bodies", [](F& f, M&, Random& r) { f.body = bad_index(r); }),
      in("frame's place", "frame", &M::frames, "finite", [](F& f, M&, Random& r) { f.pose.position[0] = bad_number(r); }),
      in("frame's axes", "frame", &M::frames, "no rotation", [](F& f, M&, Random&) { f.pose.rotation.setZero(); }),
      in("frame left-handed", "frame", &M::frames, "left-handed", [](F& f, M&, Random&) { f.pose.rotation *= -1; }),
      in("frame's node below", "frame", &M::frames, "flexible_frame", [](F& f, M&, Random&) { f.flexible_frame = -7; }),
      in("frame's node", "frame", &M::frames, [](const F& f) { return f.flexible_frame >= 0; }, "flexible_frame",
         [](F& f, M&, Random& r) { f.flexible_frame = 4 + r.index(1 << 30); }),
      in("frame's other node", "frame", &M::frames, [](const F& f) { return f.flexible_frame >= 0; }, "m away",
         [](F& f, M&, Random&) { f.flexible_frame = (f.flexible_frame + 1) % 4; }),
      {"node of a rigid body",
       [](M& m, Random& random) -> Called {
         F* f = any(m.frames, random, [&](const F& x) { return x.body >= 0 && rigid(m.bodies[static_cast<std::size_t>(x.body)]); });
         if (!f) return {};
         f->flexible_frame = 0;
         return called("frame", f->name);
       },
       "is rigid"},
      // Joints.
      in("frame a of a joint", "joint", &M::joints, "frame_a", [](J& j, M&, Random& r) { j.frame_a = bad_index(r); }),
      in("frame b of a joint", "joint", &M::joints, "frame_b",
         [](J& j, M& m, Random&) { j.frame_b = static_cast<int>(m.frames.size()); }),
      in("joint of a body with itself", "joint", &M::joints, "both sides", [](J& j, M&, Random&) { j.frame_b = j.frame_a; }),
      in("type of a joint", "joint", &M::joints, "type",
         [](J& j, M&, Random& r) { j.type = static_cast<JointType>(bad_index(r)); }),
      in("cut of a joint", "joint", &M::joints, "cut", [](J& j, M&, Random& r) { j.cut = static_cast<J::Cut>(bad_index(r)); }),
      in("too many positions", "joint", &M::joints, "initial_position",
         [](J& j, M&, Random&) { j.initial_position.assign(9, 0.0); }),
      in("too many velocities", "joint", &M::joints, "initial_velocity",
         [](J& j, M&, Random&) { j.initial_velocity.assign(9, 0.0); }),
      in("initial velocity", "joint", &M::joints, [](const J& j) { return joint_info(j.type).velocities > 0; }, "initial_velocity",
         [](J& j, M&, Random& r) { j.initial_velocity.assign(static_cast<std::size_t>(joint_info(j.type).velocities), std::nullopt);
           j.initial_velocity[0] = bad_number(r); }),
      in("drive of no coordinate", "joint", &M::joints, "drive", [](J& j, M&, Random& r) { j.drives = {drive(bad_index(r))}; }),
      in("drive of a rotation", "joint", &M::joints, [](const J& j) { return j.type == JointType::spherical; }, "no scalar coordinate",
         [](J& j, M&, Random&) { j.drives = {drive(0)}; }),
      in("drive of a held joint", "joint", &M::joints, [](const J& j) { return j.type == JointType::fixed; }, "no scalar coordinate",
         [](J& j, M&, Random&) { j.drives = {drive(0)}; }),
      in("driven twice", "joint", &M::joints, [](const J& j) { return j.type == JointType::revolute; }, "driven twice",
         [](J& j, M&, Random&) { j.drives = {drive(0), drive(0)}; }),
      in("drive without a law", "joint", &M::joints, [](const J& j) { return j.type == JointType::prismatic; }, "no law",
         [](J& j, M&, Random&) { j.drives = {drive(0, {})}; }),
      in("drive that is not finite", "joint", &M::joints, [](const J& j) { return j.type == JointType::revolute; }, "finite",
         [](J& j, M&, Random&) { j.drives = {drive(0, Function::expression("1/t", "t"))}; }),
      in("drive against its start", "joint", &M::joints, [](const J& j) { return j.type == JointType::revolute; }, "contradicts",
         [](J& j, M&, Random&) { j.drives = {drive(0, Function::constant(1))}; j.initial_position = {2.0}; }),
      in("spring of no coordinate", "joint", &M::joints, "spring",
         [](J& j, M&, Random& r) { j.springs = {{bad_index(r), Function::linear(1), {}}}; }),
      in("joint's spring without force", "joint", &M::joints, [](const J& j) { return j.type == JointType::cylindrical; }, "no force",
         [](J& j, M&, Random&) { j.springs = {{1, {}, {}}}; }),
      // Springs, loads, roads, tyres.
      in("end a of a spring", "spring", &M::springs, "frame_a", [](spec::Spring& s, M&, Random& r) { s.frame_a = bad_index(r); }),
      in("end b of a spring", "spring", &M::springs, "frame_b", [](spec::Spring& s, M&, Random& r) { s.frame_b = bad_index(r); }),
      in("spring without length", "spring", &M::springs, "length 0", [](spec::Spring& s, M&, Random&) { s.frame_b = s.frame_a; }),
      in("spring without force", "spring", &M::springs, "no force",
         [](spec::Spring& s, M&, Random&) { s.elastic = s.damping = {}; s.general = {}; }),
      in("frame of a load", "load", &M::loads, "frame", [](spec::Load& l, M&, Random& r) { l.frame = bad_index(r); }),
      in("force of a load", "load", &M::loads, "force", [](spec::Load& l, M&, Random& r) { l.force[0] = bad_number(r); }),
      in("moment of a load", "load", &M::loads, "moment", [](spec::Load& l, M&, Random& r) { l.moment[2] = bad_number(r); }),
      in("load without scale", "load", &M::loads, "scale", [](spec::Load& l, M&, Random&) { l.scale = {}; }),
      in("load on the ground", "load", &M::loads, "ground",
         [](spec::Load& l, M& m, Random&) { l.frame = static_cast<int>(m.frames.size());
           m.frames.push_back({"on the ground", {}, -1, {}, -1}); }),
      in("road without height", "road", &M::roads, "height", [](spec::Road& x, M&, Random&) { x.height = {}; }),
      in("road over nothing", "road", &M::roads, "over",
         [](spec::Road& x, M&, Random& r) { x.over = static_cast<spec::Road::Over>(bad_index(r)); }),
      in("road drawn backwards", "road", &M::roads, "beyond", [](spec::Road& x, M&, Random&) { x.draw_from = 2; x.draw_to = 1; }),
      in("frame of a tyre", "tyre", &M::tyres, "frame", [](spec::Tyre& t, M&, Random& r) { t.frame = bad_index(r); }),
      in("road of a tyre", "tyre", &M::tyres, "roads", [](spec::Tyre& t, M&, Random& r) { t.road = bad_index(r); }),
      in("stiffness of a tyre", "tyre", &M::tyres, "stiffness",
         [](spec::Tyre& t, M&, Random& r) { t.stiffness = r.chance(0.5) ? 0 : bad_number(r); }),
      in("radius of a tyre", "tyre", &M::tyres, "radius", [](spec::Tyre& t, M&, Random& r) { t.radius = -r.number(0, 1); }),
      in("law of a tyre", "tyre", &M::tyres, "no law 'tire'", [](spec::Tyre& t, M&, Random&) { t.law = "tire"; }),
      in("numbers of a brush", "tyre", &M::tyres, "has 10 numbers, 0 are given", [](spec::Tyre& t, M&, Random&) { t.law = "brush_tyre"; }),
      in("a negative number of a brush", "tyre", &M::tyres, "friction is -1",
         [](spec::Tyre& t, M&, Random&) { t.law = "brush_tyre", t.numbers = {0, 1, 1, -1, 1, 1, 1, 0, 0, 0}; }),
      in("axis of a wheel", "tyre", &M::tyres, "axis has no length",
         [](spec::Tyre& t, M&, Random&) { t.law = "brush_tyre", t.axis.setZero(), t.numbers.assign(10, 1); }),
      in("numbers of a formula", "tyre", &M::tyres, "numbers, 0 are given", [](spec::Tyre& t, M&, Random&) { t.law = "magic_tyre"; }),
      in("grid without heights", "road", &M::roads, "0 × 0 heights", [](spec::Road& x, M&, Random&) { x.over = spec::Road::Over::grid; }),
      in("spacing of a grid", "road", &M::roads, "spacing along y",
         [](spec::Road& x, M&, Random&) { x.over = spec::Road::Over::grid, x.heights.setZero(2, 2), x.spacing[1] = 0; }),
      in("friction of a road", "road", &M::roads, "friction", [](spec::Road& x, M&, Random& r) { x.friction = -r.number(0.1, 1); }),
      in("a patch of a road", "road", &M::roads, "along x", [](spec::Road& x, M&, Random&) { x.patches.push_back({{1, 0}, {0, 1}, 1}); }),
      // Outputs.
      in("start of an input", "input", &M::inputs, "start", [](spec::Input& i, M&, Random& r) { i.start = bad_number(r); }),
      in("start outside of the range", "input", &M::inputs, "range", [](spec::Input& i, M&, Random&) { i.max = i.start - 1; i.min = i.start - 2; }),
      in("empty range", "input", &M::inputs, "empty", [](spec::Input& i, M&, Random&) { i.min = 2; i.max = 1; }),
      in("hold of an input", "input", &M::inputs, "hold", [](spec::Input& i, M&, Random& r) { i.hold = static_cast<spec::Input::Hold>(bad_index(r)); }),
      in("signal without formula", "signal", &M::signals, "formula", [](spec::Signal& s, M&, Random&) { s.law.formula = {}; }),
      in("negative interval", "signal", &M::signals, "every", [](spec::Signal& s, M&, Random&) { s.every = -0.1; }),
      in("interval no number", "signal", &M::signals, "every", [](spec::Signal& s, M&, Random& r) { s.every = bad_number(r); }),
      in("argument too many", "signal", &M::signals, "variables", [](spec::Signal& s, M&, Random&) { s.law.arguments.push_back({}); }),
      in("argument of no kind", "signal", &M::signals, "kind", [](spec::Signal& s, M&, Random& r) {
           s.law.arguments.at(0).kind = static_cast<spec::Source::Kind>(bad_index(r)); }),
      in("argument that is not there", "signal", &M::signals, "argument", [](spec::Signal& s, M&, Random& r) {
           s.law.arguments.at(0) = {spec::Source::Kind::signal, bad_index(r)}; }),
      in("sensor that is not there", "signal", &M::signals, "argument", [](spec::Signal& s, M&, Random& r) {
           s.law.arguments.at(0) = {spec::Source::Kind::sensor, bad_index(r)}; }),
      in("item of a sensor", "sensor", &M::sensors, "item", [](O& o, M&, Random& r) { o.item = bad_index(r); }),
      in("law that is none", "element", &M::elements, "no law", [](spec::Element& e, M&, Random&) { e.law = "actuater"; }),
      in("law elsewhere", "element", &M::elements, "does not act", [](spec::Element& e, M&, Random&) { e.on = e.law == "bushing" ? spec::Element::On::line : spec::Element::On::frames; }),
      in("place of no kind", "element", &M::elements, "on", [](spec::Element& e, M&, Random& r) { e.on = static_cast<spec::Element::On>(bad_index(r)); }),
      in("joint of an element", "element", &M::elements, [](const spec::Element& e) { return e.on == spec::Element::On::coordinate; }, "joint",
         [](spec::Element& e, M&, Random& r) { e.joint = bad_index(r); }),
      in("coordinate of an element", "element", &M::elements, [](const spec::Element& e) { return e.on == spec::Element::On::coordinate; }, "coordinate",
         [](spec::Element& e, M&, Random& r) { e.coordinate = bad_index(r); }),
      in("frame of an element", "element", &M::elements, [](const spec::Element& e) { return e.joint < 0 && e.terms.empty(); }, "frame",
         [](spec::Element& e, M&, Random& r) { e.frame_b = bad_index(r); }),
      in("axis without length", "element", &M::elements, [](const spec::Element& e) { return e.on == spec::Element::On::axis; }, "direction",
         [](spec::Element& e, M&, Random&) { e.direction.setZero(); }),
      in("numbers of an element", "element", &M::elements, "numbers", [](spec::Element& e, M&, Random& r) { e.numbers.push_back(bad_number(r)); }),
      in("signals of an element", "element", &M::elements, "signals", [](spec::Element& e, M&, Random&) { e.arguments.push_back({}); }),
      in("formula of a torsion spring", "element", &M::elements, [](const spec::Element& e) { return !e.terms.empty(); }, "its formula has 3 variables",
         [](spec::Element& e, M&, Random&) { e.general.arguments.clear(); }),
      in("signal of a torsion spring", "element", &M::elements, [](const spec::Element& e) { return !e.terms.empty(); }, "argument",
         [](spec::Element& e, M&, Random& r) { e.general.arguments[0].index = bad_index(r); }),
      in("torsion spring without a force", "element", &M::elements, [](const spec::Element& e) { return !e.terms.empty(); }, "specifies no force",
         [](spec::Element& e, M&, Random&) { e.general = {}; e.functions[0] = {}; }),
      in("formula of another law", "element", &M::elements, [](const spec::Element& e) { return e.law == "actuator"; }, "has no formula 'general'",
         [](spec::Element& e, M&, Random&) { e.general = {Formula::expression("x", {"x", "v"}), {}}; }),
      in("user without a function", "element", &M::elements, "function", [](spec::Element& e, M&, Random&) { e.law = "user"; e.arguments.clear(); e.numbers.clear(); e.branches.clear(); }),
      in("relaxation of a branch", "element", &M::elements, [](const spec::Element& e) { return !e.branches.empty(); }, "relaxation",
         [](spec::Element& e, M&, Random&) { e.branches[0].relaxation = 0; }),
      in("stiffness that is not symmetric", "element", &M::elements, [](const spec::Element& e) { return e.law == "bushing"; }, "symmetric",
         [](spec::Element& e, M&, Random&) { e.numbers[1] = 1e3; }),
      in("branch that is not symmetric", "element", &M::elements, [](const spec::Element& e) { return !e.branches.empty(); }, "symmetric",
         [](spec::Element& e, M&, Random&) { e.branches[0].stiffness(0, 4) = 1e3; }),
      in("kind of an output", "output", &M::outputs, "kind",
         [](O& o, M&, Random&) { o.kind = "none"; }),
      in("item of an output", "output", &M::outputs, [](const O& o) { return o.item >= 0; }, "item",
         [](O& o, M&, Random& r) { o.item = bad_index(r); }),
      in("component of an output", "output", &M::outputs, [](const O& o) { return o.component > 0; }, "component",
         [](O& o, M&, Random& r) { o.component = bad_index(r); }),
      in("component of a place", "output", &M::outputs, of_kind({"position", "velocity", "angular_velocity", "linear_momentum"}), "component",
         [](O& o, M&, Random&) { o.component = 3; }),
      in("offset of an output", "output", &M::outputs, "offset", [](O& o, M&, Random& r) { o.offset = bad_number(r); }),
      in("direction of an output", "output", &M::outputs, of_kind({"deflection", "displacement"}), "direction",
         [](O& o, M&, Random& r) { o.direction = Vec3d::Constant(r.chance(0.5) ? 0 : bad_number(r)); }),
      in("reference of an output", "output", &M::outputs, of_kind({"displacement"}), "reference",
         [](O& o, M&, Random& r) { o.reference = bad_index(r); }),
      in("bodies of an output", "output", &M::outputs, of_kind({"centre_of_mass", "angular_momentum"}), "bodies",
         [](O& o, M&, Random& r) { o.bodies = {0, bad_index(r)}; }),
      in("a body twice", "output", &M::outputs, of_kind({"linear_momentum"}), "twice",
         [](O& o, M&, Random&) { o.bodies = {1, 0, 1}; }),
      in("about", "output", &M::outputs, of_kind({"angular_momentum"}), "about",
         [](O& o, M&, Random& r) { o.about = Vec3d(0, bad_number(r), 0); }),
      {"coordinate of a held joint",
       [](M& m, Random& random) -> Called {
         J* j = any(m.joints, random, [](const J& x) { return joint_info(x.type).velocities == 0; });
         if (!j) return {};
         add_output(m, "joint", static_cast<int>(j - m.joints.data()));
         return called("output", m.outputs.back().name);
       },
       "no scalar coordinate"},
      {"mode of a rigid body",
       [](M& m, Random& random) -> Called {
         B* b = any(m.bodies, random, rigid);
         if (!b) return {};
         add_output(m, "modal_amplitude", static_cast<int>(b - m.bodies.data()));
         return called("output", m.outputs.back().name);
       },
       "has no modes"},
      {"stress of beams",
       [](M& m, Random& random) -> Called {
         B* b = any(m.bodies, random, flexible);
         if (!b) return {};
         add_output(m, random.chance(0.5) ? "stress" : "strain", static_cast<int>(b - m.bodies.data()));
         return called("output", m.outputs.back().name);
       },
       "modes; reduce"},
      {"momentum of nothing",
       [](M& m, Random&) -> Called {
         m.bodies.emplace_back();
         m.bodies.back().name = "nothing";
         add_output(m, "linear_momentum", -1);
         m.outputs.back().bodies = {static_cast<int>(m.bodies.size()) - 1};
         return called("output", m.outputs.back().name);
       },
       "has no mass"},
      // The simulation.
      {"gravity", [](M& m, Random& r) -> Called { m.gravity[1] = bad_number(r); return "model"; }, "gravity"},
      {"no bodies", [](M& m, Random&) -> Called { m = {}; return "model"; }, "no body"},
      in_simulation("step", "step", [](S& s) { s.step = 0; }),
      in_simulation("step no number", "step", [](S& s) { s.step = nan; }),
      in_simulation("end", "end", [](S& s) { s.end = -1; }),
      in_simulation("endless", "end", [](S& s) { s.end = infinity; }),
      in_simulation("step beyond the end", "longer", [](S& s) { s.step = 2 * s.end; }),
      in_simulation("too many steps", "too many", [](S& s) { s.step = 1e-300; }),
      in_simulation("output interval", "output_interval", [](S& s) { s.output_interval = 1.5 * s.step; }),
      in_simulation("rho", "rho", [](S& s) { s.rho = 1.5; }),
      in_simulation("rho no number", "rho", [](S& s) { s.rho = nan; }),
      in_simulation("rho of hht", "rho", [](S& s) { s.integrator = S::Integrator::hht; s.rho = 0.4; }),
      in_simulation("rho of newmark", "rho", [](S& s) { s.integrator = S::Integrator::newmark; s.rho = 0.4; }),
      in_simulation("xi", "xi", [](S& s) { s.integrator = S::Integrator::newmark; s.xi = 0.1; }),
      in_simulation("xi elsewhere", "xi", [](S& s) { s.xi = -0.1; }),
      in_simulation("formulation", "formulation", [](S& s) { s.formulation = static_cast<S::Formulation>(2); }),
      in_simulation("inertia", "inertia", [](S& s) { s.inertia = static_cast<S::Inertia>(-1); }),
      in_simulation("formalism", "formalism", [](S& s) { s.formalism = static_cast<S::Formalism>(66); }),
      in_simulation("integrator", "integrator", [](S& s) { s.integrator = static_cast<S::Integrator>(66); }),
      in_simulation("accuracy", "accuracy", [](S& s) { s.accuracy = 1e-6; }),
      in_simulation("tolerance", "tolerance", [](S& s) { s.tolerance = -1e-3; }),
      in_simulation("penalty", "penalty", [](S& s) { s.penalty = infinity; }),
      in_simulation("iterations", "max_iterations", [](S& s) { s.max_iterations = -1; }),
      in_simulation("substeps", "substeps", [](S& s) { s.substeps = 1 << 30; }),
  };
  // clang-format on
  return all;
}

constexpr unsigned seeds = 6;

class Mistakes : public testing::TestWithParam<Mistake> {};

TEST_P(Mistakes, AreNamed) {
  const Mistake& mistake = GetParam();
  int made = 0;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    Random random(900 + seed);
    spec::Model model = good_spec(seed);
    const Called name = mistake.make(model, random);
    if (!name) continue;
    ++made;
    const std::string message = message_of(model);
    EXPECT_THAT(message, testing::HasSubstr(*name)) << mistake.name << ", seed " << seed;
    EXPECT_THAT(message, testing::HasSubstr(mistake.says)) << mistake.name << ", seed " << seed;
    EXPECT_THROW(Model::compile(model), InputError);
  }
  EXPECT_GE(made, 1);
  RecordProperty("made", made);
}

INSTANTIATE_TEST_SUITE_P(Spec, Mistakes, testing::ValuesIn(mistakes()), [](const auto& mistake) {
  std::string name = mistake.param.name;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
});

TEST(CheckSpec, FindsNothingInGoodSpecs) {
  for (unsigned seed = 0; seed < 3 * seeds; ++seed) EXPECT_EQ(message_of(good_spec(seed)), "") << seed;
}

TEST(CheckSpec, KeepsMarksAndSaysAllAtOnce) {
  spec::Model m = good_spec(1);
  m.joints[0].mark = {"my.yaml", 7, 3};
  m.joints[0].frame_a = 70;
  m.tyres[1].radius = -1;
  try {
    check_spec(m);
    FAIL();
  } catch (const InputError& error) {
    ASSERT_EQ(error.diagnostics().size(), 2);
    EXPECT_EQ(to_string(error.diagnostics()[0]), "my.yaml:7:3: joint '" + m.joints[0].name +
                                                     "': frame_a is 70, but the model has " +
                                                     std::to_string(m.frames.size()) + " frames (0 to " +
                                                     std::to_string(m.frames.size() - 1) + ")");
    EXPECT_EQ(to_string(error.diagnostics()[1]), "tyre 'tyre1': radius is -1; it must be positive");
  }
}

TEST(CheckSpec, PointMassesAndThinRodsAreBodies) {
  spec::Model m = good_spec(0);
  for (const Vec3d& moments : {Vec3d(0, 0, 0), Vec3d(0, 1, 1), Vec3d(1, 1, 2)}) {
    for (spec::Body& b : m.bodies)
      if (!b.flexible) b.inertia = moments.asDiagonal();
    EXPECT_EQ(message_of(m), "");
  }
}

/// Every number of a spec.
struct Numbers {
  std::vector<int*> integers;
  std::vector<double*> reals;

  explicit Numbers(spec::Model& m) {
    const auto real = [&](auto& values) {
      for (Eigen::Index k = 0; k < values.size(); ++k) reals.push_back(values.data() + k);
    };
    const auto pose = [&](spec::Pose& p) { real(p.position), real(p.rotation); };
    real(m.gravity);
    for (auto& b : m.bodies) pose(b.pose), reals.push_back(&b.mass), real(b.com), real(b.inertia);
    for (auto& f : m.frames) integers.insert(integers.end(), {&f.body, &f.flexible_frame}), pose(f.pose);
    for (auto& j : m.joints) {
      integers.insert(integers.end(), {&j.frame_a, &j.frame_b});
      for (auto& d : j.drives) integers.push_back(&d.coordinate);
      for (auto& s : j.springs) integers.push_back(&s.coordinate);
    }
    for (auto& s : m.springs) integers.insert(integers.end(), {&s.frame_a, &s.frame_b});
    for (auto& l : m.loads) integers.push_back(&l.frame), real(l.force), real(l.moment);
    for (auto& t : m.tyres) {
      integers.insert(integers.end(), {&t.frame, &t.road});
      reals.insert(reals.end(), {&t.stiffness, &t.radius});
    }
    for (auto& o : m.outputs) {
      integers.insert(integers.end(), {&o.item, &o.component, &o.reference, &o.node});
      real(o.direction), reals.push_back(&o.offset);
      for (int& b : o.bodies) integers.push_back(&b);
    }
    auto& s = m.simulation;
    integers.insert(integers.end(), {&s.max_iterations, &s.substeps});
    reals.insert(reals.end(), {&s.step, &s.end, &s.output_interval, &s.rho, &s.xi, &s.tolerance, &s.penalty});
  }
};

TEST(CheckSpec, AnyNumberInAnyPlaceIsRefusedOrRuns) {
  constexpr std::array integers{
      -2, -1, 0, 1, 2, 3, 5, 8, 1000, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()};
  constexpr std::array reals{nan, infinity, -infinity, 0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, -1e9, 0.5};
  int refused = 0, ran = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    Random random(5000 + seed);
    spec::Model model = good_spec(seed % 10);
    model.simulation.max_iterations = 20;
    Numbers numbers(model);
    if (random.chance(0.6))
      **any(numbers.integers, random) = *any(integers, random);
    else
      **any(numbers.reals, random) = *any(reals, random);
    try {
      Simulation simulation(Model::compile(model));
      simulation.step();
      ResultsRow row;
      simulation.sample(row);
      ++ran;
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(ran, 20);
  RecordProperty("refused", refused);
  RecordProperty("ran", ran);
}

}  // namespace
}  // namespace mimbre::test::check_spec_test

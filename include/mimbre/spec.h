#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mimbre/diagnostics.h"
#include "mimbre/function.h"
#include "mimbre/inertia_term.h"
#include "mimbre/joint_type.h"
#include "mimbre/method.h"
#include "mimbre/road_file.h"

namespace mimbre {
class OutsideBlock;
struct ReducedBody;
struct SurfaceMesh;
}  // namespace mimbre

/// The user's model, with templates placed, expressions evaluated and names resolved to indices: the input
/// of compile(). Everything of a body is in that body's own axes here; only Body::pose and ground frames are
/// global.
namespace mimbre::spec {

struct Pose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< these axes to the outer axes
};

/// For drawing only. A frame of the body carries it.
struct Shape {
  enum class Kind { box, cylinder, sphere, mesh } kind = Kind::box;
  Pose pose;  ///< in body axes; a cylinder's axis is z
  /// box: edges; cylinder: radius, length, 0; sphere: radius, 0, 0; mesh: factors on its coordinates, of
  /// which negative ones mirror it
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  std::shared_ptr<const SurfaceMesh> mesh = nullptr;
};

struct Body {
  std::string name;
  Mark mark;
  Pose pose;  ///< body frame in global axes, assembled position
  // A rigid body: mass, centre of mass, inertia about the centre of mass. Mass 0 (with inertia 0) is allowed.
  double mass = 0;
  Eigen::Vector3d com = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  std::shared_ptr<const ReducedBody>
      flexible;            ///< set for a flexible body; then mass, com, inertia are unused
  InertiaTerms neglected;  ///< of a flexible body
  /// Linear elastodynamics: it moves as if it were rigid, and what acts on it then bends it, without
  /// reaction.
  bool elastodynamic = false;
  std::vector<Shape> shapes;
  std::vector<std::array<Eigen::Vector3d, 2>> lines;  ///< drawing of a rigid body, body axes
};

constexpr int ground = -1;

/// A point with axes on a body (or on the ground).
struct Frame {
  std::string name;
  Mark mark;
  int body = ground;
  Pose pose;  ///< undeformed, in body axes (global axes for the ground)
  int flexible_frame =
      -1;         ///< for a flexible body: index into ReducedBody::frames whose X, X_theta move this frame
  int node = -1;  ///< likewise, where no frame does: index into ReducedBody::nodes, whose shapes move it
};

/// What an argument of a signal or of a law is.
struct Source {
  enum class Kind {
    time,    ///< s
    input,   ///< Model::inputs
    signal,  ///< Model::signals
    sensor   ///< Model::sensors
  } kind = Kind::time;
  int index = -1;
};

/// A formula of a law's own variables, which come first, and of what `arguments` names.
struct Law {
  Formula formula;
  std::vector<Source> arguments;
};

/// A value from outside, which the host sets between steps, or a parameter of the model that may be changed
/// between them.
struct Input {
  std::string name;
  Mark mark;
  std::string unit;
  double start = 0;
  double min = -std::numeric_limits<double>::infinity();  ///< what is set is kept within these
  double max = std::numeric_limits<double>::infinity();
  /// constant: from the moment it is set. linear: in a straight line, so that it is reached at the end of the
  /// step that follows.
  enum class Hold { constant, linear } hold = Hold::constant;
  bool tunable = false;  ///< a parameter
};

/// A value made of others.
struct Signal {
  std::string name;
  Mark mark;
  std::string unit;
  Law law;            ///< without variables of its own
  double every = 0;   ///< s: evaluated that often and kept in between; 0: always
  bool named = true;  ///< by the user: it has a channel
  int block = -1;     ///< instead of `law`: index into Model::blocks, which has an `every` of its own
  int output = 0;     ///< of that block
};

/// What makes signals of others and of what it remembers: a controller, a filter, a delay. One of the types
/// of src/signals/blocks, whose file there defines the fields.
struct Block {
  std::string name;
  Mark mark;
  std::string type;         ///< pid, transfer_function, state_space, …
  std::vector<Law> inputs;  ///< without variables of their own
  std::vector<double> numbers;
  std::vector<Eigen::MatrixXd> matrices;
  Function function;                            ///< of a table of one variable
  double every = 0;                             ///< s: sampled that often and kept in between; 0: continuous
  std::shared_ptr<const OutsideBlock> outside;  ///< of type fmu: what computes it (mimbre/outside_block.h)
};

/// What happens when a value crosses zero.
struct Event {
  std::string name;
  Mark mark;
  Law when;  ///< the value; without variables of its own
  enum class Direction { either, rising, falling } direction = Direction::either;
  struct Set {
    int input = -1;  ///< index into Model::inputs
    Law value;       ///< as it is at that moment
  };
  std::vector<Set> sets;
  bool stop = false;  ///< the run ends there
};

struct Drive {
  int coordinate = 0;  ///< of the joint's velocity coordinates (scalar ones only)
  /// Of time: the coordinate (s → m or rad), or its speed (s → m/s or rad/s), which starts from the joint's
  /// initial position, or from 0 where none is given.
  Function law;
  enum class Of { position, speed } of = Of::position;
  int signal = -1;  ///< instead of `law`: index into Model::signals
};

/// Spring and damper on one scalar joint coordinate: force on it = -(elastic(q) + damping(q̇)).
struct JointSpring {
  int coordinate = 0;
  Function elastic;
  Function damping;
  Law general = {};  ///< of coordinate, rate, …
};

struct Joint {
  std::string name;
  Mark mark;
  JointType type = JointType::fixed;
  int frame_a = -1;  ///< indices into Model::frames
  int frame_b = -1;
  enum class Cut { automatic, never, always } cut = Cut::automatic;
  std::vector<Drive> drives;
  std::vector<JointSpring> springs;
  /// Given initial coordinates and velocities, one entry per velocity coordinate; nullopt = free to be found.
  /// For spherical/floating rotations: rotation vector. Empty: nothing given (starts from the assembled
  /// position, at rest).
  std::vector<std::optional<double>> initial_position;
  std::vector<std::optional<double>> initial_velocity;
  /// Near what a coordinate is where it is free to be found, likewise.
  std::vector<std::optional<double>> near;
  bool apart = false;  ///< the frames are those of bodies drawn apart (mimbre/assembly.h)
  /// Between rigid segments of one elastic body: it starts straight and at rest, as modes do, unless loops
  /// need it.
  bool elastic = false;
};

/// Translational spring–damper between two frames' origins: tension = elastic(length) + damping(rate) +
/// general(length, rate, …).
struct Spring {
  std::string name;
  Mark mark;
  int frame_a = -1;
  int frame_b = -1;
  Function elastic;
  Function damping;
  Law general;
};

/// Force and moment on a frame's origin: direction · function(time).
struct Load {
  std::string name;
  Mark mark;
  int frame = -1;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< per unit of `scale`
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  Function scale;         ///< of time
  bool follower = false;  ///< direction fixed in the frame instead of in global axes
  int signal = -1;        ///< instead of `scale`: index into Model::signals
};

struct Road {
  std::string name;
  Mark mark;
  enum class Over { distance, time, grid } over = Over::distance;
  Function height;  ///< of global x (m) or of time (s)
  /// for drawing
  double draw_from = 0, draw_to = 0;
  int signal = -1;  ///< instead of a height over time: index into Model::signals
  /// Of a grid: heights(j, i) is global z over x = origin[0] + i spacing[0], y = origin[1] + j spacing[1];
  /// its border goes on level.
  Eigen::MatrixXd heights;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero(), spacing = Eigen::Vector2d::Ones();  ///< m
  /// Of a grid, instead of `heights`: one along a line that may bend (read_road_grid), as its file means it:
  /// bilinear between its points. Kinks are rounded, by which no height changes by more than 0.1 mm.
  RoadGrid along_line;
  double friction = 1;  ///< factor on the friction of tyres
  /// Global x and y between which the factor is another one; of patches that overlap the last counts.
  struct Patch {
    Eigen::Vector2d low, high;
    double friction = 1;
  };
  std::vector<Patch> patches;
};

/// A wheel on a road, by one of the laws for tyres of src/forces/table.h. "tyre" is the benchmark's: a
/// vertical force stiffness · (radius − (z_wheel − z_road)) when positive, on the frame's origin. Others roll
/// with the frame's body about an axis of the frame, and slip.
struct Tyre {
  std::string name;
  Mark mark;
  int frame = -1;
  int road = -1;
  double stiffness = 0;
  double radius = 0;
  std::string law = "tyre";
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  ///< in the frame, to the left of forwards
  std::vector<double> numbers;                      ///< of the law, as the table describes them
};

/// Arguments and results of a law written by the user (see Element::law "user").
struct LawCall {
  double time = 0;
  double step = 0;                  ///< s, of the step that is made; 0 in a position at rest (statics, start)
  int components = 1;               ///< of what is measured: 1, or 6 between two frames
  const double* x = nullptr;        ///< measured: m, rad
  const double* v = nullptr;        ///< rates
  const double* signals = nullptr;  ///< Element::arguments in their order
  const double* states = nullptr;   ///< at the start of the step
  // To be filled; all are 0 before.
  double* force = nullptr;  ///< that resists the measure, N, N m
  double* stiffness =
      nullptr;  ///< ∂force/∂x, components × components, symmetric; may stay 0 where it is soft
  double* damping = nullptr;      ///< ∂force/∂v, likewise
  double* next = nullptr;         ///< states at the end of the step
  double stored = 0;              ///< J
  double* dissipating = nullptr;  ///< share of `force` that dissipates; what is neither that nor from
                                  ///< `stored` counts as the work of a load
};

/// A force law of the user's own: a function object. It must neither throw nor, where the run has to keep its
/// deadlines, allocate or lock.
struct UserLaw {
  std::function<void(LawCall&)> evaluate;
  bool sampled = false;        ///< called once a step, with what is measured at its start, and kept over it
  std::vector<double> states;  ///< that it has, at the start of a run
  bool elastic = false;        ///< has `stored`: the gradient of it is not booked as work
};

/// One branch of a bushing: a spring in row with a damper, in all six components.
struct MaxwellBranch {
  Eigen::Matrix<double, 6, 6> stiffness = Eigen::Matrix<double, 6, 6>::Zero();  ///< N/m, N, N m
  double relaxation = 1;                                                        ///< s: damping over stiffness
};

/// A force between two frames, or on a joint coordinate, by one of the laws of src/forces/table.h. Others
/// than those that have a struct of their own above.
struct Element {
  std::string name;
  Mark mark;
  std::string law;  ///< its name in the table: actuator, bushing, gas_spring, cable, motor, user, …
  /// What it measures, and so where it acts: along the line between two frames; on a coordinate of a joint;
  /// along or about an axis of frame a; all six components of b's motion in the axes of a; a sum of
  /// coordinates of joints (`terms`); the length of a line over several frames (`path`); the velocity of
  /// frame b against the ground, in its own axes.
  enum class On { line, coordinate, axis, frames, coordinates, path, velocity } on = On::line;
  int frame_a = -1;
  int frame_b = -1;
  int joint = -1;  ///< and its velocity coordinate
  int coordinate = 0;
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< the axis, in frame a
  bool about = false;                                    ///< about it
  /// factor · a joint's velocity coordinate.
  struct Term {
    int joint = -1;
    int coordinate = 0;
    double factor = 1;
  };
  std::vector<Term> terms;          ///< of the sum
  std::vector<int> path;            ///< frames, two at least, from end to end
  std::vector<double> numbers;      ///< of the law, as the table describes them
  std::vector<Function> functions;  ///< likewise
  std::vector<Source> arguments;    ///< signals that the law takes
  Law general;                      ///< of a torsion spring: of the sum, its rate, …
  std::vector<MaxwellBranch> branches;
  std::shared_ptr<const UserLaw> user;
};

/// Equations between bodies that are no joint of the tree: they always close a loop, and do no work.
struct Constraint {
  std::string name;
  Mark mark;
  /// As in model files: "coupling" of joints' coordinates, Σ factor · coordinate = numbers[0]; else between
  /// two frames; src/constraints describes each type.
  std::string type = "coupling";
  /// A coupling's coordinates: angles count their turns.
  struct Term {
    int joint = -1;
    int coordinate = 0;  ///< of its velocity coordinates (scalar ones only)
    double factor = 1;
  };
  std::vector<Term> terms;
  // Of the others.
  int frame_a = -1;
  int frame_b = -1;
  std::vector<double> numbers;  ///< of the type, in the order of its description
  /// Of a curve, in the axes of frame a: the cubic spline through them over the length of its chords.
  std::vector<Eigen::Vector3d> points;
  bool closed = false;  ///< the last point is followed by the first; else it goes on straight beyond its ends
  int road = -1;        ///< of what rolls on one
};

/// What spheres touch: a solid that a frame carries, given in the axes of that frame. Distances are negative
/// inside of it.
struct Surface {
  std::string name;
  Mark mark;
  /// half_space (all below the plane z = 0); box (size: edges along x, y, z), cylinder (size: radius, length;
  /// about the z axis), capsule (likewise, with half spheres at the ends of that length), sphere (size:
  /// radius), all about the origin; heights (all below a grid of heights z over x and y; beyond its border
  /// the border goes on); mesh (closed, of triangles that are counterclockwise from outside). By the names of
  /// src/forces/surfaces.
  std::string kind = "half_space";
  int frame = -1;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< m, see the kinds
  /// heights(j, i) is that over x = i spacing[0], y = j spacing[1].
  Eigen::MatrixXd heights;
  Eigen::Vector2d spacing = Eigen::Vector2d::Zero();  ///< m
  std::vector<Eigen::Vector3d> vertices;              ///< of a mesh, m
  std::vector<std::array<int, 3>> triangles;
};

/// Spheres about points of bodies: about the origins of frames, or about all nodes of a flexible body's
/// surface.
struct Spheres {
  std::vector<int> frames;
  int surface_of = -1;  ///< a flexible body with a mesh
  double radius = 0;    ///< m
};

/// Spheres that press and rub against surfaces of other bodies, and on request against one another.
/// Normal force: f(d) (1 + c ḋ) of the depth d, as of a stop; tangential force: bristles that stick without
/// creeping up to a limit in proportion to it.
struct Contact {
  std::string name;
  Mark mark;
  std::vector<Spheres> spheres;
  std::vector<int> surfaces;    ///< indices into Model::surfaces
  bool among = false;           ///< spheres of different bodies touch one another too
  bool swarm = false;           ///< of `among`: only those that are near each other are looked at
  std::vector<double> numbers;  ///< of the law, as Contact in src/forces/contact.h describes them
};

/// A named channel of the results.
struct Output {
  std::string name;
  Mark mark;
  /// By its key in the model file: position, velocity, joint, stress, …; for programs also element_force,
  /// element_measure, element_rate, signal, input. docs/model-file.md describes them, src/outputs has them.
  std::string kind = "position";
  int item = -1;  ///< index of the frame, joint, body, spring, tyre, contact, element, signal or input
  std::vector<int> bodies;               ///< of motion of mass (none: all of the model), or one of a contact
  std::optional<Eigen::Vector3d> about;  ///< a fixed point, global
  bool own_axes = false;
  int component = 0;   ///< by its number among those of the kind
  int reference = -1;  ///< frame
  int node = -1;       ///< of ReducedBody::nodes, or 2 k (start) or 2 k + 1 (end) of element k of bars
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< body axes; of a displacement those of `reference`
  double offset = 0;                                    ///< is added: joint, displacement
};

struct Model {
  std::string title;
  std::string file;
  std::string text;  ///< the model file's text, kept in the results
  Eigen::Vector3d gravity{0, 0, -9.81};
  std::vector<Body> bodies;
  std::vector<Frame> frames;
  std::vector<Joint> joints;
  std::vector<Spring> springs;
  std::vector<Load> loads;
  std::vector<Road> roads;
  std::vector<Tyre> tyres;
  std::vector<Element> elements;
  std::vector<Constraint> constraints;
  std::vector<Surface> surfaces;
  std::vector<Contact> contacts;
  std::vector<Input> inputs;
  std::vector<Signal> signals;
  std::vector<Block> blocks;
  std::vector<Event> events;
  std::vector<Output> sensors;  ///< what signals and laws see of the motion
  std::vector<Output> outputs;
  Simulation simulation;
};

}  // namespace mimbre::spec

#pragma once
#include <Eigen/Core>
#include <algorithm>

#include <array>
#include <cmath>
#include <limits>

#include "base/array.h"
#include "compile/rows.h"
#include "joints/joint_kind.h"
#include "linalg/block_sparse.h"
#include "math/function_data.h"
#include "math/space_curve.h"
#include "mimbre/inertia_term.h"
#include "mimbre/spec.h"
#include "roads/grid.h"

/// What the step needs, made once by compile() and then put into one block of memory (compile/image.h): flat,
/// constant, in tree order (parent before child), free of names and types. "Common point" below is the point,
/// moving with the mechanism, to which all Cartesian quantities refer.
namespace mimbre {

using Vec3d = Eigen::Vector3d;
using Mat3d = Eigen::Matrix3d;
constexpr int pad(int n) { return (n + 7) / 8 * 8; }
/// Likewise of motion subspaces and Jacobian rows, whose bodies mostly have few coordinates.
constexpr int pad_columns(int n) { return (n + 3) / 4 * 4; }

/// Gauss points of a planar beam element by absolute nodal coordinates, as weights of its eight amplitudes
/// along or across: slope and curvature of the deformed axis, stiffness times length.
struct AncfElement {
  std::array<int, 8> amplitudes{};  ///< -1: zero
  double length = 0;
  struct Point {
    std::array<double, 4> slope{}, curvature{};  ///< r' − along, r'' per (u, p) of both nodes
    double stiffness = 0;                        ///< EA or EI times length
  };
  std::array<Point, 3> axial;
  std::array<Point, 2> bending;
};

/// Likewise of a beam in space (AncfBeam::SpatialElement): its vectors are r and r' of both nodes of a cable,
/// r and the section's directions of three nodes of a thick beam, in the axes of the line.
struct AncfSpatialElement {
  bool thick = false;
  std::array<int, 27> amplitudes{};  ///< of the vectors' components; -1: zero
  double length = 0;
  struct Point {
    /// By the vectors: of r' and r'' of a cable, of a vector and its derivative of a thick beam.
    std::array<double, 4> lower{}, higher{};
    std::array<double, 6> stiffness{};  ///< of the strains, times length
  };
  /// Of a cable three for stretch, two for bending; of a thick beam two for the strains of the line, three
  /// for those of the section.
  std::array<Point, 5> points;
};

/// Geometric stiffness (GeometricStiffness), the matrices one below the other.
struct GeometricData {
  int modes = 0;
  Array<int> loads;
  int inertial = 0;          ///< of these the first: loads of inertia and gravity
  Rows stiffness;            ///< loads · modes × stride
  Rows boundary_loads;       ///< count × stride: R
  Rows boundary_compliance;  ///< count × stride: row l is K⁻¹ R_l, the amplitudes that one unit of the load
                             ///< causes
  /// 6 × stride: acceleration of the origin and angular acceleration of the rigid motion that is nearest, by
  /// mass, to that of each mode, body axes.
  Rows mean_motion;
  bool empty() const { return loads.empty(); }
};

/// Constants of a flexible body, mode blocks row-major with `stride` columns (modes padded with zeros).
struct FlexibleData {
  int modes = 0;       ///< of the blocks below: amplitudes and their products (dynamics/amplitudes.h)
  int amplitudes = 0;  ///< coordinates
  int stride = 0;
  Array<std::array<int, 2>> products;
  Rows S;  ///< 3 × stride
  Rows C;  ///< 3 × stride: ∫ r̄ × X dm of the undeformed body, row a S̄^b_c − S̄^c_b, (a, b, c) cyclic
  Rows S_position;  ///< 9 × stride: row 3 i + j is row j of S̄^i
  Rows S_modes;     ///< stride rows (l) × 9 stride: block 3 i + j of row l holds S^ij(l, ·)
  Rows
      coriolis;  ///< stride rows (l) × 3 stride: block a of row l holds (S^bc − S^cb)(l, ·), (a, b, c) cyclic
  Rows mass;                         ///< stride × stride
  Rows stiffness;                    ///< stride × stride
  Rows damping;                      ///< stride × stride
  bool identity_mass = false;        ///< Mff = I: modes are orthonormal
  bool diagonal_stiffness = false;   ///< stiffness and damping are diagonal
  bool nonlinear_stiffness = false;  ///< products have stiffness
  /// Not both empty: elastic forces are these elements' (dynamics/ancf.h), `stiffness` is their tangent at
  /// y = 0.
  Array<AncfElement> ancf;
  Array<AncfSpatialElement> ancf_spatial;
  double ancf_damping = 0;  ///< s
  GeometricData geometric;  ///< empty: stress does not stiffen

  bool absolute() const { return !ancf.empty() || !ancf_spatial.empty(); }  ///< absolute nodal coordinates
};

/// What X_theta y does to a frame's axes: BoundaryRotation, or, of an AncfBeam, the change of slope in a
/// plane, the change of direction in space (the frame turns by the shortest way), or the axes of its section.
enum class FrameTurn { exponential, successive, infinitesimal, slope, direction, section };

/// A point with axes on a body; body -1 is the ground.
struct FrameData {
  int body = -1;
  Vec3d position = Vec3d::Zero();      ///< undeformed, body axes; ground: global
  Mat3d rotation = Mat3d::Identity();  ///< undeformed frame axes to body axes
  int flexible = -1;                   ///< index of the flexible body's data when modes move the frame
  bool turns = false;                  ///< modes turn the frame too
  bool bends = false;  ///< what acts on it bends the body (X, X_theta), though the modes do not move it
  FrameTurn turn = FrameTurn::exponential;
  /// By slope: its undeformed direction, and the plane's normal; by section: x and z of the undeformed line.
  Vec3d along = Vec3d::Zero(), normal = Vec3d::Zero();
  /// By section: amplitudes of its directions y and z in the axes of the line; -1: zero.
  std::array<int, 6> directions{};
  bool full = true;  ///< the step needs axes and accelerations, not only position and velocity
  bool central = false, aligned = false;  ///< it stays at its body's origin; it stays along its axes
  Rows X, X_theta;                        ///< 3 × stride
  int subspace = -1;  ///< its motion subspace: velocity of the frame per coordinate of its body
  int spec = -1;      ///< index into spec::Model::frames
};

struct BodyData {
  int spec = -1;
  int parent = -1;
  int joint_spec = -1;
  spec::JointType joint = spec::JointType::fixed;
  bool reversed = false;    ///< the body carries the joint's frame a, its parent carries frame b
  int inboard_frame = -1;   ///< the joint's frame on the parent
  int outboard_frame = -1;  ///< the joint's frame on this body
  int q = 0;                ///< first position coordinate: joint, then modal amplitudes
  int v = 0;                ///< first velocity coordinate: joint, then modal amplitudes
  int joint_velocities = 0;
  int joint_positions = 0;
  unsigned joint_lengths = 0;  ///< JointInfo::lengths
  bool joint_biased = false;   ///< JointInfo::biased
  /// Of each velocity coordinate: along or about which axis of the joint's frame a it always is, -1 for none.
  std::array<signed char, 6> joint_axes{-1, -1, -1, -1, -1, -1};
  int modes = 0;
  int flexible = -1;
  InertiaTerms neglected;               ///< complete()
  bool elastodynamic = false;           ///< its modes move nothing but themselves
  int first_frame = 0, last_frame = 0;  ///< frames that dynamics needs: [first, last)
  double mass = 0;
  Vec3d first_moment = Vec3d::Zero();   ///< rigid body: ∫ r̄ dm
  Mat3d second_moment = Mat3d::Zero();  ///< rigid body: ∫ r̄ r̄ᵀ dm
  Mat3d inertia = Mat3d::Zero();        ///< rigid body: about the body's origin
  int subspace = -1;                    ///< motion subspace of a rigid body

  int size() const { return joint_velocities + modes; }
};

/// Motion subspace, 6 × size, of one body's coordinates (joint, modes) seen at one of its frames, or anywhere
/// on a rigid body: velocity per unit velocity coordinate.
struct MotionSubspace {
  int body = -1;
  int frame = -1;  ///< of a flexible body; -1 on a rigid one
  int offset = 0;  ///< into Workspace::subspaces
  int stride = 0;  ///< padded size
};

/// One body on the path of a scalar equation or force: which motion subspaces move its end B (plus) and its
/// end A (minus).
struct PathEntry {
  int body = -1;
  int plus = -1;  ///< motion subspace or -1
  int minus = -1;
  int offset = 0;  ///< into the Jacobian storage of one row
  int first = 0;   ///< of the body's velocity coordinates
  int count = 0;   ///< of them
};

/// The bodies that matter between two frames, leaf to root, and their places in the matrix.
struct Path {
  Array<PathEntry> entries;
  int width = 0;  ///< padded total size of the entries
  /// place of block (entries[i], entries[j]), j ≤ i, index i (i + 1) / 2 + j
  Array<linalg::BlockPlace> places;
};

/// Equations [first, first + count) with rows of the Jacobian along one path.
struct EquationRows {
  int first_equation = 0;
  int count = 0;
  double scale[6] = {1, 1, 1, 1, 1, 1};  ///< of the penalty: length² for angles
  Path path;
  int jacobian = 0;  ///< offset of the rows in the workspace
};

/// A cut joint: equations between two frames.
struct LoopData : EquationRows {
  int joint_spec = -1;
  int frame_a = -1, frame_b = -1;
  Array<LoopClosure> closure;
};

/// What a constraint has between two frames: all of it, or of a coupling one joint's coordinate.
struct ConstraintTerm {
  int frame_a = -1, frame_b = -1;
  // Of a coupling.
  double factor = 1;
  int joint_spec = -1;
  spec::JointType joint = spec::JointType::fixed;
  int local = 0;     ///< of the joint's velocity coordinates
  int body = -1;     ///< the tree body whose joint it is; -1: of a cut joint
  int q = 0, v = 0;  ///< its places, in the tree
  int turns = -1;    ///< of the constraint's states the one that counts turns; -1: none
  Path path;         ///< none of the tree's; its offsets are those of the constraint's path
};

/// Equations between bodies: their constants. The equations are in src/constraints.
struct ConstraintData : EquationRows {
  int spec = -1;
  int kind = 0;                 ///< row of the list
  bool of_coordinates = false;  ///< a coupling
  unsigned lengths = 0;         ///< bit r: equation r is a length, m, otherwise an angle, rad
  unsigned rates = 0;           ///< bit r: equation r is one of velocities alone
  Array<ConstraintTerm> terms;
  int covectors = 0;  ///< first of count × terms in the workspace, those of one equation next to each other
  Array<double> numbers;  ///< of its kind
  SpaceCurve curve;
  int road = -1;                    ///< that it is on
  int states = 0, state_count = 0;  ///< among the model's: turns, or the place on the curve
  int next_states = 0;              ///< likewise in the workspace

  bool is_length(int equation) const { return (lengths >> equation & 1u) != 0; }
  bool is_rate(int equation) const { return (rates >> equation & 1u) != 0; }
};

/// A joint coordinate prescribed over time: one equation on one velocity coordinate.
struct DriveData {
  int joint_spec = -1;
  int body = -1;
  int q = 0, v = 0;  ///< coordinate indices
  int equation = 0;
  int local = 0;  ///< coordinate within the body's block
  int slot = 0;   ///< of its position among the signals
  double scale = 1;
};

/// What a force element measures, and so where it acts. Numbers of components in measure_size().
enum class Measure {
  none,        ///< nothing: it acts on frame b
  distance,    ///< between the frames' origins
  coordinate,  ///< of a joint, in the tree or cut
  height,      ///< of frame b's origin above a road
  axis,        ///< of b along, or about, a direction of frame a
  relative,    ///< of b in the axes of a: displacement and rotation vector
  velocity,    ///< of frame b's origin against the ground, in its own axes
  sum,         ///< of what other elements, its legs, measure
  contact,  ///< of a sphere about b against a surface in a: gap, slip in the step; where it resists rolling,
            ///< turn in the step too
  wheel     ///< of a wheel about b on a road: gap, then velocities of slip and of turning
};
constexpr int measure_size(Measure m) {
  return m == Measure::relative || m == Measure::wheel ? 6 : m == Measure::velocity ? 3 : 1;
}

/// Whether a component of what is measured is the velocity itself.
constexpr bool is_velocity(Measure m, int component) {
  return m == Measure::velocity || (m == Measure::wheel && component > 0);
}
constexpr bool on_road(Measure m) { return m == Measure::height || m == Measure::wheel; }

/// What of the surroundings an element keeps from its measure for its law: the height of the road, or the
/// tangents of a surface in its axes, or as in forces/measure_wheel.h.
constexpr int surroundings_size(Measure m) { return m == Measure::contact ? 6 : m == Measure::wheel ? 5 : 1; }

/// One of the summands of Measure::sum: an element that only measures, and carries its share of the force.
struct Leg {
  int element = -1;
  double factor = 1;
  Array<int> offsets;  ///< of its path's entries (of a tree coordinate: of its place) in a row of the sum
};

/// A force element: what it measures, its law and the law's constants. The laws are in src/forces, one file
/// each, and in the table there.
struct ElementData {
  int law = 0;    ///< row of the table
  int spec = -1;  ///< index among its kind in the spec
  Measure measure = Measure::none;
  int count = 1;                   ///< components
  int frame_a = -1, frame_b = -1;  ///< a of height and none: -1, the ground
  // A coordinate.
  int joint_spec = -1;
  spec::JointType joint = spec::JointType::fixed;
  int local = 0;     ///< of the joint's velocity coordinates
  int body = -1;     ///< the tree body whose joint it is; -1: of a cut joint
  int q = 0, v = 0;  ///< its places, in the tree
  int turns = -1;    ///< of its states the one that counts turns; -1: none
  // Others.
  int road = -1;
  int surface = -1;        ///< contact: that is touched
  double radius = 0;       ///< contact: of the sphere; wheel
  double rolling = 0;      ///< wheel: share of its deflection by which it rolls as if it were smaller
  double footprint = 0;    ///< wheel: half the length along which it feels a profile, m
  double struck_mass = 0;  ///< contact: of both bodies, as far as they move in an impact, kg
  /// axis: direction; wheel: its axis, in b; none: force and moment
  Vec3d direction = Vec3d::Zero(), second = Vec3d::Zero();
  bool about = false;                  ///< axis: turns
  bool follower = false;               ///< none: turns with the frame
  double reference = 0;                ///< where it is in the assembled position: distance, axis
  Vec3d position = Vec3d::Zero();      ///< relative: of b in a, in the assembled position
  Mat3d rotation = Mat3d::Identity();  ///< likewise: axes of b to axes of a
  // The law's: where they begin among the model's.
  int numbers = 0, functions = -1, formula = -1, arguments = 0, argument_count = 0;
  int states = 0, state_count = 0;
  int feedback = -1;   ///< slot of a signal that its own motion may decide
  int own_states = 0;  ///< of these the first that is the law's, behind the turns
  bool user = false, sampled = false, elastic = false;  ///< a law that the user wrote, and its properties
  bool marked = false;                                  ///< a change of its tangent may ask for a new matrix
  int inertia = -1;     ///< among the model's numbers: of what is measured, kg or kg m²; -1: none
  Array<Leg> legs;      ///< of a sum; they come behind it
  bool leg = false;     ///< is one
  bool pooled = false;  ///< contact: of those two spheres of its contact's swarm that its states name
  // In the step.
  int storage = 0;  ///< of its ElementState
  Path path;
  int jacobian = 0;
};

/// Behind the law's states a pooled contact has its two spheres, counted from 1; 0: none.
constexpr int pair_states = 2;
inline int law_states(const ElementData& e) { return e.state_count - (e.pooled ? pair_states : 0); }

/// Numbers of its ElementState (forces/element.h).
inline int element_storage(const ElementData& e) {
  return 9 * e.count + 2 * e.count * e.count + surroundings_size(e.measure) + 1 + e.state_count;
}

/// A sphere of a swarm.
struct SwarmSphere {
  int frame = -1;
  int surface = -1;  ///< it as others see it
  double radius = 0;
  Path path;  ///< of its frame against the ground
};

/// Spheres that touch one another: pooled elements [first, last) are places for pairs that are near each
/// other, which change from step to step (simulation/step/swarm_search.h).
struct SwarmData {
  int first = 0, last = 0;
  Array<SwarmSphere> spheres;
};

/// A formula of own variables and signals.
struct LawData {
  Expression formula;
  Array<int> slots;  ///< behind its own variables
};

/// What a step sees of time, inputs and sensors is one vector of numbered slots. Slot 0 is the time.
struct SignalsData {
  struct OfTime {
    int slot;
    FunctionData function;
  };
  /// What the host sets: at `held` the value and when it was last changed, or for a straight line value,
  /// time, next value, next time.
  struct HeldInput {
    int slot, held;
    bool linear;
    int input;  ///< of the spec; -1: a sampled signal
  };
  struct Computed {
    int slot;
    LawData law;
    int block = -1;  ///< instead of the law: makes its outputs, from the slot on
  };
  /// A block (src/signals/blocks). At `held`: whether it has begun (0, 1); its inputs, then its states, when
  /// the step starts.
  struct Block {
    int type;  ///< row of the table
    int slot;  ///< of its first output
    int inputs, outputs, states;
    int held, numbers;
    int function;         ///< -1: none
    int matrices;         ///< of its step, in SignalValues
    double every;         ///< s; 0: continuous
    bool ahead;           ///< what it makes is used before it is made, in a loop that it closes
    Array<LawData> laws;  ///< its inputs, of a continuous one
    int memory() const { return 1 + inputs + states; }
  };
  /// ∫ of slot `rate` over time since the step's start: at `held` the value, then the time.
  struct Integral {
    int slot, rate, held;
  };
  /// A formula that is evaluated at instants, of slots or sensors of the spec.
  struct Seen {
    Expression formula;
    struct Argument {
      int slot, sensor;  ///< one of them is -1
    };
    Array<Argument> arguments;
  };
  /// What is evaluated every `every` seconds: at `held` its values; behind them when the next are due, and
  /// when these were made.
  struct Sampled {
    int held, values;
    double every;
    int block;           ///< -1: the value is that of the only input
    Array<Seen> inputs;  ///< of the signal or block
  };
  struct Sensor {
    int slot, sensor;
  };
  int slots = 1;
  int first_moving = 1;  ///< slot from which on they are of sensors and of what follows from them
  Array<OfTime> of_time;
  Array<HeldInput> held;
  Array<Computed> fixed;  ///< of time and inputs, in the order in which they need each other
  Array<Integral> integrals;
  Array<Sensor> sensors;
  Array<Computed> moving;                          ///< of sensors, in that order
  bool fixed_loops = false, moving_loops = false;  ///< some of them are blocks `ahead`
  Array<Block> blocks;
  Array<double> numbers;          ///< of blocks
  Array<FunctionData> functions;  ///< likewise
  int matrices = 0;               ///< numbers of all blocks that a step's length decides
  /// At `clock` in what is held: the time that continuous blocks were last moved on to; behind it whether
  /// something has jumped since then (0, 1). -1: there are none.
  int clock = -1;
  Array<Sampled> sampled;
  Array<int> seen;  ///< sensors of the spec that are seen within a step
  // By what they belong to in the spec.
  Array<int> slot_of_input, slot_of_signal, slot_of_sensor, slot_of_load, slot_of_road;
  Array<Array<int>> slot_of_drive;  ///< by joint
  Array<double> start;              ///< of the block that is held
};

/// A component of the motion that signals see.
struct SensorData {
  int kind = 0;  ///< place in the list of outputs (outputs/table.h)
  int component = 0;
  int frame = -1, reference = -1;
  int element = -1;      ///< of coordinates and lengths: the element that measures it
  bool is_rate = false;  ///< the rate of what that measures
  bool own_axes = false;
  Vec3d direction = Vec3d::Zero();
  double offset = 0;
  int body = -1;         ///< of amplitudes
  Array<double> shapes;  ///< amplitude and deflection: Σ shapes[k] y[k]
};

struct RoadData {
  spec::Road::Over over = spec::Road::Over::distance;
  FunctionData height;  ///< over distance
  int slot = 0;         ///< of its height, over time
  double friction = 1;
  struct Patch {
    std::array<double, 2> low, high;
    double friction;
  };
  Array<Patch> patches;
  // A grid: rows along y of heights along x.
  std::array<double, 2> origin{}, spacing{1, 1};
  int rows = 0, columns = 0;
  Array<double> heights;
  roads::GridArrays own;  ///< of a road along a line, instead; else empty
  bool along_line() const { return !own.line.empty(); }
};

/// Triangles with a tree of boxes over them, and what the sign of a distance takes (forces/surfaces/mesh.h).
struct TriangleMesh {
  struct Node {
    Vec3d low, high;
    int first = 0, count = 0;  ///< of its triangles; 0: its children are at `first` and behind it
  };
  Array<Vec3d> vertices, vertex_normals;  ///< normals: of any length, outwards
  Array<std::array<int, 3>> triangles;
  Array<std::array<int, 3>> neighbours;  ///< across the edges from corners 0, 1, 2; -1: none
  Array<Node> nodes;                     ///< the root first
};

/// What spheres touch, in the axes of its frame.
struct SurfaceData {
  int kind = 0;  ///< row of the table (forces/surfaces/table.h)
  Vec3d size = Vec3d::Zero();
  TriangleMesh mesh;
};

/// Off-diagonal block (ancestor, body) of the mass matrix.
struct MassPlace {
  int ancestor = -1;
  int subspace = -1;  ///< the ancestor's motion subspace on the way to the body
  linalg::BlockPlace place;
};

struct Compiled {
  /// The model that this was compiled from, in this process: names, marks, texts and laws of the user.
  const spec::Model* source = nullptr;
  const spec::Model& spec() const { return *source; }

  int positions = 0, velocities = 0, equations = 0;
  Vec3d gravity = Vec3d::Zero();

  Array<BodyData> bodies;    ///< tree order
  Array<int> body_of_spec;   ///< spec body → tree body
  Array<FrameData> frames;   ///< by body; frames that dynamics needs first
  int dynamic_frames = 0;    ///< frames [0, dynamic_frames) are needed in the step, the others for output
  Array<int> frame_of_spec;  ///< spec frame → frame
  int first_ground_frame = 0, last_ground_frame = 0;
  Array<FlexibleData> flexible;
  Array<MotionSubspace> subspaces;
  int subspace_storage = 0;
  int jacobian_storage = 0;
  Array<Array<MassPlace>> mass_places;  ///< by body: its ancestors, nearest first
  Array<linalg::BlockPlace> diagonal;   ///< by body

  Array<LoopData> loops;
  Array<DriveData> drives;
  Array<ConstraintData> constraints;
  int constraint_covectors = 0, constraint_states = 0;  ///< of all of them
  Array<RoadData> roads;
  Array<SurfaceData> surfaces;  ///< those of the spec, then spheres that others touch
  /// Springs, tyres, loads and joint springs in the order of the spec, then its other elements, then every
  /// pair of a sphere and a surface.
  Array<ElementData> elements;
  int first_tyre = 0, first_load = 0, first_joint_spring = 0, first_other = 0;
  Array<int> sums;              ///< elements that are sums
  Array<int> first_of_contact;  ///< element of each contact of the spec, then the first behind them
  int element_storage = 0;
  Array<double> numbers;          ///< of laws
  Array<FunctionData> functions;  ///< likewise
  Array<LawData> formulas;        ///< likewise
  Array<int> arguments;           ///< likewise: slots
  Array<double> states;           ///< of laws, at the start
  SignalsData signals;
  Array<SensorData> sensors;  ///< those that are seen within a step

  linalg::BlockSymbolic symbolic;
  double mass_scale = 1;    ///< mean mass of the bodies that have one, kg
  double length_scale = 1;  ///< typical distance between frames of a body, m

  Array<SwarmData> swarms;  ///< by contact of the spec; of others without spheres
};

/// Calls f with the equations of cut joints, then of constraints.
template <class F>
void for_rows(const Compiled& m, const F& f) {
  for (const LoopData& loop : m.loops) f(static_cast<const EquationRows&>(loop));
  for (const ConstraintData& constraint : m.constraints) f(static_cast<const EquationRows&>(constraint));
}

/// Round-off of positions, by the length scale: of a mechanism that is far wider than that, or of many
/// bodies, more.
inline double round_off_of_positions(const Compiled& m) {
  double extent = 0;
  for (int f = m.first_ground_frame; f < m.last_ground_frame; ++f)
    extent = std::max(extent, (m.frames[f].position - m.frames[m.first_ground_frame].position).norm());
  return 16 * std::numeric_limits<double>::epsilon() *
         (1 + extent / m.length_scale + 4 * std::sqrt(static_cast<double>(m.bodies.size())));
}

/// Size of a body's modal amplitudes that moves it by about the length scale. Orthonormal modes have ∫ φ² dm
/// = 1.
inline double amplitude_scale(const Compiled& m, const BodyData& body) {
  const bool orthonormal = body.flexible >= 0 && m.flexible[body.flexible].identity_mass && body.mass > 0;
  return orthonormal ? m.length_scale * std::sqrt(body.mass) : m.length_scale;
}

}  // namespace mimbre

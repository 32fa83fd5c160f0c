#pragma once
#include <Eigen/Core>
#include <array>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mimbre/model.h"
#include "mimbre/spec.h"

/// What a mechanism is made of, as one gives it to a ModelBuilder. SI units, radians. Points, directions and
/// axes are global, of the assembled position; where `in` names a body or a frame, they are in its axes and
/// from its origin. All fields have defaults; the ones with "needed" behind them must be given.
namespace mimbre::build {

/// The tensor of a body: moments, and products as the tensor's entries.
Eigen::Matrix3d inertia(double xx, double yy, double zz, double xy = 0, double xz = 0, double yz = 0);

/// One or two axes of a frame; what is not given follows, always in the same way. None: those of `in`.
struct Axes {
  std::optional<Eigen::Vector3d> x{}, y{}, z{};
};

struct RigidBody {
  double mass = 0;                                      ///< kg
  Eigen::Vector3d com = Eigen::Vector3d::Zero();        ///< the centre of mass
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();    ///< kg m², about it, in the axes of the body's frame
  std::optional<Eigen::Vector3d> at{};                  ///< origin of the body's frame; default: `com`
  Axes axes{};                                          ///< of the body's frame
  std::vector<spec::Shape> shapes{};                    ///< to be drawn, in body axes
  std::vector<std::array<Eigen::Vector3d, 2>> lines{};  ///< likewise
  std::string in{};
};

/// Where the tangent frame of a flexible body lies: the axes of its ReducedBody.
struct FlexibleBody {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  Axes axes{};
  std::vector<spec::Shape> shapes{};
  std::string in{};
  bool elastodynamic = false;  ///< it bends by linear elastodynamics: see spec::Body
  InertiaTerms neglected{};    ///< terms of its inertia that the model does without
};

/// A point with axes that others can name.
struct Frame {
  std::string on{};  ///< a body, or "ground"; needed
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  Axes axes{};
  std::string in{};
};

/// Joins two bodies, frames or nodes (BODY.NODE, of a flexible body); coordinates are those of the second
/// relative to the first, all zero in the assembled position.
struct Joint {
  spec::JointType type = spec::JointType::fixed;
  std::array<std::string, 2> between{};   ///< needed
  std::optional<Eigen::Vector3d> at{};    ///< needed where bodies are named, but for floating, fixed, bracket
  std::optional<Eigen::Vector3d> axis{};  ///< needed likewise; universal: the first; planar: the normal
  std::optional<Eigen::Vector3d> axis2{};  ///< universal: the second, at right angles
  /// Of the second body, which is drawn apart from the first: its point, and its axes where they differ. To
  /// be compiled, such a model is brought together: Model::compile(brought_together(builder.build())).
  std::optional<Eigen::Vector3d> at_b{}, axis_b{}, axis2_b{};
  spec::Joint::Cut cut = spec::Joint::Cut::automatic;
  std::vector<spec::Drive> drives{};
  std::vector<spec::JointSpring> springs{};
  /// Initial coordinates and rates, one entry per velocity coordinate; nullopt where it is free. Rates of a
  /// floating joint: linear velocity, then angular velocity, in the axes of `in`.
  std::vector<std::optional<double>> position{}, velocity{};
  std::vector<std::optional<double>> near{};  ///< what coordinates are that are free to be found
  std::string in{};
};

/// Pulls two points towards each other: elastic(length) + damping(rate) + force(length, rate, time).
struct Spring {
  std::array<std::string, 2> between{};                ///< bodies (with `at`), frames, nodes; needed
  std::array<std::optional<Eigen::Vector3d>, 2> at{};  ///< of a body; default: its frame's origin
  Function elastic{}, damping{};
  Formula force{};
  std::string in{};
};

struct Load {
  std::string on{};                                  ///< a body, frame or node; needed
  std::optional<Eigen::Vector3d> at{};               ///< of a body; default: its frame's origin
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   ///< N, per unit of `scale`
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();  ///< N m, likewise
  Function scale = Function::constant(1);            ///< of time
  bool follower = false;                             ///< the direction turns with the body
  std::string in{};
};

struct Road {
  spec::Road::Over over = spec::Road::Over::distance;
  std::vector<std::array<double, 2>>
      points{};                    ///< (x or t, z) in ascending order; one that comes twice is a jump; needed
  std::optional<double> repeat{};  ///< period, no shorter than the points reach; beyond them all is level
  /// Of a grid, instead: rows along y of heights along x, m, from `origin` on every `spacing`.
  Eigen::MatrixXd heights{};
  Eigen::Vector2d origin = Eigen::Vector2d::Zero(), spacing = Eigen::Vector2d::Ones();
  RoadGrid along_line{};  ///< of a grid, instead of `heights`: a road from a file, read_road_grid(path)
  double friction = 1;    ///< factor on that of tyres
  std::vector<spec::Road::Patch> patches{};
};

struct Tyre {
  std::string on{};  ///< needed
  std::optional<Eigen::Vector3d> at{};
  std::string road{};    ///< needed
  double stiffness = 0;  ///< N/m
  double radius = 0;     ///< m
  std::string in{};
  std::string law = "tyre";                         ///< vertical; brush_tyre: it rolls and slips
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  ///< that it rolls about, to the left of forwards
  std::vector<double> numbers{};                    ///< of the law, in the order of its table
};

/// A value from outside, or (`tunable`) a parameter that may change between steps.
struct Input {
  double start = 0;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  spec::Input::Hold hold = spec::Input::Hold::constant;
  bool tunable = false;
  std::string unit{};
};

/// A formula of inputs, signals, outputs and the time.
struct Signal {
  std::string value{};            ///< "200*(wanted - angle)"; needed
  std::vector<std::string> of{};  ///< the names in it, "t" among them where it stands there
  double every = 0;               ///< s: evaluated that often; 0: always
  std::string unit{};
};

/// What makes signals of others and of what it remembers, by one of the types of src/signals/blocks:
/// pid, transfer_function, state_space, table, table_2d, rate_limit, delay, hysteresis, noise, fmu.
struct Block {
  std::string type{};                       ///< needed
  std::vector<std::string> inputs{};        ///< formulas: of pid what is measured, then the setpoint
  std::vector<std::string> of{};            ///< the names in them, "t" among them where it stands there
  std::map<std::string, double> numbers{};  ///< by their names in the table; others have their defaults
  /// transfer_function: numerator and denominator, highest powers first; state_space: A, B, C, and (they may
  /// be left out) D and initial; table_2d: x, y, values.
  std::map<std::string, Eigen::MatrixXd> matrices{};
  Function function{};                 ///< of a table
  double every = 0;                    ///< s: sampled that often; 0: continuous
  std::vector<std::string> outputs{};  ///< names of its signals, where there are several
  std::string unit{};
  std::shared_ptr<const OutsideBlock> outside{};  ///< of type fmu: load_fmu() (mimbre/fmu_import.h)
};

/// What happens when a value crosses zero.
struct Event {
  std::string when{};             ///< "height - 0.1"; needed
  std::vector<std::string> of{};  ///< the names in all its formulas
  spec::Event::Direction direction = spec::Event::Direction::either;
  std::vector<std::pair<std::string, std::string>> set{};  ///< inputs, and formulas of what they are set to
  bool stop = false;                                       ///< the run ends there
};

/// A force by one of the laws of src/forces: actuator, bushing, gas_spring, user.
struct Element {
  std::string law{};                                   ///< needed
  std::array<std::string, 2> between{};                ///< needed, or `joint`
  std::array<std::optional<Eigen::Vector3d>, 2> at{};  ///< of a body; default: its frame's origin
  std::string joint{};                                 ///< on its coordinate
  int coordinate = 0;
  std::optional<Eigen::Vector3d> along{},
      about{};                         ///< along, or about, a direction that turns with the first
  bool all_six = false;                ///< in all components, as a bushing always is
  std::vector<std::string> signals{};  ///< that the law takes
  std::vector<double> numbers{};       ///< of the law, in the order of its table
  std::vector<Function> functions{};   ///< of a bushing: six elastic laws, six of damping; of a torsion
                                       ///< spring: elastic law, damping; of a motor: its curve
  Eigen::Matrix<double, 6, 6> stiffness = Eigen::Matrix<double, 6, 6>::Zero();  ///< of a bushing
  Eigen::Matrix<double, 6, 6> damping = Eigen::Matrix<double, 6, 6>::Zero();    ///< likewise
  std::vector<spec::MaxwellBranch> branches{};                                  ///< likewise
  std::shared_ptr<const spec::UserLaw> user{};
  std::string in{};
  /// On a sum of joints' coordinates, by their names.
  struct Term {
    std::string joint{};
    int coordinate = 0;
    double factor = 1;
  };
  std::vector<Term> terms{};
  /// Along a line over points: bodies, frames or nodes, each at a place or (none, or fewer) at its own.
  std::vector<std::string> over{};
  std::vector<std::optional<Eigen::Vector3d>> places{};
  std::string on{};  ///< against the velocity of a body or frame, at `at[0]`
};

/// What spheres touch; the meaning of sizes, heights and triangles depends on the kind (spec::Surface).
struct Surface {
  std::string kind = "half_space";
  std::string on = "ground";            ///< a body, or a frame, whose place and axes then are the surface's
  std::optional<Eigen::Vector3d> at{};  ///< on a body; default: its frame's origin
  Axes axes{};                          ///< likewise
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  ///< m
  Eigen::MatrixXd heights{};
  Eigen::Vector2d spacing = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector3d> vertices{};
  std::vector<std::array<int, 3>> triangles{};
  std::string in{};
};

/// Spheres about points of bodies, or about all nodes of a flexible body's surface.
struct Spheres {
  std::string on{};                   ///< a body, frame or node; needed, or `surface_of`
  std::vector<Eigen::Vector3d> at{};  ///< of a body; default: its frame's origin
  std::string surface_of{};           ///< a flexible body
  double radius = 0;                  ///< m; needed
};

/// Spheres that touch surfaces and one another. The numbers are those of Contact in
/// src/forces/contact.h.
struct Contact {
  std::vector<Spheres> spheres{};       ///< needed
  std::vector<std::string> surfaces{};  ///< needed, or `among`
  bool among = false;                   ///< they touch one another
  bool swarm = false;                   ///< of these only those that are near each other are looked at
  double stiffness = 0;                 ///< N/m; needed
  double exponent = 1;
  double depth = std::numeric_limits<double>::infinity();  ///< m; infinite: by the mechanism's scales
  double restitution = 1;
  double friction = 0, static_ratio = 1;
  double stribeck = std::numeric_limits<double>::infinity();  ///< m/s; infinite: by the mechanism's scales
  double tangential = 0.7;
  double settling = std::numeric_limits<double>::infinity();  ///< s; infinite: by stiffness and mass
  double rolling = 0, spinning = 0;                           ///< m
  std::string in{};
};

/// Equations between bodies that are no joint of the tree.
struct Constraint {
  std::string type = "coupling";  ///< as in model files, but gear, rack and differential, which are below
  /// Of a coupling, Σ factor · coordinate = constant.
  struct Term {
    std::string joint{};
    double factor = 1;
    int coordinate = 0;
  };
  std::vector<Term> terms{};
  std::array<std::string, 2> between{};  ///< of the others: bodies, frames, nodes
  /// Of a body: where the constraint acts; default: of a distance the origin of the body's frame, else the
  /// place of the other side.
  std::array<std::optional<Eigen::Vector3d>, 2> at{};
  /// Directions on the first and on the second; default: z of the frames that are named; of the second also
  /// that of the first.
  std::optional<Eigen::Vector3d> axis{}, axis2{};
  /// By their keys in model files, SI units: "length" of a distance, default: as assembled; "lead" of a
  /// screw, for each turn; "constant" of a coupling.
  std::map<std::string, double> numbers{};
  std::vector<Eigen::Vector3d> points{};  ///< of a curve
  bool closed = false;
  std::string road{};  ///< that is rolled on: between the ground and a wheel
  std::string in{};
};

/// The first of two joints turns `ratio` times as fast as the second, in the other sense where negative: of
/// wheels with 17 and 51 teeth outside −3, of a ring with 51 teeth inside 3.
Constraint gear(const std::string& first, const std::string& second, double ratio);
/// A pinion moves a rack by `travel`, m, for each turn.
Constraint rack(const std::string& pinion, const std::string& rack, double travel);
/// The cage turns with the mean of both sides.
Constraint differential(const std::string& cage, const std::string& left, const std::string& right);

/// A channel. `kind` is a word of model files (docs/model-file.md, `outputs`): position, velocity,
/// acceleration, angular_velocity, roll, pitch, yaw, deflection, displacement (of a body, frame or node);
/// joint, joint_velocity, joint_acceleration, joint_force, joint_rotation, joint_quaternion; modal_amplitude,
/// stress, strain (of a body); centre_of_mass, linear_momentum, angular_momentum (of bodies); spring_force,
/// spring_length; tyre_force, tyre_moment, tyre_slip, tyre_slip_angle, tyre_camber, tyre_deflection;
/// contact_force, contact_depth, contact_count.
struct Output {
  std::string kind{};                      ///< needed
  std::string of{};                        ///< what has it; needed
  std::vector<std::string> bodies{};       ///< of motion of mass, in place of `of`; none of both: all
  std::string component{};                 ///< "x", "fz", "von_mises", "0", …
  std::optional<Eigen::Vector3d> at{};     ///< of a body, or on its surface
  std::optional<Eigen::Vector3d> along{};  ///< of deflection and strain
  std::string relative_to{};               ///< of displacement: a frame or body
  std::optional<Eigen::Vector3d> about{};  ///< of angular momentum: a fixed point
  std::optional<int> node{};               ///< of stress and strain: in the file of the mesh
  double offset = 0;                       ///< of joint: is added
  bool own_axes = false;                   ///< of angular_velocity: in the frame's own axes
  std::string on{};                        ///< of contacts: the body on which they act; none: their spheres
  std::string in{};
};

}  // namespace mimbre::build

namespace mimbre {

/// Builds a mechanism from things that are named and refer to each other by name, as a model file does:
///
///     ModelBuilder m("Pendulum");
///     m.add_body("bar", {.mass = 0.6, .com = {0.5, 0, 0}, .inertia = build::inertia(1e-5, 0.05, 0.05)});
///     m.add_joint("hinge", {.type = spec::JointType::revolute,
///                           .between = {"ground", "bar"},
///                           .at = Eigen::Vector3d{0, 0, 0},
///                           .axis = Eigen::Vector3d{0, 1, 0}});
///     m.add_output("angle", {.kind = "joint", .of = "hinge"});
///     m.set_simulation({.step = 0.01, .end = 5});
///     const auto model = m.compile();
///
/// Things come before those that name them. A body is a frame too, at its origin; the world is "ground".
/// Names have 1 to 100 letters, digits, '_', '-' or '.'; bodies and frames share theirs.
///
/// A call that cannot be done throws InputError, which names the thing, what is wrong, and names that could
/// be meant, and leaves the builder as it was. build() reports all mistakes that only the whole model shows.
class ModelBuilder {
 public:
  explicit ModelBuilder(std::string title = {});
  ModelBuilder(const ModelBuilder& other);
  ModelBuilder(ModelBuilder&&) noexcept;
  ModelBuilder& operator=(ModelBuilder other) noexcept;
  ~ModelBuilder();

  void set_gravity(const Eigen::Vector3d& gravity);  ///< m/s²; default (0, 0, −9.81)
  void set_simulation(const spec::Simulation& simulation);

  void add_body(const std::string& name, const build::RigidBody& body);
  void add_flexible_body(const std::string& name, std::shared_ptr<const ReducedBody> reduced,
                         const build::FlexibleBody& place = {});
  void add_frame(const std::string& name, const build::Frame& frame);
  void add_joint(const std::string& name, const build::Joint& joint);
  void add_spring(const std::string& name, const build::Spring& spring);
  void add_load(const std::string& name, const build::Load& load);
  void add_road(const std::string& name, const build::Road& road);
  void add_tyre(const std::string& name, const build::Tyre& tyre);
  void add_output(const std::string& name, const build::Output& output);
  void add_input(const std::string& name, const build::Input& input);
  void add_signal(const std::string& name, const build::Signal& signal);
  /// Its output is a signal of that name.
  void add_block(const std::string& name, const build::Block& block);
  void add_event(const std::string& name, const build::Event& event);
  void add_element(const std::string& name, const build::Element& element);
  void add_surface(const std::string& name, const build::Surface& surface);
  void add_contact(const std::string& name, const build::Contact& contact);
  void add_constraint(const std::string& name, const build::Constraint& constraint);

  /// What has been added, checked as a whole. The builder may go on afterwards.
  spec::Model build() const;
  std::shared_ptr<const Model> compile() const;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace mimbre

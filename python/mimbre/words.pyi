"""The keys of a model file, for type checkers and editors. Made by scripts/python-words from their schema."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias, TypedDict

import numpy as np
import numpy.typing as npt
from typing_extensions import Required

from .reduction import ReducedBody

Array: TypeAlias = npt.NDArray[Any]
Number: TypeAlias = float | str | bool | np.floating[Any] | np.integer[Any]

Flag: TypeAlias = bool | str | float

Vector: TypeAlias = Sequence[Number] | Array

Points: TypeAlias = Sequence[Sequence[Number] | Array] | Array

class ParameterKeys(TypedDict, total=False):
    # A number (SI), an expression of the parameters above, a word, or true or false.
    value: float | str | bool
    # The words that it may be.
    choices: Sequence[str]
    # The least value.
    min: Number
    # The largest value.
    max: Number
    # Whole numbers only.
    integer: bool
    # Description for people.
    about: str
    # May be set between steps; laws and signals alone may use it.
    tunable: Flag
    # The name of a body, frame, joint or another thing, in place of a value.
    name: str

Parameter: TypeAlias = float | str | bool | ParameterKeys

class Requirement(TypedDict, total=False):
    # An expression of parameters that must not be 0.
    that: Required[Number]
    # Message if the condition is not met.
    message: Required[str]

class Material(TypedDict, total=False):
    """Pa, –, kg/m³"""
    # Young's modulus, Pa.
    young: Required[Number]
    # Poisson's ratio.
    poisson: Required[Number]
    # kg/m³.
    density: Required[Number]

class Section(TypedDict, total=False):
    type: Literal["round", "tube", "rectangle"]
    # Outer diameter, m.
    diameter: Number
    # Along the element's y and z: kA of Timoshenko's theory.
    shear_areas: Sequence[Number] | Array
    # m.
    inner_diameter: Number
    # Along the element's y, m.
    width: Number
    # Along the element's z, m.
    height: Number
    # m².
    area: Number
    # Second moment of area about y, m⁴.
    Iy: Number
    # Second moment of area about z, m⁴.
    Iz: Number
    # Torsion constant, m⁴.
    J: Number
    # How far the outermost fibres are from the axis, along the element's y and z, m: for stress.
    outermost: Sequence[Number] | Array
    # Torque over the largest shear stress, m³: with outermost, for stress.
    torsion_modulus: Number

class Pose(TypedDict, total=False):
    # Origin, m, global in the assembled position.
    at: Vector
    # Direction of the x axis.
    x: Vector
    # Direction of the y axis.
    y: Vector
    # Direction of the z axis.
    z: Vector

class Shape(TypedDict, total=False):
    # Edges along x, y, z, m.
    box: Vector
    # Radius and length, m.
    cylinder: Sequence[Number] | Array
    # Radius, m.
    sphere: Number
    # A surface's file, found from the model's folder: STL, OBJ, glTF, PLY or Collada.
    mesh: str
    # Factors on the mesh's coordinates: 0.001 where they are millimetres; negative ones mirror.
    scale: Number | Vector
    # Centre, of a mesh the origin of its coordinates, m, global.
    at: Vector
    # The cylinder's axis.
    axis: Vector
    # The x axis of the box or mesh.
    x: Vector
    # The y axis of the box or mesh.
    y: Vector

class NodeKeys(TypedDict, total=False):
    # m, global; with `on`: beside the bar, rigidly joined to it.
    at: Vector
    # Bar and part of its length.
    on: Sequence[Any] | Array

Node: TypeAlias = Vector | NodeKeys

Bar = TypedDict("Bar", {"from": Required[str], "to": Required[str], "elements": Number, "section": str, "material": str, "beam_theory": Literal["euler_bernoulli", "rayleigh", "timoshenko"] | str, "y": Vector}, total=False)

class StaticMode(TypedDict, total=False):
    # Whose displacement or rotation by one unit gives the shape.
    node: Required[str]
    # Direction of the displacement, global.
    along: Vector
    # Axis of the rotation, global.
    about: Vector
    # All six of the node.
    all: Flag
    # Name of the mode.
    name: str
    # Left out where this is false (0).
    when: Flag

class FlexibleAxialModesKeys(TypedDict, total=False):
    # How many.
    count: Required[Number]
    # Of the bar: free or held.
    end: Literal["held", "free"] | str

class FlexibleSubstructuresKeys(TypedDict, total=False):
    # How many pieces.
    count: Required[Number]
    # Of every piece but the last; default: as the last.
    dynamic_modes: Number

class Flexible(TypedDict, total=False):
    # Default of the bars.
    material: str
    # Default of the bars.
    section: str
    # Named points, which are frames BODY.NODE too.
    nodes: Required[Mapping[str, Node]]
    # Beams between nodes, by name.
    bars: Required[Mapping[str, Bar]]
    # Nodes that the tangent frame holds.
    clamped: Required[Sequence[str]]
    # Unit displacements and rotations through which forces come in.
    static_modes: Sequence[StaticMode]
    # How many of the lowest modes with the nodes of static modes held; 0 to 500.
    dynamic_modes: Number
    # β of C = β K, s.
    stiffness_damping: Number
    # Normal of the plane in which alone it moves, along an axis of its frame.
    planar: Vector
    # What bending does along the beam. Or text with $parameter or 'condition ? word : word'.
    stiffening: Literal["linear", "foreshortening", "nonlinear_stiffness_1", "nonlinear_stiffness_2", "geometric_stiffness"] | str
    # Of the nonlinear stiffnesses: the strain energy's gradient, or the published force.
    stiffening_force: Literal["consistent", "published"] | str
    # What becomes of the bars: modes; a floating frame for every element; absolute nodal coordinates in a
    # plane, or in space as a cable or as a thick beam that shears and twists; rigid segments, one at each
    # node, with springs against turning in the middle of each element, or also along and across.
    beam: Literal["reduced", "corotational", "ancf", "segments", "stretching_segments", "ancf_cable", "ancf_thick"] | str
    # Of the bars: sections at right angles to the axis, these with rotary inertia, or shear and rotary
    # inertia.
    beam_theory: Literal["euler_bernoulli", "rayleigh", "timoshenko"] | str
    # Of the bars: consistent with the elements' displacements, or lumped at their nodes.
    mass_matrix: Literal["consistent", "lumped"] | str
    # How frames turn by the small rotations of their modes.
    boundary_rotation: Literal["exponential", "successive", "infinitesimal"] | str
    # Of one straight bar: the static stretch of its free end, then dynamic modes that only stretch; with
    # the end free, the bar's own axial modes.
    axial_modes: Number | FlexibleAxialModesKeys
    # Pieces into which the bars are cut, joined by brackets.
    substructures: Number | FlexibleSubstructuresKeys

class BodyRigid(TypedDict, total=False):
    """Its description as a rigid body."""
    # kg.
    mass: Required[Number]
    # Centre of mass, m, global.
    com: Vector
    # Ixx Iyy Izz [Ixy Ixz Iyz] about the centre of mass, axes of the body's frame.
    inertia: Sequence[Number] | Array

class Body(TypedDict, total=False):
    # kg.
    mass: Number
    # Centre of mass, m, global.
    com: Vector
    # Ixx Iyy Izz [Ixy Ixz Iyz] about the centre of mass, axes of the body's frame.
    inertia: Sequence[Number] | Array
    # rigid, flexible or reduced, where it has several descriptions.
    as_: str
    # Its frame; default: at the centre of mass, global axes; of a flexible body its tangent frame.
    frame: Pose
    # How it deforms: in its floating frame, as a part of the mechanism; or by linear elastodynamics: the
    # mechanism moves as if the body were rigid, and what acts on it bends it, without reaction.
    flexibility: Literal["floating_frame", "elastodynamics"] | str
    # Its description as a rigid body.
    rigid: BodyRigid
    # Its description by beams.
    flexible: Flexible
    # A reduced body's file, found from the model's folder.
    reduced: str | ReducedBody
    # For drawing only.
    shapes: Sequence[Shape]
    # For drawing only: lists of points, m, global.
    lines: Sequence[Sequence[Vector] | Array]

class Frame(TypedDict, total=False):
    # On which it is; ground is the world.
    body: Required[str]
    # Origin, m, global; on a flexible body a node lies there.
    at: Required[Vector]
    # Direction of the x axis.
    x: Vector
    # Direction of the y axis.
    y: Vector
    # Direction of the z axis.
    z: Vector

Between: TypeAlias = Sequence[str]

InitialValues: TypeAlias = Number | Sequence[float | str | None]

class LawKeysPieces(TypedDict, total=False):
    # Where the piece ends; the last has none.
    until: Number
    # Coefficients, of the variable itself.
    polynomial: Required[Sequence[Number] | Array]

class LawKeys(TypedDict, total=False):
    # N/m or N m/rad.
    stiffness: Number
    # Length or angle without force, m or rad.
    zero: Number
    # Of damping, N s/m or N m s/rad.
    coefficient: Number
    # Force, N, or torque, N m.
    constant: Number
    # Coefficients from the constant one on.
    polynomial: Sequence[Number] | Array
    # One polynomial after another.
    pieces: Sequence[LawKeysPieces]
    # Points [x, y] with ascending x.
    table: Points
    # Between the points; cubic is monotone.
    interpolation: Literal["linear", "cubic"]

Law: TypeAlias = str | float | LawKeys

class Drive(TypedDict, total=False):
    """A prescribed coordinate, by its position or by its speed; an expression is one of t."""
    # Law or expression of t, m or rad.
    position: Law
    # Instead of the position, which then starts from the joint's `position` (or 0).
    speed: Law
    # Which of several coordinates of the joint, from 0.
    coordinate: Number

class JointSpring(TypedDict, total=False):
    # N/m or N m/rad.
    stiffness: Number
    # N s/m or N m s/rad, or a law of the rate.
    damping: Law
    # Coordinate without force, m or rad.
    zero: Number
    # Law of the coordinate, in place of a stiffness.
    elastic: Law
    # Which of several coordinates of the joint, from 0.
    coordinate: Number

OneOrTwoVectors: TypeAlias = Vector | Sequence[Vector] | Array

class Joint(TypedDict, total=False):
    # Which motions it leaves.
    type: Required[Literal["fixed", "bracket", "revolute", "prismatic", "cylindrical", "universal", "spherical", "planar", "floating", "pin_slot"]]
    # Two bodies, frames or nodes; coordinates are those of the second relative to the first.
    between: Required[Between]
    # Its point, m, global; named frames determine it. Two: a point of each body, which are drawn apart
    # and brought together.
    at: OneOrTwoVectors
    # The joint's z axis, global: of rotation, of translation, of a plane its normal; of a universal joint
    # the first; of a pin_slot joint the pin's.
    axis: OneOrTwoVectors
    # Second axis of a universal joint; direction of the slot of a pin_slot joint. At right angles to the
    # first.
    axis2: OneOrTwoVectors
    # Whether it may be or is cut where loops are closed.
    cut: Literal["automatic", "never", "always"]
    # Initial coordinates, m or rad; null: free to be found.
    position: InitialValues
    # Approximate initial coordinates, if the assembly may choose them, m or rad; null: as drawn.
    near: InitialValues
    # Initial rates, m/s or rad/s.
    velocity: InitialValues
    # Prescribed motion.
    drive: Drive | Sequence[Drive]
    # Springs and dampers on its coordinates.
    spring: JointSpring | Sequence[JointSpring]

class ConstraintTerms(TypedDict, total=False):
    # Whose coordinate.
    joint: Required[str]
    # Which of several, from 0.
    coordinate: Number
    # That it is multiplied by.
    factor: Required[Number]

class Constraint(TypedDict, total=False):
    # Kind: of coordinates of joints (the first four), or of two bodies.
    type: Required[Literal["coupling", "gear", "rack", "differential", "distance", "on_line", "on_plane", "on_curve", "parallel", "perpendicular", "constant_velocity", "screw", "orientation", "rolling", "rolling_on_road", "knife_edge"]]
    # Of a gear the two, of a rack pinion and rack, of a differential cage, left and right.
    joints: Sequence[str]
    # Of each of the joints which of its coordinates, where they have several.
    coordinates: Sequence[Number | None] | Array
    # Of a gear: speed of the first joint over that of the second; negative: the other way round.
    ratio: Number
    # Of a gear, of both wheels, instead of a ratio; in mesh they turn against each other.
    teeth: Sequence[Number] | Array
    # Of a gear with teeth: one of the wheels is a ring, so that both turn the same way.
    internal: Flag
    # Of a rack's pinion, or of a rolling wheel from its centre to its rim, m.
    radius: Number
    # Of a rolling wheel, m: radius of its rim across the wheel; 0, the default: a sharp disc; `radius`
    # itself: a ball.
    crown: Number
    # Of a rack for each turn of the pinion, m, instead of the radius.
    travel: Number
    # Of a coupling: the sum of the coordinates times their factors stays equal to `constant`.
    terms: Sequence[ConstraintTerms]
    # Of couplings: what the sum is; default: 0.
    constant: Number
    # Two bodies, frames or nodes.
    between: Between
    # Where it acts, m, global: one place; of a distance two, one of each body; of rolling a point of the
    # plane and the wheel's centre; on a road the wheel's centre.
    at: Sequence[Number | Vector | None] | Array
    # Of rolling on a road: the wheel, a body or a frame whose z axis is the wheel's.
    on: str
    # That is rolled on, over a grid.
    road: str
    # On the first, global: direction of a line, a plane's normal, an axis, a shaft; of a knife edge, on
    # the second: across the edge; of rolling on a road the wheel's axis.
    axis: Vector
    # On the second, likewise; of rolling the wheel's axis; default but for perpendicular axes: `axis`.
    axis2: Vector
    # Of a distance, m; default: as assembled.
    length: Number
    # Of a screw, m for each turn, right-handed where positive.
    lead: Number
    # Of a curve on the first, m, global, in the assembled position.
    points: Sequence[Vector] | Array
    # Whether the curve is closed; otherwise it continues straight beyond its ends.
    closed: Flag

class Spring(TypedDict, total=False):
    # Two bodies, frames or nodes.
    between: Required[Between]
    # Two points, m, global; null: at a frame, or at the origin of a body's frame.
    at: Sequence[Vector | None] | Array
    # Law of the length (m), N; pulling is positive.
    elastic: Law
    # Law of its rate (m/s), N, or a number, N s/m.
    damping: Law
    # Tension, an expression of l (length), v (rate) and t (time).
    force: str | float

class Load(TypedDict, total=False):
    # A body, frame or node.
    on: Required[str]
    # Its point on a body, m, global.
    at: Vector
    # N, global.
    force: Vector
    # N m, global.
    moment: Vector
    # Times this: a law or expression of t; default: 1.
    scale: Law
    # Whether it turns with the body.
    follower: Flag

RoadIso8608 = TypedDict("RoadIso8608", {"class": Literal["A", "B", "C", "D", "E", "F", "G", "H"], "roughness": Number, "waviness": Number, "length": Required[Number], "width": Number, "seed": int | str}, total=False)

class RoadPatches(TypedDict, total=False):
    # From, to, m; default: everywhere.
    x: Sequence[Number] | Array
    # From, to, m; default: everywhere.
    y: Sequence[Number] | Array
    # Factor there.
    friction: Required[Number]

class Road(TypedDict, total=False):
    # Height over distance, over time, or over a grid of x and y.
    over: Required[Literal["distance", "time", "grid"]]
    # [m or s, height in m]; a repeated first number is a jump; level beyond the ends.
    points: Points
    # Period, m or s.
    repeat: Number
    # Of a road over time, instead of points: an expression of t, inputs and signals.
    height: str | float
    # Of a grid: x and y of the first height, m.
    origin: Sequence[Number] | Array
    # Of a grid: cells along x and y, m.
    spacing: Sequence[Number] | Array
    # Of a grid: rows along y of heights along x, m.
    heights: Sequence[Sequence[Number] | Array] | Array
    # Of a grid: an OpenCRG file (.crg) instead of heights, sampled every 'spacing', by default its
    # increment.
    file: str
    # Of a grid: a random road instead of heights.
    iso8608: RoadIso8608
    # Factor on the friction of tyres, 1 by default.
    friction: Number
    # Places with another friction; the last one counts.
    patches: Sequence[RoadPatches]

class Tyre(TypedDict, total=False):
    # A body; of a tyre that rolls, the one that turns with it.
    on: Required[str]
    # Its centre, m, global.
    at: Vector
    # Name of a road.
    road: Required[str]
    # Vertical, N/m.
    stiffness: Number
    # m.
    radius: Number
    # vertical: a spring only, the default; brush, magic_formula, tmeasy: roll, slip and steer.
    model: Literal["vertical", "brush", "magic_formula", "tmeasy"]
    # Of magic_formula: a tyre property file (.tir) of MF-Tyre 5.2, 6.1 or 6.2; stiffness and radius are
    # in it.
    file: str
    # That it rolls about, to the left of forwards, global; default: [0, 1, 0].
    axis: Vector
    # Vertical, N s/m; default 0.
    damping: Number
    # Force over slip, at small slip, N.
    longitudinal_stiffness: Number
    # Force over slip angle, at small angles, N/rad.
    cornering_stiffness: Number
    # Limit of the force along the road, by the vertical one.
    friction: Number
    # Way on which the force along follows its slip, m.
    longitudinal_relaxation: Number
    # Way on which the force across follows its slip, m.
    lateral_relaxation: Number
    # Of the footprint, m.
    half_length: Number
    # At which these are so: stiffnesses go with the load; 0: they do not, N; default 0.
    load: Number
    # Force that resists rolling, by the vertical one; default 0.
    rolling_resistance: Number
    # Damping over stiffness of the carcass, of a wheel that stands, s; default 0.11 sqrt(R/g).
    settling: Number
    # Of tmeasy: largest force along, N.
    longitudinal_peak: Number
    # Of tmeasy: slip at which it is.
    longitudinal_peak_slip: Number
    # Of tmeasy: force along where all slides, N.
    longitudinal_sliding: Number
    # Of tmeasy: slip from which on all slides; above the peak's.
    longitudinal_sliding_slip: Number
    # Of tmeasy: largest force across, N.
    lateral_peak: Number
    # Of tmeasy: slip at which it is.
    lateral_peak_slip: Number
    # Of tmeasy: force across where all slides, N.
    lateral_sliding: Number
    # Of tmeasy: slip from which on all slides; above the peak's.
    lateral_sliding_slip: Number
    # Of tmeasy: at twice the load, over that at the load; default 2.
    longitudinal_stiffness_growth: Number
    # Of tmeasy: at twice the load, over that at the load; default 2.
    longitudinal_peak_growth: Number
    # Of tmeasy: at twice the load, over that at the load; default 1.
    longitudinal_peak_slip_growth: Number
    # Of tmeasy: at twice the load, over that at the load; default 2.
    longitudinal_sliding_growth: Number
    # Of tmeasy: at twice the load, over that at the load; default 1.
    longitudinal_sliding_slip_growth: Number
    # Of tmeasy: at twice the load, over that at the load; default 2.
    cornering_stiffness_growth: Number
    # Of tmeasy: at twice the load, over that at the load; default 2.
    lateral_peak_growth: Number
    # Of tmeasy: at twice the load, over that at the load; default 1.
    lateral_peak_slip_growth: Number
    # Of tmeasy: at twice the load, over that at the load; default 2.
    lateral_sliding_growth: Number
    # Of tmeasy: at twice the load, over that at the load; default 1.
    lateral_sliding_slip_growth: Number
    # Of tmeasy: lever of the force across at no slip, by the footprint's length; default 1/6.
    trail: Number
    # Of tmeasy: slip across at which the trail is 0; default 0.2.
    trail_zero_slip: Number
    # Of tmeasy: slip across from which on the trail stays 0; default 0.5.
    trail_end_slip: Number

class Output(TypedDict, total=False):
    # Point on a body, m, global.
    at: Vector
    # x y z, fx … mz, xx …, or a number from 0.
    component: str | int
    # Direction, global in the assembled position.
    along: Vector
    # Is added.
    offset: Number
    # Of a frame or body, m, global.
    position: str
    # m/s, global.
    velocity: str
    # m/s², global.
    acceleration: str
    # rad.
    roll: str
    # rad.
    pitch: str
    # rad.
    yaw: str
    # Of a point of a flexible body, m.
    deflection: str
    # Of a frame in the axes of `relative_to`, m.
    displacement: str
    # Of a displacement: the frame in whose axes it is seen.
    relative_to: str
    # Its coordinate, m or rad.
    joint: str
    # Its rate, m/s or rad/s.
    joint_velocity: str
    # Its acceleration, m/s² or rad/s².
    joint_acceleration: str
    # Rotation vector of a spherical or floating joint, x y z, rad.
    joint_rotation: str
    # Unit quaternion of a spherical or floating joint, w x y z.
    joint_quaternion: str
    # Force (N) or moment (N m) on the joint's second body, global.
    joint_force: str
    # Of a flexible body: m, rad, or 1.
    modal_amplitude: str
    # A body of `mimbre reduce`; its largest von Mises stress, or that of component, node and at.
    stress: str
    # Likewise; with `along` the elongation in a direction.
    strain: str
    # A flexible body made of bars: N, Vy, Vz, T, My, Mz or von_mises in the section at the node of its
    # bars at the place `at`; without a place in all sections, without a component all of them.
    section_force: str
    # Of a stress or strain: the node's number in the body's mesh.
    node: Number
    # N; tension is positive.
    spring_force: str
    # m.
    spring_length: str
    # N, of the road on it, in the axes of its contact: component vertical (where none is named),
    # longitudinal, lateral.
    tyre_force: str
    # N m, likewise: component overturning, rolling, aligning.
    tyre_moment: str
    # Over its speed forwards, positive where it drives.
    tyre_slip: str
    # rad, from forwards to where it goes, positive to the left.
    tyre_slip_angle: str
    # rad, positive to the right.
    tyre_camber: str
    # m, along the road's normal.
    tyre_deflection: str
    # N: component x, y, z in global axes on its spheres, or normal, tangential: sums of magnitudes.
    contact_force: str
    # m, the largest.
    contact_depth: str
    # Pairs that touch.
    contact_count: str
    # Of a contact: the body whose share it is; without it all spheres.
    on: str
    # rad/s.
    angular_velocity: str
    # rad/s².
    angular_acceleration: str
    # Of an angular velocity or acceleration: global axes, or the frame's own.
    axes: Literal["global", "own"]
    # Of a body, a list of bodies, or `all`.
    centre_of_mass: str | Sequence[str]
    # Likewise.
    linear_momentum: str | Sequence[str]
    # Likewise; about their centre of mass, or about the fixed point `about`.
    angular_momentum: str | Sequence[str]
    # Fixed point that moments of momentum are taken about, m.
    about: Vector

class Integrator(TypedDict, total=False):
    # How steps are made.
    type: Required[Literal["generalized_alpha", "newmark", "hht", "conserve", "rk4", "dopri853", "radau", "auto"]]
    # Spectral radius of generalized_alpha (0 to 1) and hht (0.5 to 1); 1 damps nothing.
    rho: Number
    # Of newmark: 0, or less, which damps.
    xi: Number
    # Of dopri853 and radau: error of each part that a step is made in, relative to the size of the
    # mechanism; without it a step has one part.
    accuracy: Number

class Simulation(TypedDict, total=False):
    # s; default: 0.01.
    step: Number
    # s; default: 10.
    end: Number
    # Of the rows of results, s; default: every step.
    output_interval: Number
    # How steps are made.
    integrator: Integrator
    # Coordinates: of the joints (relative), or points and unit vectors (natural).
    formulation: Literal["relative", "natural"]
    # Inertia of flexible bodies: shape integrals, or projection of the mesh's mass matrix in every
    # evaluation.
    inertia: Literal["integrals", "projection", "projection_translations"]
    # How the constraints enter the equations of motion.
    formalism: Literal["index3", "index1", "baumgarte", "penalty", "index1_augmented", "independent", "global_modes", "transfer_matrices"]
    # Of the iterations, relative; default: 1e-5.
    tolerance: Number
    # Weight of the constraints; default: that of the formalism.
    penalty: Number
    # Of a step.
    max_iterations: Number
    # Parts in which an inaccurate step is made again; 1: never.
    substeps: Number
    # Error of a step's energy balance, relative to the energy in motion, above which it is made again in
    # substeps; default: 1e-4.
    energy_tolerance: Number
    # For real time: a step is made once, and accepted after max_iterations (6).
    fixed_cost: Flag

class Actuator(TypedDict, total=False):
    # On whose coordinate it acts.
    joint: str
    # Which of several, from 0.
    coordinate: Number
    # Two bodies, frames or nodes that it acts between.
    between: Between
    # Their points, m, global.
    at: Sequence[Any] | Array
    # Direction of the force, turning with the first body.
    along: Vector
    # Axis of the torque, turning with the first body.
    about: Vector
    # An expression of t, inputs, signals and outputs.
    force: str | float
    # Likewise, about an angle.
    torque: str | float
    # Likewise.
    moment: str | float

class BushingLawsX(TypedDict, total=False):
    """In this direction."""
    # Law of the measure, N or N m.
    elastic: Law
    # Law of its rate.
    damping: Law

class BushingLawsY(TypedDict, total=False):
    """In this direction."""
    # Law of the measure, N or N m.
    elastic: Law
    # Law of its rate.
    damping: Law

class BushingLawsZ(TypedDict, total=False):
    """In this direction."""
    # Law of the measure, N or N m.
    elastic: Law
    # Law of its rate.
    damping: Law

class BushingLawsRx(TypedDict, total=False):
    """In this direction."""
    # Law of the measure, N or N m.
    elastic: Law
    # Law of its rate.
    damping: Law

class BushingLawsRy(TypedDict, total=False):
    """In this direction."""
    # Law of the measure, N or N m.
    elastic: Law
    # Law of its rate.
    damping: Law

class BushingLawsRz(TypedDict, total=False):
    """In this direction."""
    # Law of the measure, N or N m.
    elastic: Law
    # Law of its rate.
    damping: Law

class BushingLaws(TypedDict, total=False):
    """Laws of single directions, added to stiffness and damping."""
    # In this direction.
    x: BushingLawsX
    # In this direction.
    y: BushingLawsY
    # In this direction.
    z: BushingLawsZ
    # In this direction.
    rx: BushingLawsRx
    # In this direction.
    ry: BushingLawsRy
    # In this direction.
    rz: BushingLawsRz

class BushingMaxwell(TypedDict, total=False):
    # Six numbers (of x, y, z and the turns about them), or six rows of six.
    stiffness: Required[Sequence[Number | Sequence[Number] | Array] | Array]
    # Time of relaxation, s.
    relaxation: Required[Number]

class Bushing(TypedDict, total=False):
    # Two bodies, frames or nodes.
    between: Required[Between]
    # Its point, m, global.
    at: Vector
    # Direction of its x axis, on the first body.
    x: Vector
    # Direction of its y axis.
    y: Vector
    # Direction of its z axis.
    z: Vector
    # Six numbers (of x, y, z and the turns about them), or six rows of six.
    stiffness: Sequence[Number | Sequence[Number] | Array] | Array
    # Six numbers (of x, y, z and the turns about them), or six rows of six.
    damping: Sequence[Number | Sequence[Number] | Array] | Array
    # Laws of single directions, added to stiffness and damping.
    laws: BushingLaws
    # Branches of a spring in row with a damper.
    maxwell: Sequence[BushingMaxwell]

class InputKeys(TypedDict, total=False):
    # For people.
    unit: str
    # Value until it is set.
    start: Number
    # Least and largest value.
    range: Sequence[Number] | Array
    # Between two settings: constant, or linear over the next step.
    hold: Literal["constant", "linear"]
    # Description for people.
    about: str

Input: TypeAlias = Number | InputKeys

class SignalKeys(TypedDict, total=False):
    # Expression of t, signals, inputs, outputs and tunable parameters.
    value: str | float
    # Evaluated at multiples of this only, s.
    every: Number
    # For people.
    unit: str
    # Description for people.
    about: Any
    # Point on a body, m, global.
    at: Vector
    # x y z, fx … mz, xx …, or a number from 0.
    component: str | int
    # Direction, global in the assembled position.
    along: Vector
    # Is added.
    offset: Number
    # Of a frame or body, m, global.
    position: str
    # m/s, global.
    velocity: str
    # m/s², global.
    acceleration: str
    # rad.
    roll: str
    # rad.
    pitch: str
    # rad.
    yaw: str
    # Of a point of a flexible body, m.
    deflection: str
    # Of a frame in the axes of `relative_to`, m.
    displacement: str
    # Of a displacement: the frame in whose axes it is seen.
    relative_to: str
    # Its coordinate, m or rad.
    joint: str
    # Its rate, m/s or rad/s.
    joint_velocity: str
    # Force (N) or moment (N m) on the joint's second body, global.
    joint_force: str
    # Of a flexible body: m, rad, or 1.
    modal_amplitude: str
    # A body of `mimbre reduce`; its largest von Mises stress, or that of component, node and at.
    stress: str
    # Likewise; with `along` the elongation in a direction.
    strain: str
    # Of a stress or strain: the node's number in the body's mesh.
    node: Number
    # N; tension is positive.
    spring_force: str
    # m.
    spring_length: str
    # N, of the road on it, in the axes of its contact: component vertical (where none is named),
    # longitudinal, lateral.
    tyre_force: str
    # N m, likewise: component overturning, rolling, aligning.
    tyre_moment: str
    # Over its speed forwards, positive where it drives.
    tyre_slip: str
    # rad, from forwards to where it goes, positive to the left.
    tyre_slip_angle: str
    # rad, positive to the right.
    tyre_camber: str
    # m, along the road's normal.
    tyre_deflection: str
    # N: component x, y, z in global axes on its spheres, or normal, tangential: sums of magnitudes.
    contact_force: str
    # m, the largest.
    contact_depth: str
    # Pairs that touch.
    contact_count: str
    # Of a contact: the body whose share it is; without it all spheres.
    on: str
    # rad/s.
    angular_velocity: str
    # rad/s².
    angular_acceleration: str
    # Of an angular velocity or acceleration: global axes, or the frame's own.
    axes: Literal["global", "own"]
    # Of a body, a list of bodies, or `all`.
    centre_of_mass: str | Sequence[str]
    # Likewise.
    linear_momentum: str | Sequence[str]
    # Likewise; about their centre of mass, or about the fixed point `about`.
    angular_momentum: str | Sequence[str]
    # Its acceleration, m/s² or rad/s².
    joint_acceleration: str
    # Rotation vector of a spherical or floating joint, x y z, rad.
    joint_rotation: str
    # Unit quaternion of a spherical or floating joint, w x y z.
    joint_quaternion: str
    # A PID controller: what it measures; the setpoint is in `setpoint`.
    pid: str | float
    # Setpoint of a PID controller; default: 0.
    setpoint: str | float
    # Proportional gain; default: 0.
    kp: Number
    # Integral gain, per s; default: 0.
    ki: Number
    # Derivative gain, s; default: 0.
    kd: Number
    # Time constant of the derivative's filter, s.
    filter: Number
    # Limit of the controller's output; default: none.
    lower: Number
    # Likewise.
    upper: Number
    # Of the setpoint in the proportional part; default: 1.
    setpoint_weight: Number
    # Of the setpoint in the derivative part; default: 0.
    derivative_weight: Number
    # The integral part at the start; default: 0.
    integral: Number
    # A linear filter: its input; with `every` its polynomials are of z, else of s.
    transfer_function: str | float
    # Coefficients of a transfer function, that of the highest power first.
    numerator: Sequence[Number] | Array
    # Likewise.
    denominator: Sequence[Number] | Array
    # A linear system: its input, or a list of them; with `every` a difference equation.
    state_space: str | float | Sequence[str | float]
    # States to their rates (with `every`: to the next ones), n rows of n.
    A: Number | Sequence[Number | Sequence[Number] | Array] | Array
    # Inputs to the same, n rows.
    B: Number | Sequence[Number | Sequence[Number] | Array] | Array
    # States to outputs, a row for each.
    C: Number | Sequence[Number | Sequence[Number] | Array] | Array
    # Inputs to outputs; default: 0.
    D: Number | Sequence[Number | Sequence[Number] | Array] | Array
    # States at the start; default: 0.
    initial: Number | Sequence[Number | Sequence[Number] | Array] | Array
    # Names of several outputs: their signals are NAME.OUTPUT. Of an FMU: the names of its variables, or
    # {OUTPUT: variable}; of a variable alone the signal is NAME.
    outputs: Mapping[str, str]
    # A table: its input, with `points`; or two, with `x`, `y` and `values`.
    table: str | float | Sequence[str | float]
    # [[x, y], ..] of a table.
    points: Points
    # Between points; default: linear.
    interpolation: Literal["linear", "cubic"]
    # Places of the rows of `values`, of the first input.
    x: Sequence[Number] | Array
    # Places of its columns, of the second.
    y: Sequence[Number] | Array
    # Of a table of two inputs; between them linear in each.
    values: Sequence[Sequence[Number] | Array] | Array
    # Follows this no faster than it may.
    rate_limit: str | float
    # Largest rate upwards, per s.
    rising: Number
    # Largest rate downwards, per s, below 0; default: -rising.
    falling: Number
    # Gives this later, by `time`.
    delay: str | float
    # Of a delay, s; with `every` a whole number of these.
    time: Number
    # A relay: its input.
    hysteresis: str | float
    # From which on a relay is high.
    rises_at: Number
    # Down to which it stays high.
    falls_at: Number
    # Output when it is low; default: 0.
    low: Number
    # Output when it is high; default: 1.
    high: Number
    # 1: at the start, between the thresholds, it is high; default: 0.
    starts_high: Number
    # White noise, a new number `every` so often.
    noise: Literal["normal", "uniform"]
    # Of noise; default: 0.
    mean: Number
    # Standard deviation of noise; default: 1.
    deviation: Number
    # Of noise, a whole number; default: 0.
    seed: Number
    # File of an FMU for co-simulation, FMI 2 or 3, that computes it: docs/fmu-import.md.
    fmu: str
    # Of an FMU: its inputs by their names, and expressions of what they get.
    inputs: Mapping[str, str | float]
    # Of an FMU: start values of its parameters and other variables by their names.
    parameters: Mapping[str, str | float | bool]
    # Of an FMU: its step from one instant to the next sees the inputs of the first (default) or of the
    # second.
    inputs_at: Literal["start", "end"]
    # Of an FMU: it runs in a process of its own, so that a crash or a hang there ends nothing else;
    # default: false.
    process: bool
    # Of an FMU in a process of its own: how long a call may take, s of the clock; default: 30.
    timeout: Number
    # A flexible body made of bars: N, Vy, Vz, T, My, Mz or von_mises in the section at the node of its
    # bars at the place `at`.
    section_force: str

Signal: TypeAlias = str | float | SignalKeys

class GasSpring(TypedDict, total=False):
    # Two bodies, frames or nodes.
    between: Required[Between]
    # Its ends, m, global.
    at: Sequence[Vector | None] | Array
    # Pa, at `length`.
    pressure: Required[Number]
    # m².
    area: Required[Number]
    # m.
    length: Required[Number]
    # Of the column of gas at `length`, m.
    gas_length: Required[Number]
    # Polytropic; default: 1.2.
    exponent: Number
    # N s/m; default: 0.
    damping: Number
    # Pa; default: 101325.
    ambient: Number

class HydraulicDamper(TypedDict, total=False):
    # Two bodies, frames or nodes.
    between: Required[Between]
    # Its ends, m, global.
    at: Sequence[Vector | None] | Array
    # Force over speed at low speed, N s/m.
    damping: Required[Number]
    # Force over squared speed of the orifices, N s²/m²; default: 0.
    quadratic: Number
    # Of the piston, m².
    area: Required[Number]
    # Of the oil column in each chamber, m.
    length: Required[Number]
    # Of the oil, Pa; default: 1.4e9.
    bulk_modulus: Number

class Friction(TypedDict, total=False):
    # On whose coordinate it acts.
    joint: Required[str]
    # Which of several, from 0.
    coordinate: Number
    # The limit in fast sliding, on a length, N: a number or an expression of t, inputs, signals and
    # outputs.
    force: str | float
    # Likewise about an angle, N m.
    torque: str | float
    # Elastic presliding displacement, m or rad; default: 1e-5 L, or 1e-5 rad.
    sticking: Number
    # The limit at rest over that in fast sliding; default: 1.
    static_ratio: Number
    # Speed over which the limit falls from the one to the other, m/s or rad/s; default: 3e-3 sqrt(g L),
    # or 3e-3 sqrt(g/L).
    stribeck: Number
    # Additional damping, N s/m or N m s/rad; default: 0.
    viscous: Number
    # Time constant of the decay of vibrations while sticking, s; default: 3e-3 sqrt(L/g).
    settling: Number

class Stop(TypedDict, total=False):
    # On whose coordinate it acts.
    joint: str
    # Which of several, from 0.
    coordinate: Number
    # Two bodies, frames or nodes.
    between: Between
    # Its ends, m, global.
    at: Sequence[Vector | None] | Array
    # Where it begins below, m or rad, of the coordinate or the distance; default: nowhere.
    lower: Number
    # Where it begins above, likewise.
    upper: Number
    # N/m or N m/rad at `depth`, or anywhere where the exponent is 1.
    stiffness: Required[Number]
    # Of the force over the depth, from 1; default: 1.
    exponent: Number
    # At which the stiffness is that, m or rad; default: 1e-3 L, on an angle 1e-3 rad.
    depth: Number
    # Coefficient of restitution: the ratio of rebound to impact speed, from 0.01 to 1; default: 1.
    restitution: Number

class Surface(TypedDict, total=False):
    # half_space: all below its plane z = 0; cylinder and capsule: about its z axis; heights: all below a
    # grid; mesh: closed triangles.
    type: Required[Literal["half_space", "box", "cylinder", "capsule", "sphere", "heights", "mesh"]]
    # A body, a frame, whose place and axes are then the surface's, or ground, the default.
    on: str
    # Its origin, m, global; default: the body's origin. A box, cylinder, capsule or sphere is centred
    # there, a grid begins there.
    at: Vector
    # Direction of its x axis, global.
    x: Vector
    # Direction of its y axis, global.
    y: Vector
    # Direction of its z axis, global: of a half-space's outward normal, of a cylinder's axis.
    z: Vector
    # Of a box: edges along x, y and z, m.
    size: Vector
    # Of a cylinder, capsule or sphere, m.
    radius: Number
    # Of a cylinder; of a capsule between the centres of its ends; m.
    length: Number
    # Of a grid: cells along x and y, m.
    spacing: Sequence[Number] | Array
    # Of a grid: rows along y of heights along x, m.
    heights: Sequence[Sequence[Number] | Array] | Array
    # Of a mesh, m, in the surface's axes.
    vertices: Sequence[Vector] | Array
    # Of a mesh: three vertices each, counted from 0, counterclockwise from outside.
    triangles: Sequence[Sequence[int]]
    # Of a mesh: a file of triangles that enclose a solid, STL, OBJ, glTF, PLY or Collada, in place of
    # vertices and triangles.
    file: str
    # Factors on the mesh's coordinates: 0.001 where they are millimetres; negative ones mirror.
    scale: Number | Vector

class Spheres(TypedDict, total=False):
    # A body, frame or node (BODY.NODE).
    on: str
    # Centres on that body, m, global; default: its origin.
    at: Vector | Sequence[Vector] | Array
    # Instead: a sphere about every node of this flexible body's surface.
    surface_of: str
    # m.
    radius: Required[Number]

class Contact(TypedDict, total=False):
    # Which spheres.
    spheres: Required[Spheres | Sequence[Spheres]]
    # Names of surfaces that they touch.
    surfaces: str | Sequence[str]
    # They touch one another; default: false.
    among: Flag
    # Of these only those that are near each other are looked at: for hundreds of spheres; default: false.
    swarm: Flag
    # N/m at `depth`, or anywhere where the exponent is 1.
    stiffness: Required[Number]
    # Of the force over the depth, from 1; 1.5 of elastic spheres (Hertz); default: 1.
    exponent: Number
    # At which the stiffness is that, m; default: 1e-3 L.
    depth: Number
    # Coefficient of restitution: the ratio of rebound to impact speed, from 0.01 to 1; default: 1.
    restitution: Number
    # Limit of the tangential force, by the normal one; default: 0.
    friction: Number
    # Of the limit at rest to that in fast sliding, from 1; default: 1.
    static_ratio: Number
    # Speed over which the limit falls to that in fast sliding, m/s; default: 3e-3 sqrt(g L).
    stribeck: Number
    # Tangential presliding stiffness, relative to the normal stiffness; default: 0.7.
    tangential: Number
    # Time constant of the decay of vibrations while sticking, s; default: 40 % of critical damping.
    settling: Number
    # Arm of the normal force that resists rolling, m; default: 0.
    rolling: Number
    # Arm of the normal force that resists turning about it, m; default: 0.
    spinning: Number

class TorsionSpringCoordinates(TypedDict, total=False):
    # Its name.
    joint: Required[str]
    # Which of several, from 0.
    coordinate: Number
    # Default: 1.
    factor: Number

class TorsionSpring(TypedDict, total=False):
    # Whose sum it measures, each times its factor.
    coordinates: Required[Sequence[TorsionSpringCoordinates]]
    # N m/rad, or N/m where the first coordinate is a length.
    stiffness: Number
    # The sum without force, rad or m; a number or an expression of t, inputs, signals and outputs;
    # default: 0.
    rest: str | float
    # In place of stiffness and rest: the force over the sum; an expression may use inputs, signals and
    # outputs.
    elastic: Law
    # Over the sum's rate; a number: the coefficient, N m s/rad or N s/m. An expression may use inputs,
    # signals and outputs.
    damping: Law

class Cable(TypedDict, total=False):
    # Bodies, frames or nodes, from end to end; those between are pulleys without friction.
    over: Required[Sequence[str]]
    # A place for each, m, global.
    at: Sequence[Vector | None] | Array
    # E A, N: tension over strain.
    axial_stiffness: Required[Number]
    # Of the taut cable, N s/m; default: 0.
    damping: Number
    # Without tension, m; a number or an expression of t, inputs, signals and outputs, as a winch has it;
    # default: such that the preload is that of the assembled position.
    length: str | float
    # Tension in the assembled position, N; default: 0.
    preload: Number

class Motor(TypedDict, total=False):
    # On whose coordinate it acts.
    joint: Required[str]
    # Which of several, from 0.
    coordinate: Number
    # Torque over speed at full command, N m over rad/s, at the motor.
    curve: Law
    # With a curve: from -1 to 1.
    command: str | float
    # With constant and resistance: V.
    voltage: str | float
    # Motor turns per turn of the joint, or rad/m; default: 1.
    ratio: Number
    # Of the rotor, kg m²; default: 0.
    inertia: Number
    # Of a DC motor: torque over current, N m/A, and voltage over speed, V s/rad.
    constant: Number
    # Of its winding, ohm.
    resistance: Number
    # A, of either sign; default: none.
    current_limit: Number
    # N m at the motor, of either sign; default: none.
    torque_limit: Number
    # Viscous, at the motor, N m s/rad; default: 0.
    drag: Number
    # Of the gear; default: 1.
    efficiency: Number

class Drag(TypedDict, total=False):
    # A body, frame or node.
    on: Required[str]
    # Where on a body, m, global.
    at: Vector
    # Direction of the first axis, global; default: the frame's.
    x: Vector
    # Likewise.
    y: Vector
    # Likewise.
    z: Vector
    # That the coefficients are for, m².
    area: Required[Number]
    # Of the air, kg/m³; default: 1.225.
    density: Number
    # Along the axes; one number: the same along all.
    coefficients: Required[Number | Vector]
    # Its velocity, m/s, global: numbers or expressions; default: none.
    wind: Sequence[str | float]

class Event(TypedDict, total=False):
    """What happens when a value crosses another."""
    # What crosses a value: an expression of t, signals, inputs, outputs and tunable parameters.
    when: Required[str | float]
    # The value; default: 0.
    crosses: Number
    # In which it has to cross; default: either.
    direction: Literal["either", "rising", "falling"]
    # Inputs and tunable parameters, and what they are set to: numbers or expressions, as they are at that
    # moment.
    set: Mapping[str, str | float]
    # Whether the run ends there; default: false.
    stop: Flag
    # Description for people.
    about: Any

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
    value: Required[float | str | bool]
    choices: Sequence[str]
    min: Number
    max: Number
    integer: bool
    about: str
    tunable: Flag

Parameter: TypeAlias = float | str | bool | ParameterKeys

class Requirement(TypedDict, total=False):
    that: Required[Number]
    message: Required[str]

class Material(TypedDict, total=False):
    """Pa, –, kg/m³"""
    young: Required[Number]
    poisson: Required[Number]
    density: Required[Number]

class Section(TypedDict, total=False):
    type: Literal["round", "tube", "rectangle"]
    diameter: Number
    # Along the element's y and z: kA of Timoshenko's theory.
    shear_areas: Sequence[Number] | Array
    inner_diameter: Number
    width: Number
    height: Number
    area: Number
    Iy: Number
    Iz: Number
    J: Number

class Pose(TypedDict, total=False):
    at: Vector
    x: Vector
    y: Vector
    z: Vector

class Shape(TypedDict, total=False):
    box: Vector
    cylinder: Sequence[Number] | Array
    sphere: Number
    at: Vector
    axis: Vector
    x: Vector
    y: Vector

class NodeKeys(TypedDict, total=False):
    at: Vector
    # Bar and part of its length.
    on: Sequence[Any] | Array

Node: TypeAlias = Vector | NodeKeys

Bar = TypedDict("Bar", {"from": Required[str], "to": Required[str], "elements": Number, "section": str, "material": str, "beam_theory": Literal["euler_bernoulli", "rayleigh", "timoshenko"] | str, "y": Vector}, total=False)

class StaticMode(TypedDict, total=False):
    node: Required[str]
    along: Vector
    about: Vector
    all: Flag
    name: str
    # Left out where this is false (0).
    when: Flag

class FlexibleAxialModesKeys(TypedDict, total=False):
    count: Required[Number]
    end: Literal["held", "free"] | str

class FlexibleSubstructuresKeys(TypedDict, total=False):
    count: Required[Number]
    # Of every piece but the last; default: as the last.
    dynamic_modes: Number

class Flexible(TypedDict, total=False):
    material: str
    section: str
    nodes: Required[Mapping[str, Node]]
    bars: Required[Mapping[str, Bar]]
    clamped: Required[Sequence[str]]
    static_modes: Sequence[StaticMode]
    dynamic_modes: Number
    stiffness_damping: Number
    planar: Vector
    # What bending does along the beam. Or text with $parameter or 'condition ? word : word'.
    stiffening: Literal["linear", "foreshortening", "nonlinear_stiffness_1", "nonlinear_stiffness_2", "geometric_stiffness"] | str
    # Of the nonlinear stiffnesses: the strain energy's gradient, or the published force.
    stiffening_force: Literal["consistent", "published"] | str
    # What becomes of the bars: modes, a floating frame for every element, or absolute nodal coordinates
    # in a plane.
    beam: Literal["reduced", "corotational", "ancf"] | str
    # Of the bars: sections at right angles to the axis, these with rotary inertia, or shear and rotary
    # inertia.
    beam_theory: Literal["euler_bernoulli", "rayleigh", "timoshenko"] | str
    # How frames turn by the small rotations of their modes.
    boundary_rotation: Literal["exponential", "successive", "infinitesimal"] | str
    # Of one straight bar: the static stretch of its free end, then dynamic modes that only stretch; with
    # the end free, the bar's own axial modes.
    axial_modes: Number | FlexibleAxialModesKeys
    # Pieces into which the bars are cut, joined by brackets.
    substructures: Number | FlexibleSubstructuresKeys

class BodyRigid(TypedDict, total=False):
    mass: Required[Number]
    com: Vector
    # Ixx Iyy Izz [Ixy Ixz Iyz] about the centre of mass, axes of the body's frame.
    inertia: Sequence[Number] | Array

class Body(TypedDict, total=False):
    mass: Number
    com: Vector
    # Ixx Iyy Izz [Ixy Ixz Iyz] about the centre of mass, axes of the body's frame.
    inertia: Sequence[Number] | Array
    as_: str
    frame: Pose
    rigid: BodyRigid
    flexible: Flexible
    reduced: str | ReducedBody
    shapes: Sequence[Shape]
    lines: Sequence[Sequence[Vector] | Array]

class Frame(TypedDict, total=False):
    body: Required[str]
    at: Required[Vector]
    x: Vector
    y: Vector
    z: Vector

Between: TypeAlias = Sequence[str]

InitialValues: TypeAlias = Number | Sequence[float | str | None]

class LawKeysPieces(TypedDict, total=False):
    until: Number
    polynomial: Required[Sequence[Number] | Array]

class LawKeys(TypedDict, total=False):
    stiffness: Number
    zero: Number
    coefficient: Number
    constant: Number
    polynomial: Sequence[Number] | Array
    pieces: Sequence[LawKeysPieces]
    table: Points
    interpolation: Literal["linear", "cubic"]

Law: TypeAlias = str | float | LawKeys

class Drive(TypedDict, total=False):
    """A prescribed coordinate, by its position or by its speed; an expression is one of t."""
    position: Law
    # Instead of the position, which then starts from the joint's `position` (or 0).
    speed: Law
    coordinate: Number

class JointSpring(TypedDict, total=False):
    stiffness: Number
    damping: Law
    zero: Number
    elastic: Law
    coordinate: Number

class Joint(TypedDict, total=False):
    type: Required[Literal["fixed", "bracket", "revolute", "prismatic", "cylindrical", "universal", "spherical", "planar", "floating"]]
    between: Required[Between]
    at: Vector
    axis: Vector
    axis2: Vector
    cut: Literal["automatic", "never", "always"]
    position: InitialValues
    velocity: InitialValues
    drive: Drive | Sequence[Drive]
    spring: JointSpring | Sequence[JointSpring]

class Spring(TypedDict, total=False):
    between: Required[Between]
    at: Sequence[Vector | None] | Array
    elastic: Law
    damping: Law
    # Tension, an expression of l (length), v (rate) and t (time).
    force: str | float

class Load(TypedDict, total=False):
    on: Required[str]
    at: Vector
    force: Vector
    moment: Vector
    scale: Law
    follower: Flag

class Road(TypedDict, total=False):
    over: Required[Literal["distance", "time"]]
    points: Points
    repeat: Number
    # Of a road over time, instead of points: an expression of t, inputs and signals.
    height: str | float

class Tyre(TypedDict, total=False):
    on: Required[str]
    at: Vector
    road: Required[str]
    stiffness: Required[Number]
    radius: Required[Number]

class Output(TypedDict, total=False):
    at: Vector
    component: str | int
    along: Vector
    offset: Number
    position: str
    velocity: str
    acceleration: str
    roll: str
    pitch: str
    yaw: str
    deflection: str
    displacement: str
    # Of a displacement: the frame in whose axes it is seen.
    relative_to: str
    joint: str
    joint_velocity: str
    joint_force: str
    modal_amplitude: str
    # A body of `mimbre reduce`; its largest von Mises stress, or what component, node and at say.
    stress: str
    # Likewise; with `along` the elongation in a direction.
    strain: str
    # Of a stress or strain: the node's number in the body's mesh.
    node: Number
    spring_force: str
    spring_length: str
    tyre_force: str
    angular_velocity: str
    # Of an angular velocity: global axes, or the frame's own.
    axes: Literal["global", "own"]
    # Of a body, a list of bodies, or `all`.
    centre_of_mass: str | Sequence[str]
    # Likewise.
    linear_momentum: str | Sequence[str]
    # Likewise; about their centre of mass, or about the fixed point `about`.
    angular_momentum: str | Sequence[str]
    about: Vector

class Integrator(TypedDict, total=False):
    type: Required[Literal["generalized_alpha", "newmark", "hht", "conserve"]]
    rho: Number
    xi: Number

class Simulation(TypedDict, total=False):
    step: Number
    end: Number
    output_interval: Number
    integrator: Integrator
    # Coordinates: of the joints (relative), or points and unit vectors (natural).
    formulation: Literal["relative", "natural"]
    # Inertia of flexible bodies: shape integrals, or projection of the mesh's mass matrix in every
    # evaluation.
    inertia: Literal["integrals", "projection", "projection_translations"]
    # How the constraints enter the equations of motion.
    formalism: Literal["index3", "index1", "baumgarte", "penalty", "index1_augmented", "independent"]
    tolerance: Number
    penalty: Number
    max_iterations: Number
    substeps: Number

class Actuator(TypedDict, total=False):
    joint: str
    coordinate: Number
    between: Between
    at: Sequence[Any] | Array
    along: Vector
    about: Vector
    # An expression of t, inputs, signals and outputs.
    force: str | float
    # Likewise, about an angle.
    torque: str | float
    # Likewise.
    moment: str | float

class BushingLawsX(TypedDict, total=False):
    elastic: Law
    damping: Law

class BushingLawsY(TypedDict, total=False):
    elastic: Law
    damping: Law

class BushingLawsZ(TypedDict, total=False):
    elastic: Law
    damping: Law

class BushingLawsRx(TypedDict, total=False):
    elastic: Law
    damping: Law

class BushingLawsRy(TypedDict, total=False):
    elastic: Law
    damping: Law

class BushingLawsRz(TypedDict, total=False):
    elastic: Law
    damping: Law

class BushingLaws(TypedDict, total=False):
    x: BushingLawsX
    y: BushingLawsY
    z: BushingLawsZ
    rx: BushingLawsRx
    ry: BushingLawsRy
    rz: BushingLawsRz

class BushingMaxwell(TypedDict, total=False):
    # Six numbers (of x, y, z and the turns about them), or six rows of six.
    stiffness: Required[Sequence[Number | Sequence[Number] | Array] | Array]
    relaxation: Required[Number]

class Bushing(TypedDict, total=False):
    between: Required[Between]
    at: Vector
    x: Vector
    y: Vector
    z: Vector
    # Six numbers (of x, y, z and the turns about them), or six rows of six.
    stiffness: Sequence[Number | Sequence[Number] | Array] | Array
    # Six numbers (of x, y, z and the turns about them), or six rows of six.
    damping: Sequence[Number | Sequence[Number] | Array] | Array
    laws: BushingLaws
    # Branches of a spring in row with a damper.
    maxwell: Sequence[BushingMaxwell]

class InputKeys(TypedDict, total=False):
    unit: str
    start: Number
    range: Sequence[Number] | Array
    hold: Literal["constant", "linear"]
    about: str

Input: TypeAlias = Number | InputKeys

class SignalKeys(TypedDict, total=False):
    value: str | float
    every: Number
    unit: str
    about: Any
    at: Vector
    component: str | int
    along: Vector
    offset: Number
    position: str
    velocity: str
    acceleration: str
    roll: str
    pitch: str
    yaw: str
    deflection: str
    displacement: str
    # Of a displacement: the frame in whose axes it is seen.
    relative_to: str
    joint: str
    joint_velocity: str
    joint_force: str
    modal_amplitude: str
    # A body of `mimbre reduce`; its largest von Mises stress, or what component, node and at say.
    stress: str
    # Likewise; with `along` the elongation in a direction.
    strain: str
    # Of a stress or strain: the node's number in the body's mesh.
    node: Number
    spring_force: str
    spring_length: str
    tyre_force: str
    angular_velocity: str
    # Of an angular velocity: global axes, or the frame's own.
    axes: Literal["global", "own"]
    # Of a body, a list of bodies, or `all`.
    centre_of_mass: str | Sequence[str]
    # Likewise.
    linear_momentum: str | Sequence[str]
    # Likewise; about their centre of mass, or about the fixed point `about`.
    angular_momentum: str | Sequence[str]

Signal: TypeAlias = str | float | SignalKeys

class GasSpring(TypedDict, total=False):
    between: Required[Between]
    at: Sequence[Vector | None] | Array
    pressure: Required[Number]
    area: Required[Number]
    length: Required[Number]
    gas_length: Required[Number]
    exponent: Number
    damping: Number
    ambient: Number

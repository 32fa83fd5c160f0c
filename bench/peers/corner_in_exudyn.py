"""One corner of the Iltis in Exudyn, on a chassis: rigid without masses of link and rod, or all three flexible."""

import numpy as np
from bar_elements import Bars, Modes, motion_at, reduced, tube
from exudyn.itemInterface import (
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerNodeRigid,
    MarkerSuperElementPosition,
    NodeGenericODE2,
    NodeRigidBodyEP,
    ObjectConnectorCartesianSpringDamper,
    ObjectConnectorDistance,
    ObjectConnectorSpringDamper,
    ObjectFFRFreducedOrder,
    ObjectGround,
    ObjectJointGeneric,
    ObjectJointRevoluteZ,
    ObjectJointSpherical,
    ObjectRigidBody,
    SensorNode,
)
from exudyn.utilities import ComputeSkewMatrix, CreateSymbolicUserFunction
from exudyn_solver import exu

either = exu.symbolic.IfThenElse
RIDE = np.array([0.0, 0.0, 0.57])  # the chassis' origin at the start
ALONG_X = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])  # its third axis is that of the chassis' x
ELEMENTS = 10  # of every bar
LINK, ROD, ARM = tube(0.03, 0.024), tube(0.02), tube(0.0379)
DAMPING = 0.01  # s, by stiffness


def leaf_spring(mbs, t, item, length, rate, stiffness, damping, force):
    return either(length < 0.106, (length - 0.106) * 1e7 - 35906 * 0.146, (length - 0.252) * 35906)


def shock_absorber(mbs, t, item, length, rate, stiffness, damping, force):
    elastic = length * (length * (length * 5.2796e7 - 6.7061e7) + 2.8397e7) - 4.0092e6
    slow = rate * (rate * (rate * (rate * -395651.0 - 59832.25) + 33955.72) + 9945.627)
    return elastic + either(rate < -0.2, rate * 1844.3 - 416.42, either(rate > 0.21, rate * 1634.727 + 1919.1638, slow))


def tyre(radius: float, road: object) -> object:
    """A vertical spring; `road` is the height by the place and the time."""

    def force(mbs, t, item, place, speed, stiffness, damping, offset):
        depth = road(place[0], t) + radius - place[2]
        return [place[0] * 0.0, place[0] * 0.0, either(depth > 0.0, depth * -4.6e5, place[0] * 0.0)]

    return force


class Model:
    """Points are of the chassis' axes and origin at the start."""

    def __init__(self, mass: float, inertia: list[float], speed: float, flexible: bool):
        self.mbs = exu.SystemContainer().AddSystem()
        self.speed, self.flexible = speed, flexible
        self.ground_body = self.mbs.AddObject(ObjectGround())
        self.ground = self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=self.ground_body))
        self.centres: dict[int, np.ndarray] = {self.ground_body: np.zeros(3)}
        self.chassis_node, self.chassis = self.body(np.zeros(3), mass, np.diag(inertia))

    def sensor(self) -> int:
        """Of the chassis' position."""
        kind = exu.OutputVariableType.Position
        return self.mbs.AddSensor(SensorNode(nodeNumber=self.chassis_node, storeInternal=True, outputVariableType=kind))

    def node(self, place: np.ndarray) -> int:
        where, motion = [*(place + RIDE), 1.0, 0, 0, 0], [self.speed, *[0.0] * 6]
        return self.mbs.AddNode(NodeRigidBodyEP(referenceCoordinates=where, initialVelocities=motion))

    def body(self, centre: np.ndarray, mass: float, inertia: np.ndarray) -> tuple[int, int]:
        node = self.node(centre)
        moments = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))]
        body = self.mbs.AddObject(ObjectRigidBody(mass=mass, inertia=moments, nodeNumber=node))
        self.weight(body)
        self.centres[body] = centre
        return node, body

    def weight(self, body: int) -> None:
        marker = self.mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
        self.mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=[0, 0, -9.81]))

    def point(self, body: int, point: np.ndarray) -> int:
        return self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=point - self.centres[body]))

    def frame(self, body: int, point: np.ndarray, axes: np.ndarray = ALONG_X) -> int:
        frame = exu.HT(rotation=axes, translation=point - self.centres[body])
        return self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localHT=frame))

    def distance(self, inner: np.ndarray, axle: int, outer: np.ndarray) -> None:
        markers = [self.point(self.chassis, inner), self.point(axle, outer)]
        length = float(np.linalg.norm(outer - inner))
        self.mbs.AddObject(ObjectConnectorDistance(markerNumbers=markers, distance=length))

    def law(self, item: int, function: object) -> None:
        symbolic_law = CreateSymbolicUserFunction(self.mbs, function, "springForceUserFunction", item)
        self.mbs.SetObjectParameter(item, "springForceUserFunction", symbolic_law)

    def spring(self, lower: int, upper: int, function: object) -> None:
        connector = ObjectConnectorSpringDamper(markerNumbers=[lower, upper], referenceLength=0.0)
        self.law(self.mbs.AddObject(connector), function)

    def revolute(self, first: int, second: int) -> None:
        self.mbs.AddObject(ObjectJointRevoluteZ(markerNumbers=[first, second]))

    def spherical(self, first: int, second: int) -> None:
        self.mbs.AddObject(ObjectJointSpherical(markerNumbers=[first, second]))


def add_corner(model: Model, x: float, forward: int, left: int, radius: float, road: object) -> None:
    """x of the axle, signs of the x offsets and of y, radius of the wheel."""

    def at(dx: float, y: float, z: float) -> np.ndarray:
        return np.array([x + forward * dx, left * y, z])

    mbs, chassis = model.mbs, model.chassis
    pivot, ball, wheel = at(0, 0.259, -0.268), at(0, 0.572066, -0.340982), at(0, 0.615038, -0.213972)
    upper, rod, seat = at(0, 0.488, -0.039), at(-0.14, 0.447998, -0.039009), at(0.075, 0.500065, -0.328989)
    upper_inner, rod_inner = at(0, 0.1585, 0.030), at(-0.14, 0.070, 0.030)
    _, axle = model.body(wheel, 57.35, np.diag([1.2402, 1.908, 1.2402]))
    add_arm, add_links = (flexible_arm, flexible_links) if model.flexible else (rigid_arm, massless_links)
    eye, arm_ball, arm_seat = add_arm(model, at, pivot, ball, seat)
    model.revolute(model.frame(chassis, pivot), eye)
    model.spherical(arm_ball, model.point(axle, ball))
    add_links(model, at, axle, (upper_inner, upper), (rod_inner, rod))
    model.spring(model.point(axle, upper), model.point(chassis, at(0, 0.488, 0.137)), leaf_spring)
    model.spring(arm_seat, model.point(chassis, at(0.075, 0.297, 0.062)), shock_absorber)
    markers = [model.ground, model.point(axle, wheel)]
    model.law(mbs.AddObject(ObjectConnectorCartesianSpringDamper(markerNumbers=markers)), tyre(radius, road))


def rigid_arm(model: Model, at: object, pivot: np.ndarray, ball: np.ndarray, seat: np.ndarray) -> tuple[int, int, int]:
    """Markers at the pivot's axis, the ball and the seat of the shock absorber."""
    along = (ball - pivot) / np.linalg.norm(ball - pivot)
    axes = np.array([[1.0, 0, 0], along, np.cross([1.0, 0, 0], along)]).T
    _, arm = model.body((pivot + ball) / 2, 6.0, axes @ np.diag([0.052099, 0.023235, 0.068864]) @ axes.T)
    return model.frame(arm, pivot), model.point(arm, ball), model.point(arm, seat)


def massless_links(model: Model, at: object, axle: int, link: tuple, rod: tuple) -> None:
    """The outer end of a link without mass on a hinge moves on a circle: two distances."""
    for dx in (-0.25, 0.25):
        model.distance(at(dx, 0.1585, 0.030), axle, link[1])
    model.distance(rod[0], axle, rod[1])


def flexible_arm(
    model: Model, at: object, pivot: np.ndarray, ball: np.ndarray, seat: np.ndarray
) -> tuple[int, int, int]:
    """Two bars; the shock absorber's seat is on the bar towards which it is offset, at 0.8 of it."""
    bars = Bars(ARM)
    near, far, head = bars.node(at(0.108, 0.259, -0.268)), bars.node(at(-0.108, 0.259, -0.268)), bars.node(ball)
    line = bars.bar(near, head, ELEMENTS)
    bars.bar(far, head, ELEMENTS)
    carrier = line[round(0.8 * ELEMENTS)]
    offset = seat - bars.nodes[carrier]
    normal = np.array([0.0, np.sign(ball[1]) * 0.072982, 0.313066])
    normal /= np.linalg.norm(normal)
    ends = [(head, np.zeros(3)), (carrier, offset)]
    static = [normal @ motion_at(bars, *end) for end in ends]
    body, node, first = add_flexible(model, reduced(bars, pivot, [near, far], static, 2, ends), pivot)
    return held_frame(model, node, ALONG_X), flexible_point(model, body, first), flexible_point(model, body, first + 1)


def flexible_links(model: Model, at: object, axle: int, link: tuple, rod: tuple) -> None:
    """The upper link on a hinge, the rod on a ball joint that holds its spin."""
    for section, (inner, outer), hinged in ((LINK, link, True), (ROD, rod, False)):
        bars = Bars(section)
        root, tip = bars.node(inner), bars.node(outer)
        bars.bar(root, tip, ELEMENTS)
        along = (outer - inner) / np.linalg.norm(outer - inner)
        end = motion_at(bars, tip, np.zeros(3))
        static = [direction @ end for direction in (np.array([1.0, 0, 0]), np.cross(along, [1.0, 0, 0]))]
        modes = reduced(bars, inner, [root], static, 4, [(tip, np.zeros(3))])
        radii = 0.015**2 + 0.012**2 if hinged else 0.01**2
        spin = modes.masses.sum() * radii / 2 * np.outer(along, along)
        body, node, first = add_flexible(model, modes, inner, spin)
        if hinged:
            model.revolute(model.frame(model.chassis, inner), held_frame(model, node, ALONG_X))
        else:
            markers = [model.frame(model.chassis, inner, np.eye(3)), held_frame(model, node, np.eye(3))]
            # Of the rotations the second, about y, which is nearly that about the rod.
            model.mbs.AddObject(ObjectJointGeneric(markerNumbers=markers, constrainedAxes=[1, 1, 1, 0, 1, 0]))
        model.spherical(flexible_point(model, body, first), model.point(axle, outer))


def held_frame(model: Model, node: int, axes: np.ndarray) -> int:
    return model.mbs.AddMarker(MarkerNodeRigid(nodeNumber=node, localHT=exu.HT(rotation=axes)))


def flexible_point(model: Model, body: int, point: int) -> int:
    return model.mbs.AddMarker(
        MarkerSuperElementPosition(bodyNumber=body, meshNodeNumbers=[point], weightingFactors=[1.0])
    )


def add_flexible(
    model: Model, modes: Modes, origin: np.ndarray, spin: np.ndarray | float = 0.0
) -> tuple[int, int, int]:
    """The body in a floating frame, the node of its frame, and the number of its first point without mass."""
    points, count = len(modes.points), len(modes.stiffness)
    node = model.node(origin)
    amplitudes = [0.0] * count
    coordinates = model.mbs.AddNode(
        NodeGenericODE2(
            referenceCoordinates=amplitudes,
            initialCoordinates=amplitudes,
            initialCoordinates_t=amplitudes,
            numberOfODE2Coordinates=count,
        )
    )
    flat, shapes = modes.points.flatten(), modes.shapes.reshape(3 * points, count)
    weight = np.repeat(modes.masses, 3)[:, None]
    place, turn, move = ComputeSkewMatrix(flat), ComputeSkewMatrix(shapes), np.tile(np.eye(3), (points, 1))
    mass = modes.masses.sum()
    centre = modes.masses @ modes.points / mass

    def matrix(values: np.ndarray) -> object:
        return exu.MatrixContainer(np.array(values))

    body = model.mbs.AddObject(
        ObjectFFRFreducedOrder(
            nodeNumbers=[node, coordinates],
            massMatrixReduced=matrix(shapes.T @ (weight * shapes)),
            stiffnessMatrixReduced=matrix(modes.stiffness),
            dampingMatrixReduced=matrix(DAMPING * modes.stiffness),
            modeBasis=shapes,
            referencePositions=flat,
            mass=mass,
            inertia=place.T @ (weight * place) + spin,
            centerOfMass=centre,
            centerOfMassTilde=ComputeSkewMatrix(centre),
            mPsiTildePsi=turn.T @ (weight * shapes),
            mPsiTildePsiTilde=turn.T @ (weight * turn),
            mPhitTPsi=move.T @ (weight * shapes),
            mPhitTPsiTilde=move.T @ (weight * turn),
            mXRefTildePsi=place.T @ (weight * shapes),
            mXRefTildePsiTilde=place.T @ (weight * turn),
        )
    )
    model.weight(body)
    return body, node, int(np.argmin(modes.masses > 0))

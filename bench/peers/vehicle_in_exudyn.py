"""The vehicle on stairs in Exudyn: rigid, its links and track rods as distances, its laws as symbolic functions."""

import exudyn_solver as solver
import numpy as np
from exudyn.itemInterface import (
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerBodyRigid,
    NodeRigidBodyEP,
    ObjectConnectorCartesianSpringDamper,
    ObjectConnectorDistance,
    ObjectConnectorSpringDamper,
    ObjectGround,
    ObjectJointRevoluteZ,
    ObjectJointSpherical,
    ObjectRigidBody,
    SensorNode,
)
from exudyn.utilities import CreateSymbolicUserFunction
from exudyn_solver import exu

symbolic = exu.symbolic
either = symbolic.IfThenElse

RIDE = np.array([0.0, 0.0, 0.57])  # the chassis' origin at the start
SPEED = 5.0  # m/s
ALONG_X = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])  # its third axis is that of the chassis' x
CORNERS = [  # x of the axle, sign of x offsets, sign of y, radius of the wheel
    (0.970, 1, 1, 0.364325),
    (0.970, 1, -1, 0.364325),
    (-1.047, -1, 1, 0.363812),
    (-1.047, -1, -1, 0.363812),
]


def leaf_spring(mbs, t, item, length, rate, stiffness, damping, force):
    return either(length < 0.106, (length - 0.106) * 1e7 - 35906 * 0.146, (length - 0.252) * 35906)


def shock_absorber(mbs, t, item, length, rate, stiffness, damping, force):
    elastic = length * (length * (length * 5.2796e7 - 6.7061e7) + 2.8397e7) - 4.0092e6
    slow = rate * (rate * (rate * (rate * -395651.0 - 59832.25) + 33955.72) + 9945.627)
    return elastic + either(rate < -0.2, rate * 1844.3 - 416.42, either(rate > 0.21, rate * 1634.727 + 1919.1638, slow))


def tyre(radius: float, stairs: float):
    def road(x):
        height = x * 0.0
        for end, level in ((34.0, 1), (31.0, 2), (28.0, 3), (25.0, 4), (22.0, 5)):
            height = either(x < end, x * 0.0 + level * stairs, height)
        return either(x < 5.0, x * 0.0, either(x < 15.0, (x - 5.0) * (stairs / 2), height))

    def force(mbs, t, item, place, speed, stiffness, damping, offset):
        depth = road(place[0]) + radius - place[2]
        return [place[0] * 0.0, place[0] * 0.0, either(depth > 0.0, depth * -4.6e5, place[0] * 0.0)]

    return force


class Vehicle:
    """Points are of the chassis' axes and origin at the start."""

    def __init__(self, stairs: float):
        self.mbs = exu.SystemContainer().AddSystem()
        self.ground = self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=self.mbs.AddObject(ObjectGround())))
        self.centres: dict[int, np.ndarray] = {}
        self.chassis_node, self.chassis = self.body(np.zeros(3), 1260.0, np.diag([130.0, 1620, 1670]))
        for corner in CORNERS:
            self.suspension(stairs, *corner)
        self.height = self.mbs.AddSensor(
            SensorNode(
                nodeNumber=self.chassis_node, storeInternal=True, outputVariableType=exu.OutputVariableType.Position
            )
        )
        self.mbs.Assemble()

    def body(self, centre: np.ndarray, mass: float, inertia: np.ndarray) -> tuple[int, int]:
        mbs, place = self.mbs, [*(centre + RIDE), 1.0, 0.0, 0.0, 0.0]
        node = mbs.AddNode(NodeRigidBodyEP(referenceCoordinates=place, initialVelocities=[SPEED, *[0.0] * 6]))
        moments = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))]
        body = mbs.AddObject(ObjectRigidBody(mass=mass, inertia=moments, nodeNumber=node))
        weight = mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
        mbs.AddLoad(LoadMassProportional(markerNumber=weight, loadVector=[0, 0, -9.81]))
        self.centres[body] = centre
        return node, body

    def point(self, body: int, point: np.ndarray) -> int:
        return self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=point - self.centres[body]))

    def hinge(self, body: int, point: np.ndarray) -> int:
        frame = exu.HT(rotation=ALONG_X, translation=point - self.centres[body])
        return self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localHT=frame))

    def distance(self, inner: np.ndarray, axle: int, outer: np.ndarray) -> None:
        markers = [self.point(self.chassis, inner), self.point(axle, outer)]
        length = float(np.linalg.norm(outer - inner))
        self.mbs.AddObject(ObjectConnectorDistance(markerNumbers=markers, distance=length))

    def law(self, item: int, function: object) -> None:
        symbolic_law = CreateSymbolicUserFunction(self.mbs, function, "springForceUserFunction", item)
        self.mbs.SetObjectParameter(item, "springForceUserFunction", symbolic_law)

    def spring(self, lower: int, upper: int, function: object) -> None:
        self.law(
            self.mbs.AddObject(ObjectConnectorSpringDamper(markerNumbers=[lower, upper], referenceLength=0.0)), function
        )

    def suspension(self, stairs: float, x: float, forward: int, left: int, radius: float) -> None:
        def at(dx: float, y: float, z: float) -> np.ndarray:
            return np.array([x + forward * dx, left * y, z])

        pivot, ball, wheel = at(0, 0.259, -0.268), at(0, 0.572066, -0.340982), at(0, 0.615038, -0.213972)
        upper, rod = at(0, 0.488, -0.039), at(-0.14, 0.447998, -0.039009)
        along = (ball - pivot) / np.linalg.norm(ball - pivot)
        axes = np.array([[1.0, 0, 0], along, np.cross([1.0, 0, 0], along)]).T
        moments = axes @ np.diag([0.052099, 0.023235, 0.068864]) @ axes.T
        _, arm = self.body((pivot + ball) / 2, 6.0, moments)
        _, axle = self.body(wheel, 57.35, np.diag([1.2402, 1.908, 1.2402]))
        mbs, chassis = self.mbs, self.chassis
        mbs.AddObject(ObjectJointRevoluteZ(markerNumbers=[self.hinge(chassis, pivot), self.hinge(arm, pivot)]))
        mbs.AddObject(ObjectJointSpherical(markerNumbers=[self.point(arm, ball), self.point(axle, ball)]))
        # The outer end of a link without mass on a hinge moves on a circle: two distances.
        for dx in (-0.25, 0.25):
            self.distance(at(dx, 0.1585, 0.030), axle, upper)
        self.distance(at(-0.14, 0.070, 0.030), axle, rod)
        self.spring(self.point(axle, upper), self.point(chassis, at(0, 0.488, 0.137)), leaf_spring)
        lower = self.point(arm, at(0.075, 0.500065, -0.328989))
        self.spring(lower, self.point(chassis, at(0.075, 0.297, 0.062)), shock_absorber)
        markers = [self.ground, self.point(axle, wheel)]
        self.law(mbs.AddObject(ObjectConnectorCartesianSpringDamper(markerNumbers=markers)), tyre(radius, stairs))


def seconds(stairs: float, end: float, step: float, **options: float) -> float:
    return solver.implicit(Vehicle(stairs).mbs, solver.settings(end, step, **options))


def heights(stairs: float, times: np.ndarray, step: float, **options: float) -> np.ndarray:
    """Of the chassis."""
    vehicle = Vehicle(stairs)
    chosen = solver.settings(float(times[-1]), step, **options)
    chosen.solution.sensors.active, chosen.solution.sensors.writePeriod = True, min(step, 0.01)
    solver.implicit(vehicle.mbs, chosen)
    table = np.array(vehicle.mbs.GetSensorStoredData(vehicle.height))
    return np.interp(times, table[:, 0], table[:, 3])[:, None]

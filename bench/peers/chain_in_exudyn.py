"""The open chain in Exudyn: a kinematic tree in minimal coordinates."""

import exudyn_solver as solver
import numpy as np
from chain import CENTRE, INERTIA, MASS, axis, speed
from exudyn.itemInterface import NodeGenericODE2, ObjectKinematicTree, SensorBody, SensorKinematicTree
from exudyn.rigidBodyUtilities import RigidBodyInertia
from exudyn_solver import exu


def build(n: int) -> tuple[exu.MainSystem, int]:
    """The system, and a sensor at the tip."""
    mbs = exu.SystemContainer().AddSystem()
    node = mbs.AddNode(
        NodeGenericODE2(
            referenceCoordinates=[0.0] * n,
            initialCoordinates=[0.0] * n,
            initialCoordinates_t=[speed(i) for i in range(n)],
            numberOfODE2Coordinates=n,
        )
    )
    along = {True: exu.JointType.RevoluteY, False: exu.JointType.RevoluteZ}
    tree = mbs.AddObject(
        ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=[along[bool(axis(i)[1])] for i in range(n)],
            linkParents=np.arange(n) - 1,
            jointTransformations=exu.Matrix3DList([np.eye(3)] * n),
            jointOffsets=exu.Vector3DList([[min(i, 1), 0, 0] for i in range(n)]),
            linkInertiasCOM=exu.Matrix3DList([np.diag(INERTIA)] * n),
            linkCOMs=exu.Vector3DList([[CENTRE, 0, 0]] * n),
            linkMasses=[MASS] * n,
            baseOffset=[0.0, 0, 0],
            gravity=[0, 0, -9.81],
        )
    )
    tip = mbs.AddSensor(
        SensorKinematicTree(
            objectNumber=tree,
            linkNumber=n - 1,
            localPosition=[1.0, 0, 0],
            writeToFile=False,
            outputVariableType=exu.OutputVariableType.Position,
        )
    )
    mbs.Assemble()
    return mbs, tip


def build_bodies(n: int, rotation: str) -> tuple[exu.MainSystem, int]:
    """The same with a body for each link, whose rotations are of this type, and joints; and a sensor at the tip."""
    mbs = exu.SystemContainer().AddSystem()
    before = mbs.CreateGround()
    inertia = RigidBodyInertia(mass=MASS, inertiaTensor=np.diag(INERTIA))
    turning, moving = np.zeros(3), np.zeros(3)  # of the link; of its joint
    for i in range(n):
        turning = turning + speed(i) * np.array(axis(i))
        link = mbs.CreateRigidBody(
            inertia=inertia,
            nodeType=getattr(exu.NodeType, rotation),
            referencePosition=[i + CENTRE, 0, 0],
            initialVelocity=moving + np.cross(turning, [CENTRE, 0, 0]),
            initialAngularVelocity=turning,
            gravity=[0, 0, -9.81],
        )
        mbs.CreateRevoluteJoint(bodyNumbers=[before, link], position=[i, 0, 0], axis=axis(i))
        moving, before = moving + np.cross(turning, [1.0, 0, 0]), link
    tip = mbs.AddSensor(
        SensorBody(
            bodyNumber=link,
            localPosition=[1.0 - CENTRE, 0, 0],
            writeToFile=False,
            outputVariableType=exu.OutputVariableType.Position,
        )
    )
    mbs.Assemble()
    return mbs, tip


def run_bodies(n: int, rotation: str, end: float, step: float, **options: float) -> tuple[np.ndarray, float]:
    """By bodies: position of the tip at the end, and CPU time of the steps."""
    mbs, tip = build_bodies(n, rotation)
    seconds = solver.implicit(mbs, solver.settings(end, step, **options))
    return np.array(mbs.GetSensorValues(tip, exu.ConfigurationType.Current)), seconds


def run(n: int, rule: str, end: float, step: float, **options: float) -> tuple[np.ndarray, float]:
    """Position of the tip at the end, and CPU time of the steps."""
    mbs, tip = build(n)
    chosen = solver.settings(end, step, **options)
    seconds = solver.implicit(mbs, chosen) if rule == "generalised-alpha" else solver.explicit(mbs, chosen, rule)
    return np.array(mbs.GetSensorValues(tip, exu.ConfigurationType.Current)), seconds

"""The ladder of four-bar loops in Exudyn: rigid bodies and revolute joints in the plane."""

import exudyn_solver as solver
import numpy as np
from exudyn.itemInterface import (
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    NodeRigidBody2D,
    ObjectGround,
    ObjectJointRevolute2D,
    ObjectRigidBody2D,
)
from exudyn_solver import exu
from ladder_model import GRAVITY, INERTIA, MASS, SPEED


def build(n: int) -> tuple[exu.MainSystem, int]:
    """The system, and the last standing bar."""
    mbs = exu.SystemContainer().AddSystem()
    ground = mbs.AddObject(ObjectGround())

    def bar(x: float, y: float, velocity: list[float]) -> int:
        node = mbs.AddNode(NodeRigidBody2D(referenceCoordinates=[x, y, 0.0], initialVelocities=velocity))
        body = mbs.AddObject(ObjectRigidBody2D(physicsMass=MASS, physicsInertia=INERTIA, nodeNumber=node))
        centre = mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
        mbs.AddLoad(LoadMassProportional(markerNumber=centre, loadVector=[0, -GRAVITY, 0]))
        return body

    def marker(body: int, x: float, y: float) -> int:
        return mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=[x, y, 0.0]))

    def revolute(a: int, b: int) -> None:
        mbs.AddObject(ObjectJointRevolute2D(markerNumbers=[a, b]))

    before = None
    for i in range(n + 1):
        standing = bar(float(i), 0.5, [-0.5 * SPEED, 0.0, SPEED])
        revolute(marker(ground, float(i), 0.0), marker(standing, 0.0, -0.5))
        if before is not None:
            revolute(marker(before, 0.5, 0.0), marker(standing, 0.0, 0.5))
        if i < n:
            top = bar(i + 0.5, 1.0, [-SPEED, 0.0, 0.0])
            if before is None:
                revolute(marker(standing, 0.0, 0.5), marker(top, -0.5, 0.0))
            else:
                revolute(marker(before, 0.5, 0.0), marker(top, -0.5, 0.0))
            before = top
    mbs.Assemble()
    return mbs, standing


def run(n: int, end: float, step: float, **options: float) -> tuple[np.ndarray, float]:
    """Position of the last bar's head at the end, and CPU time of the steps."""
    mbs, last = build(n)
    seconds = solver.implicit(mbs, solver.settings(end, step, **options))
    position = exu.OutputVariableType.Position
    return np.array(mbs.GetObjectOutputBody(last, position, localPosition=[0.0, 0.5, 0.0]))[:2], seconds

"""The spin-up beam in the plane in Exudyn: ANCF cable elements on a hub with a prescribed angle."""

import exudyn_solver as solver
import numpy as np
from exudyn.itemInterface import (
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    NodePoint2DSlope1,
    NodePointGround,
    NodeRigidBody2D,
    ObjectANCFCable2D,
    ObjectConnectorCoordinate,
    ObjectJointGeneric,
    ObjectRigidBody2D,
    SensorNode,
)
from exudyn.utilities import CreateSymbolicUserFunction
from exudyn_solver import exu

symbolic = exu.symbolic

LENGTH, AREA, BENDING, DENSITY, YOUNG = 10.0, 4e-4, 2e-7, 3000.0, 7e10
RATE, RISE = 6.0, 15.0  # rad/s, reached after s


def angle(t: np.ndarray) -> np.ndarray:
    rising = RATE / RISE * (t**2 / 2 + (RISE / (2 * np.pi)) ** 2 * (np.cos(2 * np.pi * t / RISE) - 1))
    return np.where(t < RISE, rising, RATE * (t - RISE / 2))


def prescribed(mbs, t, item, offset):
    turns = (symbolic.cos(2 * np.pi / RISE * t) - 1) * (RISE / (2 * np.pi)) ** 2
    return symbolic.IfThenElse(t < RISE, (t * t * 0.5 + turns) * (RATE / RISE), (t - RISE / 2) * RATE)


def prescribed_rate(mbs, t, item, offset):
    turns = symbolic.sin(2 * np.pi / RISE * t) * (RISE / (2 * np.pi))
    return symbolic.IfThenElse(t < RISE, (t - turns) * (RATE / RISE), t * 0.0 + RATE)


def build(elements: int) -> tuple[exu.MainSystem, int]:
    """The system, and a sensor of the tip's position."""
    mbs = exu.SystemContainer().AddSystem()
    fixed = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    turning = mbs.AddNode(NodeRigidBody2D())
    hub = mbs.AddObject(ObjectRigidBody2D(physicsMass=1, physicsInertia=1, nodeNumber=turning))
    for coordinate in range(3):
        of_hub = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=turning, coordinate=coordinate))
        held = mbs.AddObject(ObjectConnectorCoordinate(markerNumbers=[fixed, of_hub]))
    for name, function in (("offsetUserFunction", prescribed), ("offsetUserFunction_t", prescribed_rate)):
        mbs.SetObjectParameter(held, name, CreateSymbolicUserFunction(mbs, function, name, held))
    size = LENGTH / elements
    nodes = [
        mbs.AddNode(NodePoint2DSlope1(referenceCoordinates=[i * size, 0.0, 1.0, 0.0])) for i in range(elements + 1)
    ]
    cables = [
        mbs.AddObject(
            ObjectANCFCable2D(
                nodeNumbers=[nodes[i], nodes[i + 1]],
                length=size,
                massPerLength=DENSITY * AREA,
                bendingStiffness=YOUNG * BENDING,
                axialStiffness=YOUNG * AREA,
            )
        )
        for i in range(elements)
    ]
    ends = [mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=[0.0, 0, 0])) for body in (hub, cables[0])]
    mbs.AddObject(ObjectJointGeneric(markerNumbers=ends, constrainedAxes=[1, 1, 0, 0, 0, 1]))
    tip = mbs.AddSensor(
        SensorNode(nodeNumber=nodes[-1], storeInternal=True, outputVariableType=exu.OutputVariableType.Position)
    )
    mbs.Assemble()
    return mbs, tip


def seconds(elements: int, end: float, step: float, **options: float) -> float:
    mbs, _ = build(elements)
    return solver.implicit(mbs, solver.settings(end, step, **options))


def displacements(elements: int, times: np.ndarray, step: float, **options: float) -> np.ndarray:
    """Of the tip in the axes of the hub, axial and transverse."""
    mbs, tip = build(elements)
    chosen = solver.settings(float(times[-1]), step, **options)
    chosen.solution.sensors.active, chosen.solution.sensors.writePeriod = True, step
    solver.implicit(mbs, chosen)
    table = np.array(mbs.GetSensorStoredData(tip))
    x, y = (np.interp(times, table[:, 0], table[:, 1 + k]) for k in range(2))
    cos, sin = np.cos(angle(times)), np.sin(angle(times))
    return np.array([cos * x + sin * y - LENGTH, cos * y - sin * x]).T

"""The robot arm in Exudyn: a kinematic tree in minimal coordinates from its URDF file, which Pinocchio reads."""

import exudyn_solver as solver
import numpy as np
from exudyn.itemInterface import NodeGenericODE2, ObjectKinematicTree
from exudyn_solver import exu


def build(urdf: str, speeds: list[float]) -> tuple[exu.MainSystem, int]:
    """The system, and the node of the joint angles."""
    import pinocchio as pin  # its parser joins the links that fixed joints connect

    robot, count = pin.buildModelFromXML(urdf), len(speeds)
    kinds = {"JointModelR" + axis: getattr(exu.JointType, "Revolute" + axis) for axis in "XYZ"}
    places, inertias = list(robot.jointPlacements)[1:], list(robot.inertias)[1:]
    mbs = exu.SystemContainer().AddSystem()
    node = mbs.AddNode(
        NodeGenericODE2(
            referenceCoordinates=[0.0] * count,
            initialCoordinates=[0.0] * count,
            initialCoordinates_t=speeds,
            numberOfODE2Coordinates=count,
        )
    )
    mbs.AddObject(
        ObjectKinematicTree(
            nodeNumber=node,
            jointTypes=[kinds[joint.shortname()] for joint in list(robot.joints)[1:]],
            linkParents=np.array(list(robot.parents)[1:]) - 1,
            jointTransformations=exu.Matrix3DList([place.rotation for place in places]),
            jointOffsets=exu.Vector3DList([place.translation for place in places]),
            linkInertiasCOM=exu.Matrix3DList([inertia.inertia for inertia in inertias]),
            linkCOMs=exu.Vector3DList([inertia.lever for inertia in inertias]),
            linkMasses=[inertia.mass for inertia in inertias],
            baseOffset=[0.0, 0, 0],
            gravity=[0, 0, -9.81],
        )
    )
    mbs.Assemble()
    return mbs, node


def run(
    urdf: str, speeds: list[float], rule: str, end: float, step: float, **options: float
) -> tuple[np.ndarray, float]:
    """Joint angles at the end, and CPU time of the steps."""
    mbs, node = build(urdf, speeds)
    chosen = solver.settings(end, step, sparse=False, **options)
    seconds = solver.implicit(mbs, chosen) if rule == "generalised-alpha" else solver.explicit(mbs, chosen, rule)
    return np.array(mbs.GetNodeOutput(node, exu.OutputVariableType.Coordinates)), seconds

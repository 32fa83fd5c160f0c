"""The ladder of four-bar loops in Drake: a discrete plant whose loops are closed by ball constraints."""

import time
from importlib.metadata import version

import numpy as np
from ladder_model import GRAVITY, INERTIA, MASS, SLENDER, SPEED
from pydrake.math import RigidTransform
from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, RevoluteJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator

VERSION = version("drake")


def build(n: int, step: float) -> MultibodyPlant:
    """Each standing bar is hinged on the ground and carries the bar to its right, which meets the next one's head."""
    plant = MultibodyPlant(time_step=step)
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)

    def bar(name: str, frame: object, centre: list[float], moments: tuple[float, float, float]) -> object:
        about_centre = UnitInertia(*(moment / MASS for moment in moments))
        body = plant.AddRigidBody(name, SpatialInertia(MASS, centre, about_centre.ShiftFromCenterOfMass(centre)))
        plant.AddJoint(RevoluteJoint(f"under_{name}", frame, body.body_frame(), [0, 0, 1]))
        return body

    def frame_at(name: str, frame: object, place: list[float]) -> object:
        return plant.AddFrame(FixedOffsetFrame(name, frame, RigidTransform(place)))

    before = None
    for i in range(n + 1):
        foot = frame_at(f"foot_{i}", plant.world_frame(), [i, 0, 0])
        standing = bar(f"bar_{i}", foot, [0, 0.5, 0], (INERTIA, SLENDER, INERTIA))
        if before is not None:
            plant.AddBallConstraint(before, [1.0, 0, 0], standing, [0.0, 1, 0])
        if i < n:
            head = frame_at(f"head_{i}", standing.body_frame(), [0, 1, 0])
            before = bar(f"top_{i}", head, [0.5, 0, 0], (SLENDER, INERTIA, INERTIA))
    plant.mutable_gravity_field().set_gravity_vector([0, -GRAVITY, 0])
    plant.Finalize()
    return plant


def run(n: int, end: float, step: float) -> tuple[np.ndarray, float]:
    """Position of the last bar's head at the end, and CPU time of the steps."""
    plant = build(n, step)
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    for i in range(n + 1):
        plant.GetJointByName(f"under_bar_{i}").set_angular_rate(context, SPEED)
        if i < n:
            plant.GetJointByName(f"under_top_{i}").set_angular_rate(context, -SPEED)
    simulator.Initialize()
    begin = time.process_time()
    simulator.AdvanceTo(end)
    seconds = time.process_time() - begin
    pose = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(f"bar_{n}"))
    return pose.multiply(np.array([0.0, 1, 0]))[:2], seconds

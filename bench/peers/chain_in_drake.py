"""The open chain in Drake: a continuous MultibodyPlant with fixed steps of its integrators, in C++."""

import time
from importlib.metadata import version

import numpy as np
from chain import CENTRE, INERTIA, MASS, axis, speed
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import FixedOffsetFrame, RevoluteJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

VERSION = version("drake")


def build(n: int) -> MultibodyPlant:
    plant = MultibodyPlant(time_step=0.0)
    centre = np.array([CENTRE, 0, 0])
    about_centre = UnitInertia(*(moment / MASS for moment in INERTIA))
    inertia = SpatialInertia(MASS, centre, about_centre.ShiftFromCenterOfMass(centre))
    frame = plant.world_frame()
    for i in range(n):
        body = plant.AddRigidBody(f"link_{i}", inertia)
        if i > 0:
            frame = plant.AddFrame(FixedOffsetFrame(f"end_{i}", frame, RigidTransform([1.0, 0, 0])))
        plant.AddJoint(RevoluteJoint(f"joint_{i}", frame, body.body_frame(), axis(i)))
        frame = body.body_frame()
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -9.81])
    plant.Finalize()
    return plant


def run(plant: MultibodyPlant, n: int, scheme: str, end: float, step: float) -> tuple[np.ndarray, float]:
    """Position of the tip at the end, and CPU time of the steps."""
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    plant.SetVelocities(context, np.array([speed(i) for i in range(n)]))
    integrator = ResetIntegratorFromFlags(simulator, scheme, step)
    integrator.set_fixed_step_mode(True)
    simulator.Initialize()
    begin = time.process_time()
    simulator.AdvanceTo(end)
    seconds = time.process_time() - begin
    last = plant.GetBodyByName(f"link_{n - 1}")
    return plant.EvalBodyPoseInWorld(context, last).multiply(np.array([1.0, 0, 0])), seconds

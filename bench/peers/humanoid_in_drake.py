"""The humanoid in Drake: a discrete plant with compliant contacts; its joints have springs by gains of their motors."""

import time
from importlib.metadata import version

import numpy as np
from humanoid_model import DISSIPATION, FRICTION, GRAVITY, SPEED, STIFFNESS, Humanoid
from pydrake.geometry import (
    AddContactMaterial,
    HalfSpace,
    ProximityProperties,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import (
    AddMultibodyPlantSceneGraph,
    CoulombFriction,
    DiscreteContactApproximation,
)
from pydrake.multibody.tree import PdControllerGains
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

VERSION = version("drake")
APPROXIMATIONS = {
    "SAP": DiscreteContactApproximation.kSap,
    "lagged": DiscreteContactApproximation.kLagged,
}


def build(robot: Humanoid, approximation: str, step: float) -> tuple[object, object]:
    """The diagram and its plant."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, step)
    plant.set_discrete_contact_approximation(APPROXIMATIONS[approximation])
    Parser(plant).AddModelsFromString(robot.urdf, "urdf")
    for name, (stiffness, damping) in robot.joints.items():
        joint = plant.GetJointByName(name)
        joint.set_position_limits([-np.inf], [np.inf])
        joint.set_velocity_limits([-np.inf], [np.inf])
        motor = plant.AddJointActuator(name, joint)
        motor.set_controller_gains(PdControllerGains(p=stiffness, d=damping))
    friction = CoulombFriction(FRICTION, FRICTION)
    law = ProximityProperties()
    AddContactMaterial(DISSIPATION, 2 * STIFFNESS, friction, law)  # two shapes in series have half of it
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform([0, 0, -robot.ground]), HalfSpace(), "ground", law
    )
    for link, centres in robot.feet.items():
        for k, centre in enumerate(centres):
            shape, place = Sphere(robot.radius), RigidTransform(centre)
            plant.RegisterCollisionGeometry(plant.GetBodyByName(link), place, shape, f"{link}_{k}", law)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -GRAVITY])
    plant.Finalize()
    return builder.Build(), plant


def started(diagram: object, plant: object) -> tuple[Simulator, object]:
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    pelvis = plant.GetBodyByName("pelvis")
    plant.SetFreeBodyPose(context, pelvis, RigidTransform())
    plant.SetFreeBodySpatialVelocity(context, pelvis, SpatialVelocity(np.zeros(3), np.array([SPEED, 0, 0])))
    wanted = np.zeros(2 * plant.num_actuated_dofs())
    plant.get_desired_state_input_port(plant.GetModelInstanceByName("g1_29dof_rev_1_0")).FixValue(context, wanted)
    simulator.Initialize()
    return simulator, context


def positions(robot: Humanoid, approximation: str, times: np.ndarray, step: float) -> np.ndarray:
    """Of the pelvis."""
    diagram, plant = build(robot, approximation, step)
    simulator, context = started(diagram, plant)
    pelvis, path = plant.GetBodyByName("pelvis"), []
    for instant in times:
        simulator.AdvanceTo(instant)
        path.append(plant.EvalBodyPoseInWorld(context, pelvis).translation())
    return np.array(path)


def seconds(robot: Humanoid, approximation: str, end: float, step: float) -> float:
    simulator, _ = started(*build(robot, approximation, step))
    begin = time.process_time()
    simulator.AdvanceTo(end)
    return time.process_time() - begin

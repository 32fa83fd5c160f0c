"""The humanoid in MuJoCo: soft contacts, springs and dampers of its joints."""

import time

import mujoco
import numpy as np
from chain_in_mujoco import INTEGRATORS
from humanoid_model import FRICTION, GRAVITY, SPEED, Humanoid

VERSION = mujoco.__version__
CONES = {"pyramidal": mujoco.mjtCone.mjCONE_PYRAMIDAL, "elliptic": mujoco.mjtCone.mjCONE_ELLIPTIC}


def build(robot: Humanoid, cone: str) -> mujoco.MjModel:
    spec = mujoco.MjSpec.from_string(robot.urdf)
    spec.option.gravity = [0, 0, -GRAVITY]
    spec.option.cone = CONES[cone]
    spec.compiler.fusestatic = True
    spec.body("pelvis").add_freejoint()
    for joint in spec.joints:
        if joint.name in robot.joints:
            stiffness, damping = robot.joints[joint.name]
            joint.stiffness, joint.damping = np.array([stiffness, 0, 0]), np.array([damping, 0, 0])
            joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
    shape = {"friction": [FRICTION, 0, 0], "condim": 3}
    ground = {"pos": [0, 0, -robot.ground], "size": [10, 10, 1], "contype": 1, "conaffinity": 2}
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, **ground, **shape)
    for link, centres in robot.feet.items():
        for centre in centres:
            sphere = {"pos": centre, "size": [robot.radius, 0, 0], "contype": 2, "conaffinity": 1, "mass": 0}
            spec.body(link).add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, **sphere, **shape)
    return spec.compile()


def started(model: mujoco.MjModel, integrator: str, step: float) -> mujoco.MjData:
    model.opt.timestep, model.opt.integrator = step, INTEGRATORS[integrator]
    data = mujoco.MjData(model)
    data.qvel[0] = SPEED
    return data


def positions(model: mujoco.MjModel, integrator: str, times: np.ndarray, step: float) -> np.ndarray:
    """Of the pelvis."""
    data, path = started(model, integrator, step), []
    for _ in range(round(times[-1] / step)):
        mujoco.mj_step(model, data)
        path.append([data.time, *data.qpos[:3]])
    table = np.array(path)
    return np.array([np.interp(times, table[:, 0], table[:, 1 + k]) for k in range(3)]).T


def depth(model: mujoco.MjModel, integrator: str, end: float, step: float) -> float:
    """The largest of the contacts at the end."""
    data = started(model, integrator, step)
    mujoco.mj_step(model, data, round(end / step))
    return max((-contact.dist for contact in data.contact), default=0.0)


def seconds(model: mujoco.MjModel, integrator: str, end: float, step: float) -> float:
    data = started(model, integrator, step)
    begin = time.process_time()
    mujoco.mj_step(model, data, round(end / step))
    return time.process_time() - begin

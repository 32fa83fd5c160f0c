"""The ladder of four-bar loops in MuJoCo: short trees of hinges, their ends joined by constraints, which are soft."""

import time

import mujoco
import numpy as np
from chain_in_mujoco import INTEGRATORS
from ladder_model import GRAVITY, INERTIA, MASS, SLENDER, SPEED

VERSION = mujoco.__version__
STIFFEST = [0.9999, 0.9999, 0.001, 0.5, 2]  # the largest impedance that MuJoCo permits, at any distance


def build(n: int) -> mujoco.MjModel:
    """Each standing bar is hinged on the ground and carries the bar to its right, which meets the next one's head."""
    spec = mujoco.MjSpec()
    spec.option.gravity = [0, -GRAVITY, 0]
    spec.option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_CONTACT)

    def bar(parent: object, name: str, place: list[float], centre: list[float], moments: list[float]) -> object:
        inertia = {"mass": MASS, "ipos": centre, "inertia": moments, "explicitinertial": True}
        body = parent.add_body(name=name, pos=place, **inertia)
        body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1])
        return body

    for i in range(n + 1):
        standing = bar(spec.worldbody, f"bar_{i}", [i, 0, 0], [0, 0.5, 0], [INERTIA, SLENDER, INERTIA])
        if i < n:
            bar(standing, f"top_{i}", [0, 1, 0], [0.5, 0, 0], [SLENDER, INERTIA, INERTIA])
    standing.add_site(name="head", pos=[0, 1, 0])
    for i in range(n):
        joined = spec.add_equality(type=mujoco.mjtEq.mjEQ_CONNECT, objtype=mujoco.mjtObj.mjOBJ_BODY)
        joined.name1, joined.name2 = f"top_{i}", f"bar_{i + 1}"
        joined.data[:3] = [1, 0, 0]
        joined.solimp = STIFFEST
    return spec.compile()


def run(model: mujoco.MjModel, integrator: str, end: float, step: float, ratio: float) -> tuple[np.ndarray, float]:
    """Position of the last bar's head at the end, and CPU time of the steps; `ratio`: time constant over step."""
    model.opt.timestep, model.opt.integrator = step, INTEGRATORS[integrator]
    model.eq_solref[:] = [ratio * step, 1]
    data = mujoco.MjData(model)
    data.qvel[::2], data.qvel[1::2] = SPEED, -SPEED
    begin = time.process_time()
    mujoco.mj_step(model, data, round(end / step))
    seconds = time.process_time() - begin
    mujoco.mj_kinematics(model, data)
    return data.site_xpos[0, :2].copy(), seconds

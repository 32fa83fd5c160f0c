"""The open chain in MuJoCo. Steps are made in C."""

import time

import mujoco
import numpy as np
from chain import CENTRE, INERTIA, MASS, axis, speed

mujoco.set_mju_user_warning(lambda message: None)  # of unstable runs, whose errors show it; else it writes a file
VERSION = mujoco.__version__
INTEGRATORS = {
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
    "Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
}


def build(n: int) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    spec.option.gravity = [0, 0, -9.81]
    spec.option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    body = spec.worldbody
    for i in range(n):
        body = body.add_body(
            pos=[min(i, 1), 0, 0], mass=MASS, ipos=[CENTRE, 0, 0], inertia=list(INERTIA), explicitinertial=True
        )
        body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=axis(i))
    body.add_site(name="tip", pos=[1, 0, 0])
    return spec.compile()


def run(model: mujoco.MjModel, integrator: str, end: float, step: float) -> tuple[np.ndarray, float]:
    """Position of the tip at the end, and CPU time of the steps."""
    model.opt.timestep, model.opt.integrator = step, INTEGRATORS[integrator]
    data = mujoco.MjData(model)
    data.qvel[:] = [speed(i) for i in range(model.nv)]
    begin = time.process_time()
    mujoco.mj_step(model, data, round(end / step))
    seconds = time.process_time() - begin
    mujoco.mj_kinematics(model, data)
    return data.site_xpos[0].copy(), seconds

"""The open chain in Pinocchio, which has accelerations (`aba`) and no integrator."""

import numpy as np
import pinocchio as pin
from chain import CENTRE, INERTIA, MASS, axis, speed
from runge_kutta import evaluation_seconds, rk4

VERSION = pin.__version__


def build(n: int) -> pin.Model:
    model, parent = pin.Model(), 0
    model.gravity.linear = np.array([0, 0, -9.81])
    for i in range(n):
        joint = pin.JointModelRY() if axis(i)[1] else pin.JointModelRZ()
        place = pin.SE3(np.eye(3), np.array([min(i, 1.0), 0, 0]))
        parent = model.addJoint(parent, joint, place, f"joint_{i}")
        inertia = pin.Inertia(MASS, np.array([CENTRE, 0, 0]), np.diag(INERTIA))
        model.appendBodyToJoint(parent, inertia, pin.SE3.Identity())
    return model


def tip(model: pin.Model, end: float, step: float) -> np.ndarray:
    data, zero = model.createData(), np.zeros(model.nv)
    start = np.array([speed(i) for i in range(model.nv)])
    q = rk4(lambda q, v: pin.aba(model, data, q, v, zero), zero, start, step, round(end / step))
    pin.forwardKinematics(model, data, q)
    return data.oMi[model.nv].act(np.array([1.0, 0, 0]))


def seconds(model: pin.Model, end: float, step: float) -> float:
    data, zero = model.createData(), np.zeros(model.nv)
    start = np.array([speed(i) for i in range(model.nv)])
    return evaluation_seconds(lambda q, v: pin.aba(model, data, q, v, zero), zero, start, 4 * round(end / step))

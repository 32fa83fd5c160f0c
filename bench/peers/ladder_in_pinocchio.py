"""The ladder of four-bar loops in Pinocchio, which has accelerations with constraints and no integrator."""

import numpy as np
import pinocchio as pin
from ladder_model import GRAVITY, INERTIA, MASS, SLENDER, SPEED
from runge_kutta import evaluation_seconds, rk4

VERSION = pin.__version__
RATE = 20.0  # 1/s, of Baumgarte's stabilisation


class Ladder:
    """Each standing bar is hinged on the ground and carries the bar to its right, which meets the next one's head."""

    def __init__(self, n: int):
        self.model = pin.Model()
        self.model.gravity.linear = np.array([0, -GRAVITY, 0])
        standing, tops = [], []
        for i in range(n + 1):
            standing.append(self.bar(0, f"bar_{i}", [i, 0, 0], [0, 0.5, 0], (INERTIA, SLENDER, INERTIA)))
            if i < n:
                tops.append(self.bar(standing[i], f"top_{i}", [0, 1, 0], [0.5, 0, 0], (SLENDER, INERTIA, INERTIA)))
        right, head = pin.SE3(np.eye(3), np.array([1.0, 0, 0])), pin.SE3(np.eye(3), np.array([0, 1.0, 0]))
        self.head, self.last = head, standing[n]
        self.loops = pin.StdVec_RigidConstraintModel()
        for i in range(n):
            kind, axes = pin.ContactType.CONTACT_3D, pin.ReferenceFrame.LOCAL
            loop = pin.RigidConstraintModel(kind, self.model, tops[i], right, standing[i + 1], head, axes)
            loop.setBaumgarteCorrectorParameters(pin.BaumgarteCorrectorParameters(RATE**2, 2 * RATE))
            self.loops.append(loop)
        self.data = self.model.createData()
        self.loop_data = pin.StdVec_RigidConstraintData([loop.createData() for loop in self.loops])
        self.zero = np.zeros(self.model.nv)
        self.start = np.array([SPEED * (-1) ** i for i in range(self.model.nv)])
        self.proximal = pin.ProximalSettings(1e-10, 1e-8, 10)  # the third equation of a planar loop repeats 0 = 0
        pin.initConstraintDynamics(self.model, self.data, self.loops, self.loop_data)

    def bar(self, parent: int, name: str, place: list, centre: list, moments: tuple) -> int:
        joint = self.model.addJoint(parent, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array(place, float)), name)
        inertia = pin.Inertia(MASS, np.array(centre, float), np.diag(moments))
        self.model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
        return joint

    def acceleration(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return pin.constraintDynamics(self.model, self.data, q, v, self.zero, self.loops, self.loop_data, self.proximal)

    def position(self, end: float, step: float) -> np.ndarray:
        """Of the last bar's head."""
        q = rk4(self.acceleration, self.zero, self.start, step, round(end / step))
        pin.forwardKinematics(self.model, self.data, q)
        return self.data.oMi[self.last].act(self.head.translation)[:2]

    def seconds(self, end: float, step: float) -> float:
        return evaluation_seconds(self.acceleration, self.zero, self.start, 4 * round(end / step))

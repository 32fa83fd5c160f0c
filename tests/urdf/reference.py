"""Writes tests/data/urdf/reference.txt: inverse dynamics and places of links by Pinocchio.

pip install pin==4.1.0; python tests/urdf/reference.py

The base is fixed, gravity is 9.81 m/s² along −z; no friction, no damping. Of each robot five random states.
"""

import pathlib

import numpy as np
import pinocchio as pin

folder = pathlib.Path(__file__).resolve().parent.parent / "data/urdf"
random = np.random.default_rng(1)


def text(values):
    return " ".join(f"{value:.17g}" for value in np.ravel(values))


lines = [f"# by tests/urdf/reference.py with Pinocchio {pin.__version__}"]
for name in ("ur5", "panda", "anymal"):
    model = pin.buildModelFromUrdf(str(folder / f"{name}.urdf"))
    data = model.createData()
    joints = list(model.names)[1:]
    lines.append(f"robot {name} {len(joints)} {text([sum(inertia.mass for inertia in model.inertias)])}")
    lines += [f"joint {joint}" for joint in joints]
    for _ in range(5):
        coordinates, v, a = (random.uniform(-2, 2, model.nv) for _ in range(3))
        q = pin.integrate(model, pin.neutral(model), coordinates)
        tau = pin.rnea(model, data, q, v, a)
        pin.framesForwardKinematics(model, data, q)
        order = [model.joints[k].idx_v for k in range(1, len(joints) + 1)]
        lines.append("state")
        for word, values in (("q", coordinates), ("v", v), ("a", a), ("tau", tau)):
            lines.append(f"{word} {text(values[order])}")
        for frame, place in zip(model.frames, data.oMf):
            if frame.type == pin.FrameType.BODY and frame.name != "universe":
                lines.append(f"link {frame.name} {text(place.translation)} {text(place.rotation)}")
(folder / "reference.txt").write_text("\n".join(lines) + "\n")

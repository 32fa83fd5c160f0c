"""Writes tests/data/urdf/reference.txt: inverse dynamics and places of links by Pinocchio.

pip install pin==4.1.0; python tests/urdf/reference.py

The base is fixed, gravity is 9.81 m/s² along −z; no friction, no damping. Of each robot five random states. The robots
are three public ones and seven random ones, tests/data/urdf/tree*.urdf, which it writes, too: trees of links with
inertia about turned axes, on joints at any angle, some of them fixed.
"""

import pathlib

import numpy as np
import pinocchio as pin

folder = pathlib.Path(__file__).resolve().parent.parent / "data/urdf"
random = np.random.default_rng(1)


def text(values):
    return " ".join(f"{value:.17g}" for value in np.ravel(values))


def triple(values):
    return " ".join(f"{value:.6g}" for value in values)


def turn(generator):
    return triple(generator.uniform(-3, 3, 3))


def tree(number):
    """A random robot; its root is massless, as a base that stands."""
    generator = np.random.default_rng(100 + number)
    text = [f'<robot name="tree{number}">', '  <link name="base"/>']
    for k in range(3 + number):
        axes = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        # Of second moments of mass, so that matter can have it.
        second = axes @ np.diag(generator.uniform(0.001, 0.05, 3)) @ axes.T
        inertia = np.trace(second) * np.eye(3) - second
        entries = zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), inertia[np.triu_indices(3)], strict=True)
        parent = "base" if k == 0 else f"link{generator.integers(max(0, k - 3), k)}"
        kind = "revolute" if k == 0 else generator.choice(["revolute", "continuous", "prismatic", "fixed"])
        limit = '<limit lower="-1" upper="2" effort="10" velocity="1"/>' if kind in ("revolute", "prismatic") else ""
        text += [
            f'  <link name="link{k}">',
            "    <inertial>",
            f'      <origin xyz="{triple(generator.uniform(-0.3, 0.3, 3))}" rpy="{turn(generator)}"/>',
            f'      <mass value="{generator.uniform(0.2, 4):.6g}"/>',
            "      <inertia " + " ".join(f'{name}="{value:.8g}"' for name, value in entries) + "/>",
            "    </inertial>",
            "  </link>",
            f'  <joint name="joint{k}" type="{kind}">',
            f'    <parent link="{parent}"/>',
            f'    <child link="link{k}"/>',
            f'    <origin xyz="{triple(generator.uniform(-0.6, 0.6, 3))}" rpy="{turn(generator)}"/>',
            f'    <axis xyz="{triple(generator.uniform(-1, 1, 3))}"/>{limit}',
            "  </joint>",
        ]
    return "\n".join([*text, "</robot>", ""])


trees = range(1, 8)
for number in trees:
    (folder / f"tree{number}.urdf").write_text(tree(number))

lines = [f"# by tests/urdf/reference.py with Pinocchio {pin.__version__}"]
for name in ("ur5", "panda", "anymal", *(f"tree{number}" for number in trees)):
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
        for frame, place in zip(model.frames, data.oMf, strict=True):
            if frame.type == pin.FrameType.BODY and frame.name != "universe":
                lines.append(f"link {frame.name} {text(place.translation)} {text(place.rotation)}")
(folder / "reference.txt").write_text("\n".join(lines) + "\n")

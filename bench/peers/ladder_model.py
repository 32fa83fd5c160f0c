"""A ladder of N four-bar loops in the plane x-y: N + 1 standing bars on the ground, N bars across their tops.

All bars have 1 m and 1 kg; N = 2 is the double four-bar mechanism. It has one degree of freedom, the angle theta of the
standing bars from +x, and passes twice a turn through the singular position in which all bars align.
"""

import numpy as np

MASS, INERTIA, GRAVITY, SPEED = 1.0, 1 / 12, 9.81, -1.0  # about the centre, about z; rad/s of the standing bars
SLENDER = 1 / (6 * 7850)  # about the bar's own axis; plays no part


def model_file(n: int) -> str:
    lines = ["mimbre: 1", f"gravity: [0, {-GRAVITY}, 0]", "bodies:"]
    for i in range(n + 1):
        lines.append(f"  bar_{i}: {{mass: {MASS}, com: [{i}, 0.5, 0], inertia: [{INERTIA}, {SLENDER}, {INERTIA}]}}")
    for i in range(n):
        lines.append(f"  top_{i}: {{mass: {MASS}, com: [{i + 0.5}, 1, 0], inertia: [{SLENDER}, {INERTIA}, {INERTIA}]}}")
    lines.append("joints:")

    def revolute(name: str, inner: str, outer: str, x: float, y: float, more: str = "") -> None:
        between = f"between: [{inner}, {outer}], at: [{x}, {y}, 0], axis: [0, 0, 1]{more}"
        lines.append(f"  {name}: {{type: revolute, {between}}}")

    revolute("foot_0", "ground", "bar_0", 0, 0, f", velocity: {SPEED}")
    revolute("head_0", "bar_0", "top_0", 0, 1)
    for i in range(1, n + 1):
        revolute(f"head_{i}", f"top_{i - 1}", f"bar_{i}", i, 1)
        revolute(f"foot_{i}", "ground", f"bar_{i}", i, 0)
    lines.append("constraints:")  # close the loops by two equations each; a revolute would repeat three more
    for i in range(1, n):
        ends = f"between: [top_{i - 1}, top_{i}], at: [{i}, 1, 0]"
        lines.append(f"  next_{i}: {{type: on_line, {ends}, axis: [0, 0, 1]}}")
    lines.append(f"outputs: [{{name: x, position: bar_{n}, at: [{n}, 1, 0], component: x}},")
    lines.append(f"          {{name: y, position: bar_{n}, at: [{n}, 1, 0], component: y}}]")
    lines.append("simulation: {step: 0.01, end: 1}")
    return "\n".join(lines) + "\n"


def exact(n: int, end: float) -> np.ndarray:
    """Position of the last bar's head at the end, from the equation of its one degree of freedom."""
    stiffness = GRAVITY * ((n + 1) / 2 + n) / ((n + 1) / 3 + n)
    theta, rate, steps = np.pi / 2, SPEED, 20000
    h = end / steps
    for _ in range(steps):  # the classical rule of Runge and Kutta
        k1, l1 = rate, -stiffness * np.cos(theta)
        k2, l2 = rate + h / 2 * l1, -stiffness * np.cos(theta + h / 2 * k1)
        k3, l3 = rate + h / 2 * l2, -stiffness * np.cos(theta + h / 2 * k2)
        k4, l4 = rate + h * l3, -stiffness * np.cos(theta + h * k3)
        theta, rate = theta + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), rate + h / 6 * (l1 + 2 * l2 + 2 * l3 + l4)
    return np.array([[n + np.cos(theta), np.sin(theta)]])

"""A five-bar robot: how far its tip reaches in each direction, and the torques of its motors along a path."""

import matplotlib.pyplot as plt
import mimbre
import numpy as np

base, upper, lower, height = 0.1, 0.25, 0.35, 0.35
tip = np.array([0, 0, height])


def five_bar(x: str, z: str) -> mimbre.Model:
    """Motors at x = -base and base; the tip moves by x and z, m, from its drawn place."""
    m = mimbre.ModelBuilder("Five-bar robot")
    for side, sign in (("left", -1), ("right", 1)):
        motor = np.array([sign * base, 0, 0])
        span = float(np.linalg.norm(tip - motor))
        way = (tip - motor) / span
        along = (upper**2 - lower**2 + span**2) / (2 * span)
        across = sign * np.sqrt(upper**2 - along**2)
        elbow = motor + along * way + across * np.array([way[2], 0, -way[0]])
        for name, a, b, mass in (("upper", motor, elbow, 0.4), ("lower", elbow, tip, 0.3)):
            slender = mass * float(np.dot(b - a, b - a)) / 12
            m.add_body(f"{side}.{name}", mass=mass, com=(a + b) / 2, inertia=[slender] * 3)
        axis = [0, 1, 0]
        m.add_joint(f"{side}.motor", type="revolute", between=["ground", f"{side}.upper"], at=motor, axis=axis)
        links = [f"{side}.upper", f"{side}.lower"]
        m.add_joint(f"{side}.elbow", type="revolute", between=links, at=elbow, axis=axis)
        m.add_joint(f"{side}.tip", type="revolute", between=[f"{side}.lower", "tool"], at=tip, axis=axis, cut="always")
    # The place of the tip as two coordinates.
    m.add_body("guide", mass=1e-3, com=tip, inertia=[1e-6] * 3)
    m.add_body("tool", mass=0.5, com=tip, inertia=[1e-4] * 3)
    m.add_joint("x", type="prismatic", between=["ground", "guide"], at=tip, axis=[1, 0, 0], drive={"position": x})
    m.add_joint("z", type="prismatic", between=["guide", "tool"], at=tip, axis=[0, 0, 1], drive={"position": z})
    m.set_simulation(end=1)
    return m.compile()


# The tip goes along rays until the loops do not close.
directions = np.linspace(0, 2 * np.pi, 25)
reached = []
for angle in directions:
    found = five_bar(f"{np.cos(angle):.9f}*t", f"{np.sin(angle):.9f}*t").kinematics(steps=60)
    stop = next((s.time for s in found.special if s.kind == "limit"), 1.0)
    reached.append(stop * np.array([np.cos(angle), np.sin(angle)]) + tip[[0, 2]])
border = np.array(reached)
print(f"straight up the tip reaches z = {border[6, 1]:.4f} m; the stretched arms, {np.sqrt(0.6**2 - 0.1**2):.4f} m")

# Which torques move it around a circle?
turn = "pi*(1 - cos(pi*t))"  # from rest to rest
path = five_bar(f"0.08*sin({turn})", f"0.08*(cos({turn}) - 1)")
forces = path.inverse_dynamics(forces=["left.motor", "right.motor"])
print(f"largest torque {np.abs(forces.force).max():.3f} N m")

fig, (left, right) = plt.subplots(1, 2, figsize=(9, 4))
left.plot(border[:, 0], border[:, 1], label="reached along rays")
left.plot(forces.run["joint.x.position"], height + forces.run["joint.z.position"], label="path")
left.set(xlabel="x, m", ylabel="z, m", aspect="equal")
left.legend()
for name in forces.names:
    right.plot(forces.time, forces[name], label=name)
right.set(xlabel="t, s", ylabel="torque, N m")
right.legend()
fig.savefig("workspace.png")

# %% [markdown]
# # A robot arm whose links bend, and its controller
#
# Yaw, shoulder, elbow: three motors move a payload of 2 kg on two thin tubes. A controller in Python closes the loop at
# every step: computed torque, from the equations of the arm as if it were rigid. How well does it do on an arm that is
# not? This file is a script and a notebook.
# %%
from dataclasses import dataclass

import matplotlib.pyplot as plt
import mimbre
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
JOINTS = ("yaw", "shoulder", "elbow")
LENGTH, HEIGHT = 0.8, 0.4  # of each link, and of the shoulder, m
OUTER, INNER = 0.032, 0.029  # diameters of the tubes, m
YOUNG, DENSITY = 7e10, 2700.0  # aluminium
LINK = DENSITY * np.pi / 4 * (OUTER**2 - INNER**2) * LENGTH  # kg
PAYLOAD, BASE = 2.0, 0.05  # kg; kg m² about the axis of yaw
MOTOR, ROTOR = 1.0, 0.15  # of the motors at the links' inner ends: kg; kg m² about each axis
GRAVITY = 9.81

# %% [markdown]
# ## The model
#
# At rest it points along x; shoulder and elbow count downwards. Each link is a beam, clamped at its inner end in its
# own frame, with all motions of its outer end as static modes and two of its own; or, for comparison, a rigid bar.
# %%


def link(m: mimbre.ModelBuilder, name: str, x: float, flexible: bool) -> None:
    ends = {"in": [x, 0, HEIGHT], "out": [x + LENGTH, 0, HEIGHT]}
    if flexible:
        m.add_body(
            name,
            frame={"at": ends["in"]},
            flexible={
                "material": "aluminium",
                "section": "tube",
                "nodes": ends,
                "bars": {"bar": {"from": "in", "to": "out", "elements": 8}},
                "clamped": ["in"],
                "static_modes": [{"node": "out", "all": True}],
                "dynamic_modes": 2,
                "stiffness_damping": 0.01,
            },
        )
    else:
        turning = LINK * LENGTH**2 / 12
        m.add_body(name, mass=LINK, com=[x + LENGTH / 2, 0, HEIGHT], inertia=[1e-4, turning, turning])
        for end, place in ends.items():
            m.add_frame(f"{name}.{end}", body=name, at=place)
    m.add_body(f"{name}.motor", mass=MOTOR, com=ends["in"], inertia=[ROTOR] * 3)
    m.add_joint(f"{name}.hub", type="fixed", between=[f"{name}.motor", f"{name}.in"])


def arm(flexible: bool = True, locked: bool = False, at: Floats | None = None) -> mimbre.ModelBuilder:
    """Driven by torques from these angles on, or with its joints locked."""
    m = mimbre.ModelBuilder("Robot arm", gravity=[0, 0, -GRAVITY])
    m.add_material("aluminium", young=YOUNG, poisson=0.3, density=DENSITY)
    m.add_section("tube", type="tube", diameter=OUTER, inner_diameter=INNER)
    m.add_body(
        "base", mass=5, com=[0, 0, 0.2], inertia=[0.1, 0.1, BASE], shapes=[{"box": [0.1, 0.1, 0.4], "at": [0, 0, 0.2]}]
    )
    link(m, "upper", 0, flexible)
    link(m, "fore", LENGTH, flexible)
    tip = [2 * LENGTH, 0, HEIGHT]
    m.add_body("payload", mass=PAYLOAD, com=tip, inertia=[1e-5] * 3, shapes=[{"sphere": 0.05, "at": tip}])
    yaw, shoulder, elbow = (
        {"drive": {"position": angle}} if locked else {"position": angle}
        for angle in (np.zeros(3) if at is None else at).tolist()
    )
    m.add_joint("yaw", type="revolute", between=["ground", "base"], at=[0, 0, 0], axis=[0, 0, 1], **yaw)
    m.add_joint("shoulder", type="revolute", between=["base", "upper.in"], axis=[0, 1, 0], **shoulder)
    m.add_joint("elbow", type="revolute", between=["upper.out", "fore.in"], axis=[0, 1, 0], **elbow)
    m.add_joint("grip", type="fixed", between=["fore.out", "payload"])
    for joint in JOINTS:
        if not locked:
            m.add_input(joint, 0.0, range=[-200, 200], unit="N m")
            m.add_actuator(joint, joint=joint, torque=joint)
        m.add_output(f"{joint}.angle", joint=joint)
        m.add_output(f"{joint}.rate", joint_velocity=joint)
    for axis in "xyz":
        m.add_output(f"tip.{axis}", position="payload", component=axis)
    m.set_simulation(step=0.001)
    return m


# %% [markdown]
# ## The controller
#
# The torques that a rigid arm needs for angles `q`, rates `v` and accelerations `a`. The kinetic energy of a rigid bar
# is that of three points: a sixth of its mass at each end, the rest in its middle. So the whole arm is four points in
# the plane that yaw turns, each `(mass, share of the upper link, share of the forearm)`, and the rotors.
# %%
POINTS = [
    (LINK * 4 / 6, 0.5, 0.0),
    (LINK / 6 + MOTOR + LINK / 6, 1.0, 0.0),
    (LINK * 4 / 6, 1.0, 0.5),
    (LINK / 6 + PAYLOAD, 1.0, 1.0),
]


def needed(q: Floats, v: Floats, a: Floats) -> Floats:
    """N m"""
    bend, turn = np.array([1, 0]), np.array([1, 1])  # how the links' angles to the horizontal vary with q[1:]
    rotors = ROTOR * (bend * (bend @ a[1:]) + turn * (turn @ a[1:]))
    torque = np.array([(BASE + 2 * ROTOR) * a[0], *rotors])
    first, second = q[1], q[1] + q[2]
    for mass, upper, fore in POINTS:
        r = LENGTH * (upper * np.cos(first) + fore * np.cos(second))
        along = -LENGTH * (upper * np.sin(first) * bend + fore * np.sin(second) * turn)  # ∂r/∂q
        up = -LENGTH * (upper * np.cos(first) * bend + fore * np.cos(second) * turn)  # ∂z/∂q
        squares = upper * np.array([np.cos(first), np.sin(first)]) * v[1] ** 2
        squares += fore * np.array([np.cos(second), np.sin(second)]) * (v[1] + v[2]) ** 2
        out = along @ a[1:] - LENGTH * squares[0] - r * v[0] ** 2
        rise = up @ a[1:] + LENGTH * squares[1] + GRAVITY
        torque[0] += mass * r * (r * a[0] + 2 * (along @ v[1:]) * v[0])
        torque[1:] += mass * (along * out + up * rise)
    return torque


FROM, TO = np.array([0.0, -0.2, 0.6]), np.array([1.2, -0.9, 1.3])  # rad
HOLD, DURATION = 1.5, 1.0  # s


def wanted(t: float) -> tuple[Floats, Floats, Floats]:
    """Angles, rates and accelerations: to stay, to go from one place to another, smoothly, to stay."""
    s, way = min(max((t - HOLD) / DURATION, 0.0), 1.0), TO - FROM
    return (
        FROM + way * (10 * s**3 - 15 * s**4 + 6 * s**5),
        way * (30 * s**2 - 60 * s**3 + 30 * s**4) / DURATION,
        way * (60 * s - 180 * s**2 + 120 * s**3) / DURATION**2,
    )


def place(q: Floats) -> Floats:
    """Of the payload on a rigid arm, m."""
    r = LENGTH * (np.cos(q[1]) + np.cos(q[1] + q[2]))
    return np.array([r * np.cos(q[0]), r * np.sin(q[0]), HEIGHT - LENGTH * (np.sin(q[1]) + np.sin(q[1] + q[2]))])


@dataclass
class Motion:
    model: mimbre.Model
    time: Floats  #: s, instants
    torque: Floats  #: over each step, steps × 3
    angle: Floats  #: instants × 3
    tip: Floats  #: instants × 3
    error: Floats  #: of the tip, m
    energy: list[dict[str, float]]  #: J, at each instant


def controlled(flexible: bool, until: float = 4.0, speed: float = 12.0) -> Motion:
    """The arm with its controller: errors of joints die as those of springs and dampers, `speed` rad/s."""
    model = arm(flexible, at=FROM).compile()
    sim = model.simulation()
    motors = sim.input_array(list(JOINTS))
    angles = sim.channel_array([f"{joint}.angle" for joint in JOINTS])
    rates = sim.channel_array([f"{joint}.rate" for joint in JOINTS])
    tip = sim.channel_array([f"tip.{axis}" for axis in "xyz"])
    time, torques, seen, tips, energy = [0.0], [], [angles.copy()], [tip.copy()], [sim.energy]
    while sim.time < until - 1e-9:
        q, v, a = wanted(sim.time)
        motors[:] = needed(angles, rates, a + 2 * speed * (v - rates) + speed**2 * (q - angles))
        sim.step()
        time.append(sim.time)
        torques.append(motors.copy())
        seen.append(angles.copy())
        tips.append(tip.copy())
        energy.append(sim.energy)
    error = np.linalg.norm(np.array(tips) - [place(wanted(t)[0]) for t in time], axis=1)
    return Motion(model, np.array(time), np.array(torques), np.array(seen), np.array(tips), error, energy)


# %% [markdown]
# ## Rigid and flexible
#
# On the rigid arm the controller is exact. On the flexible one its joints go where they are to, and the tip does not:
# it hangs lower by what the links sag, and swings on after the way. The links are straight as they are let go, so for
# the first second and a half the arm is held where it is.
# %%
rigid, flexible = controlled(False), controlled(True)
for name, motion in {"rigid": rigid, "flexible": flexible}.items():
    off = np.abs(motion.angle - [wanted(t)[0] for t in motion.time]).max()
    print(
        f"{name}: joints off by at most {off:.1e} rad, tip by {1e3 * motion.error.max():.1f} mm, at last "
        f"{1e3 * motion.error[-1]:.1f} mm"
    )
figure, axes = plt.subplots(1, 2, figsize=(10, 3.5))
for name, motion in {"rigid": rigid, "flexible": flexible}.items():
    axes[0].plot(motion.time, 1e3 * motion.error, label=name)
    axes[1].plot(motion.time[:-1], motion.torque[:, 1], label=name)
axes[0].set(xlabel="time, s", ylabel="deviation of the tip, mm")
axes[1].set(xlabel="time, s", ylabel="torque of the shoulder, N m")
axes[1].legend()
figure.savefig("robot_arm.png")

# %% [markdown]
# ## Once more, to look at
#
# The torques, played as inputs, give the same motion, as a run with its page: animation, plots, summary.
# %%
played = flexible.model.run(
    until=flexible.time[-1],
    inputs={joint: (flexible.time[:-1], flexible.torque[:, k]) for k, joint in enumerate(JOINTS)},
)
print(f"played again, the tip differs by {np.abs(played['tip.z'] - flexible.tip[:, 2]).max():.1e} m")
played.show()

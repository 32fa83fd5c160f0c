# %% [markdown]
# # How a robot arm vibrates over its workspace
#
# Gears twist and links bend: an arm whose motors hold still vibrates, the slower the farther it reaches and the more it
# carries. The lowest modes of an arm with three joints, what they consist of, and a map of the first frequency. This
# file is a script and a notebook.
# %%
import matplotlib.pyplot as plt
import mimbre
import numpy as np

LENGTH, HEIGHT = 0.7, 0.5  # of each link, and of the shoulder, m
OUTER, INNER = 0.06, 0.054  # diameters of the tubes, m
PAYLOAD = 6.0  # kg
GEARS = {"yaw": 3e4, "shoulder": 3e4, "elbow": 1.5e4}  # N m/rad
POSES = {"stretched out": (0.0, 0.0), "elbow bent": (-0.6, 1.6), "folded": (-1.2, 2.6)}  # shoulder, elbow, rad

# %% [markdown]
# ## The model
#
# Each joint is two: a motor, whose angle an input gives, and behind it the gear, a spring. Links are beams, clamped at
# their inner ends, with all motions of their outer ends as static modes and two modes of their own. At zero angles the
# arm points along x; shoulder and elbow count downwards.


# %%
def add_joint(m: mimbre.ModelBuilder, name: str, bodies: tuple[str, str], at: list[float], axis: list[float]) -> None:
    """A motor that holds its angle, and a gear that twists."""
    m.add_input(name, 0.0, unit="rad")
    m.add_body(f"{name}.rotor", mass=2.0, com=at, inertia=[0.01] * 3)
    rotor = f"{name}.axis"
    m.add_frame(rotor, body=f"{name}.rotor", at=at)
    inner, outer = bodies
    m.add_joint(f"{name}.motor", type="revolute", between=[inner, rotor], axis=axis, drive={"position": name})
    m.add_joint(
        f"{name}.gear",
        type="revolute",
        between=[rotor, outer],
        axis=axis,
        spring={"stiffness": GEARS[name], "damping": 1e-3 * GEARS[name]},
    )


def add_link(m: mimbre.ModelBuilder, name: str, x: float) -> None:
    ends = {"in": [x, 0, HEIGHT], "out": [x + LENGTH, 0, HEIGHT]}
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
            "stiffness_damping": 1e-4,
        },
    )


def arm() -> mimbre.Model:
    m = mimbre.ModelBuilder("Robot arm", gravity=[0, 0, -9.81])
    m.add_material("aluminium", young=7e10, poisson=0.3, density=2700)
    m.add_section("tube", type="tube", diameter=OUTER, inner_diameter=INNER)
    m.add_body("column", mass=20, com=[0, 0, HEIGHT / 2], inertia=[0.5, 0.5, 0.3])
    add_link(m, "upper", 0)
    add_link(m, "fore", LENGTH)
    m.add_body("payload", mass=PAYLOAD, com=[2 * LENGTH, 0, HEIGHT], inertia=[0.01] * 3)
    add_joint(m, "yaw", ("ground", "column"), [0, 0, 0], [0, 0, 1])
    add_joint(m, "shoulder", ("column", "upper.in"), [0, 0, HEIGHT], [0, 1, 0])
    add_joint(m, "elbow", ("upper.out", "fore.in"), [LENGTH, 0, HEIGHT], [0, 1, 0])
    m.add_joint("grip", type="fixed", between=["fore.out", "payload"])
    return m.compile()


model = arm()

# %% [markdown]
# ## Modes of three poses
#
# A mode knows where its energy is: `elastic` has the shares of springs and flexible bodies in what is bent and twisted.
# In the plane of the arm the gears of shoulder and elbow are the soft parts; across it the gear of yaw and both links.


# %%
def modes_at(shoulder: float, elbow: float, most: int = 4) -> list[mimbre.EigenMode]:
    """The lowest ones, with the motors at these angles."""
    return list(model.modes(at="equilibrium", most=most, inputs={"shoulder": shoulder, "elbow": elbow}))


for pose, angles in POSES.items():
    print(f"{pose}:")
    for mode in modes_at(*angles):
        parts = ", ".join(f"{name} {100 * share:.0f} %" for name, share in list(mode.elastic.items())[:3])
        print(f"  {mode.frequency:5.1f} Hz, damping ratio {mode.damping:.3f}: {parts}")

# %% [markdown]
# ## Over the workspace
#
# The first frequency over the angles of shoulder and elbow. The angle of yaw changes nothing, and that of the shoulder
# little: the weight hardly bends the arm. The elbow is what matters, as it sets how far the payload is from yaw and
# shoulder.
# %%
shoulders, elbows = np.linspace(-1.5, 0.5, 13), np.linspace(0.0, 2.7, 19)
first = np.array([[modes_at(float(s), float(e), most=1)[0].frequency for s in shoulders] for e in elbows])
lowest, highest = np.unravel_index(first.argmin(), first.shape), np.unravel_index(first.argmax(), first.shape)
for name, (row, column) in {"lowest": lowest, "highest": highest}.items():
    print(f"{name}: {first[row, column]:.2f} Hz, shoulder {shoulders[column]:+.2f} rad, elbow {elbows[row]:.2f} rad")

figure, axes = plt.subplots()
levels = axes.contourf(shoulders, elbows, first, 16)
figure.colorbar(levels, label="first frequency, Hz")
axes.set(xlabel="shoulder, rad", ylabel="elbow, rad")
plt.show()

# %% [markdown]
# # How a car rides and steers
#
# The Iltis of `examples/iltis`, a vehicle with a flexible suspension: its modes at rest by name, the steering that
# a circle takes, and its modes over the speed. This file is a script and a notebook.
# %%
from pathlib import Path

import matplotlib.pyplot as plt
import mimbre
import numpy as np

folder = Path("examples/iltis")

# %% [markdown]
# ## Modes at rest
#
# Every mode knows what it consists of: `coordinates` has the shares of the joints' coordinates in its motion. The
# chassis moves by the joint `free`, whose coordinates are those along and about x, y and z; the wheels hop by their
# arms.
# %%
RIDE = {"'free' along z": "bounce", "'free' about y": "pitch", "'free' about x": "roll"}


def name_of(mode: mimbre.EigenMode) -> str:
    """By the coordinate with the largest share, or that of all wheels."""
    hop = sum(share for of, share in mode.coordinates.items() if of.endswith(".arm'"))
    most = max(mode.coordinates, key=lambda of: mode.coordinates[of])
    return "wheel hop" if hop > mode.coordinates[most] else RIDE.get(most, most)


model = mimbre.Model.from_file(folder / "vehicle.yaml")
ride = [mode for mode in model.modes(at="equilibrium", most=10) if mode.kind == "oscillating"]
for mode in ride:
    print(f"{mode.frequency:6.2f} Hz, damping ratio {mode.damping:.2f}: {name_of(mode)}")

# %% [markdown]
# ## Steering on a circle
#
# Around a circle of 40 m, faster and faster: the circle asks for the same rack all along, and what more the car needs
# is understeer. The gradient is that of the wheels' angle, which is base over radius where the tyres do not slip.
# %%
driven = mimbre.Model.from_file(folder / "steady.yaml")
base, radius = 2.017, 40.0
accelerations = np.array([0.5, 1.0, 1.5, 2.0, 2.5])
racks = []
for acceleration in accelerations:
    found = driven.trim(find=["steering", "throttle"], speed=float(np.sqrt(acceleration * radius)), radius=radius)
    racks.append(found["rack"])
    print(f"{acceleration:4.2f} m/s²: rack {1e3 * found['rack']:.3f} mm, sideslip {found.sideslip:+.4f} rad")
slope, slowly = np.polyfit(accelerations, racks, 1)
print(f"understeer gradient {base / radius * slope / slowly:.4f} rad s²/m")

figure, axes = plt.subplots()
axes.plot(accelerations, 1e3 * np.array(racks), "o-")
axes.set(xlabel="lateral acceleration, m/s²", ylabel="rack, mm")
plt.show()

# %% [markdown]
# ## Modes over the speed
#
# Driven straight on, with the throttle that each speed needs: a root locus. Tyres damp yaw and sideslip the less, the
# faster the car goes; a car that oversteers would cross the axis to the right. Links are rigid here, which is faster.
# %%
RIGID = {"arms": "rigid", "links": "rigid", "rods": "rigid"}
stiff = mimbre.Model.from_file(folder / "steady.yaml", **RIGID)
speeds = np.linspace(10, 40, 7)
loci = {speed: stiff.modes(hold={"speed": float(speed)}, find=["throttle"]) for speed in speeds}

figure, axes = plt.subplots()
for speed, modes in loci.items():
    slow = modes.values[(np.abs(modes.values) < 25) & (np.abs(modes.values) > 1e-9)]
    axes.plot(slow.real, slow.imag, "o", markersize=2 + speed / 10, label=f"{speed:.0f} m/s")
axes.set(xlabel="real part, 1/s", ylabel="imaginary part, 1/s")
axes.legend()
plt.show()

for speed, modes in loci.items():
    side = [mode for mode in modes if mode.kind == "oscillating" and mode.frequency < 3]
    yaw = max(side, key=lambda mode: mode.coordinates.get("'free' along y", 0.0))
    grows = any(mode.grows for mode in modes)
    print(f"{speed:2.0f} m/s: sideslip {yaw.frequency:.2f} Hz, damping ratio {yaw.damping:.2f}; grows: {grows}")

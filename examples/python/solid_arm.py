# %% [markdown]
# # From a solid part to its stress
#
# The arm of a car's suspension, meshed by Gmsh, becomes a flexible body, goes into the suspension, and says where and
# when it is stressed. [docs/finite-elements.md](../../docs/finite-elements.md) does the same with the program. The mesh
# lies in `examples/solid-arm`; with Gmsh it is made anew by
#
#     gmsh -3 -order 2 -format msh22 examples/solid-arm/arm.geo -o arm.msh
#
# Run it from the repository's root. This file is a script and a notebook.
# %%
import shutil
from pathlib import Path

import matplotlib.pyplot as plt
import mimbre
import numpy as np

folder = Path("solid-arm-study")  # a copy of the examples, so that theirs stay as they are
for part in ("solid-arm", "iltis"):
    shutil.copytree(Path("examples", part), folder / part, dirs_exist_ok=True)

# %% [markdown]
# ## Reduction
#
# An interface is where a joint or a force takes hold: the nodes of a group of the mesh, tied to a point. The mesh is in
# mm. The validation report lists the checks and the frequency up to which the body is valid.
# %%
arm = mimbre.reduce(
    folder / "solid-arm/arm.msh",
    units="mm",
    materials=(2.1e11, 0.3, 7850),
    interfaces={
        "front": mimbre.Interface("group:front", point=[108, 0, 0]),
        "rear": mimbre.Interface("group:rear", point=[-108, 0, 0]),
        "ball": mimbre.Interface("group:ball", point=[0, 321.4603, 0]),
        "shock": mimbre.Interface("group:seat", point=[75, 248.6166, -4.6668]),
    },
    modes=2,
    free_modes=6,
    damping=0.01,
)
print(arm)
for check in arm.checks:
    print("ok" if check.passed else "NO", f"{check.name}: {check.detail}")
arm.save(folder / "solid-arm/arm.h5")
arm.report(folder / "modes.html")

# %% [markdown]
# ## A run
#
# The road drops by 0.2 m after two seconds.
# %%
run = mimbre.Model.from_file(folder / "solid-arm/suspension.yaml", drop=0.2).run()
run.save(folder / "run.h5")
run.plot("wheel.z", "chassis.z")

# %% [markdown]
# ## Stress
#
# The largest von Mises stress of the surface is an output of this model. Where it is, the hot spots say, and what a
# node has over time, its history.
# %%
name = "front_left.arm"
spots = mimbre.stress(run, spots=3)[name]
for spot in spots:
    place = ", ".join(f"{1e3 * x:.0f}" for x in spot.position)
    print(f"node {spot.node} at ({place}) mm: {spot.von_mises / 1e6:.0f} MPa at {spot.time:.2f} s")
history = mimbre.stress_history(run, name, nodes=[spot.node for spot in spots])
figure, axes = plt.subplots()
axes.plot(run.time, run["arm.stress"] / 1e6, "k", lw=1, label="largest of the surface")
for node, stress in zip(history.nodes, history.von_mises.T, strict=True):
    axes.plot(history.time, stress / 1e6, lw=1, label=f"node {node}")
axes.set(xlabel="time, s", ylabel="von Mises stress, MPa")
axes.legend()
figure.savefig(folder / "stress.png")

# %% [markdown]
# All of the surface, when it is worst:
# %%
field = mimbre.stress_history(run, name)
worst = int(np.argmax(field.von_mises.max(axis=1)))
figure, axes = plt.subplots()
x, y, _ = 1e3 * field.positions.T
colours = axes.scatter(x, y, c=field.von_mises[worst] / 1e6, s=8, cmap="viridis")
axes.set(xlabel="x, mm", ylabel="y, mm", title=f"von Mises stress at {field.time[worst]:.2f} s, MPa", aspect="equal")
figure.colorbar(colours)
figure.savefig(folder / "field.png")

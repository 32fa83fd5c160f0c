# %% [markdown]
# # Modes of a wind turbine's rotor over its speed
#
# Three blades that bend turn with the hub, and tension stiffens them the faster they turn. Together the blades make
# waves: all alike (collective), or one after the other, forward or backward around the hub. This file is a script and
# a notebook.
# %%
from pathlib import Path

import matplotlib.pyplot as plt
import mimbre
import numpy as np

model = mimbre.Model.from_file(Path("examples/wind-turbine/model.yaml"), weight=0, thrust=0)

# %% [markdown]
# ## A Campbell diagram
#
# Frequencies as they are seen from the blades, without weight and wind, when the rotor has its speed (after 8 s). Lines
# through the origin are once, twice, three times a turn: where they cross a frequency, that share of the load excites
# it.
# %%
rpm = np.linspace(2, 14, 3)
found = model.campbell("rpm", rpm, speed="rpm", at=9.0, most=8)
for branch in found.branches:
    first, last = branch.values[0].imag / (2 * np.pi), branch.values[-1].imag / (2 * np.pi)
    print(f"{first:.3f} Hz at {rpm[0]:.0f} rpm, {last:.3f} Hz at {rpm[-1]:.0f} rpm: {branch.name[:60]}")

figure, axes = plt.subplots()
for branch in found.branches:
    axes.plot(found.values, np.abs(branch.values.imag) / (2 * np.pi))
for order in (1, 2, 3):
    axes.plot(found.values, order * found.values / 60, "k--", linewidth=0.7)
axes.set(xlabel="rpm", ylabel="Hz")
plt.show()

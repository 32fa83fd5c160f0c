"""A steel rod on a hinge, let go from the horizontal: built, run, drawn."""

import matplotlib.pyplot as plt
import mimbre
import numpy as np

m = mimbre.ModelBuilder("Pendulum")
mass = 7850 * np.pi / 4 * 0.01**2
m.add_body("bar", mass=mass, com=[0.5, 0, 0], inertia=[1e-5, mass / 12, mass / 12])
m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
m.add_output("angle", joint="hinge")
run = m.compile().run(until=2, step=0.01)

lowest = run.time[run["angle"] > np.pi / 2][0]
print(f"lowest at t = {lowest:.2f} s; the numerics fed in {run['energy.numerical'][-1]:.1e} J")
run.plot("angle")
plt.savefig("pendulum.png")

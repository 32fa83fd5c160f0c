"""A controller in Python closes a loop at every step: it swings a pendulum up to the horizontal and holds it there."""

import mimbre
import numpy as np

m = mimbre.ModelBuilder("Held pendulum")
m.add_body("bar", mass=0.6, com=[0, 0, -0.5], inertia=[0.05, 0.05, 1e-5])
m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
m.add_input("torque", 0.0, range=[-5, 5], unit="N m")
m.add_actuator("motor", joint="hinge", torque="torque")
m.add_output("angle", joint="hinge")
m.add_output("rate", joint_velocity="hinge")
m.set_simulation(step=0.001)

sim = m.compile().simulation()
u = sim.input_array(["torque"])  # what is written here counts from the next step on
y = sim.channel_array(["angle", "rate"])  # has their values after each step
wanted = -np.pi / 2
for _ in range(3000):
    angle, rate = y
    u[0] = 20 * (wanted - angle) - 4 * rate - 0.6 * 9.81 * 0.5
    sim.step()
print(f"angle {y[0]:.6f} rad, wanted {wanted:.6f} rad")

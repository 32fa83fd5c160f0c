"""What an action in mimbre.gym costs beside the steps that it makes: alone, and in many environments on one core.

build/python-env/bin/python bench/python/gym_overhead.py
"""

from __future__ import annotations

import time
from collections.abc import Callable

import mimbre
import mimbre.gym
import numpy as np

SKIP, MANY = 2, 64


def pendulum() -> mimbre.Model:
    m = mimbre.ModelBuilder("Pendulum")
    m.add_input("torque", 0.0, range=[-1, 1])
    m.add_body("bar", mass=0.6, com=[0.5, 0, 0], inertia=[1e-5, 0.05, 0.05])
    m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    m.add_actuator("motor", joint="hinge", torque="torque")
    m.add_output("angle", joint="hinge")
    m.add_output("rate", joint_velocity="hinge")
    m.add_signal("reward", "-angle^2")
    m.set_simulation(step=0.001)
    return m.compile()


def cost(act: Callable[[], object], count: int) -> float:
    """Processor time of a call, µs: the least of some rounds."""
    rounds = []
    for _ in range(7):
        start = time.process_time()
        for _ in range(count):
            act()
        rounds.append((time.process_time() - start) / count * 1e6)
    return min(rounds)


model = pendulum()
names = ["angle", "rate"]
sim = model.simulation()
env = mimbre.gym.make(model, actions=["torque"], observations=names, reward="signal.reward", skip=SKIP)
envs = mimbre.gym.make_vec(
    model, MANY, actions=["torque"], observations=names, reward="signal.reward", skip=SKIP, threads=1
)
env.reset(seed=0)
envs.reset(seed=0)
action, actions = np.zeros(1), np.zeros((MANY, 1))
alone = cost(lambda: sim.step(SKIP), 4000)
one = cost(lambda: env.step(action), 2000)
each = cost(lambda: envs.step(actions), 50) / MANY
many = each - alone
print(f"{SKIP} steps {alone:.1f} µs; an action {one - alone:.1f} µs more, of {MANY} at once {many:.1f} µs more each")

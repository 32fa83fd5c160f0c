# %% [markdown]
# # Learning to hold a flexible pendulum upright
#
# A rod that bends, with a weight on its end, stands on a cart. A motor moves the cart. What force is needed, seen the
# cart, the rod's angle at its foot and how it bends? Here the answer is found by trying: by the cross-entropy method,
# in many simulations at once. This file is a script and a notebook (Jupyter with jupytext, VS Code).
# %%
from typing import Any

import matplotlib.pyplot as plt
import mimbre
import mimbre.gym
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

# %% [markdown]
# ## The model
#
# The rod is a beam, clamped at its foot in its own frame, with three bending modes. `start` is the angle an episode
# begins with. Reward and end are signals of the model, so that no Python is called for them: 1 for each moment upright,
# less for what is off.
# %%
m = mimbre.ModelBuilder("Flexible pendulum on a cart")
m.add_parameter("start", 0.05)
m.add_input("force", 0.0, range=[-20, 20], unit="N")
m.add_material("aluminium", young=7e10, poisson=0.3, density=2700)
m.add_section("rod", type="round", diameter="6 mm")
m.add_body("cart", mass=1, com=[0, 0, 0], inertia=[0.01, 0.01, 0.01], shapes=[{"box": [0.3, 0.2, 0.1]}])
m.add_body(
    "rod",
    frame={"at": [0, 0, 0], "x": [0, 0, 1], "y": [0, 1, 0]},
    flexible={
        "material": "aluminium",
        "section": "rod",
        "nodes": {"foot": [0, 0, 0], "tip": [0, 0, 1]},
        "bars": {"bar": {"from": "foot", "to": "tip", "elements": 8}},
        "clamped": ["foot"],
        "static_modes": [{"node": "tip", "along": [1, 0, 0]}],
        "dynamic_modes": 2,
        "planar": [0, 1, 0],
        "stiffness_damping": 2e-3,
    },
)
m.add_body("weight", mass=0.1, com=[0, 0, 1], inertia=[1e-5] * 3, shapes=[{"sphere": 0.03, "at": [0, 0, 1]}])
m.add_joint("rail", type="prismatic", between=["ground", "cart"], at=[0, 0, 0], axis=[1, 0, 0])
m.add_joint("pin", type="revolute", between=["cart", "rod"], at=[0, 0, 0], axis=[0, 1, 0], position="start")
m.add_joint("clamp", type="fixed", between=["rod.tip", "weight"])
m.add_actuator("motor", joint="rail", force="force")
m.add_output("place", joint="rail")
m.add_output("speed", joint_velocity="rail")
m.add_output("angle", joint="pin")
m.add_output("rate", joint_velocity="pin")
m.add_output("bend", deflection="rod.tip", along=[1, 0, 0])
m.add_output("tip", position="weight", component="x", at=[0, 0, 1])
m.add_signal("reward", "1 - place^2 - 4*(tip - place)^2 - 0.001*force^2")
m.add_signal("fallen", "angle^2 > 0.25 || place^2 > 4 ? 1 : 0")
m.set_simulation(step=0.004)
model = m.compile()

# %% [markdown]
# ## The environment
#
# An action is a force that is kept for five steps, 20 ms. Each episode begins at another angle.
# %%
SEEN = ["place", "speed", "angle", "rate", "bend"]
TASK: dict[str, Any] = {
    "actions": ["force"],
    "observations": SEEN,
    "reward": "signal.reward",
    "terminate": "signal.fallen",
    "time_limit": 4.0,
    "skip": 5,
    "randomise": {"start": (-0.1, 0.1)},
}
env = mimbre.gym.make(model, **TASK, render_mode="rgb_array")
observation, info = env.reset(seed=0)
print(f"begins at {info['parameters']['start']:.3f} rad, and sees", dict(zip(SEEN, observation.tolist(), strict=True)))

# %% [markdown]
# ## Learning
#
# A policy is five gains: force = gains · observation. Of 48 policies, each in an environment of its own, the eight that
# earn most say where the next 48 are looked for. All have the same angle to begin with, so that they can be compared.
# %%
COUNT, BEST, GENERATIONS = 48, 8, 14
envs = mimbre.gym.make_vec(model, COUNT, **TASK)


def earned(gains: Floats, seed: int) -> Floats:
    """By each policy in one episode."""
    seen, _ = envs.reset(seed=[seed] * COUNT)
    total, going = np.zeros(COUNT), np.ones(COUNT, dtype=bool)
    while going.any():
        seen, rewards, terminated, truncated, _ = envs.step(np.sum(gains * seen, axis=1)[:, None])
        total += np.where(going, rewards, 0)
        going &= ~(terminated | truncated)
    return total


random = np.random.default_rng(1)
mean, spread = np.zeros(len(SEEN)), np.full(len(SEEN), 30.0)
history = []
for generation in range(GENERATIONS):
    gains = mean + spread * random.standard_normal((COUNT, len(SEEN)))
    reward = earned(gains, seed=generation)
    best = gains[np.argsort(reward)[-BEST:]]
    mean, spread = best.mean(axis=0), best.std(axis=0) + 2 / (1 + generation)
    history.append(np.sort(reward)[-BEST:].mean())
envs.close()
print(f"the best earn {history[0]:.0f} at first and {history[-1]:.0f} at last, of 200 that can be had")
print("gains:", dict(zip(SEEN, mean.round(1).tolist(), strict=True)))

# %% [markdown]
# ## What was learnt
#
# From angles that were not tried, the rod is still upright after 4 s, and the cart is near where it began.
# %%
figure, axes = plt.subplots(1, 2, figsize=(9, 3.5))
upright = []
for start in (-0.12, -0.03, 0.07, 0.13):
    seen, info = env.reset(options={"start": start})
    places, over = [seen], False
    while not over:
        seen, earns, terminated, truncated, info = env.step(np.array([mean @ seen]))
        places.append(seen)
        over = terminated or truncated
    upright.append(not terminated and abs(seen[2]) < 0.05)
    axes[0].plot(0.02 * np.arange(len(places)), [seen[2] for seen in places], label=f"{start} rad")
axes[0].set(xlabel="time, s", ylabel="angle, rad")
axes[0].legend()
axes[1].imshow(env.render())
axes[1].axis("off")
figure.savefig("learning.png")
print(f"{sum(upright)} of {len(upright)} stand")

# %% [markdown]
# # Optimising
#
# Two things that runs are made for: to find what a machine's numbers are, from what was measured on it, and to choose
# them so that it does best. Both with `scipy.optimize`; a run is one call of the function. Run it from the repository's
# root. This file is a script and a notebook.
# %%
import sys
from typing import Any

import matplotlib.pyplot as plt
import mimbre
import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares, minimize

Floats = npt.NDArray[np.float64]

# %% [markdown]
# ## Stiffness and damping from a measurement
#
# A bar on a hinge with a spring, of which neither stiffness nor damping is known. They are *tunable* parameters, so
# that they can be other ones in each run of the same model, without compiling it anew.
# %%
m = mimbre.ModelBuilder("Bar on a spring")
m.add_parameter("k", 10.0, min=0, max=100, tunable=True)  # N m/rad
m.add_parameter("c", 0.1, min=0, max=10, tunable=True)  # N m s/rad
m.add_body("bar", mass=0.6, com=[0, 0, -0.5], inertia=[0.05, 0.05, 1e-5])
m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0], position=0.8)
m.add_actuator("spring", joint="hinge", torque="-k*angle - c*rate")
m.add_output("angle", joint="hinge")
m.add_output("rate", joint_velocity="hinge")
m.set_simulation(step=0.005, end=3)
bar = m.compile()


def angle(k: float, c: float) -> Floats:
    return np.asarray(bar.run(inputs={"k": k, "c": c})["angle"])


# %% [markdown]
# What was measured is made here by numbers that the search does not know, with a noise of 5 mrad.
# %%
TRUE, NOISE = np.array([12.3, 0.21]), 5e-3
measured = angle(*TRUE) + NOISE * np.random.default_rng(0).standard_normal(601)


def off(p: Floats) -> Floats:
    return (angle(*p) - measured) / NOISE


fit: Any = least_squares(off, x0=[5, 0.05], bounds=([0, 0], [100, 10]), x_scale=[10, 0.1])
deviation = np.sqrt(np.diag(np.linalg.inv(fit.jac.T @ fit.jac)))
for name, found, sigma, true in zip("kc", fit.x, deviation, TRUE, strict=True):
    print(f"{name} = {found:.4f} ± {sigma:.4f}, in truth {true}")
print(f"{fit.nfev} steps of the search; residuals of {np.std(fit.fun):.2f} times the noise")

measured, noisy = angle(*TRUE), measured
exact: Any = least_squares(off, x0=[5, 0.05], x_scale=[10, 0.1], xtol=1e-12)
print(f"without noise: off by {np.abs(exact.x / TRUE - 1).max():.1e}")

time = 0.005 * np.arange(601)
figure, axes = plt.subplots()
axes.plot(time, noisy, ".", ms=2, label="measured")
axes.plot(time, angle(5, 0.05), lw=1, label="first guess")
axes.plot(time, angle(*fit.x), lw=1, label="found")
axes.set(xlabel="time, s", ylabel="angle, rad")
axes.legend()
figure.savefig("identified.png")

# %% [markdown]
# ## Dampers for a soft ride
#
# The Iltis of [iltis.py](iltis.py) drives over the stairs of its benchmark, 0.1 m each. What do further dampers between
# its axles and its chassis have to be, front and rear, for the least vertical acceleration on the way down?
# %%
sys.path.insert(0, "examples/python")
from iltis import vehicle  # noqa: E402

m = vehicle(stairs=0.1)
for end, x in {"front": 0.97, "rear": -1.047}.items():
    m.add_parameter(end, 0.0, min=0, max=20000, tunable=True)  # N s/m
    for side, y in {"left": 1, "right": -1}.items():
        m.add_spring(
            f"further.{end}_{side}",
            between=[f"{end}_{side}.axle", "chassis"],
            at=[[x, 0.615 * y, 0.356], [x, 0.5 * y, 0.8]],
            damping=f"{end}*v",
        )
m.add_output("acceleration", acceleration="chassis", component="z")
car = m.compile()


def comfort(values: Any) -> float:
    """Root mean square of the chassis' vertical acceleration, from 2 s on, m/s²."""
    front, rear = values
    run = car.run(inputs={"front": front, "rear": rear}, until=7)
    return float(np.sqrt(np.mean(run["acceleration"][run.time > 2] ** 2)))


tuned = minimize(
    comfort,
    x0=[1000, 1000],
    bounds=[(0, 20000)] * 2,
    method="Nelder-Mead",
    options={"initial_simplex": [[1000, 1000], [3000, 1000], [1000, 3000]], "xatol": 200, "fatol": 0.01},
)
print(f"without: {comfort([0, 0]):.2f} m/s²")
print(f"front {tuned.x[0]:.0f}, rear {tuned.x[1]:.0f} N s/m: {tuned.fun:.2f} m/s², after {tuned.nfev} runs")

# %% [markdown]
# Is that the best there is? A sweep looks at the whole range, on all cores.
# %%
GRID = [0.0, 1000.0, 2000.0, 3500.0, 6000.0]


def late(history: Any) -> float:
    return float(np.sqrt(np.mean(np.asarray(history)[201:] ** 2)))


seen = mimbre.sweep(car, {"front": GRID, "rear": GRID}, outputs=["acceleration"], reduce=late, until=7)
print(seen["acceleration"].to_pandas().round(2))
print("none of these is better:", bool(tuned.fun < seen["acceleration"].min()))
figure, axes = plt.subplots()
lines = axes.contour(GRID, GRID, seen["acceleration"].T, levels=12)
axes.clabel(lines)
axes.plot(*tuned.x, "kx")
axes.set(xlabel="front, N s/m", ylabel="rear, N s/m", title="vertical acceleration, m/s²")
figure.savefig("comfort.png")

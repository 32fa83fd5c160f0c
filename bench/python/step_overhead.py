"""What a step costs more when Python makes it: CPU time of steps with inputs set and three channels read, over that of
the same steps in C++ alone, which neither set nor read."""

import time
from collections.abc import Callable

import mimbre

STEPS, REPEATS = 20_000, 15

m = mimbre.ModelBuilder("Pendulum")
m.add_input("torque", 0.0)
m.add_body("bar", mass=0.6, com=[0.5, 0, 0], inertia=[1e-5, 0.05, 0.05])
m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
m.add_actuator("motor", joint="hinge", torque="torque")
m.add_output("angle", joint="hinge")
m.add_output("rate", joint_velocity="hinge")
m.add_output("z", position="bar", component="z")
sim = m.compile().simulation(step=0.001)
torque, channels = sim.input("torque"), [sim.channel(name) for name in ("angle", "rate", "z")]
a, b, c = channels


def alone() -> None:
    sim.step(STEPS)


def bare() -> None:
    step = sim.step
    for _ in range(STEPS):
        step()


def handles() -> None:
    step = sim.step
    for _ in range(STEPS):
        torque.value = 0.1
        step()
        a.value, b.value, c.value  # noqa: B018


def arrays() -> None:
    step, u, y = live.step, live_u, live_y
    for _ in range(STEPS):
        u[0] = 0.1
        step()
        y[0], y[1], y[2]


live = sim.clone()
live_u, live_y = live.input_array(["torque"]), live.channel_array(["angle", "rate", "z"])


def best(work: Callable[[], None]) -> float:
    """Of several times, µs a step."""
    times = []
    for _ in range(REPEATS):
        start = time.thread_time()
        work()
        times.append(time.thread_time() - start)
    return min(times) / STEPS * 1e6


cpp = best(alone)
print(f"C++ step                                     {cpp:6.2f} µs")
for name, work in {
    "step() of Python": bare,
    "an input set, three channels read, by handle": handles,
    "the same by arrays": arrays,
}.items():
    print(f"{name:44} {best(work) - cpp:+6.2f} µs")

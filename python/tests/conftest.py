"""What the tests share."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import mimbre
import pytest

top = Path(__file__).resolve().parents[2]


@pytest.fixture
def examples() -> Path:
    return top / "examples"


def made_pendulum() -> mimbre.Model:
    """One coordinate, one output `angle`, an input and a tunable parameter that turn it."""
    m = mimbre.ModelBuilder("Pendulum")
    m.add_parameter("k", 2.0, min=0, max=10, tunable=True)
    m.add_input("torque", 0.0, range=[-1, 1])
    m.add_body("bar", mass=0.6, com=[0.5, 0, 0], inertia=[1e-5, 0.05, 0.05])
    m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    m.add_actuator("motor", joint="hinge", torque="torque - k*angle")
    m.add_output("angle", joint="hinge")
    m.add_output("rate", joint_velocity="hinge")
    m.add_output("z", position="bar", component="z")
    m.set_simulation(step=0.01, end=2)
    return m.compile()


@pytest.fixture(scope="session")
def pendulum() -> mimbre.Model:
    return made_pendulum()


def program(*arguments: object, code: int = 0) -> str:
    """What `mimbre` prints, and that it ends with this exit code."""
    command = [sys.executable, "-m", "mimbre", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stderr
    return done.stdout


@pytest.fixture(autouse=True, scope="session")
def ctrl_c() -> None:
    """Where the tests run in the background, shells have it ignored."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True)
def same_environment() -> Iterator[None]:
    """Dask sets how many threads BLAS takes, on which the last digits of reductions depend."""
    before = dict(os.environ)
    yield
    os.environ.clear()
    os.environ.update(before)


@pytest.fixture
def rod() -> str:
    """A rod on a hinge that a torque from outside turns."""
    return """
mimbre: 1
gravity: [0, 0, -9.81]
inputs:
  torque: {unit: N m, range: [-50, 50]}
bodies:
  rod: {mass: 1, com: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1]}
joints:
  hinge: {type: revolute, between: [ground, rod], at: [0, 0, 0], axis: [0, 1, 0]}
actuators:
  motor: {joint: hinge, torque: torque}
outputs:
  - {name: angle, joint: hinge}
simulation: {step: 0.002, end: 1}
"""

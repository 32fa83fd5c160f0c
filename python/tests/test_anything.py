"""Everything is called with anything: what is wrong is an exception, and never the end of the process.

Run by itself, `python python/tests/test_anything.py SECONDS`, it goes on for so long, with new arguments each time."""

from __future__ import annotations

import ctypes
import faulthandler
import os
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import mimbre
import mimbre.gym
import numpy as np
import pytest
import scipy.sparse
from conftest import made_pendulum
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

Calls = dict[str, Callable[..., object]]

shapes = st.lists(st.integers(0, 4), max_size=3)
NUMBERS = st.one_of(
    st.floats(),
    st.integers(-3, 50),
    st.integers(),
    st.sampled_from([0.0, -0.0, 1e-320, 1e308, float("nan"), float("inf"), 2**31, 2**63, 2**64, np.float32(1), True]),
)
ARRAYS = st.one_of(
    st.builds(np.zeros, shapes),
    st.builds(np.ones, shapes, st.sampled_from(["f4", "f8", "i8", "c16", "O", "U3", "?", ">f8"])),
    st.builds(
        lambda n, bad: np.where(np.eye(n) > 0, bad, 1.0), st.integers(0, 6), NUMBERS.filter(lambda x: abs(x) < 1e300)
    ),
    st.builds(lambda n: np.eye(n)[::2, ::-1], st.integers(1, 6)),
    st.builds(lambda n: scipy.sparse.eye_array(n, format="csr"), st.integers(0, 12)),
)
NAMES = st.one_of(
    st.text(max_size=8),
    st.sampled_from(
        ["", "bar", "hinge", "angle", "torque", "k", "motor", "ground", "group:all", "x" * 5000, "\0", "\ud800"]
    ),
)
LEAVES = st.one_of(
    st.none(),
    NUMBERS,
    NAMES,
    ARRAYS,
    st.binary(max_size=8),
    st.complex_numbers(),
    st.sampled_from([object(), print, mimbre]),
)
ANYTHING = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.tuples(inner, inner), st.dictionaries(NAMES, inner, max_size=3)
    ),
    max_leaves=6,
)


def within(value: Any, most: float) -> Any:
    """Numbers that only take long are cut."""
    return min(value, most) if isinstance(value, int | float) else value


def built(name: Any, add: str, keys: dict[str, Any]) -> object:
    m = mimbre.ModelBuilder("anything")
    m.add_parameter("k", 2.0, min=0, max=10, tunable=True)
    m.add_input("torque", 0.0)
    m.add_body("bar", mass=0.6, com=[0.5, 0, 0], inertia=[1e-5, 0.05, 0.05])
    m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    m.add_output("angle", joint="hinge")
    getattr(m, add)(name, **keys)
    return m.compile().run(until=0.02, step=0.01)


RIGHT: dict[str, dict[str, Any]] = {
    "add_body": {"mass": 1, "com": [0, 0, 1], "inertia": [1, 1, 1]},
    "add_frame": {"on": "bar", "at": [0, 0, 0]},
    "add_joint": {"type": "spherical", "between": ["ground", "bar"], "at": [1, 0, 0]},
    "add_spring": {"between": ["ground", "bar"], "at": [[0, 0, 1], [1, 0, 0]], "elastic": {"stiffness": 100}},
    "add_bushing": {"between": ["ground", "bar"], "at": [0, 0, 0], "stiffness": [1, 1, 1, 1, 1, 1]},
    "add_gas_spring": {"between": ["ground", "bar"], "at": [[0, 0, 1], [1, 0, 0]]},
    "add_load": {"on": "bar", "at": [0, 0, 0], "force": [0, 0, 1]},
    "add_actuator": {"joint": "hinge", "torque": "torque - k*angle"},
    "add_law": {"joint": "hinge", "torque": lambda t, x, v: -x},
    "add_output": {"joint": "hinge"},
    "add_signal": {"value": "t"},
    "add_material": {"youngs_modulus": 1},
    "place": {"part": lambda part: None, "at": [0, 0, 0]},
}
REDUCTION = {
    "stiffness": np.zeros((6, 6)),
    "mass": np.eye(6),
    "nodes": np.array([[0.0, 0, 0], [1, 0, 0]]),
    "interfaces": {"end": [0]},
    "dofs": np.array([(node, k) for node in (0, 1) for k in (0, 1, 2)]),
    "modes": 1,
    "user_modes": None,
    "loads": None,
    "materials": None,
    "damping": 0.0,
}


def calls(pendulum: mimbre.Model, folder: Path, data: st.DataObject) -> Calls:
    """What can be called, with arguments that are right but for some."""

    def drawn() -> Any:
        return data.draw(ANYTHING)

    def number() -> Any:
        return data.draw(NUMBERS)

    def keys(right: dict[str, Any], *kept: str) -> dict[str, Any]:
        changed = {name: value for name, value in right.items() if name in kept or data.draw(st.integers(0, 9))}
        for name in data.draw(st.lists(st.sampled_from(sorted(right)), max_size=2)):
            changed[name] = drawn()
        return changed

    simulation = pendulum.simulation()
    run = pendulum.run(until=0.02)
    add = data.draw(st.sampled_from(sorted(RIGHT)))
    return {
        "from_file": lambda: mimbre.Model.from_file(drawn()),
        "from_text": lambda: mimbre.Model.from_text(drawn(), k=drawn()),
        "from_urdf": lambda: mimbre.Model.from_urdf(drawn(), packages=drawn()),
        "with": lambda: pendulum.run(until=within(drawn(), 0.05), step=within(drawn(), 1), rho=drawn(), xi=drawn()),
        "inputs": lambda: pendulum.run(inputs=drawn(), until=0.02),
        "input": lambda: pendulum.run(inputs={"torque": drawn(), "k": drawn()}, until=0.02),
        "table": lambda: pendulum.run(inputs={"torque": (drawn(), drawn())}, until=0.02),
        "function": lambda: pendulum.run(inputs={"torque": lambda t: drawn()}, until=0.02),
        "progress": lambda: pendulum.run(progress=drawn(), until=0.02),
        "method": lambda: pendulum.run(formulation=drawn(), integrator=drawn(), tolerance=drawn(), until=0.02),
        "step": lambda: simulation.step(within(drawn(), 100)),
        "step_until": lambda: simulation.step_until(within(drawn(), 1)),
        "restore": lambda: simulation.restore(drawn()),
        "restore changed": lambda: restored(pendulum, simulation.save(), data),
        "input of": lambda: simulation.input(drawn()),
        "channel of": lambda: simulation.channel(drawn()),
        "set": lambda: setattr(simulation.input("torque"), "value", drawn()),
        "set and step": lambda: (setattr(simulation.input("k"), "value", number()), simulation.step(3)),
        "set array": lambda: (
            simulation.input_array(["torque", "k"]).__setitem__(slice(None), drawn()),
            simulation.step(),
        ),
        "input array": lambda: simulation.input_array(drawn()),
        "channel array": lambda: simulation.channel_array(drawn()),
        "pose": lambda: simulation.pose(drawn()),
        "channel": lambda: run[drawn()],
        "poses": lambda: run.poses(drawn()),
        "open": lambda: mimbre.Run.open(drawn()),
        "plot": lambda: run.plot(drawn()),
        "show": lambda: run.show(drawn())._repr_html_(),
        "export": lambda: run.export(folder / "vtk", instants=drawn(), progress=drawn()),
        "report": lambda: mimbre.report(drawn(), folder / "page.html"),
        "reports": lambda: mimbre.report({drawn(): run, drawn(): drawn()}, folder / "page.html"),
        "build": lambda: built(data.draw(NAMES), add, keys(RIGHT[add])),
        "build as": lambda: built(drawn(), add, RIGHT[add]),
        "simulate as": lambda: mimbre.ModelBuilder(drawn()).set_simulation(step=drawn(), end=drawn()),
        "law": lambda: mimbre.ModelBuilder().add_law(
            "law", joint="hinge", torque=drawn(), signals=drawn(), states=drawn(), stores=drawn()
        ),
        "law gives": lambda: built("law", "add_law", {"joint": "hinge", "torque": lambda *_: drawn()}),
        "law with states": lambda: built(
            "law", "add_law", {"joint": "hinge", "torque": lambda *_: (drawn(), drawn()), "states": [0.0, 1.0]}
        ),
        "compiled law": lambda: built(
            "law", "add_law", {"joint": "hinge", "torque": ctypes.CFUNCTYPE(None)(), "signals": drawn()}
        ),
        "reduce": lambda: mimbre.reduce(drawn(), interfaces=drawn(), modes=within(drawn(), 5)),
        "reduce matrices": lambda: mimbre.reduce(**keys(REDUCTION)),
        "body": lambda: mimbre.ReducedBody.open(drawn()),
        "interface": lambda: mimbre.reduce(**REDUCTION | {"interfaces": {"end": mimbre.Interface(drawn(), drawn())}}),
        "static": lambda: mimbre.static(data.draw(st.sampled_from([pendulum, run, None])), rho=drawn()),
        "verify": lambda: pendulum.verify(until=within(drawn(), 0.05), refine=drawn(), step=0.01),
        "compare": lambda: mimbre.compare(run, drawn()),
        "stress": lambda: mimbre.stress(run, drawn(), spots=drawn(), apart=drawn()),
        "select": lambda: mimbre.select(pendulum, drawn(), error=drawn()),
        "inertia terms": lambda: mimbre.inertia_terms(
            pendulum, error=drawn(), outputs=drawn(), until=drawn(), measure=drawn()
        ),
        "convert": lambda: mimbre.convert(drawn(), drawn()),
        "sweep": lambda: mimbre.sweep(pendulum, drawn(), outputs=["angle"], until=0.02),
        "sweep as": lambda: mimbre.sweep(pendulum, {"k": [1, 2]}, outputs=drawn(), reduce=drawn(), until=0.02),
        "sweep with": lambda: mimbre.sweep(pendulum, {"k": drawn()}, inputs=drawn(), until=0.02),
        "gym": lambda: mimbre.gym.make(
            pendulum, actions=drawn(), observations=drawn(), reward=drawn(), time_limit=drawn(), skip=within(drawn(), 9)
        ),
        "gym as": lambda: mimbre.gym.make_vec(
            pendulum, within(drawn(), 3), actions=["torque"], observations=["angle"], reward=drawn(), randomise=drawn()
        ).reset(seed=drawn()),
        "samples": lambda: mimbre.samples(drawn(), within(drawn(), 100), drawn()),
        "simulation": lambda: mimbre.Simulation(drawn(), step=drawn()),
        "unmade": lambda: mimbre.Simulation.__new__(mimbre.Simulation).step(),
        "unmade state": lambda: mimbre.Simulation.__new__(mimbre.Simulation).restore(b""),
        "unmade model": lambda: mimbre.Model.__new__(mimbre.Model).run(),
        "unmade run": lambda: mimbre.Run.__new__(mimbre.Run)["angle"],
    }


def restored(pendulum: mimbre.Model, state: bytes, data: st.DataObject) -> None:
    """A state with some bytes changed."""
    changed = bytearray(state)
    for _ in range(data.draw(st.integers(1, 4))):
        changed[data.draw(st.integers(0, len(changed) - 1))] = data.draw(st.integers(0, 255))
    simulation = pendulum.simulation()
    simulation.restore(bytes(changed[: data.draw(st.integers(0, len(changed)))]))
    simulation.step(3)


def attack(pendulum: mimbre.Model, folder: Path, data: st.DataObject) -> str:
    """One call. Returns which it was, and how it ended."""
    all_calls = calls(pendulum, folder, data)
    name = data.draw(st.sampled_from(sorted(all_calls)))
    outcome = "answered"
    try:
        all_calls[name]()
    except Exception as error:
        outcome = type(error).__name__
    plt.close("all")
    return f"{name}: {outcome}"


@settings(max_examples=400, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
@pytest.mark.filterwarnings("ignore")
def test_no_argument_ends_the_process(pendulum, tmp_path, data, monkeypatch):
    monkeypatch.chdir(tmp_path)
    attack(pendulum, tmp_path, data)


def attack_for(seconds: float) -> Counter[str]:
    """Returns how many calls ended how."""
    faulthandler.enable()
    warnings.simplefilter("ignore")
    pendulum = made_pendulum()
    end = time.monotonic() + seconds
    outcomes: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)

        @settings(max_examples=1000, deadline=None, suppress_health_check=list(HealthCheck), database=None)
        @given(data=st.data())
        def many(data: st.DataObject) -> None:
            began = time.monotonic()
            outcome = attack(pendulum, Path(folder), data)
            outcomes[outcome] += 1
            if time.monotonic() - began > 10:
                print(f"{outcome} took {time.monotonic() - began:.0f} s", flush=True)

        while time.monotonic() < end:
            many()
    return outcomes


if __name__ == "__main__":
    all_outcomes = attack_for(float(sys.argv[1]))
    for outcome, count in sorted(all_outcomes.items()):
        print(f"{count:8} {outcome}")
    print(f"{sum(all_outcomes.values())} calls, the process lives")

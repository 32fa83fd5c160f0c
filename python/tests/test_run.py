"""Runs: the same bits as the program's, arrays without copies, labels, other forms."""

from __future__ import annotations

import concurrent.futures as futures
import copy
import multiprocessing
import os
import pickle
import signal
import threading
from pathlib import Path

import matplotlib as mpl
import mimbre
import numpy as np
import pytest
from conftest import program

mpl.use("Agg")


@pytest.mark.parametrize(
    ("model", "parameters", "options"),
    [
        ("tutorial/pendulum.yaml", {}, {}),
        ("pendulum/flexible.yaml", {"length": 1.2, "elements": 8}, {"until": 0.5, "step": 0.004, "rho": 0.6}),
        ("iltis/vehicle.yaml", {"stairs": 0.15}, {"until": 0.3}),
        (
            "double-four-bar/mechanism.yaml",
            {},
            {"until": 0.5, "formulation": "natural", "integrator": "newmark", "xi": -0.1},
        ),
    ],
)
def test_a_run_is_that_of_the_program_to_the_bit(examples, tmp_path, model, parameters, options):
    path = str(examples / model)
    words = {"xi": "integrator-xi"}
    arguments = [f"--set={name}={value}" for name, value in parameters.items()]
    arguments += [f"--{words.get(name, name)}={value}" for name, value in options.items()]
    program("run", path, "--quiet", "-o", tmp_path / "program.h5", *arguments)
    run = mimbre.Model.from_file(path, **parameters).run(**options)
    run.save(tmp_path / "python.h5")
    assert (tmp_path / "python.h5").read_bytes() == (tmp_path / "program.h5").read_bytes()

    again = mimbre.Run.open(tmp_path / "program.h5")
    assert list(again) == list(run)
    assert all(np.array_equal(again[name], run[name], equal_nan=True) for name in run)
    assert again.summary.items() <= run.summary.items()


def test_a_pendulum_swings_as_its_closed_form_says():
    """A compound pendulum of small angle: ω² = m g l / (I + m l²)."""
    m = mimbre.ModelBuilder()
    m.add_body("bar", mass=0.6, com=[0, 0, -0.5], inertia=[0.05, 0.05, 1e-5])
    m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0], position=1e-3)
    m.add_output("angle", joint="hinge")
    run = m.compile().run(until=3, step=1e-3, integrator="newmark")
    frequency = np.sqrt(0.6 * 9.81 * 0.5 / (0.05 + 0.6 * 0.5**2))
    assert run["angle"] == pytest.approx(1e-3 * np.cos(frequency * run.time), abs=2e-8)


def test_channels_are_the_runs_own_memory(pendulum):
    run = pendulum.run()
    a, b = run["angle"], run["angle"]
    assert a.__array_interface__["data"][0] == b.__array_interface__["data"][0]
    assert run.time.__array_interface__["data"][0] == run.time.__array_interface__["data"][0]
    assert not a.flags.owndata
    assert not a.flags.writeable
    assert a.flags.c_contiguous
    last = a.copy()
    del run, b
    assert np.array_equal(a, last)  # the memory stays as long as the array does


def test_channels_know_what_they_are(pendulum):
    run = pendulum.run()
    angle = run["angle"]
    assert (angle.name, angle.unit) == ("angle", "rad")
    assert "hinge" in angle.meaning
    assert angle[5:10].unit == "rad"
    assert type(np.sin(angle)) is np.ndarray
    assert type(angle + 1) is np.ndarray
    assert isinstance(angle.max(), float)
    assert run.units["rate"] == "rad/s"
    assert len(run) == len(list(run)) == len(run.meanings)
    assert "angle" in run
    assert "angel" not in run
    assert run.energy["kinetic"].unit == "J"
    assert run.poses("bar").shape == (len(run.time), 7)


def test_other_forms(pendulum, tmp_path):
    run = pendulum.run()
    table = run.to_pandas()
    assert table["angle"].to_numpy() == pytest.approx(run["angle"])
    assert table.index.to_numpy() == pytest.approx(run.time)
    assert table.attrs["units"]["angle"] == "rad"
    data = run.to_xarray()
    assert data["angle"].attrs["units"] == "rad"
    assert float(data["angle"].sel(time=1.0, method="nearest")) == run["angle"][100]
    axes = run.plot("angle", "rate")
    assert len(axes.lines) == 2
    run.report(tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Pendulum" in page
    assert run.show()._repr_html_().startswith("<iframe srcdoc=")


def test_inputs_are_numbers_tables_or_functions(pendulum):
    constant = pendulum.run(inputs={"torque": 0.5})
    table = pendulum.run(inputs={"torque": ([0, 1, 2], [0.5, 0.5, 0.5])})
    function = pendulum.run(inputs={"torque": lambda t: 0.5})
    for run in (table, function):
        assert np.array_equal(run["angle"], constant["angle"])
    times = []
    pendulum.run(inputs={"torque": lambda t: times.append(t) or 0.0, "k": 1}, until=0.05)
    assert times == pytest.approx([0, 0, 0.01, 0.02, 0.03, 0.04])


def test_inputs_are_read_from_tables_in_files(pendulum, tmp_path):
    constant = pendulum.run(inputs={"torque": ([0, 0.5], [0.5, -0.5]), "k": 2})
    one, all_ = tmp_path / "one.csv", tmp_path / "all.csv"
    one.write_text("value;t [s]\r\n0,5;0\r\n-0,5;0,5\r\n")
    all_.write_text("t,torque,k\n0,0.5,2\n0.5,-0.5,\n")
    for inputs in ({"torque": one, "k": 2}, {"torque": str(all_), "k": 2}, all_, str(all_)):
        assert np.array_equal(pendulum.run(inputs=inputs)["angle"], constant["angle"])
    one.write_text("t,value\n0,nan\n")
    with pytest.raises(mimbre.InputError, match=r"one.csv:2:1: the value of 'torque': 'nan' is not a finite number"):
        pendulum.run(inputs={"torque": one})
    with pytest.raises(mimbre.UnknownName, match="torque"):
        pendulum.run(inputs={"torqe": all_})
    with pytest.raises(mimbre.InputError, match="missing"):
        pendulum.run(inputs=tmp_path / "missing.csv")


LATCH = """
mimbre: 1
parameters: {F: {value: 1, tunable: true}}
inputs: {u: 0, ramp: {start: 0, hold: linear}}
bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0]}}
actuators: {a: {joint: j, force: "F + u + ramp"}}
events: {half: {when: t, crosses: 0.5, direction: rising, set: {F: 0, u: 0, ramp: 0}}}
outputs: [{name: v, joint_velocity: j}]
simulation: {step: 0.01, end: 1}
"""


@pytest.mark.parametrize(
    ("inputs", "impulse"),
    [
        ({}, 0.5),
        ({"F": 1.0}, 0.5),  # as the file's own value
        ({"F": 3.0, "u": 2.0, "ramp": 1.0}, 3.0),
        ({"F": ([0.0, 0.2], [1.0, 3.0])}, 0.2 + 0.9),  # a table that has ended holds no longer
        ({"F": ([0.0, 0.8], [1.0, 3.0])}, 0.5 + 0.6),  # the event wins until the next point
        ({"F": ([0.7], [2.0])}, 1.0 + 0.6),  # before its first point, too
        ({"ramp": ([0.0, 0.2], [0.0, 2.0])}, 0.5 + 0.2 + 0.6),
        ({"ramp": ([0.0, 1.0], [2.0, 2.0])}, 0.5 + 2.0),  # on its lines the table wins, and a function always does
        ({"F": lambda t: 2.0}, 2.0),
    ],
)
def test_what_an_event_sets_lasts_until_an_input_says_otherwise(inputs, impulse):
    """One kilogram has the force's impulse; the event at 0.5 s ends the force."""
    model = mimbre.Model.from_text(LATCH)
    assert model.run(inputs=inputs)["v"][-1] == pytest.approx(impulse, abs=0.035)  # a step or two later
    if all(isinstance(value, float) for value in inputs.values()):
        sim = model.simulation(inputs=inputs)
        sim.step_until(1)
        assert model.run(inputs=inputs)["v"][-1] == sim.channel("v").value


def test_a_resumed_run_keeps_what_an_event_set(tmp_path):
    """Also where it is resumed after the event, between two points of the table."""
    (tmp_path / "latch.yaml").write_text(LATCH)
    (tmp_path / "force.csv").write_text("t,F,ramp\n0,1,0\n0.3,3,1\n0.9,2,\n")
    options = [tmp_path / "latch.yaml", "--input", tmp_path / "force.csv", "-q", "--csv"]
    program("run", *options, tmp_path / "whole.csv")
    program("run", *options, tmp_path / "part.csv", "--until", 0.6, "--save-state", tmp_path / "state")
    program("run", *options, tmp_path / "part.csv", "--resume", tmp_path / "state")
    whole = (tmp_path / "whole.csv").read_text()
    assert (tmp_path / "part.csv").read_text() == whole
    assert float(whole.split(",")[-1]) == pytest.approx(0.3 + 0.6 + 0.15 + 0.2 + 0.2, abs=0.02)


def test_what_a_function_raises_comes_through(pendulum):
    def torque(t):
        if t > 0.1:
            raise LookupError("nothing known")
        return 0.0

    with pytest.raises(LookupError, match="nothing known"):
        pendulum.run(inputs={"torque": torque})
    with pytest.raises(ValueError, match=r"'torque'.*gave nan; a finite number"):
        pendulum.run(inputs={"torque": lambda t: float("nan")})
    with pytest.raises(ValueError, match=r"gave 'x'"):
        pendulum.run(inputs={"torque": lambda t: "x"})


def test_ctrl_c_stops_a_run_with_what_it_had(pendulum):
    with pytest.raises(mimbre.Interrupted, match="interrupted at t = ") as stopped:
        pendulum.run(until=1e4, progress=lambda t: t > 0 and os.kill(os.getpid(), signal.SIGINT))
    run = stopped.value.run
    assert 0 < run.time[-1] < 1e4
    assert len(run["angle"]) == len(run.time)
    assert run.summary["status"] == "interrupted"


def test_other_threads_go_on_during_a_run(pendulum):
    ticks = []
    done = threading.Event()

    def tick():
        while not done.wait(1e-3):
            ticks.append(0)

    thread = threading.Thread(target=tick)
    thread.start()
    pendulum.run(until=500)
    done.set()
    thread.join()
    assert len(ticks) > 3


def test_progress_is_told(pendulum):
    times = []
    pendulum.run(until=2000, progress=times.append)
    assert times == sorted(times)
    assert len(times) > 0


def test_a_run_that_fails_has_what_it_had(examples):
    m = mimbre.ModelBuilder()
    m.add_body("bar", mass=1, com=[0.5, 0, 0], inertia=[1e-3, 0.1, 0.1])
    m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    m.add_actuator("motor", joint="hinge", torque="t < 0.1 ? 0 : sqrt(0.1 - t)")
    m.add_output("angle", joint="hinge")
    with pytest.raises(mimbre.SimulationError) as failed:
        m.compile().run(until=1)
    assert failed.value.run is not None
    assert failed.value.run.time[-1] == pytest.approx(0.1, abs=0.011)


def failing(how: str) -> float:
    """Its torque is no number from 0.1 s on, or its input's function raises there."""
    m = mimbre.ModelBuilder()
    m.add_input("push", 0.0)
    m.add_body("bar", mass=1, com=[0.5, 0, 0], inertia=[1e-3, 0.1, 0.1])
    m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    m.add_actuator("motor", joint="hinge", torque="push + (t < 0.1 ? 1 : sqrt(0.1 - t))")
    m.add_output("angle", joint="hinge")

    def push(t: float) -> float:
        if how == "raises" and t > 0.05:
            raise LookupError("nothing known")
        return 0.0

    return float(m.compile().run(until=1, inputs={"push": push})["angle"][-1])


@pytest.mark.parametrize(
    ("how", "kind", "end"), [("fails", mimbre.SimulationError, 0.1), ("raises", LookupError, 0.05)]
)
def test_a_run_that_fails_in_another_process_has_its_reason_and_what_it_had(how, kind, end):
    with pytest.raises(kind) as here:
        failing(how)
    with futures.ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        error = pool.submit(failing, how).exception()
    assert isinstance(error, kind)
    assert str(error) == str(here.value)
    assert error.run.time[-1] == pytest.approx(end, abs=0.011)
    assert np.array_equal(error.run["angle"], here.value.run["angle"])


def test_a_pickled_run_is_the_same(pendulum, tmp_path):
    run = pendulum.run(inputs={"torque": 0.5})
    for other in (pickle.loads(pickle.dumps(run)), copy.deepcopy(run)):
        assert other.summary == run.summary
        assert list(other) == list(run)
        for name in run:
            assert np.array_equal(other[name], run[name], equal_nan=True)
            assert (other[name].unit, other[name].meaning) == (run[name].unit, run[name].meaning)
        for one, file in ((run, "a.h5"), (other, "b.h5")):
            one.save(tmp_path / file)
        assert (tmp_path / "a.h5").read_bytes() == (tmp_path / "b.h5").read_bytes()
    stopped = pickle.loads(pickle.dumps(mimbre.Interrupted("stopped", run)))
    assert str(stopped) == "stopped"
    assert np.array_equal(stopped.run["angle"], run["angle"])
    data = mimbre.sweep(pendulum, {"k": [1, 2]})
    assert pickle.loads(pickle.dumps(mimbre.SweepInterrupted("stopped", data))).data.equals(data)


def test_files_are_read(tmp_path):
    with pytest.raises(mimbre.InputError, match=r"no such file|does not exist"):
        mimbre.Run.open(tmp_path / "none.h5")
    Path(tmp_path / "bad.h5").write_text("no results")
    with pytest.raises(mimbre.InputError):
        mimbre.Run.open(tmp_path / "bad.h5")

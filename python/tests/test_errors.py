"""Mistakes that people make, and what they are told."""

from __future__ import annotations

import pickle
from pathlib import Path

import mimbre
import numpy as np
import pytest
from mimbre import _core


def body(m: mimbre.ModelBuilder, **keys):
    m.add_body("bar", **{"mass": 1, "com": [0.5, 0, 0], "inertia": [0.01, 0.1, 0.1], **keys})
    m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    return m.compile()


M = mimbre.Model
PENDULUM = "examples/tutorial/pendulum.yaml"
MISTAKES = {
    "a file that is not there": (lambda p, f: M.from_file("pendulumm.yaml"), "there is no such file"),
    "no file's name": (lambda p, f: M.from_file(5), "a file's name is needed, not 5 (int)"),
    "a parameter that is not there": (lambda p, f: M.from_file(f, lenght=2), "did you mean 'length'?"),
    "a parameter out of range": (lambda p, f: M.from_file(f, length=20), "20 is not a number from 0.1 to 10"),
    "a parameter of the wrong type": (
        lambda p, f: M.from_file(f, length=[1]),
        "a number is needed, not [1] (list)",
    ),
    "no constructor": (lambda p, f: M(), "Model.from_file(path)"),
    "a text as a time": (lambda p, f: p.run(until="5"), "until: a number is needed, not '5' (str)"),
    "a time before the start": (lambda p, f: p.run(until=-1), "until: is -1; a number of seconds from 0"),
    "a time that is none": (lambda p, f: p.run(until=float("nan")), "until: is nan; a finite number"),
    "no step": (lambda p, f: p.run(step=0), "step: is 0; a number of seconds above 0"),
    "a step longer than the run": (
        lambda p, f: p.run(step=3, until=2),
        "give a shorter step or a later until",
    ),
    "a method that is not there": (lambda p, f: p.run(formulation="relativ"), "did you mean 'relative'?"),
    "an option that is not there": (lambda p, f: p.run(integratr="hht"), "did you mean 'integrator'?"),
    "options that contradict": (
        lambda p, f: p.run(integrator="newmark", rho=0.5),
        "rho belongs to generalized_alpha and hht",
    ),
    "a radius out of range": (lambda p, f: p.run(rho=2), "rho: is 2; a number from 0 to 1"),
    "an input that is not there": (lambda p, f: p.run(inputs={"torqe": 1}), "torq"),
    "inputs that are no mapping": (lambda p, f: p.run(inputs=[1]), "inputs: names with values are needed"),
    "an input's list without times": (
        lambda p, f: p.run(inputs={"torque": ([0, 1], [1])}),
        "2 times and 1 values",
    ),
    "an input's times that do not ascend": (
        lambda p, f: p.run(inputs={"torque": ([1, 0], [1, 1])}),
        "times do not increase",
    ),
    "an input that is not finite": (lambda p, f: p.run(inputs={"torque": np.inf}), "input 'torque': is inf"),
    "a channel that is not there": (lambda p, f: p.run()["angel"], "did you mean 'angle'?"),
    "a channel by number": (lambda p, f: p.run()[0], "there is no channel 0"),
    "a handle that is not there": (lambda p, f: p.simulation().channel("angel"), "did you mean 'angle'?"),
    "an input's handle that is not there": (lambda p, f: p.simulation().input("torq"), "torq"),
    "a parameter that no number can be": (
        lambda p, f: mimbre.Model.from_file(f, length=10**400),
        "'length': is too large",
    ),
    "an input that no number can be": (lambda p, f: p.run(inputs={"torque": -(10**400)}), "'torque': is too large"),
    "a sweep over what no number can be": (lambda p, f: mimbre.sweep(p, {"k": [1, 10**400]}), "k: is too large"),
    "back in time": (lambda p, f: p.simulation().step_until(-1), "is not after now"),
    "a mass below zero": (lambda p, f: body(mimbre.ModelBuilder(), mass=-1), "mass"),
    "a mass that is no number": (
        lambda p, f: body(mimbre.ModelBuilder(), mass=float("nan")),
        "body 'bar': mass: is nan",
    ),
    "a unit that does not fit": (lambda p, f: body(mimbre.ModelBuilder(), mass="5 mm"), "mass"),
    "a vector of two": (lambda p, f: body(mimbre.ModelBuilder(), com=[1, 2]), "com"),
    "an object in a model": (
        lambda p, f: body(mimbre.ModelBuilder(), com=object()),
        "is no number, text, list or map",
    ),
    "no interface": (lambda p, f: mimbre.reduce("x.inp", interfaces={}), "at least one is needed"),
    "a mesh that is not there": (lambda p, f: mimbre.reduce("x.inp", interfaces={"a": "set:a"}), "x.inp"),
    "matrices without nodes": (
        lambda p, f: mimbre.reduce(stiffness=np.eye(3), mass=np.eye(3), interfaces={"a": [0]}),
        "stiffness, mass and nodes are needed",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_told(pendulum, examples, mistake):
    make, said = MISTAKES[mistake]
    with pytest.raises(mimbre.InputError) as wrong:
        make(pendulum, examples / "tutorial/pendulum.yaml")
    assert said in str(wrong.value)
    assert wrong.value.diagnostics
    assert all(isinstance(d, mimbre.Diagnostic) and d.message for d in wrong.value.diagnostics)


def test_a_mistake_in_a_file_has_its_place(tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text("mimbre: 1\nbodies:\n  bar: {mass: heavy}\n  rod: {mas: 1}\n", encoding="utf-8")
    with pytest.raises(mimbre.InputError) as wrong:
        mimbre.Model.from_file(path)
    places = {(d.file, d.line) for d in wrong.value.diagnostics}
    assert {(str(path), 3), (str(path), 4)} <= places
    again = pickle.loads(pickle.dumps(wrong.value))
    assert again.diagnostics == wrong.value.diagnostics
    assert str(again) == str(wrong.value)


def test_an_unknown_name_is_a_key_error_too(pendulum):
    with pytest.raises(KeyError):
        pendulum.run()["angel"]


def test_names_of_files_may_be_paths(pendulum, tmp_path):
    run = pendulum.run(until=0.1)
    run.save(Path(tmp_path) / "run.h5")
    assert mimbre.Run.open(Path(tmp_path) / "run.h5").title == "Pendulum"


def test_files_are_read_by_another_process_first(pendulum, tmp_path):
    path, helper = tmp_path / "run.h5", tmp_path / "helper"
    pendulum.run(until=0.1).save(path)
    carried = Path(mimbre.__file__).with_name("bin") / "mimbre"
    assert carried.exists()
    helper.write_text("#!/bin/sh\nprintf 'mimbre rehearsal 1\\n'\nkill -SEGV $$\n", encoding="utf-8")
    helper.chmod(0o700)
    try:
        _core.isolate_reading(str(helper))
        with pytest.raises(mimbre.InputError, match="is damaged: it cannot be read to its end"):
            mimbre.Run.open(path)
        _core.isolate_reading("")
        assert mimbre.Run.open(path).title == "Pendulum"
    finally:
        _core.isolate_reading(str(carried))
    assert mimbre.Run.open(path).title == "Pendulum"

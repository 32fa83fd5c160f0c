"""`mimbre sweep`: the study's file, its mistakes, what is printed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import mimbre
import numpy as np
import pytest
from conftest import program, top
from mimbre import study_file
from mimbre.sweep_command import sweep_command
from scipy.stats import qmc

MODEL = """
mimbre: 1
title: Pendulum
parameters:
  k: {value: 2, min: 0, max: 10, tunable: true}
  mass: {value: 0.6, min: 0.1, max: 5}
  bar: {value: long, choices: [long, short]}
inputs: {push: 0, wind: {start: 0, hold: linear}}
bodies: {bar: {mass: mass, com: ["bar == long ? 0.5 : 0.25", 0, 0], inertia: [1.0e-5, 0.05, 0.05]}}
joints: {hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}}
actuators: {motor: {joint: hinge, torque: "push + wind - k*angle"}}
outputs: [{name: angle, joint: hinge}, {name: z, position: bar, component: z}]
simulation: {step: 0.01, end: 0.5}
"""
STUDY = """
study: 1
model: model.yaml
grid: {k: [0.5, 1, 7/2], mass: {from: 0.6, to: 1.2, count: 2}}
outputs: [angle]
reduce: [max, last]
"""


@pytest.fixture
def folder(tmp_path) -> Path:
    (tmp_path / "model.yaml").write_text(MODEL)
    return tmp_path


def study(folder: Path, text: str) -> Path:
    path = folder / "study.yaml"
    path.write_text(text)
    return path


@pytest.fixture
def sweep(capsys):
    """The command in this process, which is quicker than one for each: what it prints, and that it ends so."""

    def run(*arguments: object, code: int = 0) -> str:
        capsys.readouterr()
        found = sweep_command([str(argument) for argument in arguments])
        told = capsys.readouterr()
        assert found == code, told.err
        return told.out if code in (0, 4) else told.err

    return run


@pytest.fixture
def rows(sweep, folder):
    return lambda text: json.loads(sweep(study(folder, text), "--json"))["rows"]


def test_a_grid_gives_the_values_of_sweep(folder, sweep):
    answer = json.loads(sweep(study(folder, STUDY), "--json"))
    assert (answer["status"], answer["runs"], answer["units"]) == ("ok", 6, {"angle": "rad"})
    schema = json.loads((top / "schema/output.schema.json").read_text())["$defs"]["sweep"]
    assert set(answer) == set(schema["required"])
    model = mimbre.Model.from_file(folder / "model.yaml")
    wanted = mimbre.sweep(model, {"k": [0.5, 1, 3.5], "mass": [0.6, 1.2]}, outputs=["angle"], reduce=["max", "last"])
    for row in answer["rows"]:
        assert row["status"] == "ok"
        for reduction in ("max", "last"):
            found = row["values"]["angle"][reduction]
            assert found == float(wanted["angle"].sel(**row["parameters"], reduction=reduction))
    table = sweep(study(folder, STUDY)).splitlines()
    assert table[0].split("  ")[-3:] == ["angle max, rad", "angle last, rad", "status"]
    assert len(table) == 7
    assert float(table[3].split()[2]) == pytest.approx(answer["rows"][2]["values"]["angle"]["max"], rel=1e-5)


def test_numbers_beyond_64_bits_are_numbers(folder, rows):
    found = rows("study: 1\nmodel: model.yaml\noutputs: z\ngrid: {k: [10000000000000000000000, 1]}\n")
    assert [row["status"] for row in found] == ["rejected", "ok"]
    assert found[0]["parameters"] == {"k": 10**22}


def test_lists_tables_and_samples(folder, rows):
    head = "study: 1\nmodel: model.yaml\noutputs: z\n"
    wanted = [{"k": 1, "bar": "long"}, {"k": 2.5, "bar": "short"}]
    (folder / "rows.csv").write_text("k, bar\n1, long\n2.5, short\n")
    for text in ("list: [{k: 1, bar: long}, {k: 2.5, bar: short}]", "list: rows.csv"):
        found = rows(head + text)
        assert [row["parameters"] for row in found] == wanted
        for row in found:
            run = mimbre.Model.from_file(folder / "model.yaml", **row["parameters"]).run()
            assert row["values"]["z"] == {"last": run["z"][-1]}
    ranges = "seed: 3, ranges: {k: [1, 5], mass: [0.5, 1]}"
    for name, sampler in (("latin-hypercube", qmc.LatinHypercube), ("sobol", qmc.Sobol)):
        found = rows(head + f"samples: {{sampler: {name}, count: 4, {ranges}}}")
        points = mimbre.samples(sampler(2, rng=np.random.default_rng(3)), 4, {"k": (1, 5), "mass": (0.5, 1)})
        assert [row["parameters"] for row in found] == points


def test_what_all_runs_have(folder, rows):
    found = rows(
        """
study: 1
model: model.yaml
set: {bar: short}
grid: {mass: 1}
inputs: {push: 0.5, wind: {times: [0, 0.2 s], values: [0, 3]}}
outputs: angle
until: 300 ms
step: 0.005
method: {integrator: newmark, xi: -0.1}
""",
    )
    wanted = mimbre.Model.from_file(folder / "model.yaml", bar="short", mass=1).run(
        until=0.3, step=0.005, integrator="newmark", xi=-0.1, inputs={"push": 0.5, "wind": ([0, 0.2], [0, 3])}
    )
    assert found[0]["values"]["angle"]["last"] == wanted["angle"][-1]


MISTAKES = {
    "model: model.yaml\ngrid: {k: 1}": ":1:1: error: study: 'study: 1' is missing",
    "study: 2\nmodel: model.yaml\ngrid: {k: 1}": ":1:8: error: study: study: version 2 is not known",
    "study: 1\ngrid: {k: 1}": "'model' is missing",
    "study: 1\nmodel: modell.yaml\ngrid: {k: 1}": ":2:8: error: study: model: there is no file",
    "study: 1\nmodel: model.yaml": "one of 'grid', 'list' and 'samples' is needed",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nlist: []": ":4:7: error: study: list: one of 'grid'",
    "study: 1\nmodel: model.yaml\ngird: {k: 1}": "unknown key 'gird' (did you mean 'grid'?)",
    "study: 1\nmodel: model.yaml\ngrid: {k: []}": "a list of values is needed",
    "study: 1\nmodel: model.yaml\ngrid: 5": "names with values are needed, this is a single value",
    "study: 1\nmodel: model.yaml\ngrid: {kk: 1}": ":3:12: error: there is no parameter 'kk'",
    "study: 1\nmodel: model.yaml\ngrid: {k: {from: 1, to: 2}}": "from, to and count are needed",
    "study: 1\nmodel: model.yaml\ngrid: {k: {from: 1, to: 2, count: 1.5}}": "1.5 is not a whole number from 1",
    "study: 1\nmodel: model.yaml\ngrid: {k: {from: 1, to: 2, count: 1e9}}": "is not a whole number from 1 to 1000000",
    "study: 1\nmodel: model.yaml\nlist: [{k: 1}, {mass: 1}]": "has mass, and the first of the list k",
    "study: 1\nmodel: model.yaml\nlist: none.csv": "cannot be read",
    "study: 1\nmodel: model.yaml\nlist: []": "there is no run",
    "study: 1\nmodel: model.yaml\nsamples: {count: 3}": "'sampler' is missing; for example sampler: latin-hypercube",
    "study: 1\nmodel: model.yaml\nsamples: {sampler: sobol, count: 5, seed: 1, ranges: {k: [1, 2]}}": "take 8",
    "study: 1\nmodel: model.yaml\nsamples: {sampler: sobel, count: 4, seed: 1, ranges: {k: [1, 2]}}": "mean 'sobol'",
    "study: 1\nmodel: model.yaml\nsamples: {sampler: sobol, count: 4, seed: 1, ranges: {k: [2, 1]}}": "not above 2",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\noutputs: [angel]": ":4:11: error: there is no channel 'angel'",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nreduce: maximum": ":4:9: error: study: reduce: 'maximum' is not one of",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nreduce: [max, max]": "each reduction is needed once",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nreduce: [max, history]": "stands alone",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nuntil: soon": "a number of seconds is needed, this is 'soon'",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nuntil: -1": "-1 s is no such time; it must be 0 or more",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nstep: 3": ":4:7: error: the step of 3 s is longer than the run",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nstep: 0": "0 s is no such time; it must be above 0",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nmethod: {rho: 2}": ":4:9: error: rho",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nmethod: {integrator: euler}": ":4:9: error: ",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\ninputs: {puhs: 1}": ":4:16: error: there is no input",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\ninputs: {push: {times: [0]}}": "as many times as values",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nset: {masss: 1}": "there is no parameter 'masss'",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nworkers: 0": "0 is not a whole number from 1",
    "study: 1\nmodel: model.yaml\ngrid: {k: 1}\nstore: .": "cannot be used as a sweep's file",
    "study: 1\nstudy: 1": "study",
    MODEL: "this is a model's file",
    "- 5": "keys are needed here",
    "study: [1": "study.yaml:",
    "": "a study starts with 'study: 1'",
}


def test_mistakes_are_told_with_their_place(folder, sweep):
    for text, message in MISTAKES.items():
        assert message in sweep(study(folder, text), code=1), text
    assert "none.yaml: error: the study cannot be read" in sweep(folder / "none.yaml", code=1)


def test_mistakes_of_a_table_have_its_lines(folder, sweep):
    head = "study: 1\nmodel: model.yaml\nlist: rows.csv"
    (folder / "rows.csv").write_text("k, bar\n\n1, long\n\n2.5\n")
    assert "rows.csv:5:1: error: 1 cells, and 2 names" in sweep(study(folder, head), code=1)
    (folder / "rows.csv").write_text("\nk, bar, k\n1, long, 2\n")
    assert "rows.csv:2:1: error: the name 'k' stands twice in the first line" in sweep(study(folder, head), code=1)


def test_a_method_is_checked_as_a_whole(folder, rows, sweep):
    """Its keys may need each other: the model's integrator would not take this rho."""
    path = folder / "model.yaml"
    path.write_text(MODEL.replace("end: 0.5}", "end: 0.5, integrator: {type: hht}}"))
    text = "study: 1\nmodel: model.yaml\ngrid: {k: 1}\noutputs: angle\nmethod: {%s}"
    found = rows(text % "integrator: generalized_alpha, rho: 0.2")
    wanted = mimbre.Model.from_file(path, k=1).run(integrator="generalized_alpha", rho=0.2)
    assert found[0]["values"]["angle"]["last"] == wanted["angle"][-1]
    assert ":5:9: error: " in sweep(study(folder, text % "rho: 0.2"), code=1)


def test_mistakes_as_json(folder, capsys):
    assert sweep_command([str(study(folder, "study: 1")), "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    assert (answer["status"], answer["errors"][0]["line"]) == ("error", 1)


def test_usage_and_the_program_without_python(folder):
    path = study(folder, STUDY)
    program("sweep", code=2)
    program("sweep", path, "--workers", "0", code=2)
    assert "STUDY" in program("sweep", "--help")
    alone = Path(mimbre.__file__).with_name("bin") / "mimbre"
    done = subprocess.run([alone, "sweep", path], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert "comes with the Python package" in done.stderr
    with subprocess.Popen(
        [sys.executable, "-m", "mimbre", "sweep", path], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as closed:
        closed.stdout.close()
        assert closed.wait() == 3
        assert "standard output cannot be written" in closed.stderr.read()


def test_rows_that_fail_are_told(folder, sweep, rows):
    text = STUDY.replace("{from: 0.6, to: 1.2, count: 2}", "[0.6, 50]")
    assert sweep(study(folder, text)).count("rejected") == 3
    sweep(study(folder, text), "--strict", code=4)
    assert "3 of 3 runs rejected" in sweep(study(folder, text.replace("[0.6, 50]", "50")), code=3)
    found = rows(text)
    assert found[1]["values"]["angle"]["max"] is None
    assert "50" in found[1]["message"]


def test_examples_of_failures_are_of_their_status(folder, sweep, capsys):
    path = folder / "model.yaml"
    path.write_text(MODEL.replace("push + wind", "sqrt(1.5 - mass - t) + push + wind"))
    text = STUDY.replace("{from: 0.6, to: 1.2, count: 2}", "[0.6, 1.2, 50]").replace("[0.5, 1, 7/2]", "[1]")
    assert sweep_command([str(study(folder, text)), "--quiet"]) == 0
    warnings = [line for line in capsys.readouterr().err.splitlines() if "for example" in line]
    found = {line.split()[6].rstrip(";"): line for line in warnings}
    assert "0.1 to 5" in found["rejected"], warnings
    assert "0.1 to 5" not in found["failed"]


def test_an_interrupted_sweep_goes_on(folder, rows):
    text = "study: 1\nmodel: model.yaml\ngrid: {k: {from: 0, to: 10, count: 60}}\nuntil: 60\nstore: study.h5\n"
    command = [sys.executable, "-m", "mimbre", "sweep", study(folder, text), "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        deadline = time.monotonic() + 300
        while not (folder / "study.h5").exists():
            assert time.monotonic() < deadline
            time.sleep(0.01)
        os.kill(running.pid, signal.SIGINT)
        out, err = running.communicate(timeout=300)
    answer = json.loads(out)
    done = sum(row["status"] == "ok" for row in answer["rows"])
    if done < 60:  # else it was quicker
        assert (running.returncode, answer["status"]) == (3, "interrupted")
        assert "the same command goes on from" in err
    whole = rows(text)
    assert whole == rows(text.replace("store: study.h5", ""))


def test_the_schema_says_what_is_read():
    schema = json.loads((top / "schema/study.schema.json").read_text())
    assert tuple(sorted(schema["properties"])) == tuple(sorted(study_file._keys))
    assert tuple(schema["properties"]["method"]["properties"]) == tuple(study_file._methods)
    assert tuple(schema["$defs"]["samples"]["properties"]["sampler"]["enum"]) == study_file.SAMPLERS


def test_the_example_runs(sweep):
    found = json.loads(sweep(top / "examples/iltis/study.yaml", "--json"))["rows"]
    assert [row["status"] for row in found] == ["ok"] * 12
    # Higher stairs throw it higher, and stiffer absorbers do not change how high the ramp is.
    peaks = [row["values"]["chassis.z"]["max"] for row in found]
    assert max(peaks[:4]) < min(peaks[4:8]) < max(peaks[4:8]) < min(peaks[8:])

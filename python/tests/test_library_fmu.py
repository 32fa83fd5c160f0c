"""FMUs with the library inside, as another program simulates them."""

from __future__ import annotations

import resource
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import mimbre
import numpy as np
import pytest
from conftest import program

fmpy = pytest.importorskip("fmpy")

hanging = """
mimbre: 1
parameters: {k: {value: 200, tunable: true, min: 1}}
inputs: {push: {unit: N, range: [-100, 100]}}
bodies: {b: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1]}}
actuators: {a: {joint: j, force: push - k*z}}
outputs: [{name: z, joint: j}]
initial: equilibrium
simulation: {step: 0.01, end: 1}
"""
stopping = """
mimbre: 1
bodies: {b: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1]}}
outputs: [{name: z, joint: j}]
events: {low: {when: z, crosses: -1, stop: true}}
simulation: {step: 0.01, end: 2}
"""


def outputs_of(path: str) -> list[str]:
    found = fmpy.read_model_description(path)
    return [v.name for v in found.modelVariables if v.causality == "output" and v.type in ("Real", "Float64")]


class Instance:
    """One of an FMU of FMI 3 that runs from time 0."""

    def __init__(self, folder: str, start: dict[int, float] | None = None, messages: list[str] | None = None) -> None:
        told = messages if messages is not None else []
        self.fmu = fmpy.instantiate_fmu(
            folder,
            fmpy.read_model_description(folder),
            "CoSimulation",
            logger=lambda environment, status, category, message: told.append(message.decode()),
        )
        self.fmu.enterInitializationMode()
        for reference, value in (start or {}).items():
            self.fmu.setFloat64([reference], [value])
        self.fmu.exitInitializationMode()

    def steps(self, first: int, end: int, step: float = 0.01) -> None:
        for k in range(first, end):
            self.fmu.doStep(currentCommunicationPoint=k * step, communicationStepSize=step)

    def value(self, reference: int) -> float:
        return float(self.fmu.getFloat64([reference])[0])

    def end(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()


def extracted(model: mimbre.Model, folder: Path, **options: Any) -> str:
    path = model.fmu(folder / "model.fmu", library=True, name="model", **options)
    return str(fmpy.extract(str(path), folder / "extracted"))


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    ("name", "until", "method"),
    [
        ("double-four-bar/mechanism.yaml", 1.0, {"formulation": "natural", "integrator": "newmark"}),
        ("ball-cascade/model.yaml", 0.3, {}),
        ("iltis/drive.yaml", 0.2, {}),
        ("spin-up-beam/beam-2d.yaml", 0.5, {"integrator": "radau"}),
    ],
)
def test_every_bit_is_that_of_a_run(
    examples: Path, tmp_path: Path, name: str, until: float, method: dict[str, Any], version: Any
) -> None:
    from fmpy.validation import validate_fmu

    model = mimbre.Model.from_file(examples / name)
    path = str(model.fmu(tmp_path / "model.fmu", version=version, name="model", library=True, **method))
    assert validate_fmu(path) == []
    run = model.run(until=until, **method)
    step = float(run.time[1] - run.time[0])
    names = [output for output in outputs_of(path) if output in run]
    assert names
    result = fmpy.simulate_fmu(path, stop_time=until, step_size=step, output_interval=step, output=names)
    for output in names:
        assert np.array_equal(result[output][: len(run.time)], run[output]), output


def test_what_is_set_before_the_start_moves_the_equilibrium(tmp_path: Path) -> None:
    folder = extracted(mimbre.Model.from_text(hanging), tmp_path)
    for k, push in [(200.0, 0.0), (50.0, 0.0), (50.0, 7.0)]:
        one = Instance(folder, {1: k, 2: push})
        assert one.value(3) == pytest.approx((push - 2 * 9.81) / k, abs=1e-9)
        one.steps(0, 50)
        assert one.value(3) == pytest.approx((push - 2 * 9.81) / k, abs=1e-9)
        one.fmu.setFloat64([2], [20.0])
        one.steps(50, 51)
        assert one.value(3) > (push - 2 * 9.81) / k + 1e-4
        one.fmu.reset()
        one.fmu.enterInitializationMode()
        one.fmu.exitInitializationMode()
        assert one.value(3) == pytest.approx(-2 * 9.81 / 200, abs=1e-9)
        one.end()


def test_a_start_that_does_not_exist_is_an_error(tmp_path: Path) -> None:
    folder = extracted(mimbre.Model.from_text(hanging.replace(", min: 1", "")), tmp_path)
    messages: list[str] = []
    one = Instance(folder, messages=messages)
    one.fmu.reset()
    one.fmu.enterInitializationMode()
    one.fmu.setFloat64([1], [0.0])  # nothing holds it
    with pytest.raises(Exception, match="error"):
        one.value(3)
    with pytest.raises(Exception, match="error"):
        one.fmu.exitInitializationMode()
    assert any("equilibrium" in message for message in messages), messages
    one.fmu.setFloat64([1], [100.0])
    assert one.value(3) == pytest.approx(-2 * 9.81 / 100, abs=1e-9)
    one.fmu.exitInitializationMode()
    # From now on inputs act in steps, and do not move the start.
    one.fmu.setFloat64([2], [50.0])
    assert one.value(3) == pytest.approx(-2 * 9.81 / 100, abs=1e-9)
    one.steps(0, 1)
    assert one.value(3) != pytest.approx(-2 * 9.81 / 100, abs=1e-6)
    one.end()


def test_an_end_within_a_short_step(tmp_path: Path) -> None:
    one = Instance(extracted(mimbre.Model.from_text(stopping), tmp_path))
    one.steps(0, 45)
    one.fmu.doStep(currentCommunicationPoint=0.45, communicationStepSize=0.001)  # the event is at 0.45152
    assert -1 < one.value(1) < -0.99
    with pytest.raises(Exception, match="discard"):
        one.fmu.doStep(currentCommunicationPoint=0.451, communicationStepSize=0.001)
    assert one.value(1) == pytest.approx(-1, abs=1e-8)
    one.fmu.freeInstance()


_on = """
import sys
from test_library_fmu import Instance
one = Instance(sys.argv[1])
one.fmu.setFMUState(one.fmu.deserializeFMUState(open(sys.argv[2], "rb").read()))
one.steps(40, 80, float(sys.argv[3]))
print(one.value(int(sys.argv[4])).hex())
one.end()
"""


@pytest.mark.parametrize("name", ["ball-cascade/model.yaml", "double-four-bar/mechanism.yaml"])
def test_states_are_saved_and_go_to_other_processes(examples: Path, tmp_path: Path, name: str) -> None:
    model = mimbre.Model.from_file(examples / name)
    folder = extracted(model, tmp_path)
    found = fmpy.read_model_description(folder)
    output = next(v.valueReference for v in found.modelVariables if v.causality == "output" and v.type == "Float64")
    step = found.defaultExperiment.stepSize
    step = float(step)
    one = Instance(folder)
    one.steps(0, 40, step)
    state = one.fmu.getFMUState()
    (tmp_path / "state").write_bytes(bytes(one.fmu.serializeFMUState(state)))
    one.steps(40, 80, step)
    last = one.value(output)
    one.fmu.setFMUState(state)
    one.steps(40, 80, step)
    assert one.value(output) == last
    one.fmu.freeFMUState(state)
    one.end()
    arguments = [sys.executable, "-c", _on, folder, str(tmp_path / "state"), repr(step), str(output)]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False, cwd=Path(__file__).parent)
    assert done.stdout.strip().splitlines()[-1:] == [last.hex()], done.stderr


def test_instances_in_threads_have_the_same_bits(tmp_path: Path, examples: Path) -> None:
    folder = extracted(mimbre.Model.from_file(examples / "double-four-bar/mechanism.yaml"), tmp_path)
    instances = [Instance(folder) for _ in range(8)]
    threads = [threading.Thread(target=one.steps, args=(0, 100)) for one in instances]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len({one.value(1).hex() for one in instances}) == 1
    for one in instances:
        one.end()


def resident() -> int:
    """Bytes of this process."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


def test_instances_come_and_go(tmp_path: Path, examples: Path) -> None:
    folder = extracted(mimbre.Model.from_file(examples / "double-four-bar/mechanism.yaml"), tmp_path)
    for k in range(1000):
        if k == 500:  # the memory of this process has settled
            before = resident()
        one = Instance(folder)
        one.fmu.getFMUState()  # goes with its instance
        one.end()
    assert resident() - before < 1_000_000


def test_an_event_that_ends_the_run_is_told(tmp_path: Path) -> None:
    messages: list[str] = []
    one = Instance(extracted(mimbre.Model.from_text(stopping), tmp_path), messages=messages)
    with pytest.raises(Exception, match="discard"):
        one.steps(0, 100)
    assert any("event 'low'" in message for message in messages), messages
    assert one.value(1) == pytest.approx(-1, abs=1e-8)
    one.fmu.freeInstance()


def test_fmi_2_has_it_terminated(tmp_path: Path) -> None:
    import ctypes

    folder = extracted(mimbre.Model.from_text(stopping), tmp_path, version=2)
    found = fmpy.read_model_description(folder)
    fmu = fmpy.instantiate_fmu(folder, found, "CoSimulation", logger=lambda *told: None)
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    ended = ctypes.c_int(7)
    terminated = 3
    fmu.fmi2GetBooleanStatus(fmu.component, terminated, ctypes.byref(ended))
    assert ended.value == 0
    for k in range(45):
        fmu.doStep(currentCommunicationPoint=k * 0.01, communicationStepSize=0.01)
    with pytest.raises(Exception, match=r"discard|status"):
        fmu.doStep(currentCommunicationPoint=0.45, communicationStepSize=0.01)
    fmu.fmi2GetBooleanStatus(fmu.component, terminated, ctypes.byref(ended))
    assert ended.value == 1
    fmu.freeInstance()


def test_an_fmu_of_a_model_is_a_block_of_another(tmp_path: Path) -> None:
    mimbre.Model.from_text(hanging).fmu(tmp_path / "hanging.fmu", library=True, name="hanging")
    outer = tmp_path / "outer.yaml"
    outer.write_text(
        stopping.replace("events: {low: {when: z, crosses: -1, stop: true}}\n", "").replace(
            "outputs: [", "signals: {f: {fmu: hanging.fmu, inputs: {push: z}, outputs: [z]}}\noutputs: ["
        )
    )
    run = mimbre.Model.from_file(outer).run(until=0.5)
    z = run["signal.f.z"]
    assert z[2] == pytest.approx(-2 * 9.81 / 200, abs=1e-3)
    assert np.ptp(z) > 1e-4


def test_what_it_cannot_be_is_refused(tmp_path: Path, examples: Path) -> None:
    model = mimbre.Model.from_text(hanging)
    with pytest.raises(mimbre.InputError, match="co-simulation alone"):
        model.fmu(tmp_path / "a.fmu", library=True, kind="me", name="a")
    with pytest.raises(mimbre.InputError, match="identifier"):
        model.fmu(tmp_path / "a.fmu", library=True, name="no name")
    model.fmu(tmp_path / "hanging.fmu", library=True, name="hanging")
    outer = tmp_path / "outer.yaml"
    outer.write_text(
        stopping.replace("outputs: [", "signals: {f: {fmu: hanging.fmu, inputs: {push: z}, outputs: [z]}}\noutputs: [")
    )
    with pytest.raises(mimbre.InputError, match="code from elsewhere"):
        mimbre.Model.from_file(outer).fmu(tmp_path / "a.fmu", library=True, name="a")


def test_the_program_writes_the_same_fmu(examples: Path, tmp_path: Path) -> None:
    file = examples / "double-four-bar/mechanism.yaml"
    program("fmu", file, "-o", tmp_path / "a.fmu", "--library", "--formulation", "natural")
    mimbre.Model.from_file(file).fmu(tmp_path / "b.fmu", library=True, formulation="natural")
    assert (tmp_path / "a.fmu").read_bytes() == (tmp_path / "b.fmu").read_bytes()
    program("fmu", file, "-o", tmp_path / "a.fmu", "--library", "--kind", "me", code=1)


# --- fixed parameters ---------------------------------------------------------------------------------------

arm = """
mimbre: 1
parameters:
  length: {value: 1.2, min: 0.1, max: 10, about: of the bar}
  width: 50 mm
  mass: 7850*width^2*length
  bars: {value: 2, min: 1, max: 5, integer: true}
  shape: {value: thick, choices: [thick, thin]}
  k: {value: 5, tunable: true}
require:
  - {that: "width < length", message: the bar is wider than it is long}
inputs: {torque: {unit: N m, range: [-50, 50]}}
bodies:
  bar: {mass: mass, com: [length/2, 0, 0], inertia: [mass/100, mass*length^2/12, mass*length^2/12]}
  link$i: {for: {i: {from: 2, to: $bars}}, mass: 1, com: [length, 0, -0.5*$i], inertia: [0.1, 0.1, 0.01]}
joints:
  hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}
  pin$i: {for: {i: {from: 2, to: $bars}}, type: revolute, between: [bar, link$i], at: [length, 0, 0], axis: [0, 1, 0]}
actuators: {motor: {joint: hinge, torque: torque - k*angle}}
outputs:
  - {name: angle, joint: hinge}
  - {name: tip, position: bar, component: z}
  - {name: held, joint_force: hinge, component: fz}
simulation: {step: 0.005, end: 1}
"""


def references_of(folder: str) -> dict[str, int]:
    return {v.name: v.valueReference for v in fmpy.read_model_description(folder).modelVariables}


def started(folder: str, values: dict[str, float], messages: list[str] | None = None) -> Any:
    """An instance of FMI 3 with parameters that are set before initialization."""
    told = messages if messages is not None else []
    found = fmpy.read_model_description(folder)
    fmu = fmpy.instantiate_fmu(
        folder,
        found,
        "CoSimulation",
        logger=lambda environment, status, category, message: told.append(message.decode()),
    )
    set_parameters(fmu, folder, values)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu


def set_parameters(fmu: Any, folder: str, values: dict[str, float]) -> None:
    kinds = {v.name: v.type for v in fmpy.read_model_description(folder).modelVariables}
    for name, value in values.items():
        if kinds[name] == "Int32":
            fmu.setInt32([references_of(folder)[name]], [int(value)])
        else:
            fmu.setFloat64([references_of(folder)[name]], [value])


def history(fmu: Any, folder: str, names: list[str], steps: int, step: float = 0.005) -> np.ndarray:
    places = [references_of(folder)[name] for name in names]
    rows = [fmu.getFloat64(places)]
    for k in range(steps):
        fmu.doStep(currentCommunicationPoint=k * step, communicationStepSize=step)
        rows.append(fmu.getFloat64(places))
    return np.array(rows)


def test_parameters_are_declared_as_the_model_file_has_them(tmp_path: Path) -> None:
    for version in (2, 3):
        (tmp_path / str(version)).mkdir()
        folder = extracted(mimbre.Model.from_text(arm), tmp_path / str(version), version=version)
        found = {v.name: v for v in fmpy.read_model_description(folder).modelVariables}
        for name, causality, variability, start in [
            ("length", "parameter", "fixed", "1.2"),
            ("width", "parameter", "fixed", "0.05"),
            ("bars", "parameter", "fixed", "2"),
            ("mass", "calculatedParameter", "fixed", None),
            ("k", "parameter", "tunable", None),
        ]:
            assert (found[name].causality, found[name].variability) == (causality, variability)
            assert start is None or float(found[name].start) == float(start)
        assert found["bars"].type == ("Integer" if version == 2 else "Int32")
        assert (float(found["length"].min), float(found["length"].max)) == (0.1, 10)
        assert (found["bars"].min, found["bars"].max) == ("1", "5")
        assert found["length"].description == "of the bar"
        assert "shape" not in found


@pytest.mark.parametrize("version", [2, 3])
def test_runs_with_parameters_are_those_of_a_model_with_them(tmp_path: Path, version: Any) -> None:
    from fmpy.validation import validate_fmu

    model = mimbre.Model.from_text(arm)
    path = str(model.fmu(tmp_path / "model.fmu", library=True, name="model", version=version))
    assert validate_fmu(path) == []
    names = ["angle", "tip", "held"]
    for values in ({}, {"length": 0.7}, {"length": 2, "width": 0.02, "bars": 4}):
        run = mimbre.Model.from_text(arm, **values).run(until=0.5)
        result = fmpy.simulate_fmu(
            path, stop_time=0.5, step_size=0.005, output_interval=0.005, output=names, start_values=values
        )
        for name in names:
            assert np.array_equal(result[name][: len(run.time)], run[name]), (values, name)


def test_parameters_of_an_example_with_flexible_bodies(examples: Path, tmp_path: Path) -> None:
    file = examples / "slider-crank/slider-crank.yaml"
    model = mimbre.Model.from_file(file)
    path = str(model.fmu(tmp_path / "model.fmu", library=True, name="model"))
    found = [v for v in fmpy.read_model_description(path).modelVariables if v.variability == "fixed"]
    assert {"speed", "step"} <= {v.name for v in found}
    run = mimbre.Model.from_file(file, speed=31.5).run(until=0.05)
    step = float(run.time[1] - run.time[0])
    outputs = [name for name in outputs_of(path) if name in run]
    result = fmpy.simulate_fmu(
        path, stop_time=0.05, step_size=step, output_interval=step, output=outputs, start_values={"speed": 31.5}
    )
    for name in outputs:
        assert np.array_equal(result[name][: len(run.time)], run[name]), name
    # The step is that of the FMU.
    messages: list[str] = []
    with pytest.raises(Exception, match="error"):
        started(str(fmpy.extract(path, tmp_path / "extracted")), {"step": 1e-4}, messages)
    assert any("with step = 0.0001" in message and "write one" in message for message in messages), messages


def test_parameters_that_follow_from_others(tmp_path: Path) -> None:
    folder = extracted(mimbre.Model.from_text(arm), tmp_path)
    of = references_of(folder)
    messages: list[str] = []
    fmu = started(folder, {"length": 2.0}, messages)
    assert fmu.getFloat64([of["mass"], of["length"]]) == [pytest.approx(7850 * 0.05**2 * 2), 2.0]
    fmu.reset()
    assert fmu.getFloat64([of["mass"], of["length"]]) == [pytest.approx(7850 * 0.05**2 * 1.2), 1.2]
    with pytest.raises(Exception, match="error"):
        fmu.setFloat64([of["mass"]], [3.0])
    assert "'mass' follows from others" in messages[-1]
    fmu.freeInstance()


def test_values_that_cannot_be_are_errors(tmp_path: Path) -> None:
    folder = extracted(mimbre.Model.from_text(arm), tmp_path)
    of = references_of(folder)
    messages: list[str] = []
    fmu = fmpy.instantiate_fmu(
        folder,
        fmpy.read_model_description(folder),
        "CoSimulation",
        logger=lambda environment, status, category, message: messages.append(message.decode()),
    )
    for reference, value, words in [
        (of["length"], 0.05, "'length' set to 0.05: a number from 0.1 to 10 is needed"),
        (of["length"], float("nan"), "'length'"),
        (of["width"], float("inf"), "'width'"),
    ]:
        with pytest.raises(Exception, match="error"):
            fmu.setFloat64([of["k"], reference], [7.0, value])
        assert words in messages[-1]
    with pytest.raises(Exception, match="error"):
        fmu.setInt32([of["bars"]], [6])
    assert "'bars' set to 6: a whole number from 1 to 5 is needed" in messages[-1]
    assert fmu.getFloat64([of["k"], of["length"], of["width"]]) == [5.0, 1.2, 0.05]
    # A condition on several, which is found when something of the model is asked for.
    fmu.enterInitializationMode()
    fmu.setFloat64([of["width"]], [1.5])
    for call in (lambda: fmu.getFloat64([of["angle"]]), fmu.exitInitializationMode):
        with pytest.raises(Exception, match="error"):
            call()
        assert "with width = 1.5" in messages[-1]
        assert "the bar is wider than it is long" in messages[-1]
    fmu.setFloat64([of["length"]], [2.0])
    fmu.exitInitializationMode()
    with pytest.raises(Exception, match="error"):
        fmu.setFloat64([of["length"]], [1.0])
    assert "'length' is fixed" in messages[-1]
    assert fmu.getFloat64([of["length"]]) == [2.0]
    fmu.freeInstance()


def test_instances_with_different_parameters_side_by_side(tmp_path: Path) -> None:
    folder = extracted(mimbre.Model.from_text(arm), tmp_path)
    cases: list[dict[str, float]] = [{}, {"length": 0.7}, {"bars": 4}, {"length": 0.7}]
    alone = []
    for values in cases:
        fmu = started(folder, values)
        alone.append(history(fmu, folder, ["angle", "held"], 40))
        fmu.freeInstance()
    together = [started(folder, values) for values in cases]
    rows: list[list[Any]] = [[] for _ in cases]
    for k in range(40):
        for fmu, row in zip(together, rows, strict=True):
            fmu.doStep(currentCommunicationPoint=k * 0.005, communicationStepSize=0.005)
            row.append(fmu.getFloat64([references_of(folder)[name] for name in ("angle", "held")]))
    for row, one in zip(rows, alone, strict=True):
        assert np.array_equal(np.array(row), one[1:])
    assert np.array_equal(alone[1], alone[3])
    assert not np.array_equal(alone[0], alone[1])
    for fmu in together:
        fmu.freeInstance()


def test_states_have_their_parameters(tmp_path: Path) -> None:
    """Also between instances whose models have another number of coordinates."""
    folder = extracted(mimbre.Model.from_text(arm), tmp_path)
    of = references_of(folder)
    one = started(folder, {"length": 0.7, "bars": 4})
    history(one, folder, ["angle"], 20)
    state = one.getFMUState()
    data = one.serializeFMUState(state)
    on = [one.getFloat64([of["angle"]])]
    for k in range(20, 40):
        one.doStep(currentCommunicationPoint=k * 0.005, communicationStepSize=0.005)
        on.append(one.getFloat64([of["angle"]]))
    other = started(folder, {"length": 3.0})
    history(other, folder, ["angle"], 7)
    other.setFMUState(other.deserializeFMUState(data))
    assert other.getFloat64([of["length"]]) == [0.7]
    assert other.getInt32([of["bars"]]) == [4]
    again = [other.getFloat64([of["angle"]])]
    for k in range(20, 40):
        other.doStep(currentCommunicationPoint=k * 0.005, communicationStepSize=0.005)
        again.append(other.getFloat64([of["angle"]]))
    assert again == on
    one.reset()
    assert one.getFloat64([of["length"]]) == [1.2]
    one.setFMUState(state)
    assert one.getFloat64([of["length"]]) == [0.7]
    assert one.getFloat64([of["angle"]]) == on[0]
    for fmu in (one, other):
        fmu.freeInstance()


def test_settings_of_the_time_when_it_was_written(tmp_path: Path) -> None:
    """A parameter that was replaced then starts from that value, also one that followed from others."""
    folder = extracted(mimbre.Model.from_text(arm, length=0.9, mass=4), tmp_path)
    found = {v.name: v for v in fmpy.read_model_description(folder).modelVariables}
    assert float(found["length"].start) == 0.9
    assert found["mass"].causality == "parameter"
    fmu = started(folder, {"length": 2.0})
    run = mimbre.Model.from_text(arm, length=2.0, mass=4).run(until=0.1)
    assert np.array_equal(history(fmu, folder, ["angle"], 20)[:, 0], run["angle"])
    fmu.freeInstance()


def test_built_models_have_no_fixed_parameters(pendulum: mimbre.Model, tmp_path: Path) -> None:
    folder = extracted(pendulum, tmp_path)
    found = fmpy.read_model_description(folder).modelVariables
    assert [v.name for v in found if v.variability == "fixed"] == []


# --- directional derivatives --------------------------------------------------------------------------------

varied = """
mimbre: 1
parameters: {k: {value: 30, tunable: true}}
inputs: {gain: {start: 1.5}, push: {unit: N, start: 20, range: [-100, 100]}, wanted: {start: 0.2}}
bodies:
  bar: {mass: 3, com: [0.5, 0, 0], inertia: [0.01, 0.2, 0.2]}
  link: {mass: 1, com: [1, 0, -0.5], inertia: [0.1, 0.1, 0.01]}
joints:
  hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}
  pin: {type: revolute, between: [bar, link], at: [1, 0, 0], axis: [0, 1, 0]}
springs:
  rope: {between: [ground, link], at: [[1, 0, 2], null], force: "k*(l - 0.5)*(1 + gain^2) + 2*v"}
loads:
  gust: {on: link, at: [1, 0, -1], force: [1, 0, 0.5], scale: push*gain^2}
signals:
  angle: {joint: hinge}
  mixed: "sin(angle + wanted)*gain^2*k"
  in_time: "exp(-t)*gain + wanted^2*t^2"
  servo: {pid: angle, setpoint: wanted*gain, kp: 2, ki: 3, kd: 0.05, filter: 0.04}
actuators: {motor: {joint: hinge, torque: servo}}
outputs:
  - {name: rope, spring_force: rope}
  - {name: height, position: link, component: z}
  - {name: held, joint_force: hinge, component: fz}
simulation: {step: 0.002, end: 1}
"""


@pytest.mark.parametrize("method", [{}, {"formulation": "natural"}, {"integrator": "radau"}])
def test_derivatives_are_those_of_differences(tmp_path: Path, method: dict[str, Any]) -> None:
    folder = extracted(mimbre.Model.from_text(varied), tmp_path, **method)
    assert 'providesDirectionalDerivatives="true"' in (Path(folder) / "modelDescription.xml").read_text()
    of = references_of(folder)
    outputs = [of[name] for name in ("rope", "height", "held", "angle", "mixed", "in_time", "servo")]
    knowns = [of[name] for name in ("k", "gain", "push", "wanted")]
    fmu = started(folder, {})
    history(fmu, folder, ["angle"], 40, 0.002)
    at = np.array(fmu.getFloat64(knowns))
    before = fmu.getFloat64(outputs)
    for seed in ([1.0, 0, 0, 0], [0, 0.7, 0, 0], [0, 0, 20.0, 0], [0.3, -0.2, 9.0, 0.5]):
        exact = np.array(fmu.getDirectionalDerivative(outputs, knowns, seed))
        assert fmu.getFloat64(outputs) == before
        state = fmu.getFMUState()

        def shown(ahead: float, along: Any = seed, start: Any = state) -> np.ndarray:
            fmu.setFloat64(knowns, list(at + ahead * np.array(along)))
            values = np.array(fmu.getFloat64(outputs))
            fmu.setFMUState(start)
            return values

        h = 1e-3
        difference = (8 * (shown(h) - shown(-h)) - (shown(2 * h) - shown(-2 * h))) / (12 * h)
        fmu.freeFMUState(state)
        assert exact == pytest.approx(difference, rel=1e-8, abs=1e-8)
    assert exact[0] != 0
    assert exact[2] != 0
    assert exact[1] == exact[3] == 0
    t = 0.08
    by_time = fmu.getDirectionalDerivative([of["in_time"], of["height"]], [of["time"]], [1.0])
    assert by_time == [pytest.approx(-np.exp(-t) * 1.5 + 2 * 0.04 * t, abs=1e-12), 0.0]
    # Between steps outputs are on a line.
    fmu.doStep(currentCommunicationPoint=0.08, communicationStepSize=0.0005)
    here = fmu.getFloat64([of["height"]])[0]
    slope = fmu.getDirectionalDerivative([of["height"]], [of["time"]], [1.0])[0]
    fmu.doStep(currentCommunicationPoint=0.0805, communicationStepSize=0.0005)
    assert slope == pytest.approx((fmu.getFloat64([of["height"]])[0] - here) / 0.0005, rel=1e-9)
    fmu.freeInstance()


def test_derivatives_with_parameters(tmp_path: Path) -> None:
    """Of the model with them, and not of an input that is none."""
    folder = extracted(mimbre.Model.from_text(arm + "signals: {moment: (torque - k*angle)*length}\n"), tmp_path)
    of = references_of(folder)
    messages: list[str] = []
    fmu = started(folder, {"length": 2.0}, messages)
    assert fmu.getDirectionalDerivative([of["moment"]], [of["torque"]], [1.0]) == [2.0]
    with pytest.raises(Exception, match="error"):
        fmu.getDirectionalDerivative([of["moment"]], [of["length"]], [1.0])
    assert "neither input nor tunable parameter" in messages[-1]
    fmu.freeInstance()

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

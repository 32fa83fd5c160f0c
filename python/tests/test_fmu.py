"""FMUs and code of models, as another program reads, compiles and simulates them."""

from __future__ import annotations

import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import mimbre
import numpy as np
import pytest
from conftest import program

fmpy = pytest.importorskip("fmpy")

models = {
    "pendulum": "tutorial/pendulum.yaml",
    "double_four_bar": "double-four-bar/mechanism.yaml",
    "suspension": "iltis/suspension.yaml",
}


def simulated(fmu: str, names: list[str], step: float, end: float, **more: Any) -> np.ndarray:
    result = fmpy.simulate_fmu(fmu, stop_time=end, step_size=step, output_interval=step, output=names, **more)
    return np.column_stack([result[name] for name in names])


def of_the_run(run: mimbre.Run, names: list[str]) -> np.ndarray:
    return np.column_stack([run[name] for name in names])


def difference(a: np.ndarray, b: np.ndarray) -> float:
    assert a.shape == b.shape
    return float((np.abs(a - b) / np.maximum(1, np.abs(b))).max())


def outputs_of(fmu: str) -> list[str]:
    found = fmpy.read_model_description(fmu)
    return [v.name for v in found.modelVariables if v.causality == "output" and v.type in ("Real", "Float64")]


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", models)
@pytest.mark.filterwarnings("ignore:output .* is not in the FMU")
def test_fmpy_validates_and_simulates(examples: Path, tmp_path: Path, name: str, version: Any) -> None:
    model = mimbre.Model.from_file(examples / models[name])
    path = str(model.fmu(tmp_path / f"{name}.fmu", version=version, name=name))
    from fmpy.validation import validate_fmu

    assert validate_fmu(path) == []
    run = model.run(until=1, fixed_cost=True)
    step = float(run.time[1] - run.time[0])
    names = outputs_of(path)
    assert difference(simulated(path, names, step, 1), of_the_run(run, names)) < 1e-10


@pytest.mark.parametrize("version", [2, 3])
def test_fmpy_compiles_the_sources(pendulum: mimbre.Model, tmp_path: Path, version: Any) -> None:
    if not shutil.which("cmake"):
        pytest.skip("there is no cmake")
    from fmpy.build import build_platform_binary

    path = pendulum.fmu(tmp_path / "pendulum.fmu", version=version, name="pendulum")
    folder = str(fmpy.extract(str(path), tmp_path / "extracted"))
    shutil.rmtree(Path(folder, "binaries"))
    build_platform_binary(folder)
    run = pendulum.run(until=1, fixed_cost=True)
    names = outputs_of(folder)
    assert difference(simulated(folder, names, 0.01, 1), of_the_run(run, names)) < 1e-10


@pytest.mark.parametrize("version", [2, 3])
def test_inputs_and_parameters_are_set(pendulum: mimbre.Model, tmp_path: Path, version: Any) -> None:
    path = str(pendulum.fmu(tmp_path / "pendulum.fmu", version=version, name="pendulum"))
    times = np.arange(101) * 0.01
    torque = np.round(np.sin(3 * times), 6)
    signal = np.array(list(zip(times, torque, strict=True)), dtype=[("time", float), ("torque", float)])
    found = simulated(path, ["angle"], 0.01, 1, input=signal, start_values={"k": 3.0})
    simulation = pendulum.simulation(fixed_cost=True)
    simulation.input("k").value = 3.0
    expected = [simulation.channel("angle").value]
    for value in torque[:-1]:
        simulation.input("torque").value = value
        simulation.step()
        expected.append(simulation.channel("angle").value)
    assert np.abs(found[:, 0] - expected).max() < 1e-10


_on = """
import sys
import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description
folder, state = sys.argv[1], open(sys.argv[2], "rb").read()
f = instantiate_fmu(folder, read_model_description(folder), "CoSimulation")
f.enterInitializationMode()
f.exitInitializationMode()
f.setFMUState(f.deserializeFMUState(state))
for k in range(50, 100):
    f.doStep(currentCommunicationPoint=k * 0.01, communicationStepSize=0.01)
print(f.getFloat64([3])[0].hex())
f.terminate()
f.freeInstance()
"""


def test_another_process_goes_on_to_the_same_bits(pendulum: mimbre.Model, tmp_path: Path) -> None:
    path = str(pendulum.fmu(tmp_path / "pendulum.fmu", name="pendulum"))
    folder = str(fmpy.extract(path, tmp_path / "extracted"))
    f = fmpy.instantiate_fmu(folder, fmpy.read_model_description(folder), "CoSimulation")
    f.enterInitializationMode()
    f.exitInitializationMode()
    for k in range(50):
        f.doStep(currentCommunicationPoint=k * 0.01, communicationStepSize=0.01)
    state = f.getFMUState()
    (tmp_path / "state").write_bytes(bytes(f.serializeFMUState(state)))
    f.freeFMUState(state)
    for k in range(50, 100):
        f.doStep(currentCommunicationPoint=k * 0.01, communicationStepSize=0.01)
    last = f.getFloat64([3])[0]
    f.terminate()
    f.freeInstance()
    arguments = [sys.executable, "-c", _on, folder, str(tmp_path / "state")]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    assert done.stdout.strip().splitlines()[-1:] == [last.hex()], done.stderr


def test_the_program_writes_the_same_fmu(examples: Path, tmp_path: Path) -> None:
    file = examples / "tutorial/pendulum.yaml"
    program("fmu", file, "-o", tmp_path / "a.fmu", "--fmi", "2")
    with pytest.warns(UserWarning, match="hinge"):
        mimbre.Model.from_file(file).fmu(tmp_path / "b.fmu", version=2)
    assert (tmp_path / "a.fmu").read_bytes() == (tmp_path / "b.fmu").read_bytes()
    program("fmu", file, "-o", tmp_path / "c.fmu", "--fmi", "4", code=2)
    program("fmu", file, "-o", tmp_path / "c.fmu", "--kind", "se", code=2)
    program("fmu", file, "-o", tmp_path / "a.fmu", "--fmi", "2", "--kind", "me")
    with pytest.warns(UserWarning, match="hinge"):
        mimbre.Model.from_file(file).fmu(tmp_path / "b.fmu", version=2, kind="me")
    assert (tmp_path / "a.fmu").read_bytes() == (tmp_path / "b.fmu").read_bytes()


def test_wrong_use_is_refused(pendulum: mimbre.Model, tmp_path: Path) -> None:
    with pytest.raises(mimbre.InputError, match="version 1"):
        pendulum.fmu(tmp_path / "a.fmu", version=1)  # type: ignore[arg-type]
    with pytest.raises(mimbre.UnknownName, match="cs, me"):
        pendulum.fmu(tmp_path / "a.fmu", kind="both")  # type: ignore[arg-type]
    with pytest.raises(mimbre.InputError, match="identifier"):
        pendulum.fmu(tmp_path / "a.fmu", name="no name")
    with pytest.raises(mimbre.InputError, match="cannot write"):
        pendulum.fmu(tmp_path / "no" / "folder" / "a.fmu", name="a")
    with pytest.raises(mimbre.InputError, match="formulation"):
        pendulum.fmu(tmp_path / "a.fmu", name="a", formulation="natural")


def test_code_is_written(pendulum: mimbre.Model, tmp_path: Path) -> None:
    path = pendulum.generate(tmp_path / "code", name="swing")
    assert path == tmp_path / "code" / "swing.c"
    assert "swing_step" in path.with_suffix(".h").read_text()


arm = """
mimbre: 1
inputs: {push: {start: 0.3, range: [-2, 2]}}
bodies: {link: {mass: 1, inertia: [0.1, 0.2, 0.3], com: [0.5, 0, 0]}}
joints: {ball: {type: spherical, between: [ground, link], at: [0, 0, 0]}}
loads: {load: {on: link, at: [1, 0, 0.2], force: [0, 1, 0], scale: push}}
signals: {shown: "push^3", wave: "sin(3*t)*push"}
outputs:
  - {name: tip.x, position: link, at: [1, 0, 0.2], component: x}
  - {name: tip.y, position: link, at: [1, 0, 0.2], component: y}
  - {name: tip.z, position: link, at: [1, 0, 0.2], component: z}
  - {name: turn, yaw: link}
simulation: {step: 0.01, end: 1}
"""


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_arrays_have_the_numbers_of_scalars(tmp_path: Path, kind: str) -> None:
    from fmpy.validation import validate_fmu

    model = mimbre.Model.from_text(arm)
    short: Any = "cs" if kind == "CoSimulation" else "me"
    scalars = str(model.fmu(tmp_path / "scalars.fmu", kind=short, name="scalars"))
    arrays = str(model.fmu(tmp_path / "arrays.fmu", kind=short, name="arrays", arrays=True))
    assert validate_fmu(arrays) == []
    described = {v.name: v for v in fmpy.read_model_description(arrays).modelVariables}
    assert [int(d.start) for d in described["tip"].dimensions] == [3]
    assert "tip.x" not in described
    assert not described["turn"].dimensions
    options: dict[str, Any] = {"stop_time": 1, "output_interval": 0.01, "fmi_type": kind}
    options |= {"step_size": 0.01} if short == "cs" else {"solver": "CVode", "record_events": False}
    found = fmpy.simulate_fmu(arrays, output=["tip", "turn"], **options)
    expected = fmpy.simulate_fmu(scalars, output=["tip.x", "tip.y", "tip.z", "turn"], **options)
    assert found["tip"].shape == (101, 3)
    for k, axis in enumerate("xyz"):
        assert np.array_equal(found["tip"][:, k], expected[f"tip.{axis}"])
    assert np.array_equal(found["turn"], expected["turn"])
    assert np.ptp(found["tip"], axis=0).min() > 1e-3


def test_the_program_writes_arrays(tmp_path: Path) -> None:
    (tmp_path / "arm.yaml").write_text(arm)
    program("fmu", tmp_path / "arm.yaml", "-o", tmp_path / "a.fmu", "--arrays")
    mimbre.Model.from_file(tmp_path / "arm.yaml").fmu(tmp_path / "b.fmu", arrays=True)
    assert (tmp_path / "a.fmu").read_bytes() == (tmp_path / "b.fmu").read_bytes()
    with pytest.raises(mimbre.InputError, match="FMI 2 has no arrays"):
        mimbre.Model.from_file(tmp_path / "arm.yaml").fmu(tmp_path / "b.fmu", version=2, arrays=True)


def announces_directions(folder: str, version: int) -> bool:
    kind = ET.parse(Path(folder) / "modelDescription.xml").getroot().find("CoSimulation")
    assert kind is not None
    return kind.get(f"providesDirectionalDerivative{'s' if version == 3 else ''}") == "true"


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("library", [False, True])
def test_directional_derivatives_at_a_communication_point(tmp_path: Path, library: bool, version: Any) -> None:
    model = mimbre.Model.from_text(arm)
    path = model.fmu(tmp_path / "arm.fmu", version=version, name="arm", library=library)
    folder = str(fmpy.extract(str(path), tmp_path / "extracted"))
    assert announces_directions(folder, version)
    description = fmpy.read_model_description(folder)
    references = {v.name: v.valueReference for v in description.modelVariables}
    f = fmpy.instantiate_fmu(folder, description, "CoSimulation")
    if version == 2:
        f.setupExperiment(startTime=0.0)
    f.enterInitializationMode()
    f.exitInitializationMode()
    for k in range(20):
        f.doStep(currentCommunicationPoint=k * 0.01, communicationStepSize=0.01)
    outputs = [references[name] for name in ("shown", "wave", "tip.x")]
    derivative = f.getDirectionalDerivative(outputs, [references["push"]], [2.0])
    assert derivative == pytest.approx([2 * 3 * 0.3**2, 2 * np.sin(0.6), 0.0], abs=1e-12)
    f.terminate()
    f.freeInstance()


def test_a_block_reads_elements_of_arrays(tmp_path: Path) -> None:
    model = mimbre.Model.from_text(arm)
    model.fmu(tmp_path / "arm.fmu", name="arm", arrays=True)
    outer = tmp_path / "outer.yaml"
    outer.write_text(
        """
mimbre: 1
bodies: {b: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1]}}
signals: {f: {fmu: arm.fmu, outputs: {ahead: "tip[1]", height: "tip[3]", turn: turn}}}
simulation: {step: 0.01, end: 0.5}
"""
    )
    run, alone = mimbre.Model.from_file(outer).run(), model.run(until=0.5, fixed_cost=True)
    for name, other in [("ahead", "tip.x"), ("height", "tip.z"), ("turn", "turn")]:
        # A step of the block sees the inputs of its beginning.
        assert np.abs(run[f"signal.f.{name}"][1:] - alone[other][:-1]).max() < 1e-10


BACK_AND_FORTH = """
mimbre: 1
bodies: {slider: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {guide: {type: prismatic, between: [ground, slider], at: [0, 0, 0], axis: [1, 0, 0]}}
inputs: {push: 1, laps: {start: 0, range: [0, 9]}}
signals: {place: {joint: guide}}
actuators: {motor: {joint: guide, force: "9*push"}}
events:
  far: {when: place, crosses: 0.1, direction: rising, set: {push: -1, laps: "laps + 1"}}
  near: {when: place, crosses: -0.1, direction: falling, set: {push: 1}}
  last: {when: laps, crosses: 2.5, stop: true}
outputs: [{name: x, joint: guide}]
simulation: {step: 3 ms, end: 20, fixed_cost: true}
"""


def instants_of_events(path: Path, folder: Path, events: bool, early: bool, step: float) -> list[tuple[float, int]]:
    """Where steps tell of events or end early, and how many events have happened there."""
    from fmpy.fmi1 import FMICallException
    from fmpy.fmi3 import FMU3Slave

    description = fmpy.read_model_description(str(path))
    assert description.coSimulation.hasEventMode
    assert description.coSimulation.mightReturnEarlyFromDoStep
    references = {v.name: v.valueReference for v in description.modelVariables}
    f = FMU3Slave(
        guid=description.instantiationToken,
        unzipDirectory=fmpy.extract(str(path), str(folder)),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
    )
    f.instantiate(eventModeUsed=events, earlyReturnAllowed=early)
    f.enterInitializationMode()
    f.exitInitializationMode()
    if events:
        assert f.updateDiscreteStates() == (False, False, False, False, False, 0.0)
        f.enterStepMode()
    told: list[tuple[float, int]] = []
    now = 0.0
    while True:
        try:
            event, ends, returned, last = f.doStep(now, step)
        except FMICallException:
            break
        assert not ends
        assert (last < now + step - 1e-9) == returned
        assert early or not returned
        now = last
        counts = f.getFloat64([references["event.far"], references["event.near"]])
        assert all(count == round(count) for count in counts)  # also between two steps of the model
        if event or returned:
            told.append((last, round(sum(counts))))
        if event:
            assert events
            f.enterEventMode()
            f.updateDiscreteStates()
            f.enterStepMode()
    f.terminate()
    f.freeInstance()
    return told


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("library", [False, True])
def test_what_is_set_before_the_start_is_no_crossing(tmp_path: Path, library: bool, version: Any) -> None:
    model = mimbre.Model.from_text(BACK_AND_FORTH)
    path = str(model.fmu(tmp_path / "back.fmu", version=version, library=library))
    names = ["laps", "event.last", "solver.steps"]
    result = fmpy.simulate_fmu(path, start_values={"laps": 3.0}, stop_time=0.15, output_interval=0.03, output=names)
    assert result["laps"][-1] == 3
    assert result["event.last"][-1] == 0
    assert result["solver.steps"][-1] == 50


@pytest.mark.parametrize("library", [False, True])
def test_events_are_told_and_end_steps(tmp_path: Path, library: bool) -> None:
    from fmpy.validation import validate_fmu

    model = mimbre.Model.from_text(BACK_AND_FORTH)
    path = tmp_path / "back.fmu"
    model.fmu(path, version=3, library=library)
    assert validate_fmu(str(path)) == []
    simulation = mimbre.Simulation(model)
    instants: list[float] = []
    while not simulation.stopped:
        simulation.step()
        if sum(count for count, *_ in simulation.events.values()) > len(instants) and not simulation.stopped:
            instants.append(simulation.time)
    assert len(instants) == 4
    for events in (False, True):
        for step in (0.1, 0.0075, 0.003, 0.0013):
            told = instants_of_events(path, tmp_path / f"{events}{step}", events, True, step)
            if events or step > 0.01:
                assert [n for _, n in told] == [1, 2, 3, 4]
                assert np.allclose([t for t, _ in told], instants, atol=1e-9)
    told = instants_of_events(path, tmp_path / "late", True, False, 0.1)
    assert [n for _, n in told] == [1, 2, 3, 4]
    assert np.allclose([t for t, _ in told], [np.ceil(10 * t - 1e-9) / 10 for t in instants], atol=1e-9)
    assert instants_of_events(path, tmp_path / "none", False, False, 0.1) == []

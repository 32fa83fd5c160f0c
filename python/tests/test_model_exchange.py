"""FMUs for model exchange: FMPy's solver against fine runs of the library."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import Any

import mimbre
import numpy as np
import pytest

fmpy = pytest.importorskip("fmpy")

double_pendulum = """
mimbre: 1
gravity: [0, 0, -9.81]
bodies:
  upper: {mass: 1, inertia: [0.02, 0.02, 0.001], com: [0, 0, -0.4]}
  lower: {mass: 0.6, inertia: [0.01, 0.01, 0.001], com: [0, 0, -1.1]}
joints:
  shoulder: {type: revolute, between: [ground, upper], at: [0, 0, 0], axis: [0, 1, 0], position: 1.2}
  elbow: {type: revolute, between: [upper, lower], at: [0, 0, -0.8], axis: [0, 1, 0], position: 0.7}
outputs:
  - {name: shoulder, joint: shoulder}
  - {name: elbow, joint: elbow}
  - {name: tip.z, position: lower, component: z}
simulation: {step: 0.001, end: 2}
"""


def simulated(fmu: str, names: list[str], end: float, every: float, tolerance: float, **more: Any) -> np.ndarray:
    result = fmpy.simulate_fmu(
        fmu,
        stop_time=end,
        output_interval=every,
        relative_tolerance=tolerance,
        output=names,
        fmi_type="ModelExchange",
        solver="CVode",
        record_events=False,
        **more,
    )
    return np.column_stack([result[name] for name in ["time", *names]])


def of_the_run(run: mimbre.Run, names: list[str], times: np.ndarray) -> np.ndarray:
    at = np.searchsorted(run.time, times - 1e-9)
    assert np.abs(run.time[at] - times).max() < 1e-9
    return np.column_stack([run[name][at] for name in names])


@pytest.mark.parametrize("version", [2, 3])
def test_double_pendulum(tmp_path: Path, version: Any) -> None:
    from fmpy.validation import validate_fmu

    model = mimbre.Model.from_text(double_pendulum)
    path = str(model.fmu(tmp_path / "swing.fmu", version=version, kind="me", name="swing"))
    assert validate_fmu(path) == []
    description = fmpy.read_model_description(path)
    assert (description.numberOfContinuousStates, description.numberOfEventIndicators) == (4, 0)
    names = ["shoulder", "elbow", "tip.z"]
    found = simulated(path, names, 2, 0.01, 1e-10)
    run = model.run(until=2, accuracy=1e-12)
    assert np.abs(found[:, 1:] - of_the_run(run, names, found[:, 0])).max() < 1e-6


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.filterwarnings("ignore:output .* is not in the FMU")
def test_slider_crank(examples: Path, tmp_path: Path, version: Any) -> None:
    from fmpy.validation import validate_fmu

    model = mimbre.Model.from_file(examples / "slider-crank/slider-crank.yaml")
    path = str(model.fmu(tmp_path / "slider.fmu", version=version, kind="me", name="slider"))
    assert validate_fmu(path) == []
    names = ["crank.angle", "slider.x", "rod.deflection"]
    found = simulated(path, names, 0.5, 0.001, 1e-9)
    run = model.run(until=0.5, accuracy=1e-10)
    assert np.abs(found[:, 1:] - of_the_run(run, names, found[:, 0])).max() < 1e-8


@pytest.mark.parametrize("version", [2, 3])
def test_suspension(examples: Path, tmp_path: Path, version: Any) -> None:
    """With the event of the road that drops after two seconds."""
    from fmpy.validation import validate_fmu

    model = mimbre.Model.from_file(examples / "iltis/suspension.yaml")
    path = str(model.fmu(tmp_path / "suspension.fmu", version=version, kind="me", name="suspension"))
    assert validate_fmu(path) == []
    names = ["chassis.z", "wheel.z", "arm.deflection"]
    found = simulated(path, names, 2.5, 0.001, 1e-9)
    run = model.run(until=2.5, accuracy=1e-10)
    expected = of_the_run(run, names, run.time)
    at = np.searchsorted(found[:, 0], run.time - 1e-9)
    assert np.abs(found[at, 1:] - expected).max() < 1e-6


@pytest.mark.parametrize("version", [2, 3])
def test_inputs_and_parameters(pendulum: mimbre.Model, tmp_path: Path, version: Any) -> None:
    path = str(pendulum.fmu(tmp_path / "pendulum.fmu", version=version, kind="me", name="pendulum"))
    signal = np.array([(0.0, 0.0), (0.2, 0.0), (0.2, 0.8), (1.0, 0.8)], dtype=[("time", float), ("torque", float)])
    found = simulated(path, ["angle"], 1, 0.01, 1e-10, input=signal, start_values={"k": 3.0})
    simulation = pendulum.simulation(step=1e-4)
    simulation.input("k").value = 3.0
    channel, expected = simulation.channel("angle"), [0.0]
    for k in range(10000):
        if k == 2000:
            simulation.input("torque").value = 0.8
        simulation.step()
        if (k + 1) % 100 == 0:
            expected.append(channel.value)
    assert np.abs(found[:, 1] - expected).max() < 1e-6


@pytest.mark.parametrize("version", [2, 3])
def test_fmpy_compiles_the_sources(tmp_path: Path, version: Any) -> None:
    if not shutil.which("cmake"):
        pytest.skip("there is no cmake")
    from fmpy.build import build_platform_binary

    model = mimbre.Model.from_text(double_pendulum)
    path = model.fmu(tmp_path / "swing.fmu", version=version, kind="me", name="swing")
    folder = str(fmpy.extract(str(path), tmp_path / "extracted"))
    shutil.rmtree(Path(folder, "binaries"))
    build_platform_binary(folder)
    found = simulated(folder, ["elbow"], 0.1, 0.01, 1e-8)
    assert math.isfinite(found[-1, 1])


def test_what_has_no_derivatives_is_refused(examples: Path, tmp_path: Path) -> None:
    model = mimbre.Model.from_file(examples / "contact/stairs.yaml")
    with pytest.raises(mimbre.InputError, match="contact"):
        model.fmu(tmp_path / "a.fmu", kind="me")

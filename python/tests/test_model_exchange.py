"""FMUs for model exchange: FMPy's solver against fine runs of the library."""

from __future__ import annotations

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

slider = """
mimbre: 1
bodies: {block: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0, 0, 0]}}
joints: {guide: {type: prismatic, between: [ground, block], at: [0, 0, 0], axis: [1, 0, 0]%s}}
outputs: [{name: x, %s}]
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


def difference(found: np.ndarray, run: mimbre.Run, names: list[str]) -> float:
    """The largest at the rows of the run, which are fewer."""
    at = np.searchsorted(found[:, 0], run.time - 1e-9)
    assert np.abs(found[at, 0] - run.time).max() < 1e-9
    return float(np.abs(found[at, 1:] - of_the_run(run, names, run.time)).max())


@pytest.mark.parametrize("version", [2, 3])
def test_double_pendulum(tmp_path: Path, version: Any) -> None:
    from fmpy.validation import validate_fmu

    model = mimbre.Model.from_text(double_pendulum)
    path = str(model.fmu(tmp_path / "swing.fmu", version=version, kind="me", name="swing"))
    assert validate_fmu(path) == []
    description = fmpy.read_model_description(path)
    assert (description.numberOfContinuousStates, description.numberOfEventIndicators) == (4, 0)
    names = ["shoulder", "elbow", "tip.z"]
    run = model.run(until=2, accuracy=1e-12)
    for tolerance, most in [(1e-9, 1e-6), (1e-10, 2e-7)]:
        found = simulated(path, names, 2, 0.01, tolerance)
        assert np.abs(found[:, 1:] - of_the_run(run, names, found[:, 0])).max() < most


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
    found = simulated(path, names, 3, 0.001, 1e-9)
    run = model.run(until=3, accuracy=1e-10)
    assert difference(found, run, names) < 1e-7


@pytest.mark.filterwarnings("ignore:output .* is not in the FMU")
def test_flexible_vehicle(examples: Path, tmp_path: Path) -> None:
    model = mimbre.Model.from_file(examples / "iltis/vehicle.yaml")
    path = str(model.fmu(tmp_path / "vehicle.fmu", kind="me", name="vehicle"))
    assert fmpy.read_model_description(path).numberOfContinuousStates == 148
    names = ["chassis.z", "wheel.front_left.z", "wheel.rear_right.z", "arm.front_left.deflection"]
    found = simulated(path, names, 8, 0.001, 1e-8)
    assert difference(found, model.run(until=8, accuracy=1e-9), names) < 5e-6


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
    expected = simulated(str(path), ["shoulder", "elbow"], 0.5, 0.01, 1e-8)
    folder = str(fmpy.extract(str(path), tmp_path / "extracted"))
    shutil.rmtree(Path(folder, "binaries"))
    build_platform_binary(folder)
    found = simulated(folder, ["shoulder", "elbow"], 0.5, 0.01, 1e-8)
    assert found.shape == expected.shape
    assert np.abs(found - expected).max() < 1e-9
    assert np.ptp(found[:, 1]) > 0.1


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    ("drive", "output", "states"),
    [(", drive: {position: sin(t)}", "joint: guide", 0), ("", "joint_force: guide, component: fz", 2)],
)
@pytest.mark.filterwarnings("ignore:output .* is not in the FMU")
def test_without_states_or_outputs(tmp_path: Path, version: Any, drive: str, output: str, states: int) -> None:
    """FMI 2 has no empty lists."""
    from fmpy.validation import validate_fmu

    model = mimbre.Model.from_text(slider % (drive, output))
    for binary_only in (False, True):
        path = str(model.fmu(tmp_path / "a.fmu", version=version, kind="me", name="a", binary_only=binary_only))
        assert validate_fmu(path) == []
        assert fmpy.read_model_description(path).numberOfContinuousStates == states


def test_what_has_no_derivatives_is_refused(examples: Path, tmp_path: Path) -> None:
    model = mimbre.Model.from_file(examples / "contact/stairs.yaml")
    with pytest.raises(mimbre.InputError, match="contact"):
        model.fmu(tmp_path / "a.fmu", kind="me")

"""Blocks that FMUs compute: controllers written in Python, made by pythonfmu and pythonfmu3, in the robot example."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import mimbre
import numpy as np
import pytest
from conftest import top

#: A PID controller with the formulas of the block `pid`, sampled: the trapezoidal rule, and a filter that is exact for
#: straight lines.
CONTROLLER = """
import math

from {package} import {fmi}Causality, {fmi}Slave, {fmi}Variability, {real}


class {name}({fmi}Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.angle = self.wanted = self.torque = 0.0
        self.kp, self.ki, self.kd, self.filter = 1.0, 0.0, 0.0, 0.01
        for name in ("angle", "wanted"):
            self.register_variable({real}(name, causality={fmi}Causality.input))
        self.register_variable({real}("torque", causality={fmi}Causality.output))
        for name in ("kp", "ki", "kd", "filter"):
            self.register_variable(
                {real}(name, causality={fmi}Causality.parameter, variability={fmi}Variability.tunable))

    def exit_initialization_mode(self):
        self.error = self.filtered = self.wanted - self.angle
        self.integral = 0.0
        self.torque = self.kp * self.error

    def do_step(self, current_time, step_size):
        if self.kp < 0:
            raise ValueError("kp is negative")
        error, z = self.wanted - self.angle, step_size / self.filter
        decay = -math.expm1(-z)
        self.integral += 0.5 * self.ki * step_size * (error + self.error)
        self.filtered += decay * (self.error - self.filtered) + (1 - decay / z) * (error - self.error)
        self.error = error
        self.torque = self.kp * error + self.integral + self.kd / self.filter * (error - self.filtered)
        return True
"""
VERSIONS = {2: ("pythonfmu", "Fmi2", "Real"), 3: ("pythonfmu3", "Fmi3", "Float64")}


@pytest.fixture(scope="module", params=[2, 3])
def controller(request, tmp_path_factory) -> Path:
    """An FMU of that version of FMI."""
    package, fmi, real = VERSIONS[request.param]
    pytest.importorskip(package)
    folder = tmp_path_factory.mktemp(package)
    name = f"Controller{request.param}"
    script = folder / f"controller{request.param}.py"
    script.write_text(CONTROLLER.format(package=package, fmi=fmi, real=real, name=name))
    subprocess.run(
        [sys.executable, "-m", package, "build", "-f", str(script), "-d", str(folder)], check=True, capture_output=True
    )
    return folder / f"{name}.fmu"


def robot(folder: Path, trim: str) -> mimbre.Model:
    """The example with one more controller at its second axis."""
    text = (top / "examples/robot/model.yaml").read_text()
    text = text.replace("\nsubsystems:", f"\n  trim: {trim}\n\nsubsystems:", 1)
    text = text.replace("\ninstances:", "\nactuators:\n  servo: {joint: real.axis2, torque: trim}\n\ninstances:", 1)
    file = folder / "robot.yaml"
    file.write_text(text)
    return mimbre.Model.from_file(str(file), begin=0.01)


def fmu(controller: Path, more: str = "", kp: float = 200) -> str:
    return (
        f"{{fmu: {controller}, inputs: {{angle: real.q2, wanted: 0.6*way}}, outputs: torque, every: 0.002, "
        f"parameters: {{kp: {kp}, ki: 400, kd: 20, filter: 0.01}}, inputs_at: end{more}}}"
    )


def test_a_controller_in_python_is_that_of_the_library(controller, tmp_path):
    own = (
        "{pid: real.q2, setpoint: 0.6*way, kp: 200, ki: 400, kd: 20, filter: 0.01, derivative_weight: 1, every: 0.002}"
    )
    expected = robot(tmp_path, own).run(until=0.2)
    found = robot(tmp_path, fmu(controller)).run(until=0.2)
    for name in ("real.q2", "real.x", "real.z", "actuator.servo.force"):
        scale = np.abs(expected[name]).max()
        assert np.abs(found[name] - expected[name]).max() < 1e-10 * scale, name
    without = robot(tmp_path, "0").run(until=0.2)
    assert np.abs(without["real.q2"] - expected["real.q2"]).max() > 1e-5


def test_it_may_run_in_a_process_of_its_own(controller, tmp_path):
    here = robot(tmp_path, fmu(controller)).run(until=0.05)
    there = robot(tmp_path, fmu(controller, ", process: true")).run(until=0.05)
    assert np.array_equal(here["real.q2"], there["real.q2"])


def test_what_python_raises_ends_the_run(controller, tmp_path):
    with pytest.raises(mimbre.SimulationError, match=r"signal 'trim': FMU 'Controller\d\.fmu' failed at t = 0\.002 s"):
        robot(tmp_path, fmu(controller, kp=-1)).run(until=0.05)


def test_it_has_no_state_that_could_be_saved(controller, tmp_path):
    simulation = robot(tmp_path, fmu(controller)).simulation()
    start = simulation.save()
    simulation.step(5)
    with pytest.raises(mimbre.InputError, match=r"the state of signal 'trim' .* cannot be saved"):
        simulation.restore(simulation.save())
    simulation.restore(start)
    simulation.step(5)

"""Steps against the clock."""

from pathlib import Path
from urllib.request import urlopen

import mimbre
import numpy as np
import pytest


@pytest.fixture
def simulation(rod: str) -> mimbre.Simulation:
    return mimbre.Model.from_text(rod).simulation()


def test_steps_are_those_of_a_run(simulation: mimbre.Simulation) -> None:
    other = simulation.clone()
    told = simulation.real_time(0.4, speed=10, lock_memory=False)
    other.step(200)
    assert told.steps == 200
    assert simulation.save() == other.save()
    assert told.message == ""
    assert 0 < told.computation.median <= told.computation.p99 <= told.computation.p9999 <= told.computation.worst
    assert told.overruns["count"] == sum(n for cause, n in told.overruns.items() if cause != "count")
    assert told.granted["memory"] == "not locked"
    assert "iterations" in told.worst_case


def test_a_controller_in_python_holds_the_rod(simulation: mimbre.Simulation) -> None:
    torque, angle = simulation.input_array(["torque"]), simulation.channel_array(["angle"])
    seen: list[float] = []

    def controller() -> None:
        rate = (angle[0] - seen[-1]) / 0.002 if seen else 0.0
        seen.append(float(angle[0]))
        torque[0] = -60 * angle[0] - 6 * rate

    simulation.real_time(3, speed=20, each_step=controller, lock_memory=False)
    assert len(seen) == 1500
    # The weight's moment against the controller's spring: 4.905 cos φ = 60 φ.
    assert np.isclose(seen[-1], 0.0815, atol=1e-3)


def test_what_a_controller_raises_ends_it(simulation: mimbre.Simulation) -> None:
    def broken() -> None:
        raise RuntimeError("no such valve")

    with pytest.raises(RuntimeError, match="no such valve"):
        simulation.real_time(10, each_step=broken, lock_memory=False)
    assert simulation.time < 0.1
    torque = simulation.input_array(["torque"])
    torque[0] = np.nan
    with pytest.raises(mimbre.InputError, match="torque"):
        simulation.real_time(10, lock_memory=False)


def test_a_page_is_served_and_a_file_recorded(
    simulation: mimbre.Simulation, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    answers: list[int] = []

    def look() -> None:
        if not answers:
            address = capsys.readouterr().out.strip()
            with urlopen(address + "status", timeout=120) as answer:
                answers.append(answer.status)

    simulation.real_time(0.5, each_step=look, page=True, record=tmp_path / "live.h5", lock_memory=False)
    assert answers == [200]
    run = mimbre.Run.open(tmp_path / "live.h5")
    assert run.time[-1] == pytest.approx(0.5)


@pytest.mark.parametrize(
    "wrong",
    [{"speed": 0}, {"duration": -1}, {"overrun": "hurry"}, {"priority": 100}, {"priority": 1.5}, {"spin": 3}],
)
def test_options_that_cannot_be(simulation: mimbre.Simulation, wrong: dict[str, object]) -> None:
    with pytest.raises((mimbre.InputError, mimbre.UnknownName)):
        simulation.real_time(**{"duration": 0.1, **wrong})  # type: ignore[arg-type]

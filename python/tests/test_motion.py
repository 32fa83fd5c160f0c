"""Motions of drives and the forces that make them, as the program computes them."""

from __future__ import annotations

import json

import mimbre
import numpy as np
import pytest
from conftest import made_pendulum, program


def driven(law: str) -> mimbre.Model:
    m = mimbre.ModelBuilder("Driven")
    m.add_body("bar", mass=0.6, com=[0.5, 0, 0], inertia=[1e-5, 0.05, 0.05])
    m.add_joint(
        "hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0], drive={"position": law}
    )
    m.set_simulation(step=0.01, end=2)
    return m.compile()


def torque(angle: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """About y, with the bar along x at angle 0: the weight turns it on."""
    return (0.05 + 0.6 * 0.25) * acceleration - 0.6 * 9.81 * 0.5 * np.cos(angle)


def test_drives_move_and_load_a_pendulum():
    model = driven("0.3*sin(4*t)")
    found = model.kinematics(steps=50)
    t = found.time
    assert (found.names, found.mobility, found.free, found.complete) == (["hinge"], 1, 0, True)
    np.testing.assert_allclose(found.of("hinge"), 0.3 * np.sin(4 * t), atol=1e-13)
    np.testing.assert_allclose(found.acceleration[:, 0], -4.8 * np.sin(4 * t), atol=1e-12)
    assert found.run["joint.hinge.position"] == pytest.approx(found.of("hinge"))
    forces = model.inverse_dynamics(steps=50)
    assert (forces.names, forces.units) == (["hinge"], ["N m"])
    np.testing.assert_allclose(forces["hinge"], torque(0.3 * np.sin(4 * t), -4.8 * np.sin(4 * t)), atol=1e-12)
    assert len(forces.run.time) == 51


def test_the_forces_of_a_run_are_those_that_made_it():
    m = mimbre.ModelBuilder("Pushed")
    m.add_body("bar", mass=0.6, com=[0.5, 0, 0], inertia=[1e-5, 0.05, 0.05])
    m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    m.add_actuator("motor", joint="hinge", torque="2*sin(3*t)")
    m.add_output("angle", joint="hinge")
    m.add_output("rate", joint_velocity="hinge")
    m.add_output("acceleration", angular_acceleration="bar", component="y")
    m.set_simulation(step=0.005, end=1)
    run = m.compile().run()
    motion = (run.time, {"hinge": (run["angle"], run["rate"], run["acceleration"])})
    found = driven("0").inverse_dynamics(motion)
    np.testing.assert_allclose(found["hinge"], 2 * np.sin(3 * run.time), atol=1e-8)


def test_a_table_is_the_program_s(tmp_path):
    t = np.linspace(0, 1, 101)
    table = tmp_path / "motion.csv"
    np.savetxt(table, np.column_stack([t, t**5]), delimiter=",", header="time,hinge", comments="")
    model = made_pendulum()
    found = model.inverse_dynamics(table)
    np.testing.assert_allclose(
        found["hinge"], torque(t**5, 20 * t**3) + 2 * t**5, atol=1e-7
    )  # a spline of degree 5 is exact
    assert model.inverse_dynamics((t, {"hinge": t**5}))["hinge"] == pytest.approx(found["hinge"], abs=1e-9)
    model.to_yaml(tmp_path / "model.yaml")
    said = json.loads(program("inverse-dynamics", tmp_path / "model.yaml", "--motion", table, "--json"))
    assert said["forces"]["hinge"]["largest"] == found["hinge"].max()


def test_a_dead_centre_is_named():
    """A bar whose end slides along x stops the drive of the slider where the bar is stretched."""
    m = mimbre.ModelBuilder("Ladder")
    one = {"mass": 1, "inertia": [1, 1, 1]}
    m.add_body("crank", com=[0.05, 0, 0], **one)
    m.add_body("rod", com=[0.2, 0, 0], **one)
    m.add_body("slider", com=[0.4, 0, 0], **one)
    m.add_joint(
        "crank", type="revolute", between=["ground", "crank"], at=[0, 0, 0], axis=[0, -1, 0], drive={"position": "t"}
    )
    m.add_joint("pin", type="revolute", between=["crank", "rod"], at=[0.1, 0, 0], axis=[0, -1, 0])
    m.add_joint("slide", type="prismatic", between=["ground", "slider"], at=[0.4, 0, 0], axis=[1, 0, 0])
    m.add_joint("wrist", type="revolute", between=["rod", "slider"], at=[0.4, 0, 0], axis=[0, -1, 0], cut="always")
    m.set_simulation(end=6)
    found = m.compile().kinematics(start=0.5)
    turns = [s for s in found.special if s.kind == "reversal" and s.joint == "slide"]
    assert [s.time for s in turns] == [pytest.approx(np.pi, abs=1e-7)]
    assert "dead centre" in turns[0].text
    with pytest.raises(KeyError, match="did you mean 'slide'"):
        found.of("slid")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"motion": ([0, 1], {"hing": [0, 1]})}, "did you mean 'hinge'"),
        ({"motion": ([0, 1], {"hinge": ([0, 1], [0, 1])})}, "positions, velocities, accelerations"),
        ({"motion": ([0, 1], {})}, "no joint coordinate"),
        ({"motion": ([0, np.nan], {"hinge": [0, 1]})}, "not finite"),
        ({"flexible": "stiff"}, "'dynamic' or 'quasistatic'"),
        ({"smooth": -1, "motion": ([0, 1], {"hinge": [0, 1]})}, "smooth"),
        ({"steps": 0}, "steps"),
        ({"inputs": {"x": 1}}, "x"),
    ],
)
def test_refuses(arguments, message):
    with pytest.raises((mimbre.InputError, mimbre.UnknownName), match=message):
        driven("t").inverse_dynamics(**arguments)


def test_drives_follow_filters_from_the_beginning() -> None:
    """A first-order lag of the time: t − (1 − exp(−10 t))/10."""
    model = mimbre.Model.from_text(
        """
        mimbre: 1
        gravity: [0, 0, 0]
        bodies: {b: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
        joints: {p: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0], drive: {position: f.y}}}
        signals: {f: {state_space: [t], A: [[-10]], B: [[10]], C: [[1]], outputs: [y]}}
        outputs: [{name: x, joint: p}]
        simulation: {step: 0.01, end: 1}
        """
    )
    for start in (0.0, 0.5):
        for steps in (7, 200):
            moved = model.kinematics(start=start, end=1, steps=steps)
            exact = moved.time - 0.1 * (1 - np.exp(-10 * moved.time))
            assert np.abs(moved.position[:, 0] - exact).max() < 1e-12
            forces = model.inverse_dynamics(start=start, end=1, steps=steps)
            assert np.abs(forces.force[:, 0] - 2 * 10 * np.exp(-10 * forces.time)).max() < 1e-9


def test_rows_far_apart_follow_filters_by_the_models_steps() -> None:
    model = mimbre.Model.from_text(
        """
        mimbre: 1
        gravity: [0, 0, 0]
        bodies: {b: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
        joints: {p: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0], drive: {position: f.y}}}
        signals: {f: {state_space: ["sin(8*t)"], A: [[-10]], B: [[10]], C: [[1]], outputs: [y]}}
        outputs: [{name: x, joint: p}]
        simulation: {step: 0.001, end: 1}
        """
    )
    for steps in (5, 20):
        moved = model.kinematics(steps=steps)
        t = moved.time
        exact = 10 / 164 * (10 * np.sin(8 * t) - 8 * np.cos(8 * t) + 8 * np.exp(-10 * t))
        assert np.abs(moved.position[:, 0] - exact).max() < 2e-5
        forces = model.inverse_dynamics(steps=steps).force[:, 0]
        rate = 10 * (np.sin(8 * t) - exact)
        assert np.abs(forces - 2 * 10 * (8 * np.cos(8 * t) - rate)).max() < 2e-2


def test_events_and_sampled_signals_count_where_all_is_prescribed() -> None:
    model = mimbre.Model.from_text(
        """
        mimbre: 1
        gravity: [0, 0, 0]
        inputs: {f: 0}
        bodies: {b: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
        joints: {p: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0], drive: {position: t}}}
        signals: {x1: {joint: p}, seen: {value: x1, every: 0.1}}
        events: {half: {when: x1, crosses: 0.55, set: {f: 7}}}
        actuators: {m: {joint: p, force: "f + 10*seen"}}
        simulation: {step: 0.01, end: 1}
        """
    )
    found = model.inverse_dynamics(start=0.05, end=0.95, steps=9)
    exact = [-(7 * (t > 0.55) + 10 * np.floor(10 * t + 1e-6) / 10) for t in found.time]
    apart = np.abs(found.force[:, 0] - exact)
    assert apart[np.abs(found.time - 0.55) > 0.01].max() < 1e-6
    held = model.inverse_dynamics(start=0.05, end=0.95, steps=9, flexible="quasistatic")
    assert any("events do not happen here" in warning for warning in held.warnings)


@pytest.mark.parametrize("law", ["-0.3*(1 - cos(5*t))", "-0.7*t", "-0.5*t"])
def test_a_slider_moves_a_crank_out_of_its_dead_centre(law: str) -> None:
    model = mimbre.Model.from_text(
        """
        mimbre: 1
        bodies:
          k: {mass: 1, com: [0.15, 0, 0], inertia: [1, 1, 1]}
          c: {mass: 1, com: [0.3, 0, 0], inertia: [1, 1, 1]}
          s: {mass: 1, com: [1.3, 0, 0], inertia: [1, 1, 1]}
        joints:
          A: {type: revolute, between: [ground, k], at: [0, 0, 0], axis: [0, 1, 0], near: 0.2}
          B: {type: revolute, between: [k, c], at: [0.3, 0, 0], axis: [0, 1, 0]}
          C: {type: revolute, between: [s, c], at: [1.3, 0, 0], axis: [0, 1, 0]}
          D: {type: prismatic, between: [ground, s], at: [1.3, 0, 0], axis: [1, 0, 0], drive: {position: "LAW"}}
        simulation: {step: 0.01, end: 1}
        """.replace("LAW", law)
    )
    found = model.kinematics()
    crank, slider = np.abs(found.position[:, 0]), found.position[:, found.names.index("D")] + 1.3
    closed = np.arccos(np.clip((0.09 + slider**2 - 1) / (0.6 * slider), -1, 1))
    assert np.allclose(np.minimum(crank, 2 * np.pi - crank), closed, atol=1e-5)
    assert crank[-1] < 2 * np.pi
    if law == "-0.7*t":  # to where the loop closes no more
        assert not found.complete
        assert found.time[-1] == pytest.approx(0.6 / 0.7, abs=0.006)
    else:
        assert found.complete
        assert found.time[-1] == 1

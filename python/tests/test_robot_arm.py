"""The robot arm of examples/python against what can be said of it by hand."""

from __future__ import annotations

import runpy
from types import SimpleNamespace

import matplotlib as mpl
import mimbre
import numpy as np
import pytest
from conftest import top


@pytest.fixture(scope="module")
def example(tmp_path_factory) -> SimpleNamespace:
    """Run once, with what it leaves."""
    mpl.use("Agg")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("arm"))
        return SimpleNamespace(**runpy.run_path(str(top / "examples/python/robot_arm.py")))


def test_the_arm_sags_as_beams_do(example):
    """Stretched out, its joints locked: a cantilever that turns the one at its end."""
    e = example
    bending = e.YOUNG * np.pi / 64 * (e.OUTER**4 - e.INNER**4)
    weight, length = e.LINK / e.LENGTH * e.GRAVITY, e.LENGTH
    tip = e.PAYLOAD * e.GRAVITY
    force = (e.LINK + e.MOTOR + e.PAYLOAD) * e.GRAVITY  # at the elbow
    moment = e.LINK * e.GRAVITY * length / 2 + tip * length
    at_elbow = force * length**3 / 3 + moment * length**2 / 2 + weight * length**4 / 8
    turned = force * length**2 / 2 + moment * length + weight * length**3 / 6
    beyond = tip * length**3 / 3 + weight * length**4 / 8
    sag = (at_elbow + turned * length + beyond) / bending
    model = e.arm(flexible=True, locked=True).compile()
    found = e.HEIGHT - mimbre.static(model)["tip.z"]
    assert 0.01 < sag < 0.1
    assert found == pytest.approx(sag, rel=5e-3)
    assert e.HEIGHT - mimbre.static(e.arm(flexible=False, locked=True).compile())["tip.z"] == pytest.approx(0, abs=1e-9)


def test_the_torques_are_those_of_the_rigid_arm(example):
    """What the controller computes, against the simulation: it accelerates as was wanted."""
    e, step = example, 1e-5
    random = np.random.default_rng(5)
    for _ in range(4):
        q, a = random.uniform(-1, 1, (2, 3))
        sim = e.arm(flexible=False, at=q).compile().simulation(step=step)
        sim.input_array(list(e.JOINTS))[:] = e.needed(q, np.zeros(3), a)
        rates = sim.channel_array([f"{joint}.rate" for joint in e.JOINTS])
        sim.step(100)
        assert rates / (100 * step) == pytest.approx(a, abs=5e-3)


def test_the_joints_go_where_they_are_to(example):
    for motion, most in ((example.rigid, 1e-3), (example.flexible, 0.03)):
        off = np.abs(motion.angle - [example.wanted(t)[0] for t in motion.time])
        assert off.max() < most
        assert off[-1].max() < most / 3
    assert example.rigid.error.max() < 1e-3
    # What the tip of the flexible one hangs lower is of the size of the sag.
    assert 5e-3 < example.flexible.error[-1] < 0.05


@pytest.mark.parametrize("name", ["rigid", "flexible"])
def test_the_motors_give_what_the_arm_has_more_and_loses(example, name):
    """From when it is to go until it has come. The work is that of the trapezoidal rule, as which the integrator
    takes a torque that is another one from step to step."""
    motion = getattr(example, name)
    start = int(np.searchsorted(motion.time, example.HOLD - 1e-9))
    stop = int(np.searchsorted(motion.time, example.HOLD + example.DURATION - 1e-9))
    mean = (motion.torque[start:stop] + motion.torque[start - 1 : stop - 1]) / 2
    work = np.sum(mean * np.diff(motion.angle, axis=0)[start:stop])
    first, last = motion.energy[start], motion.energy[stop]
    gained = sum(last[term] - first[term] for term in ("kinetic", "gravitational", "elastic"))
    lost = last["dissipated"] - first["dissipated"]
    assert work > 1
    assert (lost > 0.01) == (name == "flexible")
    assert work == pytest.approx(gained + lost, rel=1e-4)


def test_played_torques_are_the_same_motion(example):
    assert np.array_equal(example.played["tip.z"], example.flexible.tip[:, 2])

"""Buckling loads and equilibria beyond them, against closed forms."""

from __future__ import annotations

import json

import mimbre
import numpy as np
import pytest
from conftest import program

COLUMN = """mimbre: 1
gravity: [0, 0, 0]
bodies: {column: {mass: 1, com: [0, 0, 0.5], inertia: [0.1, 0.1, 0.1]}}
frames: {top: {body: column, at: [0, 0, 1]}}
joints: {foot: {type: revolute, between: [ground, column], at: [0, 0, 0], axis: [0, 1, 0], spring: {stiffness: 10}}}
loads: {press: {on: top, force: [0, 0, -1]}}
outputs: [{name: angle, joint: foot}]
"""


@pytest.fixture
def column():
    return mimbre.Model.from_text(COLUMN)


def test_buckling_of_a_column_on_a_spring(column):
    found = column.buckling()
    assert found.loads == ["press"]
    assert found[0].factor == pytest.approx(10, rel=1e-6)
    assert found[0].shape["foot"] ** 2 * 10 / 2 == pytest.approx(1, rel=1e-6)
    assert found[0].text == "'foot' 100 %"


def test_the_path_beyond_it(column):
    heard = []
    path = column.equilibrium_path(end=15, progress=lambda factor, points: heard.append((factor, points)))
    assert len(path) == 3
    assert [(s.kind, s.moving) for s in path[0].special] == [("bifurcation", "'foot' 100 %")]
    assert path[0].factors[path[0].special[0].point] == pytest.approx(10, rel=1e-8)
    assert path.units == {"angle": "rad"}
    for branch in path.branches[1:]:
        assert branch.parent == 0
        assert branch.end == ""
        assert branch.factors[-1] == pytest.approx(15)
        np.testing.assert_allclose(branch.factors * np.sin(branch["angle"]), 10 * branch["angle"], atol=1e-7)
        assert set(branch.unstable[1:]) == {0}
    assert path[1]["angle"][-1] == pytest.approx(-path[2]["angle"][-1])
    assert len(heard) == sum(len(branch.factors) for branch in path.branches)


def test_what_is_refused(column):
    with pytest.raises(mimbre.InputError, match="did you mean 'press'"):
        column.equilibrium_path(loads=["pres"])
    with pytest.raises(mimbre.InputError, match="no range"):
        column.equilibrium_path(start=1)
    with pytest.raises(mimbre.InputError, match="at least 1"):
        column.buckling(count=0)
    with pytest.raises(mimbre.InputError, match="did you mean 'angle'"):
        column.equilibrium_path()[0]["angl"]

    def stop(factor, points):
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        column.equilibrium_path(end=15, progress=stop)


def test_the_program_says_the_same(column, tmp_path):
    (tmp_path / "column.yaml").write_text(COLUMN)
    file, table = tmp_path / "column.yaml", tmp_path / "path.csv"
    answer = json.loads(program("static", file, "--path", "--to", 15, "--json", "-o", table))
    path = column.equilibrium_path(end=15)
    assert [len(branch["points"]) for branch in answer["branches"]] == [len(b.factors) for b in path.branches]
    assert answer["branches"][1]["points"][-1]["outputs"]["angle"] == path[1]["angle"][-1]
    lines = table.read_text().splitlines()
    assert lines[0] == "branch,factor,unstable,point,angle"
    assert len(lines) == 1 + sum(len(b.factors) for b in path.branches)


ON_A_SPRING = """
mimbre: 1
bodies: {b: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints: {p: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1], spring: {stiffness: 100}}}
outputs: [{name: z, joint: p}]
signals:
  place: {joint: p}
  pull: PULL
actuators: {m: {joint: p, force: "-pull"}}
simulation: {step: 0.002}
"""


def test_events_do_not_happen_at_rest() -> None:
    text = ON_A_SPRING.replace("PULL", "0") + "events: {low: {when: place, crosses: -1}}\n"
    found = mimbre.static(mimbre.Model.from_text(text))
    assert found["z"] == pytest.approx(-2 * 9.81 / 100, rel=1e-9)
    assert not found.warnings


@pytest.mark.parametrize(
    ("signal", "moves"),
    [
        ("{transfer_function: place, numerator: [30], denominator: [0.1, 1]}", True),
        ("{transfer_function: place, numerator: [30], denominator: [1, -0.5], every: 0.01}", True),
        ('{value: "-50*place", every: 0.01}', True),
        ("{state_space: ['2 + 0*place'], A: [[-10]], B: [[10]], C: [[1]], initial: [2]}", False),
        ("{delay: place, time: 0.1}", False),
        ("{hysteresis: place, rises_at: 0.1, falls_at: -0.1}", False),
        ("30*place", False),
    ],
)
def test_signals_that_would_not_stay_are_named(signal: str, moves: bool) -> None:
    found = mimbre.static(mimbre.Model.from_text(ON_A_SPRING.replace("PULL", signal)))
    assert any("'pull' would not stay" in warning for warning in found.warnings) == moves, found.warnings

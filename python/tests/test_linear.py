"""Linear models, modes and Campbell diagrams: the program's, and closed forms."""

from __future__ import annotations

import json
import math

import h5py
import mimbre
import numpy as np
import pytest
from conftest import program

CART = """mimbre: 1
title: Cart
gravity: [0, 0, 0]
parameters: {stiffness: 100}
bodies: {cart: {mass: 4, com: [0, 0, 0], inertia: [1, 1, 1]}}
joints:
  rail: {type: prismatic, between: [ground, cart], at: [0, 0, 0], axis: [1, 0, 0],
         spring: {stiffness: stiffness, damping: 8}}
inputs: {push: {start: 0, unit: N}}
actuators: {motor: {joint: rail, force: 3*push}}
outputs:
  - {name: x, joint: rail}
  - {name: a, joint_acceleration: rail}
"""


@pytest.fixture
def cart():
    return mimbre.Model.from_text(CART)


def test_the_linear_model_of_a_cart(cart):
    linear = cart.linearise()
    assert linear.point == "equilibrium"
    np.testing.assert_allclose(linear.A, [[0, 1], [-25, -2]], atol=1e-12)
    np.testing.assert_allclose(linear.B, [[0], [0.75]], atol=1e-12)
    np.testing.assert_allclose(linear.C, [[1, 0], [-25, -2]], atol=1e-9)
    np.testing.assert_allclose(linear.D, [[0], [0.75]], atol=1e-9)
    assert (linear.states, linear.state_units) == (["rail", "d/dt rail"], ["m", "m/s"])
    assert (linear.inputs, linear.input_units, linear.outputs) == (["push"], ["N"], ["x", "a"])
    assert (linear.coordinates, linear.speeds, linear.input_values) == (1, 1, [0])
    s = 2j * math.pi * 3
    np.testing.assert_allclose(linear.response([3])[0, :, 0], np.array([3, 3 * s**2]) / (4 * s**2 + 8 * s + 100))


def test_scipy_s_object(cart):
    system = cart.linearise().to_scipy()
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(system.A)), np.sort_complex(np.roots([4, 8, 100])))
    no_inputs = mimbre.Model.from_text(CART.replace("inputs: {push: {start: 0, unit: N}}\n", "").replace("3*push", "1"))
    with pytest.raises(mimbre.InputError, match="has no inputs"):
        no_inputs.linearise().to_scipy()


def test_control_s_object(cart):
    control = pytest.importorskip("control")
    system = cart.linearise().to_control()
    assert isinstance(system, control.StateSpace)
    assert system.input_labels == ["push"]
    assert system.output_labels == ["x", "a"]


def test_files_are_those_of_the_program(cart, tmp_path):
    (tmp_path / "cart.yaml").write_text(CART)
    said = json.loads(program("linearise", tmp_path / "cart.yaml", "--json"))
    cart.linearise().save(tmp_path / "cart.json")
    saved = json.loads((tmp_path / "cart.json").read_text())
    assert {**said, "title": ""} == {**saved, "title": ""}
    with pytest.raises(mimbre.InputError, match="no format that is known"):
        cart.linearise().save(tmp_path / "cart.txt")


def test_modes_are_saved_with_their_shapes(cart, tmp_path):
    modes = cart.modes()
    modes.save(tmp_path / "shapes.h5")
    with h5py.File(tmp_path / "shapes.h5") as file:
        assert file.attrs["format"] == b"mimbre-mechanism-modes-1"
        value = file["value_real"][:] + 1j * file["value_imaginary"][:]
        np.testing.assert_allclose(value, modes.values)
        moved = file["displacement_real"][:] + 1j * file["displacement_imaginary"][:]
        np.testing.assert_allclose(moved, [[[modes[0].shape[0], 0, 0]]], atol=1e-12)
        assert [name.decode() for name in file["body_names"]] == ["cart"]
    assert modes.save_vtk(tmp_path / "vtk") == str(tmp_path / "vtk" / "mode_1.pvd")
    assert len(list((tmp_path / "vtk").glob("mode_1_*.vtp"))) == 24
    with pytest.raises(mimbre.InputError, match=r"\.html or \.h5"):
        modes.save(tmp_path / "shapes.csv")


def test_pages_of_modes_and_of_bode_plots(cart, tmp_path):
    try:
        cart.modes().save(tmp_path / "shapes.html")
    except RuntimeError as error:
        pytest.skip(str(error))  # built without the pages
    assert "mimbre-mechanism-modes-1" in (tmp_path / "shapes.html").read_text(encoding="utf-8")
    linear = cart.linearise()
    linear.save(tmp_path / "bode.html", np.geomspace(0.1, 10, 20))
    assert "mimbre-bode-1" in (tmp_path / "bode.html").read_text(encoding="utf-8")
    for frequencies in (), [1], [2, 1], [0, 1]:
        with pytest.raises(mimbre.InputError, match="a page of Bode plots needs"):
            linear.save(tmp_path / "bode.html", frequencies)
    mute = mimbre.Model.from_text(CART[: CART.index("outputs:")]).linearise()
    with pytest.raises(mimbre.InputError, match="has no outputs"):
        mute.save(tmp_path / "bode.html", [1, 2])


def test_modes_are_those_of_the_program(examples):
    path = examples / "double-wishbone/model.yaml"
    modes = mimbre.Model.from_file(path).modes(most=4)
    said = json.loads(program("modes", path, "--most", 4, "--json"))
    assert modes.point == said["point"]
    assert modes.coordinates == said["coordinates"]
    assert len(modes) == len(said["modes"])
    for mode, other in zip(modes, said["modes"], strict=True):
        assert mode.value == complex(other["real"], other["imaginary"])
        assert mode.text == other["text"]
        assert mode.kind == other["kind"]
        np.testing.assert_array_equal(mode.shape, [complex(*x) for x in other["shape"]])


def test_modes_by_either_solver(examples):
    model = mimbre.Model.from_file(examples / "pendulum/flexible.yaml")
    dense = model.modes(most=3, solver="dense")
    sparse = model.modes(most=3, solver="sparse")
    np.testing.assert_allclose(sparse.values, dense.values, rtol=1e-8)
    assert any("sparse matrices" in note for note in sparse.notes)
    assert not any("sparse matrices" in note for note in dense.notes)
    with pytest.raises(mimbre.InputError, match="solver of modes"):
        model.modes(solver="iterative")
    # It has no states, as tyres and bushings have them.
    with pytest.raises(mimbre.SimulationError, match="sparse solver cannot find these modes"):
        mimbre.Model.from_file(examples / "double-wishbone/model.yaml").modes(most=4, solver="sparse")


def test_modes_of_a_cart(cart):
    (mode,) = cart.modes()
    assert mode.value == pytest.approx(complex(-1, math.sqrt(24)))
    assert (mode.frequency, mode.damping) == pytest.approx((5 / (2 * math.pi), 0.2))
    assert mode.coordinates == {"'rail'": pytest.approx(1)}
    assert cart.modes().values == pytest.approx([mode.value])
    assert cart.modes(at=0.5).point == "t = 0.5 s"


def test_blades_are_in_waves(examples):
    path = examples / "wind-turbine/model.yaml"
    modes = mimbre.Model.from_file(path, weight=0).modes(at=25, most=3)
    assert {next(iter(mode.blades)) for mode in modes} == {"collective", "forward", "backward"}
    assert all(max(mode.blades.values()) > 0.999 for mode in modes)
    assert modes[0].text.startswith("blades ")


def test_modes_over_a_parameter(cart):
    values = [50, 100, 200]
    diagram = cart.campbell("stiffness", values)
    (branch,) = diagram.branches
    np.testing.assert_allclose(branch.values, -1 + 1j * np.sqrt(np.array(values) / 4 - 1))
    assert diagram.criticals == diagram.onsets == []


def test_friswell_s_rotor_over_the_speed(examples):
    """Seen from the ground, at 4000 rpm: Friswell et al., Dynamics of Rotating Machines (2010)."""
    model = mimbre.Model.from_file(examples / "rotor/two-discs.yaml")
    diagram = model.campbell("rpm", np.linspace(0, 4000, 9), speed="rpm", at="steady")
    last = sorted(abs(branch.values[-1].imag) for branch in diagram.branches)
    for published in (85.39, 87.80, 251.78, 294.71, 600.18, 650.41):
        assert min(abs(value - published) for value in last) < 1e-3 * published
    first = sorted(abs(branch.values[0].imag) for branch in diagram.branches)
    for published in (86.66, 274.31, 650.41, 716.78):
        assert sum(abs(value - published) < 3e-4 * published for value in first) == (1 if published == 650.41 else 2)
    # Each speed is the frequency of the mode there.
    assert [round(c.value) for c in diagram.criticals if c.value > 100][:2] == pytest.approx([822, 833], abs=8)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"at": "noon"}, "equilibrium"),
        ({"at": -1.0}, "a time from 0 on"),
        ({"delay_order": 9}, "1 to 8"),
        ({"inputs": {"pull": 1}}, "pull"),
        ({"inputs": {"push": "much"}}, "a number is needed"),
    ],
)
def test_what_is_no_point_is_refused(cart, arguments, message):
    with pytest.raises(mimbre.InputError, match=message):
        cart.linearise(**arguments)
    with pytest.raises(mimbre.InputError, match=message):
        cart.modes(**arguments)


def test_what_cannot_be_followed_is_refused(cart):
    with pytest.raises(mimbre.InputError, match="each larger"):
        cart.campbell("stiffness", [3, 2])
    with pytest.raises(mimbre.InputError, match="stiffnes"):
        cart.campbell("stiffnes", [2, 3])
    with pytest.raises(mimbre.InputError, match="rpm"):
        cart.campbell("stiffness", [2, 3], speed="rpms")


def test_a_motion_without_mass_is_named():
    text = CART.replace("mass: 4", "mass: 0").replace("[1, 1, 1]", "[0, 0, 0]")
    with pytest.raises(mimbre.SimulationError, match="'rail' moves no mass"):
        mimbre.Model.from_text(text).modes(at="start")


RIGID = {"arms": "rigid", "links": "rigid", "rods": "rigid"}
CONDITIONS = ["--hold", "speed=12", "--hold", "radius=80", "--find", "steering", "--find", "throttle"]


@pytest.fixture
def driven(examples):
    return mimbre.Model.from_file(examples / "iltis" / "steady.yaml", **RIGID)


def driven_by_program(command, examples, *words):
    settings = [text for name, value in RIGID.items() for text in ("--set", f"{name}={value}")]
    return json.loads(program(command, examples / "iltis" / "steady.yaml", *settings, *words, "--json"))


def test_a_point_of_steady_driving_is_that_of_the_program(driven, examples):
    hold, find = {"speed": 12, "radius": 80}, ["steering", "throttle"]
    modes = driven.modes(at="steady", hold=hold, find=find, body="chassis")
    said = driven_by_program("modes", examples, *CONDITIONS)
    assert modes.point == said["point"] == "steady driving at 12 m/s, 1.8 m/s² to the left"
    assert list(modes.values) == [complex(mode["real"], mode["imaginary"]) for mode in said["modes"]]
    linear = driven.linearise(hold=hold, find=find)
    written = driven_by_program("linearise", examples, *CONDITIONS)
    np.testing.assert_array_equal(linear.A, written["A"])
    assert linear.point == modes.point
    # The inputs of the point are those of trim.
    turn = driven.trim(speed=12, radius=80, find=find)
    assert linear.input_values[linear.inputs.index("steering")] == turn.inputs["steering"]


def test_modes_over_a_held_condition_are_those_of_each_value(driven, examples):
    diagram = driven.campbell("hold.speed", [8, 12, 16], hold={"radius": 80}, find=["steering", "throttle"])
    assert diagram.parameter == "speed"
    said = driven_by_program("modes", examples, *CONDITIONS, "--over", "hold.speed=8:16:3")
    assert len(said["branches"]) == len(diagram.branches)
    for branch, other in zip(diagram.branches, said["branches"], strict=True):
        assert branch.name == other["name"]
    alone = driven.modes(hold={"speed": 16, "radius": 80}, find=["steering", "throttle"]).values
    last = np.array([branch.values[-1] for branch in diagram.branches])
    for value in alone:
        assert np.nanmin(np.abs(last - value)) <= 1e-6 * max(1, abs(value))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"hold": {"sped": 20}, "find": ["throttle"]}, "did you mean 'speed'"),
        ({"hold": {"speed": "fast"}, "find": ["throttle"]}, "speed: a number is needed"),
        ({"hold": {"speed": 20}}, "0 inputs to find"),
        ({"hold": {"speed": 20}, "find": ["throttel"]}, "throttel"),
        ({"hold": {"speed": 20}, "find": ["throttle"], "at": "start"}, "steady driving"),
        ({"hold": {"speed": 20}, "find": ["throttle"], "body": "hood"}, "chassis"),
    ],
)
def test_conditions_that_do_not_go_together_are_refused(driven, arguments, message):
    for find in (driven.linearise, driven.modes):
        with pytest.raises(mimbre.InputError, match=message):
            find(**arguments)


def test_a_condition_with_the_name_of_a_parameter_is_refused(driven):
    """The parameter `speed` of the file is that of the start."""
    with pytest.raises(mimbre.InputError, match=r"write 'hold\.speed' for the condition"):
        driven.campbell("speed", [10, 12], hold={"speed": 10}, find=["throttle"])
    with pytest.raises(mimbre.InputError, match="find looks for this input"):
        driven.campbell("throttle", [0, 1], hold={"speed": 10}, find=["throttle"])
    with pytest.raises(mimbre.SimulationError, match="lateral_acceleration = 30: no steady driving"):
        driven.campbell(
            "lateral_acceleration",
            [1, 30],
            hold={"speed": 20, "lateral_acceleration": 1},
            find=["steering", "throttle"],
        )


def test_steady_driving_is_that_of_the_program(examples):
    path = examples / "iltis" / "steady.yaml"
    rigid = {"arms": "rigid", "links": "rigid", "rods": "rigid"}
    turn = mimbre.Model.from_file(path, **rigid).trim(speed=20, radius=200, find=["steering", "throttle"])
    settings = [text for name, value in rigid.items() for text in ("--set", f"{name}={value}")]
    conditions = ["--hold", "speed=20", "--hold", "radius=200", "--find", "steering", "--find", "throttle"]
    said = json.loads(program("trim", path, *settings, *conditions, "--json"))
    assert turn.inputs == said["inputs"]
    assert turn["rack"] == said["outputs"]["rack"]
    assert turn.yaw_rate == pytest.approx(0.1, rel=1e-9)
    with pytest.raises(mimbre.InputError, match="to find"):
        mimbre.Model.from_file(path, **rigid).trim(speed=20, find=["steering", "throttle"])

"""Simulations, step by step: handles, states, copies."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
import threading
import time

import mimbre
import numpy as np
import pytest


def test_steps_are_those_of_a_run(pendulum):
    run = pendulum.run(until=0.515)
    sim = pendulum.simulation()
    angle = sim.channel("angle")
    values = [angle.value]
    for _ in range(51):
        sim.step()
        values.append(angle.value)
    sim.step_until(0.515)
    values.append(angle.value)
    assert np.array_equal(values, run["angle"])
    other = pendulum.simulation()
    other.step_until(0.515)
    assert other.time == run.time[-1]
    assert other.channel("angle").value == run["angle"][-1]
    other = pendulum.simulation()
    other.step(51)
    assert other.channel("angle").value == run["angle"][51]


def test_steps_are_not_counted_below_zero(pendulum):
    sim = pendulum.simulation()
    sim.step(2)
    time = sim.time
    sim.step(0)
    with pytest.raises(mimbre.InputError, match=r"step: count is -1; it cannot be below 0"):
        sim.step(-1)
    assert sim.time == time


def test_inputs_and_parameters_by_handle(pendulum):
    sim = pendulum.simulation()
    torque, k = sim.input("torque"), sim.input("k")
    assert (torque.name, torque.min, torque.max, torque.tunable) == ("torque", -1, 1, False)
    assert k.tunable
    torque.value = 5
    assert torque.value == 1  # kept within its range
    k.value = 3.5
    sim.step(10)
    run = pendulum.run(inputs={"torque": 1, "k": 3.5}, until=0.1)
    assert sim.channel("angle").value == run["angle"][-1]
    assert sim.channel("angle").unit == "rad"
    with pytest.raises(mimbre.InputError, match="nan"):
        torque.value = float("nan")
    assert torque.value == 1


def test_arrays_of_inputs_and_channels_are_live(pendulum):
    sim = pendulum.simulation()
    u = sim.input_array(["torque", "k"])
    y = sim.channel_array(["angle", "rate", "z"])
    u[:] = 0.5, 1.5
    address = y.__array_interface__["data"][0]
    sim.step(20)
    run = pendulum.run(inputs={"torque": 0.5, "k": 1.5}, until=0.2)
    assert np.array_equal(y, [run[name][-1] for name in ("angle", "rate", "z")])
    assert y.__array_interface__["data"][0] == address
    u[0] = np.nan
    with pytest.raises(mimbre.InputError, match=r"'torque': is nan"):
        sim.step()
    del sim
    assert np.isfinite(y).all()  # the memory outlives the simulation


def test_an_input_array_counts_as_long_as_it_is_kept(pendulum):
    sim = pendulum.simulation()
    torque, k = sim.input("torque"), sim.input("k")
    u = sim.input_array(["torque"])
    u[0] = 0.5
    sim.step()
    torque.value = 0.7
    sim.step()
    assert torque.value == 0.5
    del u
    torque.value = 0.7
    sim.step()
    assert torque.value == 0.7
    sim.input_array(["torque"])[0] = -0.5  # counts, though nobody keeps the array
    sim.step()
    assert torque.value == -0.5
    both = sim.input_array(["torque", "k"])
    both[:] = 0.1, 3
    other = sim.input_array(["torque"])
    other[0] = 0.2
    sim.step()
    assert (torque.value, k.value) == (0.2, 3)
    del other
    both[:] = 0.3, 4
    sim.step()
    assert (torque.value, k.value) == (0.2, 4)
    state = sim.save()
    both[1] = 5
    sim.step()
    sim.restore(state)
    assert both[1] == k.value == 4


def test_arrays_that_are_left_cost_nothing(pendulum):
    sim = pendulum.simulation()

    def seconds() -> float:
        begin = time.perf_counter()
        sim.step(5000)
        return time.perf_counter() - begin

    few = min(seconds() for _ in range(3))
    for _ in range(5000):
        sim.input_array(["torque", "k"])[0] = 0.1
        sim.channel_array(["angle", "z"])
    assert sim.input("torque").value == 0
    sim.step()
    assert sim.input("torque").value == 0.1
    assert min(seconds() for _ in range(3)) < 10 * few


def test_a_restored_state_goes_on_to_the_same_bits(pendulum, examples):
    vehicle = mimbre.Model.from_file(examples / "iltis/vehicle.yaml")
    for model, channel in ((pendulum, "angle"), (vehicle, "chassis.z")):
        sim = model.simulation()
        sim.step(15)
        state = sim.save()
        assert isinstance(state, bytes)
        z = sim.channel_array([channel])
        sim.step(15)
        wanted = z.copy()
        sim.restore(state)
        sim.step(15)
        assert z == wanted
        for other in (sim.clone(), copy.copy(sim), copy.deepcopy(sim), pickle.loads(pickle.dumps(sim))):
            assert other.time == sim.time
            assert other.channel(channel).value == wanted[0]
            assert other.save() == sim.save()


def test_a_pickled_simulation_goes_on_in_another_process(examples, tmp_path):
    sim = mimbre.Model.from_file(examples / "solid-arm/suspension.yaml").simulation(step=0.002)
    sim.step(5)
    (tmp_path / "sim").write_bytes(pickle.dumps(sim))
    sim.step(5)
    code = f"import pickle; s = pickle.load(open({str(tmp_path / 'sim')!r}, 'rb')); s.step(5); print(s.save().hex())"
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert other.stdout.strip() == sim.save().hex()


def test_restoring_restores_what_input_arrays_say(pendulum):
    """They would put their old values over the inputs of the state at the next step."""
    sim = pendulum.simulation()
    u = sim.input_array(["torque", "k"])
    u[:] = 0.5, 1.5
    sim.step(5)
    state = sim.save()
    sim.step(5)
    wanted = sim.save()
    u[:] = -1, 7
    sim.step(5)
    sim.restore(state)
    assert u.tolist() == [0.5, 1.5]
    sim.step(5)
    assert sim.save() == wanted


@pytest.mark.parametrize("formulation", ["relative", "natural"])
def test_a_simulation_starts_with_other_inputs(pendulum, formulation):
    """As a run does; copies too."""
    sim = pendulum.simulation(inputs={"torque": 0.5, "k": 3}, formulation=formulation)
    assert (sim.input("torque").value, sim.input("k").value) == (0.5, 3)
    run = pendulum.run(inputs={"torque": 0.5, "k": 3}, until=0.1, formulation=formulation)
    z = sim.channel("z")
    values = [z.value]
    for other in (sim.clone(), pickle.loads(pickle.dumps(sim))):
        assert other.save() == sim.save()
    for _ in range(10):
        sim.step()
        values.append(z.value)
    assert np.array_equal(values, run["z"])
    for wrong, message in (({"torc": 1}, "torc"), ({"k": float("nan")}, "finite"), (3, "names with numbers")):
        with pytest.raises(mimbre.InputError, match=message):
            pendulum.simulation(inputs=wrong)


def test_iterations_parts_and_a_fixed_cost(pendulum):
    few, whole = pendulum.simulation(step=0.05, fixed_cost=True, max_iterations=2), pendulum.simulation(step=0.05)
    for sim in (few, whole):
        sim.step_until(1)
    apart = abs(few.channel("angle").value - whole.channel("angle").value)
    assert 0 < apart < 0.05
    pendulum.simulation(max_iterations=5, substeps=2).step()
    given = mimbre.Model.from_text(
        "mimbre: 1\nbodies: {a: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}\nsimulation: {fixed_cost: true}\n"
    )
    given.simulation(fixed_cost=False, substeps=3).step()
    with pytest.raises(mimbre.InputError, match=r"leave substeps out, or take fixed_cost=False, too"):
        given.simulation(substeps=3)
    for method, said in (
        ({"fixed_cost": 1}, "True or False"),
        ({"fixed_cost": True, "substeps": 3}, "fixed_cost makes each step once; leave substeps out"),
        ({"max_iterations": 0}, "from 1 to 1000"),
        ({"max_iterations": 2.5}, "whole number"),
    ):
        with pytest.raises(mimbre.InputError, match=said):
            pendulum.simulation(**method)


def test_unknown_names_are_key_errors(pendulum):
    sim = pendulum.simulation()
    for ask in (sim.channel, sim.input, sim.pose, lambda name: pendulum.run(inputs={name: 1})):
        with pytest.raises(KeyError, match=r"there is no .*'angel'") as raised:
            ask("angel")
        assert isinstance(raised.value, mimbre.UnknownName)
        assert raised.value.diagnostics[0].message == str(raised.value)
    with pytest.raises(mimbre.UnknownName, match=r"did you mean 'angle'\?"):
        sim.channel_array(["angel"])
    with pytest.raises(mimbre.UnknownName, match="there is no body 'baar'"):
        mimbre.select(pendulum, "baar", error=0.01)


def test_no_equilibrium_is_an_input_error():
    """Of what falls."""
    m = mimbre.ModelBuilder(initial="equilibrium")
    m.add_body("stone", mass=1, com=[0, 0, 0], inertia=[1, 1, 1])
    m.add_joint("rail", type="prismatic", between=["ground", "stone"], at=[0, 0, 0], axis=[0, 0, 1])
    with pytest.raises(mimbre.InputError, match="equilibrium"):
        m.compile().simulation()


def test_a_state_of_another_model_is_refused(pendulum, examples):
    other = mimbre.Model.from_file(examples / "tutorial/pendulum.yaml").simulation()
    sim = pendulum.simulation()
    for state in (
        other.save(),
        b"",
        b"x" * 1000,
        sim.save()[:-1],
        sim.save()[:50] + b"\xff" + sim.save()[51:],
    ):
        with pytest.raises(mimbre.InputError):
            sim.restore(state)
    sim.step()


def test_one_simulation_is_for_one_thread(pendulum):
    """Others are told instead of crashing."""
    sim = pendulum.simulation()
    thread = threading.Thread(target=lambda: sim.step(300_000))
    thread.start()
    refused = 0
    while thread.is_alive():
        try:
            _ = sim.time
        except mimbre.SimulationError as error:
            assert "another thread" in str(error)  # noqa: PT017
            refused += 1
    thread.join()
    assert refused > 0
    assert sim.time == pytest.approx(3000)


def test_a_failed_step_leaves_the_state(pendulum):
    m = mimbre.ModelBuilder()
    m.add_body("bar", mass=1, com=[0.5, 0, 0], inertia=[1e-3, 0.1, 0.1])
    m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    m.add_actuator("motor", joint="hinge", torque="t < 0.1 ? 0 : sqrt(0.1 - t)")
    sim = m.compile().simulation()
    with pytest.raises(mimbre.SimulationError):
        sim.step(100)
    time = sim.time
    with pytest.raises(mimbre.SimulationError):
        sim.step()
    assert sim.time == time


def test_energy_pose_and_names(pendulum):
    sim = pendulum.simulation()
    sim.step(30)
    assert sim.energy["kinetic"] > 0
    position, rotation = sim.pose("bar")
    assert position[2] == sim.channel("z").value
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)
    assert sim.input_names() == ["torque", "k"] or sorted(sim.input_names()) == ["k", "torque"]
    assert "angle" in sim.channel_names()
    assert "0.3" in repr(sim)
    assert sim.model is pendulum


def test_a_contact_after_free_flight_goes_on_with_the_same_bits() -> None:
    model = mimbre.Model.from_text(
        """
        mimbre: 1
        bodies: {b: {mass: 2, com: [0, 0, 0.5], inertia: [0.01, 0.01, 0.01]}}
        joints: {f: {type: floating, between: [ground, b], at: [0, 0, 0.5], velocity: [1, 0, 0, 0, 0, 0]}}
        surfaces: {floor: {type: half_space}}
        contacts:
          c:
            spheres: {on: b, at: [[0, 0, 0.5]], radius: 0.1}
            surfaces: [floor]
            stiffness: 1e5
            restitution: 0.5
        simulation: {step: 0.005, end: 1}
        """
    )
    for method in ({"integrator": "conserve"}, {"integrator": "newmark"}, {"substeps": 1}, {}):
        straight = model.simulation(**method)
        states = [straight.save()]
        for _ in range(80):
            straight.step()
            states.append(straight.save())
        for begin in (0, 30, 55, 57):
            other = model.simulation(**method)
            other.restore(states[begin])
            for k in range(begin + 1, 81):
                other.step()
                assert other.save() == states[k], (method, begin, k)


def test_a_delay_is_as_fine_as_the_steps() -> None:
    text = """
        mimbre: 1
        gravity: [0, 0, 0]
        bodies: {b: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
        joints: {p: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0], velocity: 1}}
        signals: {place: {joint: p}, late: {delay: place, time: 0.137}}
        actuators: {m: {joint: p, force: "-8*late - 10*place"}}
        outputs: [{name: x, joint: p}]
        simulation: {step: STEP, end: 2}
        """
    fine = mimbre.Model.from_text(text.replace("STEP", "0.00025")).run()
    coarse = mimbre.Model.from_text(text.replace("STEP", "0.1")).run(step=0.00025)
    assert np.abs(fine["x"][-1] - coarse["x"][-1]) < 1e-10

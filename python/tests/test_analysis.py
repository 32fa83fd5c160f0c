"""The program's other commands as functions: the same answers."""

from __future__ import annotations

import json
import subprocess
import sys

import mimbre
import numpy as np
import pytest
from conftest import program


def test_the_static_equilibrium_is_the_program_s(examples):
    path = examples / "iltis/suspension.yaml"
    found = mimbre.static(mimbre.Model.from_file(path, drop=0.1))
    said = json.loads(program("static", path, "--set", "drop=0.1", "--json"))
    assert found.outputs == said["outputs"]
    assert found.units == said["units"]
    assert found["tyre.force"] == said["outputs"]["tyre.force"]
    assert (found.stable, found.iterations) == (said["stable"], said["iterations"])
    with pytest.raises(KeyError, match=r"did you mean 'tyre.force'"):
        found["tyre.forc"]


def test_the_equilibrium_of_a_model_in_code():
    """A weight on a spring."""
    m = mimbre.ModelBuilder()
    m.add_body("mass", mass=2, com=[0, 0, 0], inertia=[1, 1, 1])
    m.add_joint("guide", type="prismatic", between=["ground", "mass"], at=[0, 0, 0], axis=[0, 0, 1])
    m.add_spring("s", between=["ground", "mass"], at=[[0, 0, 1], [0, 0, 0]], elastic={"stiffness": 100, "zero": 1})
    m.add_output("z", joint="guide")
    assert mimbre.static(m.compile())["z"] == pytest.approx(-2 * 9.81 / 100)


def test_verify_is_the_program_s(examples):
    path = examples / "tutorial/pendulum.yaml"
    found = mimbre.Model.from_file(path).verify(until=0.5, step=0.01)
    said = json.loads(program("verify", path, "--until", 0.5, "--step", 0.01, "--json", "-q"))
    assert found.agree is said["agree"] is True
    assert found.refinement_ratio == said["refinement_ratio"]
    assert found.verdict == said["verdict"]
    assert found.failures == []
    assert all(channel.agrees for channel in found.channels.values())
    with pytest.raises(mimbre.InputError, match="both formulations"):
        mimbre.Model.from_file(path).verify(formulation="natural")


def test_compare_is_the_program_s(pendulum, tmp_path):
    a, b = pendulum.run(until=1), pendulum.run(until=1, step=0.02)
    found = mimbre.compare(a, b)
    a.save(tmp_path / "a.h5")
    b.save(tmp_path / "b.h5")
    said = json.loads(program("compare", tmp_path / "a.h5", tmp_path / "b.h5", "--json"))["channels"]
    assert set(found) == set(said)
    for name, d in found.items():
        assert (d.unit, d.max_difference, d.mean_difference, d.time, d.amplitude, d.interpolation_error) == (
            said[name]["unit"],
            said[name]["max_difference"],
            said[name]["mean_difference"],
            said[name]["at_time"],
            said[name]["amplitude"],
            said[name]["interpolation_error"],
        )
        assert np.isinf(d.relative) or d.relative == said[name]["relative"]
    assert mimbre.compare(tmp_path / "a.h5", a)["angle"].max_difference == 0
    with pytest.raises(mimbre.InputError):
        mimbre.compare(a, 3)  # type: ignore[arg-type]


def test_compare_leaves_out_what_has_other_units():
    def sliding(**output):
        m = mimbre.ModelBuilder()
        m.add_body("mass", mass=2, com=[0, 0, 0], inertia=[1, 1, 1])
        m.add_joint("guide", type="prismatic", between=["ground", "mass"], at=[0, 0, 0], axis=[0, 0, 1])
        m.add_output("z", **output)
        return m.compile().run(until=0.1, step=0.01)

    position, velocity = sliding(joint="guide"), sliding(joint_velocity="guide")
    with pytest.warns(UserWarning, match=r"not compared, as their units differ: 'z' \(m and m/s\)"):
        assert "z" not in mimbre.compare(position, velocity)


def test_stress_is_the_program_s(examples, pendulum, tmp_path):
    run = mimbre.Model.from_file(examples / "solid-arm/suspension.yaml").run(until=0.2)
    run.save(tmp_path / "run.h5")
    found = mimbre.stress(tmp_path / "run.h5", spots=3)
    said = json.loads(program("stress", tmp_path / "run.h5", "--json", "--spots", 3))["bodies"]
    assert list(found) == [body["name"] for body in said]
    for body in said:
        for spot, wanted in zip(found[body["name"]], body["hot_spots"], strict=True):
            assert spot.node == wanted["node"]
            assert list(spot.position) == wanted["position"]
            assert (spot.von_mises, spot.time, spot.stress) == (wanted["von_mises"], wanted["time"], wanted["stress"])
    name = next(iter(found))
    # A file has amplitudes in single precision.
    assert mimbre.stress(run)[name][0].von_mises == pytest.approx(found[name][0].von_mises, rel=1e-6)
    assert list(mimbre.stress(tmp_path / "run.h5", [name])) == [name]
    # Over time: the same at that node and instant, and nowhere more.
    history = mimbre.stress_history(run, name)
    worst = mimbre.stress(run)[name][0]
    von_mises = history.von_mises
    assert von_mises.max() == pytest.approx(worst.von_mises, rel=1e-9)
    instant, column = np.unravel_index(von_mises.argmax(), von_mises.shape)
    assert history.time[instant] == worst.time
    assert history.nodes[column] == worst.node
    assert history.positions[column] == pytest.approx(worst.position)
    assert history.stress[instant, column] == pytest.approx(list(worst.stress.values()), rel=1e-9, abs=1e-3)
    one = mimbre.stress_history(run, name, nodes=[worst.node])
    assert np.allclose(one.stress[:, 0], history.stress[:, column], rtol=1e-12, atol=1e-6)
    with pytest.raises(mimbre.InputError, match="-5 is not on the surface"):
        mimbre.stress_history(run, name, nodes=[-5])
    with pytest.raises(mimbre.UnknownName, match="there is no body with stress 'nobody'"):
        mimbre.stress(run, ["nobody"])
    with pytest.raises(mimbre.InputError, match="no body has stress modes"):
        mimbre.stress(pendulum.run(until=0.1))


def test_select_is_the_program_s(examples, tmp_path):
    path = examples / "iltis/suspension.yaml"
    found = mimbre.select(mimbre.Model.from_file(path), "front_left.arm", error=0.05, until=0.5)
    said = json.loads(
        program(
            "select", path, "--body", "front_left.arm", "--error", 5, "--end", 0.5, "-o", tmp_path / "b.h5", "--json"
        )
    )
    assert found.body.modes == said["modes"]
    assert found.achieved_error == pytest.approx(said["achieved_error"] / 100)
    assert [mode.name for mode in found.kept] == [mode["name"] for mode in said["kept"]]
    assert np.array_equal(found.body.stiffness, mimbre.ReducedBody.open(tmp_path / "b.h5").stiffness)
    with pytest.raises(mimbre.UnknownName, match=r"did you mean 'front_left.arm'"):
        mimbre.select(mimbre.Model.from_file(path), "front_left.arn")


BAR = """
mimbre: 1
gravity: [0, 0, 0]
materials: {alloy: {young: 7e10, poisson: 0.3, density: 2700}}
sections: {strip: {type: rectangle, height: 0.004, width: 0.02}}
bodies:
  bar:
    frame: {at: [0, 0, 0]}
    flexible:
      material: alloy
      section: strip
      nodes: {root: [0, 0, 0], tip: [1, 0, 0]}
      bars: {all: {from: root, to: tip, elements: 4}}
      clamped: [root]
      dynamic_modes: 2
joints:
  motor: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 0, 1], drive: {position: 2*t^2}}
outputs:
  - {name: tip, deflection: bar.tip, along: [0, 1, 0]}
simulation: {step: 1e-3, end: 0.4, output_interval: 1e-2}
"""


def test_inertia_terms_are_the_program_s(tmp_path):
    path = tmp_path / "bar.yaml"
    path.write_text(BAR)
    model = mimbre.Model.from_file(path)
    stages = []
    found = mimbre.inertia_terms(model, error=0.005, progress=lambda stage, done: stages.append((stage, done)))
    said = json.loads(program("terms", path, "--error", 0.5, "--json"))
    assert found.neglected == said["neglected"]
    assert "coriolis_body" in found.neglected["bar"]
    assert "rotation_coupling" not in found.neglected["bar"]
    assert found.error == pytest.approx(said["error"] / 100)
    assert found.error <= 0.005
    assert found.runs == said["runs"]
    assert found.notes == said["notes"] == []
    assert [term.name for term in found.terms] == [term["term"] for term in said["terms"]]
    assert all(np.isnan(term.cost) for term in found.terms)
    assert stages[0] == ("run with all terms", 0)
    with pytest.raises(mimbre.UnknownName, match="'tip'"):
        mimbre.inertia_terms(model, outputs=["tipp"])
    with pytest.raises(mimbre.InputError, match="no flexible body"):
        mimbre.inertia_terms(built_pendulum())
    with pytest.raises(mimbre.InputError, match="error: is 0"):
        mimbre.inertia_terms(model, error=0)
    more = mimbre.inertia_terms(model, error=0.005, until=0.2, measure=True)
    assert more.cost > 0


def built_pendulum():
    m = mimbre.ModelBuilder()
    m.add_body("bar", mass=1, com=[1, 0, 0], inertia=[1, 1, 1])
    m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    return m.compile()


def test_convert_is_the_program_s(examples, tmp_path):
    path = examples / "solid-arm/arm.h5"
    body = mimbre.convert(path, tmp_path / "arm.sid", stress=False)
    program("convert", path, "--to", "sid", "--no-stress", "-o", tmp_path / "theirs.sid")
    assert (tmp_path / "arm.sid").read_bytes() == (tmp_path / "theirs.sid").read_bytes()
    assert body.modes == mimbre.ReducedBody.open(tmp_path / "arm.sid").modes
    mimbre.convert(body, tmp_path / "arm.fem")
    with pytest.raises(mimbre.InputError):
        mimbre.convert(path, tmp_path / "arm.txt")


def test_long_work_tells_how_far_it_is_and_can_be_stopped(examples, tmp_path):
    path = examples / "iltis/suspension.yaml"
    model = mimbre.Model.from_file(path)
    told: list[object] = []
    mimbre.select(
        model, "front_left.arm", error=0.05, until=0.2, progress=lambda stage, done: told.append((stage, done))
    )
    assert told[0] == ("run with all modes", 0)
    assert all(0 <= done <= 1 for _, done in told)  # type: ignore[misc]

    class Enough(Exception):
        pass

    def enough(*_: object) -> None:
        raise Enough

    run = mimbre.Model.from_file(examples / "tutorial/pendulum.yaml").run(until=0.5)
    kept = tmp_path / "kept"
    opened = run.export(kept)
    before = {file.name: file.read_bytes() for file in kept.iterdir()}
    for work in (
        lambda: mimbre.select(model, "front_left.arm", progress=enough),
        lambda: model.verify(progress=enough),
        lambda: run.export(kept, progress=enough),
    ):
        with pytest.raises(Enough):
            work()
    assert {file.name: file.read_bytes() for file in kept.iterdir()} == before
    assert opened == str(kept / "run.pvd")
    for call in (model.verify, lambda progress: mimbre.select(model, "front_left.arm", progress=progress), model.run):
        with pytest.raises(mimbre.InputError, match="progress: a function is needed, not 3"):
            call(progress=3)


@pytest.mark.parametrize("work", ["model.verify(until=1000)", "mimbre.select(model, 'front_left.arm', until=1000)"])
def test_ctrl_c_ends_long_work(examples, work):
    program = (
        "import mimbre, signal, threading, _thread\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        f"model = mimbre.Model.from_file({str(examples / 'iltis/suspension.yaml')!r})\n"
        "try:\n    threading.Timer(0.5, _thread.interrupt_main).start()\n"
        f"    {work}\nexcept KeyboardInterrupt:\n    print('stopped')\n"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=300, check=True)
    assert ended.stdout == "stopped\n"


def test_the_files_for_paraview_are_the_program_s(examples, tmp_path):
    run = mimbre.Model.from_file(examples / "tutorial/pendulum.yaml").run(until=0.5)
    run.save(tmp_path / "run.h5")
    run = mimbre.Run.open(tmp_path / "run.h5")
    run.export(tmp_path / "ours", instants=5)
    program("export", tmp_path / "run.h5", "--vtk", tmp_path / "theirs", "--instants", 5)
    ours, theirs = (
        {file.name: file.read_bytes() for file in (tmp_path / name).iterdir()} for name in ("ours", "theirs")
    )
    assert ours == theirs
    assert len(ours) > 5
    with pytest.raises(mimbre.InputError, match="whole number from 2"):
        run.export(tmp_path / "ours", instants=1)


def test_a_page_of_several_runs(pendulum, tmp_path):
    fine, coarse = pendulum.run(until=0.5), pendulum.run(until=0.5, step=0.02)
    coarse.save(tmp_path / "coarse.h5")
    mimbre.report({"one step": fine, "twice that": tmp_path / "coarse.h5"}, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "one step" in page
    assert "twice that" in page
    with pytest.raises(mimbre.InputError, match="two"):
        mimbre.report({"alone": fine}, tmp_path / "page.html")
    with pytest.raises(mimbre.InputError, match="names with runs"):
        mimbre.report([fine, coarse], tmp_path / "page.html")  # type: ignore[arg-type]

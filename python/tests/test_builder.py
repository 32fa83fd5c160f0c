"""Models in code."""

from __future__ import annotations

import inspect
import pickle
import runpy

import mimbre
import numpy as np
import pytest


def line() -> int:
    """Of the caller."""
    frame = inspect.currentframe()
    assert frame is not None
    assert frame.f_back is not None
    return frame.f_back.f_lineno


def four_bar() -> mimbre.ModelBuilder:
    m = mimbre.ModelBuilder("Four-bar", gravity=np.array([0, 0, -9.81]))
    m.add_material("steel", young=2.1e11, poisson=0.3, density=7850)
    m.add_section("rod", type="round", diameter="8 mm")
    m.add_body("crank", mass=0.5, com=(0, 0, 0.1), inertia=np.array([0.002, 0.002, 0.0001]))
    m.add_body(
        "coupler",
        frame={"at": [0, 0, 0.2], "x": [0.6, 0, 0.3], "y": [0, 1, 0]},
        flexible={
            "material": "steel",
            "section": "rod",
            "nodes": {"crank": [0, 0, 0.2], "rocker": [0.6, 0, 0.5]},
            "bars": {"bar": {"from": "crank", "to": "rocker", "elements": np.int64(10)}},
            "clamped": ["crank"],
            "static_modes": [
                {"node": "rocker", "along": [0.6, 0, 0.3]},
                {"node": "rocker", "along": [-0.3, 0, 0.6]},
            ],
            "dynamic_modes": 2,
            "planar": [0, 1, 0],
            "stiffness_damping": np.float64(1e-5),
        },
    )
    m.add_body("rocker", mass=1, com=[0.6, 0, 0.25], inertia=[0.02, 0.02, 0.0005])
    m.add_joint(
        "motor",
        type="revolute",
        between=["ground", "crank"],
        at=[0, 0, 0],
        axis=[0, 1, 0],
        drive={"position": "2*pi*(t - 0.5*(1 - exp(-2*t)))"},
    )
    m.add_joint("crank_pin", type="revolute", between=["crank", "coupler"], at=[0, 0, 0.2], axis=[0, 1, 0])
    m.add_joint("pivot", type="revolute", between=["ground", "rocker"], at=[0.6, 0, 0], axis=[0, 1, 0])
    m.add_joint("rocker_pin", type="revolute", between=["coupler", "rocker"], at=[0.6, 0, 0.5], axis=[0, 1, 0])
    m.add_output("rocker", joint="pivot")
    m.set_simulation(step=0.001, end=1)
    return m


def test_a_built_model_is_the_one_that_its_file_says(tmp_path):
    built = four_bar().compile()
    run = built.run(until=0.2)
    assert np.ptp(run["rocker"]) > 0
    text = built.to_yaml(tmp_path / "model.yaml")
    assert text == four_bar().to_yaml() == (tmp_path / "model.yaml").read_text(encoding="utf-8")
    read = mimbre.Model.from_file(tmp_path / "model.yaml")
    assert read.simulation().fingerprint == built.simulation().fingerprint
    assert np.array_equal(read.run(until=0.2)["rocker"], run["rocker"])
    assert read.to_yaml() == text
    again = pickle.loads(pickle.dumps(built))
    assert again.simulation().fingerprint == built.simulation().fingerprint


@pytest.mark.parametrize("path", ["iltis/vehicle.yaml", "tutorial/pendulum.yaml", "spin-up-beam/beam-3d.yaml"])
def test_a_file_comes_back(examples, tmp_path, path):
    model = mimbre.Model.from_file(examples / path)
    model.to_yaml(tmp_path / "model.yaml")
    read = mimbre.Model.from_file(tmp_path / "model.yaml")
    assert read.simulation().fingerprint == model.simulation().fingerprint


def wheel(part: mimbre.Subsystem, radius: float = 0.3) -> None:
    part.add_body("wheel", mass=20, com=[0, 0.7, 0], inertia=[1, 2, 1])
    part.add_body("arm", mass=5, com=[0, 0.35, 0], inertia=[0.1, 0.1, 0.1])
    part.add_joint(
        "pivot",
        type="revolute",
        between=["frame", "arm"],
        at=[0, 0.2, 0],
        axis=[1, 0, 0],
        spring={"stiffness": 1e4, "damping": 300},
    )
    part.add_joint("hub", type="revolute", between=["arm", "wheel"], at=[0, 0.7, 0], axis=[0, 1, 0])
    part.add_tyre("tyre", on="wheel", at=[0, 0.7, 0], road="flat", stiffness=2e5, radius=radius)
    part.add_output("{instance}.angle", joint="pivot")


def cart(*radii: float) -> mimbre.ModelBuilder:
    m = mimbre.ModelBuilder("Cart")
    m.add_road("flat", over="distance", points=[[-10, -0.3], [10, -0.3]])
    m.add_body("frame", mass=500, com=[0, 0, 0.2], inertia=[50, 100, 100])
    for radius, (x, mirror) in zip(radii, [(1, None), (1, "y"), (-1, None), (-1, "y")], strict=True):
        m.place(
            f"{'front' if x > 0 else 'rear'}_{'right' if mirror else 'left'}",
            wheel,
            at=[x, 0, 0],
            mirror=mirror,
            radius=radius,
        )
    m.set_simulation(end=0.5)
    return m


def test_subsystems_are_functions():
    m = cart(0.3, 0.3, 0.3, 0.31)
    text = m.to_yaml()
    assert text.count("add_") == 0
    assert text.count("wheel: {mass") == 2  # one template for three wheels, one for the other
    run = m.compile().run()
    left, right = run["front_left.angle"], run["front_right.angle"]
    assert left.shape == right.shape
    assert np.ptp(left) > 0


def test_the_vehicle_in_code_is_that_of_the_file(examples):
    """To the same bits in every channel, and in few lines."""
    example = examples / "python/iltis.py"
    assert len(example.read_text(encoding="utf-8").splitlines()) <= 150
    built = runpy.run_path(str(example))["vehicle"](stairs=0.2).compile().run(until=4)
    read = mimbre.Model.from_file(examples / "iltis/vehicle.yaml", stairs=0.2).run(until=4)
    assert set(built) == set(read)
    for name in read:
        assert np.array_equal(built[name], read[name]), name
    assert np.ptp(read["chassis.z"]) > 0.5


def test_subsystems_have_parameters():
    part = mimbre.Subsystem()
    part.add_parameter("m", 1.0)
    part.add_body("bob", mass="m", com=[0, 0, -1], inertia=[0.1, 0.1, 0.1])
    part.add_joint("string", type="spherical", between=["ground", "bob"], at=[0, 0, 0])
    model = mimbre.ModelBuilder()
    model.place("light", part, at=[0, 0, 0])
    model.place("heavy", part, at=[1, 0, 0], m=5)
    model.add_output("p", linear_momentum="heavy.bob", component="x")
    compiled = model.compile()
    assert compiled.bodies == ["light.bob", "heavy.bob"]
    assert model.to_yaml().count("bob: ") == 1


def axle(part, mass):
    part.add_parameter("carrier", name="frame")
    part.add_body("shaft", mass=mass, com=[0, 0, 0], inertia=[700, 50, 700])
    part.add_joint("bearing", type="revolute", between=["$carrier", "shaft"], at=[0, 0, 0], axis=[0, 1, 0])
    part.add_output("{instance}.angle", joint="bearing")


def bogie(part):
    part.add_body("frame", mass=2600, com=[0, 0, 0.1], inertia=[2000, 1800, 3500])
    part.place("front", axle, at=[1.25, 0, 0], mass=800)
    part.place("rear", axle, at=[-1.25, 0, 0], mirror="x", mass=800)


def test_subsystems_stand_in_subsystems():
    m = mimbre.ModelBuilder("Train")
    m.place("a", bogie)
    m.place("b", bogie, at=[8.6, 0, 0], rotate=[0, 0, 0.1])
    model = m.compile()
    assert model.bodies == [f"{b}.{part}" for b in "ab" for part in ("frame", "front.shaft", "rear.shaft")]
    assert model.outputs == [f"{b}.{end}.angle" for b in "ab" for end in ("front", "rear")]
    assert m.to_yaml().count("shaft: {") == 1  # one template for all
    read = mimbre.Model.from_text(m.to_yaml())
    assert read.simulation().fingerprint == model.simulation().fingerprint
    part = mimbre.Subsystem()
    with pytest.raises(mimbre.InputError, match="would stand in itself"):
        part.place("it", part)
    outer = mimbre.Subsystem()
    outer.place("inner", part)
    with pytest.raises(mimbre.InputError, match="would stand in itself"):
        part.place("it", outer)


def test_a_robot_from_urdf(examples):
    path = examples.parent / "tests/data/urdf/panda.urdf"
    model = mimbre.Model.from_urdf(path)
    assert model.coordinates == 9
    assert "panda_joint4" in model.outputs
    assert "panda_finger_joint2_mimic: {type: coupling" in model.to_yaml()
    assert mimbre.Model.from_urdf(path, floating=True).coordinates == 15
    assert len(mimbre.Model.from_urdf(path, keep_fixed=True).bodies) > len(model.bodies)
    assert "restitution: 0.1" in model.to_yaml()
    with pytest.raises(mimbre.InputError, match="no such file"):
        mimbre.Model.from_urdf("nowhere.urdf")


def test_a_model_that_names_files_elsewhere_stays_in_its_folder(examples, tmp_path):
    model = mimbre.Model.from_file(examples / "solid-arm/suspension.yaml")
    with pytest.raises(mimbre.InputError, match=r"outside of its folder; write it into .*solid-arm"):
        model.to_yaml(tmp_path / "model.yaml")
    read = pickle.loads(pickle.dumps(model))
    assert read.simulation().fingerprint == model.simulation().fingerprint


@pytest.fixture
def pushed(tmp_path, monkeypatch):
    """Of a file that includes its body, by relative paths: M kilograms pushed by 1 N."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "body.yaml").write_text("bodies: {b: {mass: M, com: [0, 0, 0], inertia: [1, 1, 1]}}\n")
    (tmp_path / "model.yaml").write_text(
        """
        mimbre: 1
        include: [body.yaml]
        parameters: {M: 1, F: {value: 1, tunable: true}}
        joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0]}}
        actuators: {a: {joint: j, force: F}}
        outputs: [{name: v, joint_velocity: j}]
        simulation: {step: 0.01, end: 1}
        """
    )
    return mimbre.Model.from_file("model.yaml")


def test_a_model_whose_files_have_changed_is_refused_where_it_needs_them(pushed, tmp_path):
    body = tmp_path / "body.yaml"
    was = body.read_text()
    wrong = r"files that have changed since it was read: .*body.yaml( \(it cannot be read\))?; read it again"
    for change in (lambda: body.write_text(was.replace(" M,", " 9,")), body.unlink):
        change()
        for use in (
            lambda: mimbre.sweep(pushed, {"M": [1.0, 2.0]}),
            lambda: pushed.campbell("M", [1.0, 2.0]),
            lambda: pickle.dumps(pushed),
            lambda: pushed.to_yaml("copy.yaml"),
        ):
            with pytest.raises(mimbre.InputError, match=wrong):
                use()
        assert pushed.run()["v"][-1] == pytest.approx(1)  # what is compiled stays as it was
        assert mimbre.sweep(pushed, {"F": [3.0]})["v"].to_numpy() == pytest.approx([3])
    body.write_text(was)
    assert mimbre.sweep(pushed, {"M": [1.0, 2.0]})["v"].to_numpy() == pytest.approx([1, 0.5])


def test_a_model_of_relative_paths_knows_its_files_from_elsewhere(pushed, tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert mimbre.sweep(pushed, {"M": [2.0]})["v"].to_numpy() == pytest.approx([0.5])
    pushed.to_yaml("copy.yaml")
    for model in (mimbre.Model.from_file("copy.yaml"), pickle.loads(pickle.dumps(pushed))):
        assert model.simulation().fingerprint == pushed.simulation().fingerprint


def test_messages_name_the_line_of_python():
    m = mimbre.ModelBuilder()
    m.add_body("bar", mass=1, com=[0, 0, 0], inertia=[1, 1, 5])
    joint = line() + 1
    m.add_joint("hinge", type="revolut", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    name = line() + 1
    m.add_joint("pin", type="revolute", between=["ground", "baar"], at=[0, 0, 0], axis=[0, 1, 0])
    key = line() + 1
    m.add_output("x", position="bar", componnt="x")
    with pytest.raises(mimbre.InputError) as wrong:
        m.compile()
    found = {d.line: d.message for d in wrong.value.diagnostics if d.file == __file__}
    assert {joint, name, key} <= set(found)
    assert "revolute" in found[joint]
    assert "did you mean 'bar'?" in found[name]
    assert "did you mean 'component'?" in found[key]
    assert f"{__file__}:{joint}: " in str(wrong.value)
    m = mimbre.ModelBuilder()
    inertia = line() + 1
    m.add_body("bar", mass=1, com=[0, 0, 0], inertia=[1, 1, 5])
    with pytest.raises(mimbre.InputError, match="triangle inequality") as wrong:
        m.compile()
    assert [d.line for d in wrong.value.diagnostics] == [inertia]


def test_warnings_name_the_line_of_python():
    m = mimbre.ModelBuilder()
    m.add_body("bar", mass=1, com=[0, 0, 0], inertia=[1, 1, 1])
    road = line() + 1
    m.add_road("nowhere", over="distance", points=[[0, 0], [1, 0]])
    m.add_output("x", position="bar", component="x")
    assert [(d.file, d.line) for d in m.compile().warnings if "not used" in d.message] == [(__file__, road)]


def test_the_builder_keeps_what_it_was_given():
    """What the caller changes afterwards does not count."""
    com = np.array([0.5, 0, 0])
    m = mimbre.ModelBuilder()
    m.add_body("bar", mass=1, com=com, inertia=[0.1, 0.1, 0.1])
    com[0] = 7
    assert "com: [0.5, 0.0, 0.0]" in m.to_yaml()
    limits = [0, 1]
    m.add_input("push", 0.0, range=limits)
    limits[1] = 7
    assert "range: [0, 1]" in m.to_yaml()


def test_a_word_of_python_has_an_underscore_behind_it():
    """With a value of its own too."""
    m = mimbre.ModelBuilder()
    m.add_parameter("width", 0.5, min_=0, max_=2)
    m.add_signal("half", "width/2", every_=0.1)
    text = m.to_yaml()
    assert "min: 0" in text
    assert "every: 0.1" in text


@pytest.mark.parametrize(
    "text", ["a: b", "true", "1e3", "it's", 'say "x"', "ü – 日本", "#1", "- x", "a\nb", "null", "~", ""]
)
def test_texts_come_through(text):
    m = mimbre.ModelBuilder(text)
    m.add_body("bar", mass=1, com=[0, 0, 0], inertia=[1, 1, 1])
    assert m.compile().title == text


def test_inertia_is_neglected(examples):
    def turned(terms):
        m = mimbre.ModelBuilder(gravity=[0, 0, 0])
        arm = mimbre.ReducedBody.open(examples / "solid-arm/arm.h5")
        m.add_body("arm", reduced=arm, frame={"at": [0, 0, 0]})
        m.add_joint(
            "hinge", type="revolute", between=["ground", "arm"], at=[0, 0, 0], axis=[0, 0, 1], drive={"position": "t^2"}
        )
        if terms:
            m.neglect_inertia("arm", terms)
        assert ("neglected_inertia" in m.to_yaml()) == bool(terms)
        return m.compile().run(until=0.1, step=1e-3)

    every, few = turned([]), turned(["rotation_coupling", "centrifugal"])
    bends, less = (np.abs(run.modes).max() for run in (every, few))
    assert less < 0.9 * bends
    with pytest.raises(mimbre.InputError, match="coriolis_modes"):
        turned(["coriolis_mode"])

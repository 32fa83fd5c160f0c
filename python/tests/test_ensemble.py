"""Sweeps: the values of single runs, by threads, processes and from a store."""

from __future__ import annotations

import concurrent.futures as futures
import multiprocessing
import os
import signal

import h5py
import mimbre
import numpy as np
import pytest
import xarray as xr
from scipy.stats import qmc

FILE = """
mimbre: 1
parameters: {k: {value: 2, min: 0, max: 10, tunable: true}, mass: {value: 0.6, min: 0.1, max: 5}}
bodies: {bar: {mass: mass, com: [0.5, 0, 0], inertia: [1.0e-5, 0.05, 0.05]}}
joints: {hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}}
actuators: {motor: {joint: hinge, torque: "-k*angle"}}
outputs: [{name: angle, joint: hinge}, {name: z, position: bar, component: z}]
simulation: {step: 0.01, end: 0.5}
"""
GRID = {"k": [0.5, 1, 3.5], "mass": [0.6, 1.2]}


@pytest.fixture
def model() -> mimbre.Model:
    return mimbre.Model.from_text(FILE)


def test_a_grid_has_the_values_of_single_runs(model):
    counts = []
    data = mimbre.sweep(model, GRID, reduce=["max", "min", "mean", "rms", "last"], progress=lambda *n: counts.append(n))
    assert data["angle"].dims == ("k", "mass", "reduction")
    assert data["angle"].attrs["units"] == "rad"
    assert (data.status == "ok").all()
    assert counts[-1] == (6, 6)
    for k in GRID["k"]:
        for mass in GRID["mass"]:
            angle = np.asarray(mimbre.Model.from_text(FILE, k=k, mass=mass).run()["angle"])
            wanted = [angle.max(), angle.min(), angle.mean(), np.sqrt(np.mean(angle**2)), angle[-1]]
            assert np.array_equal(data["angle"].sel(k=k, mass=mass), wanted)


def test_tunables_may_be_texts_with_units(model):
    """As parameters that the model is compiled with may: their values are those of numbers."""
    data = mimbre.sweep(model, {"k": ["3500 g", "7/2", 3.5], "mass": ["0.6"]})
    assert (data.status == "ok").all()
    assert len(set(data["angle"].to_numpy().ravel())) == 1
    refused = mimbre.sweep(model, {"k": ["eleven"]})
    assert "eleven" in str(refused["message"][0].item())


def test_histories_functions_lists_and_samples(model):
    rows = mimbre.samples(qmc.Sobol(2, rng=1), 4, {"k": (1, 5), "mass": (0.5, 1)})
    data = mimbre.sweep(model, rows, outputs="z", reduce="history", until=0.2)
    assert data["z"].dims == ("run", "time")
    for k, row in enumerate(rows):
        assert 1 <= row["k"] <= 5
        assert np.array_equal(data["z"][k], model._with(row).run(until=0.2)["z"])
    table = (["k", "mass"], [[row["k"], row["mass"]] for row in rows])
    assert mimbre.sweep(model, table, outputs=["z"], reduce=np.ptp, until=0.2)["z"].to_numpy() == pytest.approx(
        np.ptp(data["z"].to_numpy(), axis=1)
    )


def test_channels_alone_have_the_values_that_they_have_among_all(examples):
    """Also of redundant constraints and of an equilibrium: kinematics, forces and reactions, in any order."""
    for name in ("iltis/vehicle.yaml", "double-four-bar/mechanism.yaml", "bricard/mechanism.yaml"):
        model = mimbre.Model.from_file(examples / name)
        for formulation in ("relative", "natural"):
            run = model.run(until=0.3, formulation=formulation)
            for names in (list(run), list(run)[::-7]):
                data = mimbre.sweep(model, [{}], outputs=names, reduce="history", until=0.3, formulation=formulation)
                for channel in names:
                    assert np.array_equal(data[channel][0], run[channel], equal_nan=True), (name, channel)


STARTS = """
mimbre: 1
parameters: {k: {value: 2, min: 0, max: 10, tunable: true}, stiff: {value: 500, min: 1, max: 1000, tunable: true}}
inputs: {angle: {start: 0.1, hold: linear}, push: 0}
bodies:
  bar: {mass: 0.6, com: [0.5, 0, 0], inertia: [1.0e-5, 0.05, 0.05]}
  tip: {mass: 0.1, com: [1, 0, 0], inertia: [1.0e-3, 1.0e-3, 1.0e-3]}
joints:
  hinge: {type: revolute, between: [ground, bar], at: [0, 0, 0], axis: [0, 1, 0]}
  crank: {type: revolute, between: [bar, tip], at: [1, 0, 0], axis: [0, 1, 0], drive: {position: angle}}
actuators: {motor: {joint: hinge, torque: "push - k*angle_now"}}
springs: {spring: {between: [ground, bar], at: [[0.5, 0, 1], [0.5, 0, 0]], elastic: "stiff*(l - 0.9)"}}
signals: {angle_now: {joint: hinge}}
outputs: [{name: a, joint: hinge}]
initial: INITIAL
simulation: {step: 0.01, end: 0.1}
"""


@pytest.mark.parametrize("initial", ["assembled", "equilibrium"])
def test_inputs_count_from_the_first_instant_on(initial):
    """Reactions, energies, driven positions and the equilibrium are those of a model that was made with them."""
    text = STARTS.replace("INITIAL", initial)
    model = mimbre.Model.from_text(text)
    made = mimbre.Model.from_text(text.replace("start: 0.1", "start: 0.2").replace("push: 0", "push: 3"), k=7, stiff=80)
    inputs = {"k": 7, "stiff": 80, "angle": 0.2, "push": 3}
    wanted, run = made.run(), model.run(inputs=inputs)
    data = mimbre.sweep(model, [inputs], outputs=list(wanted), reduce="history")
    for name in wanted:
        assert np.array_equal(run[name], wanted[name], equal_nan=True), name
        assert np.array_equal(data[name][0], wanted[name], equal_nan=True), name
    other = model.run()
    assert other["joint.hinge.force.z"][0] != wanted["joint.hinge.force.z"][0]
    called = []
    by_function = model.run(inputs={**inputs, "push": lambda time: called.append(time) or 3.0})
    assert np.array_equal(by_function["a"], wanted["a"])
    assert called[0] == 0


def test_what_an_event_sets_outlasts_the_values_of_a_sweep():
    """The force F + u acts on one kilogram until the event ends it; F compiles nothing anew, mass does."""
    model = mimbre.Model.from_text(
        """
        mimbre: 1
        parameters: {F: {value: 1, tunable: true}, mass: 1}
        inputs: {u: 0}
        bodies: {b: {mass: mass, com: [0, 0, 0], inertia: [1, 1, 1]}}
        joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0]}}
        actuators: {a: {joint: j, force: F + u}}
        events: {half: {when: t, crosses: 0.5, direction: rising, set: {F: 0, u: 0}}}
        outputs: [{name: v, joint_velocity: j}]
        simulation: {step: 0.01, end: 1}
        """
    )
    data = mimbre.sweep(model, {"F": [1.0, 2.0], "mass": [1.0, 2.0]}, inputs={"u": 1.0})
    assert data["v"].to_numpy() == pytest.approx(np.array([[1, 0.5], [1.5, 0.75]]), rel=1e-6)


def test_a_model_compiled_anew_keeps_its_laws():
    m = mimbre.ModelBuilder("Held")
    m.add_parameter("mass", 1.0, min=0.1, max=5)
    m.add_body("bar", mass="mass", com=[0, 0, 0], inertia=[1, 1, 1])
    m.add_joint("slide", type="prismatic", between=["ground", "bar"], at=[0, 0, 0], axis=[1, 0, 0])
    m.add_law("push", joint="slide", force=lambda time, x, v: -2.0)
    m.add_output("x", joint="slide")
    m.set_simulation(step=0.01, end=1)
    data = mimbre.sweep(m.compile(), {"mass": [1.0, 2.0]})
    assert data["x"].to_numpy() == pytest.approx([1.0, 0.5], rel=1e-3)


def test_failures_are_rows_with_their_reason(model):
    data = mimbre.sweep(model, {"mass": [0.6, -1.0, 1.0]})
    assert list(data.status) == ["ok", "rejected", "ok"]
    assert "from 0.1 to 5" in str(data.message[1].item())
    assert np.isnan(data["angle"][1])
    assert "from 0 to 10" in str(mimbre.sweep(model, {"k": [11]}).message[0].item())

    def picky(history):
        raise ZeroDivisionError("nothing there")

    assert "nothing there" in str(mimbre.sweep(model, {"k": [1]}, reduce=picky).message[0].item())


def test_a_store_is_taken_up_where_it_ended(model, tmp_path):
    path = tmp_path / "study.h5"

    def interrupt(done, total):
        if done >= 3:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(mimbre.SweepInterrupted) as stopped:
        mimbre.sweep(model, {"k": np.linspace(0, 10, 40)}, store=path, progress=interrupt)
    done = int((stopped.value.data.status == "ok").sum())
    assert 3 <= done < 40
    counts = []
    data = mimbre.sweep(model, {"k": np.linspace(0, 10, 40)}, store=path, progress=lambda *n: counts.append(n[0]))
    assert counts[0] > done
    assert sum(np.diff([done, *counts])) == 40 - done
    xr.testing.assert_identical(data, mimbre.sweep(model, {"k": np.linspace(0, 10, 40)}))
    counts.clear()
    again = mimbre.sweep(model, {"k": np.linspace(0, 10, 40)}, store=path, progress=lambda *n: counts.append(n))
    xr.testing.assert_identical(data, again)
    assert not counts  # nothing was run
    with pytest.raises(mimbre.InputError, match=r"another study: there until"):
        mimbre.sweep(model, {"k": np.linspace(0, 10, 40)}, store=path, until=0.1)


def test_workers_leave_histories(model, tmp_path):
    """Of threads and of processes, beside what is reduced; what is missing is run again."""
    plain = mimbre.sweep(model, GRID)
    folder, store = tmp_path / "histories", tmp_path / "study.h5"
    xr.testing.assert_identical(mimbre.sweep(model, GRID, histories=folder, store=store, workers=1), plain)

    def check():
        files = sorted(folder.iterdir())
        assert [file.name for file in files] == [f"run-{k:06}.h5" for k in range(6)]
        for file in files:
            with h5py.File(file) as run:
                wanted = mimbre.Model.from_text(FILE, k=run.attrs["k"], mass=run.attrs["mass"]).run()
                assert np.array_equal(run["time"], wanted.time)
                assert np.array_equal(run["angle"], wanted["angle"])

    check()
    (folder / "run-000003.h5").unlink()
    (folder / ".run-000003.h5.1").write_text("of a worker that was killed")
    counts = []
    mimbre.sweep(model, GRID, histories=folder, store=store, progress=lambda *n: counts.append(n))
    assert counts == [(6, 6)]
    check()
    with pytest.raises(mimbre.InputError, match="has runs of another sweep"):
        mimbre.sweep(model, GRID, histories=folder)
    with futures.ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        mimbre.sweep(model, GRID, histories=tmp_path / "others", executor=pool)
    folder = tmp_path / "others"
    check()


@pytest.mark.parametrize("reduce", ["last", "history"])
def test_a_sweep_with_histories_that_is_killed_at_once_goes_on(model, tmp_path, reduce):
    """Its workers have written histories before the store has a row."""
    folder, store = tmp_path / "histories", tmp_path / "study.h5"

    class Killed(Exception):
        pass

    class Worker(futures.Executor):
        def submit(self, work, *arguments):
            work(*arguments)
            raise Killed

    keys = {"histories": folder, "store": store, "reduce": reduce}
    with pytest.raises(Killed):
        mimbre.sweep(model, GRID, executor=Worker(), **keys)
    assert any(folder.iterdir())
    h5py.File(store, "r+").close()  # nobody has it open
    xr.testing.assert_identical(mimbre.sweep(model, GRID, **keys), mimbre.sweep(model, GRID, reduce=reduce))
    (folder / "run-000006.h5").touch()
    with pytest.raises(mimbre.InputError, match="has runs of another sweep"):
        mimbre.sweep(model, GRID, **keys)
    (folder / "run-000006.h5").unlink()
    store.unlink()
    for _ in range(2):  # to refuse makes no store that would know them
        with pytest.raises(mimbre.InputError, match="has runs of another sweep"):
            mimbre.sweep(model, GRID, **keys)


def test_a_message_that_is_cut_inside_a_character_is_read_again(model, tmp_path):
    """Messages are kept in so many bytes."""

    def fails(history):
        raise RuntimeError("x" + "ä" * 300)

    store = tmp_path / "study.h5"
    first = mimbre.sweep(model, {"k": 1}, reduce=fails, store=store)
    again = mimbre.sweep(model, {"k": 1}, reduce=fails, store=store)
    text = str(again.message.values.flat[0])
    assert str(first.message.values.flat[0]).startswith(text)
    assert 390 < len(text.encode()) <= 400


def test_the_model_of_the_check_is_that_of_its_run(model, monkeypatch):
    made = []
    with_ = mimbre.Model._with
    monkeypatch.setattr(mimbre.Model, "_with", lambda self, values: made.append(values) or with_(self, values))
    mimbre.sweep(model, {"mass": [0.6, 1.2]}, workers=1)
    assert made == [{"mass": 0.6}, {"mass": 1.2}]


def test_processes_give_the_same_bits(model):
    with futures.ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        xr.testing.assert_identical(mimbre.sweep(model, GRID, executor=pool), mimbre.sweep(model, GRID))


def test_mistakes_are_told_before_anything_runs(model):
    for arguments, message in (
        ({"parameters": {"mas": [1]}}, "there is no parameter 'mas'"),
        ({"parameters": 3}, "names with lists of values"),
        ({"parameters": [{"k": 1}, {"mass": 1}]}, "run 1 has mass"),
        ({"parameters": GRID, "outputs": ["angel"]}, "did you mean 'angle'"),
        ({"parameters": GRID, "reduce": "maximum"}, "there is no reduction"),
        ({"parameters": GRID, "inputs": {"k": 1}}, "one of the parameters"),
        ({"parameters": GRID, "executor": 5}, "a Dask Client or an executor"),
        ({"parameters": GRID, "step": 1.0}, "longer than the run"),
        ({"parameters": GRID, "until": -1}, "a number of seconds from 0"),
        ({"parameters": GRID, "workers": 0}, "a number of threads from 1"),
        ({"parameters": GRID, "workers": 2, "executor": 5}, "give one of both"),
        ({"parameters": GRID, "histories": __file__}, "is no folder"),
        ({"parameters": {"k": [float("nan")]}}, "finite"),
    ):
        with pytest.raises(mimbre.InputError, match=message):
            mimbre.sweep(model, **arguments)


@pytest.mark.parametrize("name", ["status", "message", "time", "reduction", "run"])
@pytest.mark.parametrize("reduce", ["last", "history", ["min", "max"]])
@pytest.mark.parametrize("tunable", ["true", "false"])
def test_names_of_the_data_set_are_refused_before_anything_runs(name, reduce, tunable):
    """And those that mean nothing else there are names as any other."""
    text = FILE.replace("parameters: {k: {", f"parameters: {{{name}: {{value: 0.1, tunable: {tunable}}}, k: {{")
    model = mimbre.Model.from_text(text.replace('"-k*angle"', f'"{name}"'))
    done = []
    clash = name in {"last": (), "history": ("time",)}.get(str(reduce), ("reduction",)) or name in ("status", "message")
    for parameters in ({name: [1, 2]}, [{name: 1}, {name: 2}]):
        if clash:
            with pytest.raises(mimbre.InputError, match=f"parameters: '{name}' is the name of something else"):
                mimbre.sweep(model, parameters, outputs="angle", reduce=reduce, progress=lambda *n: done.append(n))
        else:
            data = mimbre.sweep(model, parameters, outputs="angle", reduce=reduce)
            assert data[name].to_numpy().tolist() == [1, 2]
            assert data["angle"].to_numpy()[1].max() > data["angle"].to_numpy()[0].max()
    assert not done


def test_a_dask_cluster_that_loses_a_worker_loses_no_row(model):
    distributed = pytest.importorskip("distributed")
    rows = {"k": np.linspace(0, 10, 120)}
    with (
        distributed.LocalCluster(3, threads_per_worker=1, dashboard_address=None, host="127.0.0.1") as cluster,
        distributed.Client(cluster) as client,
    ):
        victims = list(client.run(os.getpid).values())

        def kill(done, total):
            if victims and done > 10:
                os.kill(victims.pop(), signal.SIGKILL)
                victims.clear()

        data = mimbre.sweep(model, rows, executor=client, until=5, progress=kill)
    assert not victims
    xr.testing.assert_identical(data, mimbre.sweep(model, rows, until=5))


def test_runs_that_an_event_ends_keep_their_rows_alone(tmp_path) -> None:
    model = mimbre.Model.from_text(
        """
        mimbre: 1
        parameters: {v0: 1}
        bodies: {b: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
        joints: {p: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [1, 0, 0], velocity: [v0]}}
        outputs: [{name: place, joint: p}, {name: speed, joint_velocity: p}]
        events: {there: {when: place, crosses: 0.5, direction: rising, stop: true}}
        simulation: {step: 0.1, end: 2}
        """
    )
    speeds = [2.0, 0.1, 1.0, 0.2, 0.87, 0.253]  # the last one ends between the last two instants
    found = mimbre.sweep(model, {"v0": speeds}, reduce=["last", "min"])
    ends = [min(0.5, 2 * v) for v in speeds]
    assert np.allclose(found["place"].sel(reduction="last"), ends, atol=1e-6)
    assert np.allclose(found["speed"].sel(reduction="min"), speeds, atol=1e-9)
    store = tmp_path / "rows.h5"
    for _ in range(2):
        found = mimbre.sweep(model, {"v0": speeds}, reduce="history", store=store, workers=1)
    assert (found["status"] == "ok").all()
    assert np.allclose(found["time"], 0.1 * np.arange(21))
    for v in speeds:
        history = found["place"].sel(v0=v).values
        exact = v * found["time"].values
        there = exact < 0.5 + 1e-9
        assert np.allclose(history[there], exact[there], atol=1e-9)
        assert np.isnan(history[~there]).all()

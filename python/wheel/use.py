"""Uses an installed wheel in a system that has nothing else; run by scripts/test-wheel."""

import importlib.metadata
import math
import shutil
import subprocess
import sys
import time
from pathlib import Path

import mimbre

PROGRAM = str(Path(sys.executable).with_name("mimbre"))


def lines(path: str) -> int:
    return sum(bool(line.strip()) for line in Path(path).read_text(encoding="utf-8").splitlines())


def same(path: str, model: str) -> None:
    assert Path(path).read_bytes() == Path(f"expected/{model}.h5").read_bytes(), f"{path} is not the program's, {model}"


def nothing_else_is_there() -> None:
    for command in ("cc", "gcc", "c++", "cmake", "ld"):
        assert shutil.which(command) is None, command
    site = str(Path(mimbre.__file__).parents[1])
    mapped = {line.split()[-1] for line in Path("/proc/self/maps").read_text().splitlines() if ".so" in line}
    for name in ("hdf5", "dmumps", "scotch", "openblas", "lapack", "gfortran", "yaml", "fmt", "curl"):
        used = [path for path in mapped if f"/lib{name}" in path]
        assert used, f"{name} is not loaded"
        assert all(path.startswith(site) for path in used), used
    files = [str(file) for file in importlib.metadata.files("mimbre") or []]
    for part in ("LICENSE", "THIRD-PARTY.txt", "model.schema.json", "_core.pyi", "py.typed"):
        assert any(file.endswith(part) for file in files), part


def pendulum_in_code() -> None:
    """Its angle against the closed form of small swings."""
    m = mimbre.ModelBuilder("Pendulum")
    m.add_body("bar", mass=0.6, com=[0, 0, -0.5], inertia=[0.05, 0.05, 1e-5])
    place = {"between": ["ground", "bar"], "at": [0, 0, 0], "axis": [0, 1, 0]}
    m.add_joint("hinge", type="revolute", position=0.01, **place)
    m.add_output("angle", joint="hinge")
    run = m.compile().run(until=2, step=0.001)
    rate = math.sqrt(0.6 * 9.81 * 0.5 / (0.05 + 0.6 * 0.25))
    assert abs(run["angle"][-1] - 0.01 * math.cos(rate * run.time[-1])) < 1e-5, run["angle"][-1]


def runs_have_the_bytes_of_the_program() -> None:
    assert lines("examples/python/pendulum.py") <= 15
    assert lines("examples/python/iltis.py") <= 150
    mimbre.Model.from_file("examples/iltis/vehicle.yaml").run().save("vehicle.h5")
    same("vehicle.h5", "vehicle")
    for number, command in enumerate(([PROGRAM], [sys.executable, "-m", "mimbre"])):
        file = f"flexible-{number}.h5"
        subprocess.run(
            [*command, "run", "examples/pendulum/flexible.yaml", "--output", file], check=True, capture_output=True
        )
        same(file, "flexible")
    subprocess.run([sys.executable, "examples/python/iltis.py"], check=True)


def reductions_work() -> None:
    faces = {"front": "group:front", "rear": "group:rear", "ball": "group:ball"}
    arm = mimbre.reduce("examples/solid-arm/arm.msh", units="mm", materials=(2.1e11, 0.3, 7850), interfaces=faces)
    assert arm.passed, arm.checks
    folder = "tests/data/scipy/"
    beam = mimbre.reduce(
        folder + "stiffness.mtx",
        mass=folder + "mass.mtx",
        nodes=folder + "nodes.csv",
        dofs=folder + "dofs.csv",
        interfaces={"root": "box(-1,-1,-1, 1e-6,1,1)"},
        modes=3,
    )
    print(f"arm: {arm.frequencies[0]:.1f} Hz; beam: {beam.frequencies[0]:.1f} Hz")
    arm.report("arm.html")
    assert "<script" in Path("arm.html").read_text(encoding="utf-8")


def reports_are_drawn() -> None:
    mimbre.Run.open("vehicle.h5").report("vehicle.html")
    assert len(Path("vehicle.html").read_text(encoding="utf-8")) > 1_000_000


def import_is_quick() -> None:
    """Says how long it takes, beside NumPy alone."""
    seconds = {}
    for name in ("numpy", "mimbre"):
        times = []
        for _ in range(5):
            began = time.perf_counter()
            subprocess.run([sys.executable, "-c", f"import {name}"], check=True)
            times.append(time.perf_counter() - began)
        seconds[name] = min(times)
    print(", ".join(f"import {name}: {value:.2f} s" for name, value in seconds.items()))


nothing_else_is_there()
pendulum_in_code()
runs_have_the_bytes_of_the_program()
reductions_work()
reports_are_drawn()
import_is_quick()

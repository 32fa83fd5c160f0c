"""The picture of the manoeuvres in docs/vehicles.md, and the figures beside it.

python3 bench/python/manoeuvres.py build/release/mimbre docs
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile
from collections.abc import Iterator

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

Column = NDArray[np.float64]
folder = pathlib.Path(__file__).parents[2] / "examples/iltis"
manoeuvres = ("step-steer", "double-lane-change", "brake-in-bend", "constant-radius")
kinds = ("flexible", "rigid")
width = 1.52  # m, of the car


def run(program: str, manoeuvre: str, kind: str) -> tuple[dict[str, Column], float]:
    """The columns of the run's table and its lateral acceleration, and what numerics added per dissipated energy."""
    with tempfile.TemporaryDirectory() as scratch:
        table = pathlib.Path(scratch, "run.csv")
        settings = [part for name in ("arms", "links", "rods") for part in ("--set", f"{name}={kind}")]
        command = [program, "run", str(folder / f"{manoeuvre}.yaml"), "--json", "--csv", str(table), *settings]
        energy = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["energy"]
        with table.open() as file:
            rows = list(csv.reader(file))
    run = dict(zip(rows[0], np.array(rows[1:], float).T, strict=True))
    ahead, left = run["speed"], np.gradient(run["y"], run["t"])
    turning = np.gradient(np.unwrap(np.arctan2(left, ahead)), run["t"])
    run["lateral"] = np.hypot(ahead, left) * turning
    # At the end there is no difference on both sides.
    return {name: column[:-2] for name, column in run.items()}, abs(energy["numerical"]) / energy["dissipated"]


def cones() -> Iterator[tuple[float, float]]:
    """Of ISO 3888-1, from where the first lane begins: x, and y of the right and of the left edge."""
    first = 1.1 * width + 0.25
    right = -first / 2
    lanes = (
        (0, 15, right, first),
        (45, 70, right + 3.5, 1.2 * width + 0.25),
        (95, 125, right, 1.3 * width + 0.25),
    )
    for begin, end, edge, lane in lanes:
        for x in np.arange(begin, end + 1, 5):
            yield 40 + float(x), edge
            yield 40 + float(x), edge + lane


def peak(values: Column) -> float:
    return float(np.abs(values).max())


def main(program: str, target: str) -> None:
    figure, axes = plt.subplots(4, 2, figsize=(11, 11), layout="constrained")
    print("manoeuvre            lateral m/s²  yaw rate rad/s  roll °  link mm  rigid less flexible  energy/dissipated")
    for row, manoeuvre in zip(axes, manoeuvres, strict=True):
        runs = {kind: run(program, manoeuvre, kind) for kind in kinds}
        flexible, left_over = runs["flexible"]
        difference = runs["rigid"][0]["yaw_rate"] - flexible["yaw_rate"]
        for kind, style in zip(kinds, ("-", "--"), strict=True):
            table = runs[kind][0]
            row[0].plot(table["t"], table["lateral"], style, label=f"lateral acceleration, {kind}")
        row[0].set(ylabel="m/s²", xlabel="s", title=manoeuvre)
        row[0].legend(loc="best", fontsize="small")
        if manoeuvre == "double-lane-change":
            row[1].plot(flexible["x"], flexible["y"], label="centre of mass")
            row[1].plot(*zip(*cones(), strict=True), ".", color="tab:orange", label="cones")
            row[1].set(xlim=(30, 175), xlabel="x, m", ylabel="y, m")
        else:
            row[1].plot(flexible["t"], 1e3 * difference, label="yaw rate, rigid less flexible")
            row[1].set(xlabel="s", ylabel="10⁻³ rad/s")
        row[1].legend(loc="best", fontsize="small")
        link = max(peak(flexible[f"{end}_{side}.link"]) for end in ("front", "rear") for side in ("left", "right"))
        print(
            f"{manoeuvre:20} {peak(flexible['lateral']):12.2f}  {peak(flexible['yaw_rate']):14.3f}"
            f"  {np.degrees(peak(flexible['roll'])):6.2f}  {1e3 * link:7.3f}"
            f"  {peak(difference):19.1e}  {left_over:17.1e}"
        )
    figure.savefig(pathlib.Path(target, "manoeuvres.png"), dpi=80)


main(*sys.argv[1:])

#!/usr/bin/env python3
"""Work against precision: CPU time and error of every integrator on several models, as JSON and as a figure.

bench/work_precision.py [--program build/release/mimbre] [--json results/work-precision.json] [--figure FILE.svg] [MODEL ...]

Models: chain, ladder, pendulum, vehicle; without names all of them. The error is the largest difference of the model's
outputs at the end from those of a run with a much smaller accuracy, relative to the largest output. CPU time is that of the
stepping loop, the least of three runs.
"""

import argparse
import json
import math
import pathlib
import subprocess
import tempfile
from dataclasses import dataclass

import chain

TOP = pathlib.Path(__file__).resolve().parent.parent
STEPPED = {"generalized_alpha": "--integrator generalized_alpha --rho 0.9", "rk4": "--integrator rk4 --substeps 1"}
CONTROLLED = ("dopri853", "radau", "auto")
ACCURACIES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
COLOURS = {"generalized_alpha": "#444", "rk4": "#b60", "dopri853": "#06c", "radau": "#090", "auto": "#c0c"}


@dataclass
class Case:
    file: str
    end: float  # s
    steps: tuple[float, ...]  # of the integrators without accuracy, s
    interval: float  # s, the step of those with accuracy
    reference: str = "--integrator dopri853 --accuracy 1e-12"


def ladder(loops: int) -> str:
    """Loops of bars of 1 m between standing bars on the ground, in a plane (bench/peers/ladder_model.py)."""
    lines = ["mimbre: 1", "gravity: [0, -9.81, 0]", "bodies:"]
    for i in range(loops + 1):
        lines.append(f"  bar_{i}: {{mass: 1, com: [{i}, 0.5, 0], inertia: [{1 / 12}, 2e-5, {1 / 12}]}}")
    for i in range(loops):
        lines.append(f"  top_{i}: {{mass: 1, com: [{i + 0.5}, 1, 0], inertia: [2e-5, {1 / 12}, {1 / 12}]}}")
    lines.append("joints:")
    for i in range(loops + 1):
        start = ", velocity: -1" if i == 0 else ""
        lines.append(
            f"  foot_{i}: {{type: revolute, between: [ground, bar_{i}], at: [{i}, 0, 0], axis: [0, 0, 1]{start}}}"
        )
    for i in range(loops):
        for bar in (i, i + 1):
            ends = f"between: [bar_{bar}, top_{i}], at: [{bar}, 1, 0]"
            lines.append(f"  head_{i}_{bar}: {{type: revolute, {ends}, axis: [0, 0, 1]}}")
    for component in "xy":
        at = f"position: bar_{loops}, at: [{loops}, 1, 0]"
        lines.append(f"{'outputs:' if component == 'x' else ''}\n  - {{name: {component}, {at}, component: {component}}}")
    return "\n".join(lines) + "\n"


def cases(folder: pathlib.Path) -> dict[str, Case]:
    (folder / "chain.yaml").write_text(chain.chain(10))
    (folder / "ladder.yaml").write_text(ladder(5))
    stiff = "--integrator radau --accuracy 1e-11"
    return {
        "chain": Case(str(folder / "chain.yaml"), 1.0, (0.02, 0.01, 0.005, 0.0025, 0.00125), 0.1),
        "ladder": Case(str(folder / "ladder.yaml"), 0.5, (0.02, 0.01, 0.005, 0.0025, 0.00125), 0.1),
        "pendulum": Case(
            str(TOP / "examples/pendulum/flexible.yaml"), 0.5, (0.01, 0.005, 0.002, 0.001, 0.0005, 0.0001), 0.05, stiff
        ),
        "vehicle": Case(
            str(TOP / "examples/iltis/vehicle.yaml"), 1.0, (0.01, 0.005, 0.002, 0.001, 0.0005), 0.01, stiff
        ),
    }


def run(program: str, case: Case, options: str, step: float) -> tuple[float, dict[str, float]]:
    """CPU seconds, the least of three, and the outputs at the end."""
    command = [program, "run", case.file, "-q", "--json", "--until", str(case.end), "--step", repr(step)]
    seconds, outputs = math.inf, {}
    for _ in range(3):
        done = subprocess.run([*command, *options.split()], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(done.stderr.strip()[-200:])
        summary = json.loads(done.stdout)
        seconds, outputs = min(seconds, summary["cpu_seconds"]), summary["outputs"]
    return seconds, outputs


def measure(program: str, name: str, case: Case) -> list[dict[str, object]]:
    _, exact = run(program, case, case.reference, case.interval)
    size = max(abs(x) for x in exact.values())
    rows: list[dict[str, object]] = []
    settings = [(i, o, s) for i, o in STEPPED.items() for s in case.steps]
    settings += [
        (i, f"--integrator {i} --accuracy {accuracy}", case.interval) for i in CONTROLLED for accuracy in ACCURACIES
    ]
    for integrator, options, step in settings:
        try:
            seconds, outputs = run(program, case, options, step)
        except RuntimeError as error:
            print(f"{name} {options} --step {step}: {error}", flush=True)
            continue
        error = max(abs(outputs[key] - exact[key]) for key in exact) / size
        rows.append(
            {"case": name, "integrator": integrator, "settings": options, "step": step, "cpu_seconds": seconds,
             "error": error}
        )  # fmt: skip
        print(f"{name} {options} --step {step}: {1e3 * seconds:.3g} ms, error {error:.2g}", flush=True)
    return rows


def figure(rows: list[dict[str, object]]) -> str:
    """One diagram a case, logarithmic in error (down to the right) and CPU time."""
    names = list(dict.fromkeys(str(row["case"]) for row in rows))
    width, height, margin = 420, 320, 50
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width * len(names)}" height="{height + 30}" '
        'font-family="sans-serif" font-size="11">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    for place, name in enumerate(names):
        own = [row for row in rows if row["case"] == name and 0 < float(str(row["error"])) < 1]
        points = [(-math.log10(float(str(r["error"]))), math.log10(1e3 * float(str(r["cpu_seconds"])))) for r in own]
        x0, x1 = math.floor(min(p[0] for p in points)), math.ceil(max(p[0] for p in points))
        y0, y1 = math.floor(min(p[1] for p in points)), math.ceil(max(p[1] for p in points))

        def x(value: float, x0: int = x0, x1: int = x1, place: int = place) -> float:
            return place * width + margin + (value - x0) / (x1 - x0) * (width - 1.5 * margin)

        def y(value: float, y0: int = y0, y1: int = y1) -> float:
            return height - margin + 10 - (value - y0) / (y1 - y0) * (height - 1.5 * margin)

        parts.append(f'<text x="{x(x0)}" y="16" font-weight="bold">{name}: CPU time, ms, against error</text>')
        for k in range(x0, x1 + 1):
            parts.append(f'<path d="M{x(k):.1f} {y(y0):.1f}V{y(y1):.1f}" stroke="#ddd"/>')
            parts.append(f'<text x="{x(k):.1f}" y="{y(y0) + 14:.1f}" text-anchor="middle">1e{-k}</text>')
        for k in range(y0, y1 + 1):
            parts.append(f'<path d="M{x(x0):.1f} {y(k):.1f}H{x(x1):.1f}" stroke="#ddd"/>')
            parts.append(f'<text x="{x(x0) - 4:.1f}" y="{y(k) + 4:.1f}" text-anchor="end">{10.0**k:g}</text>')
        for integrator, colour in COLOURS.items():
            line = [p for p, row in zip(points, own, strict=True) if row["integrator"] == integrator]
            if not line:
                continue
            path = "L".join(f"{x(a):.1f} {y(b):.1f}" for a, b in line)
            dash = ' stroke-dasharray="3 3"' if integrator == "auto" else ""
            parts.append(f'<path d="M{path}" fill="none" stroke="{colour}"{dash}/>')
            parts += [f'<circle cx="{x(a):.1f}" cy="{y(b):.1f}" r="2.5" fill="{colour}"/>' for a, b in line]
    for k, (integrator, colour) in enumerate(COLOURS.items()):
        parts.append(f'<text x="{margin + 130 * k}" y="{height + 18}" fill="{colour}">{integrator}</text>')
    return "\n".join([*parts, "</svg>"]) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("models", nargs="*")
    parser.add_argument("--program", default=str(TOP / "build/release/mimbre"))
    parser.add_argument("--json", default="results/work-precision.json")
    parser.add_argument("--figure", default="results/work-precision.svg")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        known = cases(pathlib.Path(folder))
        rows = [
            row for name in arguments.models or known for row in measure(arguments.program, name, known[name])
        ]
    for file, text in ((arguments.json, json.dumps(rows, indent=1) + "\n"), (arguments.figure, figure(rows))):
        pathlib.Path(file).parent.mkdir(parents=True, exist_ok=True)
        pathlib.Path(file).write_text(text)
        print(f"wrote {file}")


if __name__ == "__main__":
    main()

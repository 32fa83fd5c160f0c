#!/usr/bin/env python3
"""Ways to model what bends, on the same models: accuracy against cost, as docs/which-formulation.md with its figures.

bench/which_formulation.py [--program build/release/mimbre] [--folder docs]

Times are CPU of the stepping loop, the least of three runs, made in turn with those of the other ways.
"""

import argparse
import csv
import json
import math
import pathlib
import subprocess
import tempfile
from dataclasses import dataclass, field

TOP = pathlib.Path(__file__).resolve().parent.parent
EXAMPLES = TOP / "examples"
TERMS = (
    "first_moment",
    "second_moment_linear",
    "second_moment_quadratic",
    "rotation_coupling",
    "centrifugal",
    "coriolis_modes",
    "coriolis_body",
)
COLOURS = ("#06c", "#c40", "#090", "#a0a", "#860", "#444", "#0aa", "#c08")
GLOBAL_MODES = "--formalism global_modes"
ROD_FREQUENCY = (math.pi / 0.3) ** 2 * math.sqrt(2.1e11 * 0.003**2 / 4 / 7850)  # rad/s, of the rod between two pins


@dataclass
class Way:
    name: str
    settings: dict[str, object] = field(default_factory=dict)
    extra: str = ""  # of the model file
    options: str = ""  # of the run


@dataclass
class Outcome:
    columns: dict[str, list[float]]
    seconds: float
    iterations: float
    failed: str = ""


class Runner:
    def __init__(self, program: str, folder: pathlib.Path) -> None:
        self.program, self.folder = program, folder

    def wrapped(self, file: pathlib.Path, extra: str) -> pathlib.Path:
        """The model with more sections."""
        if not extra:
            return file
        path = self.folder / f"{file.stem}-{abs(hash(extra))}.yaml"
        path.write_text(f"mimbre: 1\ninclude: [{json.dumps(str(file))}]\n{extra}")
        return path

    def run(self, file: pathlib.Path, way: Way, options: str, extra: str = "") -> Outcome:
        table = self.folder / "run.csv"
        table.unlink(missing_ok=True)
        command = [self.program, "run", str(self.wrapped(file, way.extra + extra)), "-q", "--json"]
        command += ["--csv", str(table), *options.split(), *way.options.split()]
        for name, value in way.settings.items():
            command += ["--set", f"{name}={value}"]
        done = subprocess.run(command, capture_output=True, text=True)
        answer = json.loads(done.stdout)
        if answer.get("status") == "error":
            raise RuntimeError(f"{way.name}: {answer['errors'][0]['message']}")
        with table.open() as lines:
            rows = [[float(x) for x in row] for row in list(csv.reader(lines))[1:]]
        with table.open() as lines:
            names = next(csv.reader(lines))
        columns = {name: [row[k] for row in rows] for k, name in enumerate(names)}
        failed = "" if done.returncode == 0 else f"fails at {columns['t'][-1]:.1f} s"
        return Outcome(columns, answer["cpu_seconds"], answer["iterations_per_step"], failed)

    def in_turn(self, file: pathlib.Path, ways: list[Way], options: str, extra: str = "") -> list[Outcome]:
        found = [self.run(file, way, options, extra) for way in ways]
        for _ in range(2):
            for way, outcome in zip(ways, found, strict=True):
                outcome.seconds = min(outcome.seconds, self.run(file, way, options, extra).seconds)
        return found


def figure(title: str, across: str, up: str, lines: dict[str, list[tuple[float, float]]], points: bool = False) -> str:
    """Curves, or marks with their names, in a diagram of two logarithmic axes."""
    width, height, left, below = 690, 400, 70, 60
    every = [p for line in lines.values() for p in line if p[0] > 0 and p[1] > 0]
    low = [math.log10(min(p[k] for p in every)) for k in (0, 1)]
    high = [math.log10(max(p[k] for p in every)) for k in (0, 1)]
    for k in (0, 1):
        margin = 0.08 * (high[k] - low[k]) + 0.05
        low[k], high[k] = low[k] - margin, high[k] + margin

    def place(p: tuple[float, float]) -> tuple[float, float]:
        share = [(math.log10(p[k]) - low[k]) / (high[k] - low[k]) for k in (0, 1)]
        return left + share[0] * (width - left - 200), height - below - share[1] * (height - below - 40)

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-size="11" '
        'font-family="sans-serif">',
        '<rect width="100%" height="100%" fill="white"/>',
        f'<text x="{left}" y="20" font-weight="bold">{title}</text>',
        f'<text x="{(left + width - 200) / 2}" y="{height - 12}" text-anchor="middle">{across}</text>',
        f'<text transform="translate(16 {height / 2}) rotate(-90)" text-anchor="middle">{up}</text>',
    ]
    for k in (0, 1):
        for decade in range(math.floor(low[k]), math.ceil(high[k]) + 1):
            for step in (1, 2, 5):
                value = step * 10.0**decade
                if not low[k] <= math.log10(value) <= high[k]:
                    continue
                x, y = place((value, 10 ** low[1]) if k == 0 else (10 ** low[0], value))
                end = "V40" if k == 0 else f"H{width - 200}"
                parts.append(f'<path d="M{x:.1f} {y:.1f}{end}" stroke="#ddd"/>')
                at = (
                    f'x="{x:.1f}" y="{y + 14:.1f}" text-anchor="middle"'
                    if k == 0
                    else f'x="{x - 4:.1f}" y="{y + 4:.1f}" text-anchor="end"'
                )
                parts.append(f"<text {at}>{value:g}</text>")
    for k, (name, line) in enumerate(lines.items()):
        colour = COLOURS[k % len(COLOURS)]
        shown = [place(p) for p in line if p[0] > 0 and p[1] > 0]
        if not shown:
            continue
        if not points:
            path = "L".join(f"{x:.1f} {y:.1f}" for x, y in shown)
            parts.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>' for x, y in shown]
        parts.append(f'<text x="{width - 192}" y="{50 + 16 * k}" fill="{colour}">● {name}</text>')
    return "\n".join([*parts, "</svg>"]) + "\n"


def table(head: list[str], rows: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in [head, ["---"] * len(head), *rows]) + "\n"


def percent(x: float) -> str:
    return "fails" if math.isinf(x) else f"{100 * x:.2g} %" if x < 0.995 else f"{100 * x:.0f} %"


def largest(found: list[float], exact: list[float]) -> float:
    """The largest difference, by the range of what it should be; infinite where a run ended early."""
    if len(found) < len(exact):
        return math.inf
    size = max(exact) - min(exact)
    return max(abs(a - b) for a, b in zip(found, exact, strict=True)) / size if size > 0 else 0


# Systems


def slider_crank(runner: Runner) -> tuple[str, str]:
    file = EXAMPLES / "slider-crank/slider-crank.yaml"
    extra = "outputs:\n  - {name: end.deflection, deflection: rod.small_end, along: [0, 0, 1]}\n"
    ways = [
        Way("floating frame", {"approach": "floating_frame"}),
        Way("with geometric stiffness", {"approach": "geometric_stiffness"}),
        Way("elastodynamics", {"approach": "elastodynamics"}),
        Way("global modes", {"approach": "floating_frame"}, options=GLOBAL_MODES),
        Way("4 segments", {"approach": "segments", "elements": 4}),
        Way("16 segments", {"approach": "segments", "elements": 16}),
        Way("corotational, 4 elements", {"approach": "corotational", "elements": 4}),
        Way("absolute coordinates, 4 elements", {"approach": "ancf", "elements": 4}),
    ]
    reference = Way("reference", {"approach": "corotational", "elements": 20})

    def bend(outcome: Outcome) -> float:
        """From the largest to the least deflection of the middle from the line of the ends, in the last two turns."""
        middle, end = outcome.columns["rod.deflection"], outcome.columns["end.deflection"]
        values = [a - 0.5 * b for a, b in zip(middle, end, strict=True)]
        last = values[len(values) // 2 :]
        return math.inf if outcome.failed else max(last) - min(last)

    rows, lines = [], {way.name: [] for way in ways}
    costs: list[Outcome] = []
    for speed in (15, 30, 60, 90, 120, 150, 180):
        turn = 2 * math.pi / speed
        options = f"--set speed={speed} --set interval={turn / 200!r} --set step={turn / 2000!r} --until {4 * turn!r}"
        exact = bend(runner.run(file, reference, options, extra))
        found = (
            runner.in_turn(file, ways, options, extra)
            if speed == 60
            else [runner.run(file, w, options, extra) for w in ways]
        )
        costs = found if speed == 60 else costs
        errors = [abs(bend(outcome) / exact - 1) for outcome in found]
        for way, error in zip(ways, errors, strict=True):
            if math.isfinite(error):
                lines[way.name].append((speed / ROD_FREQUENCY, 100 * error))
        rows.append([str(speed), f"{speed / ROD_FREQUENCY:.3f}", f"{1e3 * exact:.3g}", *map(percent, errors)])
    head = ["speed, rad/s", "by the rod's frequency", "bend, mm", *(way.name for way in ways)]
    cost = table(
        ["", *(way.name for way in ways)],
        [["time by the floating frame's", *(f"{c.seconds / costs[0].seconds:.2f}" for c in costs)]],
    )
    return table(head, rows) + "\n" + cost, figure(
        "Slider–crank: error of the rod's bend", "speed of the crank by the rod's first frequency", "error, %", lines
    )


def critical_speed(runner: Runner) -> str:
    """The rod with a short crank about its first frequency, where the slider does not push it over."""
    file = EXAMPLES / "slider-crank/slider-crank.yaml"
    extra = "outputs:\n  - {name: end.deflection, deflection: rod.small_end, along: [0, 0, 1]}\n"
    crank, length, diameter, young, density, damping = 0.003, 0.3, 0.006, 2.1e11, 7850, 1e-5
    frequency = (math.pi / length) ** 2 * math.sqrt(young * diameter**2 / 16 / density)
    ratio = damping / 2 * frequency
    ways = [
        Way("elastodynamics", {"approach": "elastodynamics", "crank": crank}),
        Way("geometric stiffness", {"approach": "geometric_stiffness", "crank": crank}),
        Way("corotational, 10 elements", {"approach": "corotational", "elements": 10, "crank": crank}),
    ]
    rows = []
    for share in (0.8, 0.9, 1, 1.1, 1.25, 1.5):
        turn = 2 * math.pi / (share * frequency)
        options = (
            f"--set speed={share * frequency!r} --set interval={turn / 40!r} --set step={turn / 200!r} --until 1.2"
        )
        closed = 2 / math.pi * crank * share**2 / math.hypot(1 - share**2, 2 * ratio * share)
        row = [f"{share:g}", f"{1e3 * closed:.3g}"]
        for way in ways:
            outcome = runner.run(file, way, options, extra)
            middle, end = outcome.columns["rod.deflection"], outcome.columns["end.deflection"]
            last = [a - 0.5 * b for a, b in zip(middle, end, strict=True)][-80:]
            row.append(outcome.failed or f"{500 * (max(last) - min(last)):.3g}")
        rows.append(row)
    return table(["speed by the rod's frequency", "closed form, mm", *(f"{way.name}, mm" for way in ways)], rows)


def stiff_limit(runner: Runner) -> str:
    """The rod stiffer and stiffer, once its vibrations have gone: by how much ways differ from geometric stiffness."""
    file = EXAMPLES / "slider-crank/slider-crank.yaml"
    extra = "outputs:\n  - {name: end.deflection, deflection: rod.small_end, along: [0, 0, 1]}\n"
    reference = Way("with geometric stiffness", {"approach": "geometric_stiffness"})
    ways = [
        Way("floating frame", {"approach": "floating_frame"}),
        Way("elastodynamics", {"approach": "elastodynamics"}),
        Way("global modes", {"approach": "floating_frame"}, options=GLOBAL_MODES),
    ]

    def bend(way: Way, options: str) -> list[float]:
        columns = runner.run(file, way, options, extra).columns
        values = [a - 0.5 * b for a, b in zip(columns["rod.deflection"], columns["end.deflection"], strict=True)]
        return values[130:]

    rows: list[list[str]] = []
    before = [0.0] * len(ways)
    for stiffer in (1, 4, 16, 64):
        root = math.sqrt(stiffer)
        options = f"--set young={2.1e11 * stiffer} --set damping={2e-4 / root} --set step={2e-5 / root}"
        options += " --set interval=0.001 --until 0.25 --tolerance 1e-10"
        exact = bend(reference, options)
        size = max(abs(x) for x in exact)
        row = [str(stiffer), f"{1e3 * size:.3g}"]
        for k, way in enumerate(ways):
            off = max(abs(a - b) for a, b in zip(bend(way, options), exact, strict=True)) / size
            row += [percent(off), f"{math.log(before[k] / off, 4):.2f}" if before[k] else ""]
            before[k] = off
        rows.append(row)
    return table(["stiffness", "bend, mm", *(head for way in ways for head in (way.name, "order"))], rows)


def spin_up(runner: Runner) -> tuple[str, str]:
    file = EXAMPLES / "spin-up-beam/beam-2d.yaml"
    ways = [
        Way("elastodynamics", {"method": "elastodynamics"}),
        Way("floating frame, linear", {"method": "linear"}),
        Way("geometric stiffness", {"method": "geometric_stiffness"}),
        Way("foreshortening", {"method": "foreshortening"}),
        *(Way(f"{n} substructures", {"method": "substructuring", "substructures": n}) for n in (5, 10, 20)),
        *(Way(f"{n} segments", {"method": "segments", "elements": n}) for n in (5, 10, 20, 40)),
        *(Way(f"corotational, {n} elements", {"method": "nonlinear_beam", "elements": n}) for n in (5, 10, 20)),
        *(
            Way(
                f"lumped corotational, {n} elements",
                {"method": "nonlinear_beam", "elements": n, "mass_matrix": "lumped"},
            )
            for n in (5, 10, 20, 40)
        ),
        *(Way(f"absolute coordinates, {n} elements", {"method": "ancf", "elements": n}) for n in (5, 10)),
    ]
    options = ""
    exact = runner.run(file, Way("reference", {"method": "nonlinear_beam", "elements": 60}), options)
    found = runner.in_turn(file, ways, options)
    rows, lines = [], {}
    for way, outcome in zip(ways, found, strict=True):
        error = largest(outcome.columns["tip.uy"], exact.columns["tip.uy"])
        shown = outcome.failed or percent(error)
        rows.append([way.name, shown, f"{1e3 * outcome.seconds:.3g}", f"{outcome.iterations:.1f}"])
        if not outcome.failed:
            family = way.name.split(",")[0].lstrip("0123456789 ")
            lines.setdefault(family, []).append((1e3 * outcome.seconds, 100 * error))
    return table(["", "error of the tip's deflection", "CPU, ms", "iterations a step"], rows), figure(
        "Spin-up beam: error against cost", "CPU of 20 s, ms", "error of the tip's deflection, %", lines
    )


def spin_up_in_space(runner: Runner) -> str:
    """Beams of any deflection, with weight: the tip's deflection in the plane of rotation and its height."""
    file = EXAMPLES / "spin-up-beam/beam-3d.yaml"
    kinds = {"corotational": "nonlinear_beam", "cable": "ancf_cable", "thick": "ancf_thick"}
    counts = {"corotational": (5, 10, 20), "cable": (3, 5, 10), "thick": (2, 3, 5)}
    ways = [
        Way(f"{name}, {n} elements", {"method": method, "elements": n})
        for name, method in kinds.items()
        for n in counts[name]
    ]
    exact = runner.run(file, Way("reference", {"method": "nonlinear_beam", "elements": 60}), "")
    rows = []
    for way, outcome in zip(ways, runner.in_turn(file, ways, ""), strict=True):
        errors = [percent(largest(outcome.columns[c], exact.columns[c])) for c in ("tip.uy", "tip.uz")]
        rows.append([way.name, *errors, f"{1e3 * outcome.seconds:.3g}", f"{outcome.iterations:.1f}"])
    return table(["", "error across", "error of the height", "CPU, ms", "iterations a step"], rows)


def cantilever(runner: Runner, first: str, settings: list[str]) -> str:
    """First frequency of a clamped bar against the number of its elements."""
    exact = 1.8751040687**2 * math.sqrt(7e10 * 2e-7 / (3000 * 4e-4)) / 10**2 / (2 * math.pi)
    rows, before = [], 0.0
    for n in (4, 8, 16, 32):
        command = [runner.program, "modes", str(EXAMPLES / "spin-up-beam/beam-2d.yaml"), "--json"]
        for setting in [*settings, f"elements={n}"]:
            command += ["--set", setting]
        answer = json.loads(subprocess.run(command, capture_output=True, text=True).stdout)
        lowest = min(mode["frequency"] for mode in answer["modes"] if mode["frequency"] > 0)
        error = lowest / exact - 1
        rows.append(
            [str(n), f"{lowest:.5f}", f"{100 * error:.3f} %", f"{math.log2(before / error):.2f}" if before else ""]
        )
        before = error
    return f"The exact frequency is {exact:.5f} Hz.\n\n" + table([first, "first frequency, Hz", "error", "order"], rows)


def frequencies(runner: Runner) -> str:
    return cantilever(runner, "segments", ["method=segments"])


def lumped(runner: Runner) -> str:
    return cantilever(runner, "elements", ["method=nonlinear_beam", "mass_matrix=lumped"])


def mechanism(runner: Runner, file: pathlib.Path, ways: list[Way], options: str) -> str:
    found = runner.in_turn(file, ways, options)
    exact = found[0]
    names = [n for n in exact.columns if n != "t" and "deflection" not in n]
    rows = []
    for way, outcome in zip(ways, found, strict=True):
        sizes = {n: max(exact.columns[n]) - min(exact.columns[n]) for n in names}
        # Channels of round-off, as the roll on a symmetric road, are none.
        real = [n for n in names if sizes[n] > 1e-6 * max(sizes.values())]
        error, worst = max((largest(outcome.columns[n], exact.columns[n]), n) for n in real)
        shown, worst = (
            ("", "") if way is ways[0] else (outcome.failed or percent(error), "" if outcome.failed else worst)
        )
        rows.append(
            [way.name, shown, worst,
             f"{outcome.seconds / exact.seconds:.2f}", f"{outcome.iterations:.2f}"]
        )  # fmt: skip
    return table(["", "largest error of an output", "which", "time by the first's", "iterations a step"], rows)


def bases(runner: Runner, name: str, title: str) -> tuple[str, str]:
    """A table of `mimbre reproduce`: error against number of modes."""
    command = [runner.program, "reproduce", "--table", name, "--json"]
    answer = json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    found: dict[str, dict[str, list[float]]] = {}
    for row in answer["rows"]:
        if row["ours"] is None:
            continue
        series, _, size = row["case"].split(", ")
        found.setdefault(series, {}).setdefault(size, []).append(row["ours"])
    lines = {series: [(k, e) for k, e in sizes.values()] for series, sizes in found.items()}
    rows = [
        [series, str(round(modes)), percent(error / 100)] for series, line in lines.items() for modes, error in line
    ]
    return table(["basis", "modes", "error of the arm's deflection"], rows), figure(
        f"{title}: error against number of modes", "modes", "error of the arm's deflection, %", lines
    )


def without_terms() -> str:
    return f"neglected_inertia: {{all: [{', '.join(TERMS)}]}}\n"


def page(runner: Runner, folder: pathlib.Path) -> str:
    crank, crank_figure = slider_crank(runner)
    (folder / "which-formulation-crank.svg").write_text(crank_figure)
    spin, spin_figure = spin_up(runner)
    (folder / "which-formulation-spin-up.svg").write_text(spin_figure)
    arms, arms_figure = bases(runner, "bases-solid-arm", "Solid arm")
    (folder / "which-formulation-bases.svg").write_text(arms_figure)
    cars, cars_figure = bases(runner, "bases-vehicle", "Vehicle")
    (folder / "which-formulation-bases-vehicle.svg").write_text(cars_figure)
    bars = {"flexible_bars": 5}
    four_bar = mechanism(
        runner,
        EXAMPLES / "double-four-bar/mechanism.yaml",
        [
            Way("floating frame", bars),
            Way("without inertia terms", bars, without_terms()),
            Way("elastodynamics", {**bars, "flexibility": "elastodynamics"}),
            Way("global modes", bars, options=GLOBAL_MODES),
            Way("rigid", {"flexible_bars": 0}),
        ],
        "--until 2",
    )
    rigid = {"arms": "rigid", "links": "rigid", "rods": "rigid"}
    vehicles = [
        mechanism(
            runner,
            EXAMPLES / f"iltis/{name}.yaml",
            [
                Way("floating frame"),
                Way("without inertia terms", {}, without_terms()),
                Way("elastodynamics", {"flexibility": "elastodynamics"}),
                Way("global modes", options=GLOBAL_MODES),
                Way("rigid", rigid),
            ],
            "",
        )
        for name in ("suspension", "vehicle")
    ]
    text = (TOP / "bench/which_formulation.md").read_text()
    parts = {
        "CRANK": crank, "CRITICAL": critical_speed(runner), "STIFF": stiff_limit(runner),
        "SPIN_UP": spin, "FREQUENCIES": frequencies(runner),
        "FOUR_BAR": four_bar,
        "SUSPENSION": vehicles[0], "VEHICLE": vehicles[1], "BASES": arms, "BASES_VEHICLE": cars,
        "LUMPED": lumped(runner), "SPIN_UP_IN_SPACE": spin_up_in_space(runner),
    }  # fmt: skip
    for name, part in parts.items():
        text = text.replace(f"[{name}]\n", part)
    return text


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", default=str(TOP / "build/release/mimbre"))
    parser.add_argument("--folder", default=str(TOP / "docs"))
    arguments = parser.parse_args()
    folder = pathlib.Path(arguments.folder)
    with tempfile.TemporaryDirectory() as temporary:
        made = page(Runner(arguments.program, pathlib.Path(temporary)), folder)
    (folder / "which-formulation.md").write_text(made)


if __name__ == "__main__":
    main()

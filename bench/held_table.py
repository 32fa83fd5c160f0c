#!/usr/bin/env python3
"""How often the watch over stretching between held ends is right: random beams, plates and solids against nonlinear runs.

    bench/held_table.py build/release/mimbre [bodies of each kind [first seed]]

Each body bends under a static load, in five steps or more, that deflects it by a twentieth to four times its thickness. Its ends or edges are held, or
free to slide, to turn, or to give way against a spring. Linear modes are compared with corotational beams, plates (S8R) and
solids (C3D20R) with CalculiX (`ccx`), geometrically nonlinear. A run is wrong where any deflection is off by more than 10 %;
an alarm is a warning of stretching (`held`). Whatever the watch has as constants was chosen on seeds below 1000.
"""

import json, math, random, shutil, subprocess, sys, tempfile
from dataclasses import dataclass
from pathlib import Path

WRONG = 0.1
YOUNG, POISSON = 2.1e11, 0.3
KINDS = ("held", "hinged", "sliding", "springs", "free")


@dataclass
class Case:
    """A strip along x, from 0 to `length`, `width` across, loaded in z at its middle (free: at its end)."""

    kind: str
    length: float
    width: float
    thickness: float
    force: float
    spring: float  # along x, N/m
    at: float  # of the load, over the length


def random_case(r, kind, slenderness, aspect):
    length = math.exp(r.uniform(math.log(0.1), math.log(5)))
    thickness = length / math.exp(r.uniform(*map(math.log, slenderness)))
    width = length * r.uniform(*aspect) if aspect[0] > 0 else thickness * r.uniform(1.2, 6)
    at = 1.0 if kind == "free" else r.choice([0.5, 0.5, 0.35])
    factor = {"held": 192, "hinged": 48, "sliding": 192, "springs": 192, "free": 3, "edges": 192}[kind]
    deflection = thickness * math.exp(r.uniform(math.log(0.05), math.log(4)))
    if kind in ("sliding", "springs", "free"):  # what errs beyond is not stretching, and said by deflection over length
        deflection = min(deflection, 0.08 * length)
    stiffness = factor * YOUNG * width * thickness**3 / 12 / length**3
    axial = YOUNG * width * thickness / length
    spring = axial * math.exp(r.uniform(math.log(1e-4), math.log(10)))
    return Case(kind, length, width, thickness, stiffness * deflection, spring, at)


# What holds the ends: joints of the model; the first holds the end at x = 0.
def joints(case, strip):
    turn = "revolute" if case.kind == "hinged" else "fixed"
    axis = ", axis: [0, 1, 0]" if case.kind == "hinged" else ""
    text = f"joints:\n  start: {{type: {turn}, between: [ground, {strip}], at: [0, 0, 0]{axis}}}\n"
    end = f"between: [ground, {strip}], at: [{case.length}, 0, 0], cut: always"
    if case.kind in ("held", "hinged"):
        text += f"  end: {{type: {turn}, {end}{axis}}}\n"
    if case.kind in ("sliding", "springs"):
        text += f"  end: {{type: prismatic, {end}, axis: [1, 0, 0]}}\n"
    if case.kind == "springs":
        text += (
            f"bushings:\n  spring: {{between: [ground, {strip}], at: [{case.length}, 0, 0], x: [1, 0, 0],"
            f" stiffness: [{case.spring}, 0, 0, 0, 0, 0]}}\n"
        )
    return text


def ending(case, place):
    return f"""loads: {{load: {{on: strip.{place}, force: [0, 0, SHARE*{case.force}]}}}}
outputs: [{{name: w, position: strip.{place}, component: z}}]
initial: equilibrium
simulation: {{step: 1e-5, end: 1e-5}}
"""


def beam(case, linear):
    nodes = {"a": [0, 0, 0]} | ({} if case.at == 1 else {"m": [case.at * case.length, 0, 0]}) | {"e": [case.length, 0, 0]}
    names = list(nodes)
    bars = ", ".join(f"b{k}: {{from: {a}, to: {b}, elements: 12}}" for k, (a, b) in enumerate(zip(names, names[1:])))
    statics = ", ".join(f"{{node: {n}, all: true}}" for n in names[1:])
    modes = f"static_modes: [{statics}]\n      dynamic_modes: 6" if linear else "beam: corotational"
    return (
        f"""mimbre: 1
gravity: [0, 0, 0]
materials: {{steel: {{young: {YOUNG}, poisson: {POISSON}, density: 7850}}}}
sections: {{flat: {{type: rectangle, width: {case.width}, height: {case.thickness}}}}}
bodies:
  strip:
    frame: {{at: [0, 0, 0]}}
    flexible:
      material: steel
      section: flat
      nodes: {json.dumps(nodes)}
      bars: {{{bars}}}
      clamped: [a]
      {modes}
"""
        + joints(case, "strip")
        + ending(case, "e" if case.at == 1 else "m")
    )


class Grid:
    """Eight-node shells (one layer of nodes) or 20-node bricks (three) over the strip."""

    def __init__(self, case, nx, ny, solid):
        self.case, self.nodes, self.elements = case, {}, []
        hx, hy, hz = case.length / nx / 2, case.width / ny / 2, case.thickness / 2
        for i in range(nx):
            for j in range(ny):
                x, y = 2 * i, 2 * j
                if not solid:
                    at = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
                    self.elements.append([self.node(x + a, y + b, 1, hx, hy, hz) for a, b in at])
                    continue
                corner = [(0, 0), (2, 0), (2, 2), (0, 2)]
                side = [(1, 0), (2, 1), (1, 2), (0, 1)]
                at = [(a, b, 0) for a, b in corner] + [(a, b, 2) for a, b in corner]
                at += [(a, b, 0) for a, b in side] + [(a, b, 2) for a, b in side] + [(a, b, 1) for a, b in corner]
                self.elements.append([self.node(x + a, y + b, c, hx, hy, hz) for a, b, c in at])
        self.size = (2 * nx, 2 * ny)

    def node(self, i, j, k, hx, hy, hz):
        place = (i * hx, j * hy - self.case.width / 2, (k - 1) * hz)
        return self.nodes.setdefault((i, j, k), (len(self.nodes) + 1, place))[0]

    def where(self, test):
        return [number for key, (number, _) in self.nodes.items() if test(*key)]

    def text(self, sets):
        kind = "C3D20R" if len(self.elements[0]) == 20 else "S8R"
        lines = ["*NODE, NSET=all"] + [f"{n}, {x!r}, {y!r}, {z!r}" for n, (x, y, z) in self.nodes.values()]
        lines.append(f"*ELEMENT, TYPE={kind}, ELSET=strip")
        for k, e in enumerate(self.elements):
            numbers = [str(n) for n in [k + 1, *e]]
            lines += [", ".join(numbers[:12]) + ("," if len(numbers) > 12 else "")]
            lines += [", ".join(numbers[12:])] if len(numbers) > 12 else []
        for name, nodes in sets.items():
            lines += [f"*NSET, NSET={name}"] + [", ".join(map(str, nodes[k : k + 8])) for k in range(0, len(nodes), 8)]
        lines += ["*MATERIAL, NAME=steel", "*ELASTIC", f"{YOUNG!r}, {POISSON}", "*DENSITY", "7850"]
        section = "*SOLID SECTION, ELSET=strip, MATERIAL=steel"
        lines += [section] if kind == "C3D20R" else [section.replace("SOLID", "SHELL"), repr(self.case.thickness)]
        return "\n".join(lines) + "\n"


def sets_of(grid, case):
    last, side = grid.size
    middle = 2 * round(case.at * last / 2)
    patch = grid.where(lambda i, j, k: abs(i - middle) <= 2 and (case.at == 1 or abs(j - side / 2) <= 2))
    sets = {"start": grid.where(lambda i, j, k: i == 0), "patch": patch}
    if case.kind == "edges":
        sets["start"] = grid.where(lambda i, j, k: i in (0, last) or j in (0, side))
    elif case.kind != "free":
        sets["end"] = grid.where(lambda i, j, k: i == last)
    return sets


def ccx(folder, grid, case, sets, nonlinear):
    """The mean deflection of the patch by the share of the load; nothing where CalculiX gives up."""
    text = grid.text(sets)
    ends = [name for name in sets if name != "patch"]
    slides = {name: name == "end" and case.kind in ("sliding", "springs") for name in ends}
    if len(grid.elements[0]) == 20:
        refs = {name: len(grid.nodes) + 2 * k + 1 for k, name in enumerate(ends)}
        for name, ref in refs.items():
            x = case.length if name == "end" else 0.0
            text += f"*NODE\n{ref}, {x!r}, 0, 0\n{ref + 1}, {x!r}, 0, 0\n"
            text += f"*RIGID BODY, NSET={name}, REF NODE={ref}, ROT NODE={ref + 1}\n"
        sprung = refs.get("end")
        held = ""
        for name, ref in refs.items():
            held += f"{ref}, {2 if slides[name] else 1}, 3\n"
            held += f"{ref + 1}, 1, 1\n{ref + 1}, 3, 3\n" if case.kind == "hinged" else f"{ref + 1}, 1, 3\n"
    else:  # rigid bodies leave the shells' rotations free
        held = ""
        for name in ends:
            held += f"{name}, {2 if slides[name] else 1}, 3\n"
            held += f"{name}, 4, 4\n{name}, 6, 6\n" if case.kind == "hinged" else f"{name}, 4, 6\n"
            if slides[name]:
                text += "*EQUATION\n" + "".join(f"2\n{n}, 1, 1, {sets[name][0]}, 1, -1\n" for n in sets[name][1:])
        sprung = sets["end"][0] if "end" in sets else 0
    if case.kind == "springs":
        text += f"*ELEMENT, TYPE=SPRING1, ELSET=spring\n{len(grid.elements) + 1}, {sprung}\n"
        text += f"*SPRING, ELSET=spring\n1\n{case.spring!r}\n"
    text += "*BOUNDARY\n" + held
    # Equal parts, as the interface has them.
    text += "*STEP, NLGEOM, INC=200\n*STATIC\n0.1, 1, 1e-5, 0.2\n*CLOAD\n" if nonlinear else "*STEP\n*STATIC\n*CLOAD\n"
    text += "".join(f"{n}, 3, {case.force / len(sets['patch'])!r}\n" for n in sets["patch"])
    text += "*NODE PRINT, NSET=patch\nU\n*END STEP\n"
    (folder / "job.inp").write_text(text)
    (folder / "job.dat").unlink(missing_ok=True)
    try:
        subprocess.run(["ccx", "job"], cwd=folder, capture_output=True, timeout=900)
    except subprocess.TimeoutExpired:
        return None
    if not (folder / "job.dat").exists():
        return None
    means = {}
    for block in (folder / "job.dat").read_text().split(" displacements")[1:]:
        lines = block.splitlines()
        rows = [line.split() for line in lines[1:] if len(line.split()) == 4]
        means[float(lines[0].split()[-1])] = sum(float(row[3]) for row in rows) / len(rows)
    return means if 1.0 in means else None


def of_mesh(program, folder, case, solid):
    if case.kind == "edges":
        nx = ny = 12
    else:
        nx = 20
        ny = max(2, 2 * round(nx * case.width / case.length / 2 / (2 if solid else 1)))
    grid = Grid(case, nx, ny, solid)
    sets = sets_of(grid, case)
    (folder / "strip.inp").write_text(grid.text(sets))
    command = [program, "reduce", "strip.inp", "--modes", "12", "--free-modes", "0", "--no-cache", "-o", "strip.h5"]
    for name in sets:
        command += ["--interface", f"{name}=set:{name}"]
    command += ["--mean", "patch", "--point", "start=0,0,0"]
    command += ["--point", f"end={case.length},0,0"] if "end" in sets else []
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr)
    return grid, sets, (
        "mimbre: 1\ngravity: [0, 0, 0]\nbodies:\n  strip: {frame: {at: [0, 0, 0]}, reduced: strip.h5}\n"
        + joints(case, "strip")
        + ending(case, "patch")
    )


def run(program, text, folder, share):
    """The deflection under a share of the load, and the summary."""
    (folder / "model.yaml").write_text(text.replace("SHARE", repr(share)))
    done = subprocess.run([program, "run", "model.yaml", "--json", "-q"], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        return None, done.stderr
    summary = json.loads(done.stdout)
    return summary["outputs"]["w"], summary


def attempt(program, what, r, folder):
    """(error, predicted, alarm, case) or a reason."""
    if what == "beams":
        case = random_case(r, r.choice(KINDS), (20, 500), (0, 0))
        text, exact = beam(case, True), beam(case, False)
        right = {share: run(program, exact, folder, share)[0] for share in (0.2, 0.4, 0.6, 0.8, 1.0)}
        if None in right.values():
            right = None
    else:
        solid = what == "solids"
        kind = r.choice(KINDS) if solid else r.choice((*KINDS, "edges", "edges"))
        case = random_case(r, kind, (15, 80) if solid else (30, 200), (0.7, 1.4) if kind == "edges" else (0.05, 0.5))
        grid, sets, text = of_mesh(program, folder, case, solid)
        right = ccx(folder, grid, case, sets, True)
        small, _ = run(program, text, folder, 1e-3)
        linear = ccx(folder, grid, case, sets, False)
        # Elements of another program are a little softer or stiffer, which is not what is asked here.
        factor = small / 1e-3 / linear[1.0] if small and linear else 0
        right = {share: factor * w for share, w in right.items()} if right and abs(factor - 1) < 0.1 else None
    if right is None:
        return f"no nonlinear answer, {case}"
    worst, most, alarm = 0.0, 0.0, False
    for share, deflection in right.items():
        value, summary = run(program, text, folder, share)
        if value is None:
            return f"linear: {summary[:200]}"
        worst = max(worst, value / deflection - 1, key=abs)
        most = max(most, summary["validity"][0]["held"] or 0.0)
        alarm = alarm or any("held ends" in w for w in summary["warnings"])
    return worst, most, alarm, case


def main():
    program = str(Path(sys.argv[1]).resolve())
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    first = int(sys.argv[3]) if len(sys.argv) > 3 else 1000
    kinds = sys.argv[4].split(",") if len(sys.argv) > 4 else ["beams", "plates", "solids"]
    print("| bodies | runs | wrong and warned | right and silent | missed | false alarms |\n| --- | --- | --- | --- | --- | --- |")
    if not shutil.which("ccx"):
        kinds = [k for k in kinds if k == "beams"]
    with tempfile.TemporaryDirectory() as name:
        for what in kinds:
            hits = silent = missed = false = runs = 0
            for seed in range(first, first + count):
                result = attempt(program, what, random.Random(f"{what} {seed}"), Path(name))
                if isinstance(result, str):
                    print(what, seed, result, file=sys.stderr)
                    continue
                error, predicted, alarm, case = result
                wrong = abs(error) > WRONG
                print(
                    what,
                    seed,
                    case.kind,
                    f"error {error:.4f} predicted {predicted:.4f}",
                    "" if wrong == alarm else ("MISSED" if wrong else "FALSE"),
                    case,
                    file=sys.stderr,
                    flush=True,
                )
                runs += 1
                hits += alarm and wrong
                false += alarm and not wrong
                missed += wrong and not alarm
                silent += not alarm and not wrong
            print(f"| {what} | {runs} | {hits} | {silent} | {missed} | {false} |", flush=True)


main()

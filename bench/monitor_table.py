#!/usr/bin/env python3
"""How often the watch over linear theory is right: random mechanisms with one flexible beam, linear against corotational.

    bench/monitor_table.py build/release/mimbre [mechanisms of each kind [first seed]]

The limits were chosen on seeds 0 to 39; those from 1000 on judge them (docs/theory.md, section 13).

A run is wrong when a position is off by more than 1 % of its range, or a bending (an output "bend") by more than 10 %; an alarm is a
warning "beyond linear theory" of the linear run.
"""

import csv, json, math, random, subprocess, sys, tempfile
from pathlib import Path

WRONG = {"bend": 0.1}  # of the range; others:
WRONG_POSITION = 0.01
HEAD = """mimbre: 1
gravity: [0, 0, {gravity}]
materials: {{steel: {{young: 2.1e11, poisson: 0.3, density: 7800}}}}
sections: {{round: {{type: round, diameter: {diameter}}}}}
"""
LINEAR = """
      static_modes: [{statics}]
      dynamic_modes: 6"""
BEAM = """
      beam: corotational"""


def bodies(diameter, name, nodes, bars, clamped, statics, linear, gravity=0):
    """The beginning of a model file, up to its first body, a beam."""
    return (
        HEAD.format(gravity=gravity, diameter=diameter)
        + f"""bodies:
  {name}:
    frame: {{at: {list(nodes.values())[0]}}}
    flexible:
      material: steel
      section: round
      nodes: {json.dumps(nodes)}
      bars: {{{", ".join(f"{k}: {{from: {a}, to: {b}, elements: 5}}" for k, (a, b) in bars.items())}}}
      clamped: [{clamped}]
      stiffness_damping: 2e-4"""
        + (LINEAR.format(statics=", ".join(f"{{node: {n}, all: true}}" for n in statics)) if linear else BEAM)
        + "\n"
    )


def lean(r):
    """Deflections from a thousandth to a third of the length, evenly on a logarithmic scale."""
    return math.exp(r.uniform(math.log(1e-3), math.log(0.3)))


def bending(d):
    return 2.1e11 * math.pi / 64 * d**4


def swing(r, linear):
    """A pendulum's rod with a heavy end, let go from the horizontal."""
    length, d = r.uniform(0.5, 2), 0.01
    mass = lean(r) * 3 * bending(d) / length**2 / 9.81 / 2
    return (
        bodies(
            d,
            "rod",
            {"root": [0, 0, 0], "mid": [length / 2, 0, 0], "tip": [length, 0, 0]},
            {"a": ("root", "mid"), "b": ("mid", "tip")},
            "root",
            ["tip"],
            linear,
            gravity=-9.81,
        )
        + f"""  ball: {{mass: {mass}, com: [{length}, 0, 0], inertia: [{1e-4 * mass}, {1e-4 * mass}, {1e-4 * mass}]}}
joints:
  pivot: {{type: revolute, between: [ground, rod], at: [0, 0, 0], axis: [0, 1, 0]}}
  end: {{type: fixed, between: [rod, ball], at: [{length}, 0, 0]}}
outputs: [{{name: x, position: ball, component: x}}, {{name: z, position: ball, component: z}}, {{name: bend, displacement: rod.tip, relative_to: rod, component: z}}]
simulation: {{step: 0.001, end: 1}}
"""
    )


def push(r, linear):
    """A cantilever that a growing and falling load bends."""
    length, d = r.uniform(0.5, 2), 0.01
    force = lean(r) * 3 * bending(d) / length**2
    return (
        bodies(
            d,
            "rod",
            {"root": [0, 0, 0], "mid": [length / 2, 0, 0], "tip": [length, 0, 0]},
            {"a": ("root", "mid"), "b": ("mid", "tip")},
            "root",
            ["tip"],
            linear,
        )
        + f"""joints:
  wall: {{type: fixed, between: [ground, rod], at: [0, 0, 0]}}
loads: {{push: {{on: rod.tip, force: [0, 0, {force}], scale: "sin(pi*t)^2"}}}}
outputs: [{{name: z, position: rod.tip, component: z}}]
simulation: {{step: 0.001, end: 1}}
"""
    )


def held(r, linear):
    """Clamped at one end, guided at the other, pushed in the middle."""
    length, d = r.uniform(0.5, 2), 0.01
    force = lean(r) * 192 * bending(d) / length**2
    return (
        bodies(
            d,
            "rod",
            {"root": [0, 0, 0], "mid": [length / 2, 0, 0], "tip": [length, 0, 0]},
            {"a": ("root", "mid"), "b": ("mid", "tip")},
            "root",
            ["mid", "tip"],
            linear,
        )
        + f"""joints:
  wall: {{type: fixed, between: [ground, rod], at: [0, 0, 0]}}
  guide: {{type: cylindrical, between: [ground, rod], at: [{length}, 0, 0], axis: [1, 0, 0], cut: always}}
loads: {{push: {{on: rod.mid, force: [0, 0, {force}], scale: "sin(pi*t)^2"}}}}
outputs: [{{name: z, position: rod.mid, component: z}}]
simulation: {{step: 0.001, end: 1}}
"""
    )


def four_bar(r, linear):
    """A four-bar with a flexible coupler and a driven crank."""
    d, crank, coupler, rocker = 0.004, 0.1, r.uniform(0.4, 0.6), r.uniform(0.25, 0.35)
    ground = r.uniform(0.42, 0.5)
    # The crank upright.
    gap = math.hypot(ground, crank)
    at = math.atan2(-crank, ground) + math.acos((gap**2 + coupler**2 - rocker**2) / (2 * gap * coupler))
    pin = [coupler * math.cos(at), 0, crank + coupler * math.sin(at)]
    speed = 30 * math.sqrt(lean(r) / 0.02)
    mid = [pin[0] / 2, 0, (crank + pin[2]) / 2]
    return (
        bodies(
            d,
            "coupler",
            {"left": [0, 0, crank], "mid": mid, "right": pin},
            {"a": ("left", "mid"), "b": ("mid", "right")},
            "left",
            ["right"],
            linear,
        )
        + f"""  crank: {{mass: 0.1, com: [0, 0, {crank / 2}], inertia: [1e-4, 1e-4, 1e-4]}}
  rocker: {{mass: 0.2, com: [{(pin[0] + ground) / 2}, 0, {pin[2] / 2}], inertia: [1e-3, 1e-3, 1e-3]}}
joints:
  crank: {{type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0], drive: {{position: "{speed}*(t < 0.2 ? 0.5*t - sin(5*pi*t)/(10*pi) : t - 0.1)"}}}}
  left: {{type: revolute, between: [crank, coupler], at: [0, 0, {crank}], axis: [0, 1, 0]}}
  rocker: {{type: revolute, between: [ground, rocker], at: [{ground}, 0, 0], axis: [0, 1, 0]}}
  right: {{type: spherical, between: [coupler, rocker], at: {pin}, cut: always}}
outputs: [{{name: rocker, joint: rocker}}, {{name: mid.x, position: coupler.mid, component: x}}, {{name: mid.z, position: coupler.mid, component: z}}, {{name: bend, displacement: coupler.mid, relative_to: coupler, component: z}}]
simulation: {{step: 0.0005, end: 0.8}}
"""
    )


def rotor(r, linear):
    """A shaft in two bearings with an eccentric disc, run up through its critical speed."""
    length, d, mass = 1.0, 0.02, r.uniform(3, 6)
    critical = math.sqrt(48 * bending(d) / length**3 / mass)
    arm = lean(r) * 0.04 * length
    return (
        bodies(
            d,
            "shaft",
            {"left": [0, 0, 0], "mid": [length / 2, 0, 0], "right": [length, 0, 0]},
            {"a": ("left", "mid"), "b": ("mid", "right")},
            "left",
            ["mid", "right"],
            linear,
        )
        + f"""  disc: {{mass: {mass}, com: [{length / 2}, 0, {arm}], inertia: [{0.005 * mass}, {0.0025 * mass}, {0.0025 * mass}]}}
joints:
  left: {{type: revolute, between: [ground, shaft], at: [0, 0, 0], axis: [1, 0, 0], drive: {{position: "{critical}*t^2"}}}}
  right: {{type: cylindrical, between: [ground, shaft], at: [{length}, 0, 0], axis: [1, 0, 0], cut: always}}
  hub: {{type: fixed, between: [shaft, disc], at: [{length / 2}, 0, 0]}}
outputs: [{{name: y, position: shaft.mid, component: y}}, {{name: z, position: shaft.mid, component: z}}]
simulation: {{step: 0.0005, end: 1}}
"""
    )


def run(program, text, folder):
    model, table = folder / "model.yaml", folder / "out.csv"
    model.write_text(text)
    table.unlink(missing_ok=True)
    done = subprocess.run(
        [program, "run", model, "--csv", table, "--json", "-q", "-o", folder / "out.h5"], capture_output=True, text=True
    )
    if done.returncode:
        return None, done.stderr
    with open(table) as file:
        rows = list(csv.reader(file))
    columns = zip(*[[float(x) for x in row] for row in rows[1:]])
    return dict(list(zip(rows[0], columns))[1:]), json.loads(done.stdout)


def worst(columns, right):
    """Of all outputs, over what makes it wrong."""
    errors = {k: max(abs(a - b) for a, b in zip(columns[k], y)) / max(1e-12, max(y) - min(y)) for k, y in right.items()}
    return max(e / WRONG.get(k, WRONG_POSITION) for k, e in errors.items()), errors


def main():
    program, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 40
    first = int(sys.argv[3]) if len(sys.argv) > 3 else 0
    print(
        "| mechanism | runs | wrong and warned | right and silent | missed | false alarms |\n| --- | --- | --- | --- | --- | --- |"
    )
    with tempfile.TemporaryDirectory() as name:
        for make in (push, swing, held, four_bar, rotor):
            hits = silent = missed = false = runs = 0
            for seed in range(first, first + count):
                linear, summary = run(program, make(random.Random(seed), True), Path(name))
                right, why = run(program, make(random.Random(seed), False), Path(name))
                if linear is None or right is None:
                    print(
                        make.__name__, seed, "does not run", (summary if linear is None else why)[:300], file=sys.stderr
                    )
                    continue
                error, errors = worst(linear, right)
                alarm = any("beyond" in text for text in summary["warnings"])
                deflection = summary["validity"][0]["deflection"]
                print(
                    make.__name__,
                    seed,
                    *(f"{k} {e:.4f}" for k, e in errors.items()),
                    f"deflection {deflection:.4f}",
                    *[t.split(":", 1)[1] for t in summary["warnings"]],
                    file=sys.stderr,
                )
                runs += 1
                hits += alarm and error > 1
                false += alarm and error <= 1
                missed += not alarm and error > 1
                silent += not alarm and error <= 1
            print(f"| {make.__doc__} | {runs} | {hits} | {silent} | {missed} | {false} |", flush=True)


main()

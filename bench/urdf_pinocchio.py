#!/usr/bin/env python3
"""Public robots against Pinocchio: joint coordinates after 0.2 s of free motion from random speeds.

    python3 -m venv env && env/bin/pip install pin==4.1.0 example-robot-data==6.0.0 pybullet==3.2.7
    env/bin/python bench/urdf_pinocchio.py build/release/mimbre env [FOLDER ...]

Every robot is converted with its root held by the ground; its stops, frictions, dampers and couplings, which
Pinocchio does not have, are taken out of the model file. mimbre integrates with the trapezoidal rule at three
steps, Pinocchio's accelerations are integrated by the classical Runge-Kutta rule at 0.1 ms; mimbre's are
extrapolated to the step 0. Joints that the converter fixed are locked in Pinocchio at the same values. Where masses or
inertias needed a repair, Pinocchio's are those of the model file; such robots are counted apart, since their inertias
are not compared. Robots that are left out are printed with the reason. Prints one line a robot and the counts.
"""

import argparse
import csv
import json
import os
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin
from urdf_survey import distinct

END, STEP, RULE = 0.2, 1e-3, 1e-4  # s; of the coarsest run and of Runge-Kutta's
SCALAR = re.compile(r"^  (\S+|\"[^\"]*\"): \{type: (revolute|prismatic), ")


class LeftOut(Exception):
    pass


def converted(program, path, folder):
    """The model file without what Pinocchio does not have, and the values of fixed joints."""
    made = folder / "robot.yaml"
    done = subprocess.run(
        [program, "convert", str(path), "--repair", "-o", str(made)], capture_output=True, text=True, errors="replace"
    )
    if done.returncode not in (0, 4):
        raise LeftOut("is not converted: " + done.stderr.strip().splitlines()[-1])
    repaired = bool(re.search(r"repaired.*(mass|moments)", done.stderr))
    fixed = {name: float(value) for name, value in re.findall(r"joint '(.*?)' is fixed at (\S+):", done.stderr)}
    text, section = [], ""
    for line in made.read_text().splitlines():
        if line and line[0] not in " #":
            section = line.split(":")[0]
        if section in ("frictions", "stops", "constraints") or line.startswith("      - {"):
            continue
        if line == "    shapes:":
            continue
        text.append(re.sub(r", spring: \{[^}]*\}", "", line))
    return text, fixed, repaired


def inertias_of(lines):
    """By joint, of the body that it moves."""
    bodies, child, body, section = {}, {}, "", ""
    for line in lines:
        if line and line[0] not in " #":
            section = line.split(":")[0]
        elif section == "bodies":
            name, value = re.match(r"^  (\S+):$", line), re.match(r"^    (mass|com|inertia|frame): (.*)$", line)
            if name:
                body = name[1].strip('"')
                bodies[body] = {"com": [0, 0, 0], "inertia": [0] * 6}
            elif value:  # {at: …} becomes {"at": …}
                bodies[body][value[1]] = json.loads(re.sub(r"([{ ])(\w+): ", r'\1"\2": ', value[2]))
        elif joint := re.match(r"^  (\S+): \{type: (\w+), between: \[(\S+), ([^\]]+)\]", line):
            child[joint[1].strip('"')] = joint[4].strip('"')
            if joint[2] == "fixed" and joint[3] != "ground":
                raise LeftOut("has repaired bodies on fixed joints")

    def inertia(body):
        xx, yy, zz, xy, xz, yz = body["inertia"]
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        frame, axes = body["frame"], np.eye(3)
        for k, name in enumerate("xyz"):
            if name in frame:
                axes[:, k] = frame[name]
        given = [k for k, name in enumerate("xyz") if name in frame]
        if given:  # two of the axes
            k = ({0, 1, 2} - set(given)).pop()
            axes[:, k] = np.cross(axes[:, (k + 1) % 3], axes[:, (k + 2) % 3])
        return pin.Inertia(body["mass"], axes.T @ (np.array(body["com"]) - np.array(frame["at"])), matrix)

    return {joint: inertia(bodies[body]) for joint, body in child.items() if body in bodies}


def our_motion(program, lines, speeds, folder):
    """Coordinates by joint at END, extrapolated over three steps; and their starts."""
    starts, model = {}, []
    for line in lines:
        joint = SCALAR.match(line)
        if joint:
            name = joint[1].strip('"')
            position = re.search(r", position: ([^,}]+)", line)
            starts[name] = float(position[1]) if position else 0.0
            line = line[: line.rindex("}")] + f", velocity: {speeds[name]!r}}}"
        elif re.match(r"^  \S+: \{type: (floating|planar|spherical)", line):
            raise LeftOut("has joints of more than one coordinate")
        model.append(line)
    if not starts:
        raise LeftOut("has no moving joint")
    results = []
    for parts in (1, 2, 4):
        step = STEP / parts
        simulation = f"simulation: {{step: {step!r}, end: {END}, output_interval: {END}}}"
        (folder / "run.yaml").write_text("\n".join([*model, simulation, ""]))
        table = folder / "run.csv"
        command = [program, "run", str(folder / "run.yaml"), "-q", "--csv", str(table)]
        command += ["--integrator", "newmark", "--tolerance", "1e-10"]
        done = subprocess.run(command, capture_output=True, text=True, errors="replace")
        if done.returncode:
            raise LeftOut("does not run: " + done.stderr.strip().splitlines()[-1])
        with open(table, encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
        last = dict(zip(rows[0], rows[-1], strict=True))
        results.append(np.array([float(last[name]) for name in starts]))
    coarse, middle = (4 * results[1] - results[0]) / 3, (4 * results[2] - results[1]) / 3
    return starts, (16 * middle - coarse) / 15


def parsed(path, inertias):
    """Pinocchio's parser leaves out inertia with numbers that it cannot read, and only prints that. `inertias`: those
    that take its place, if any."""
    with tempfile.TemporaryFile() as messages:
        kept = os.dup(2)
        os.dup2(messages.fileno(), 2)
        try:
            model = pin.buildModelFromUrdf(str(path))
        finally:
            os.dup2(kept, 2)
            os.close(kept)
        messages.seek(0)
        if not inertias and b"Could not parse inertial" in messages.read():
            raise LeftOut("Pinocchio leaves out inertia whose numbers it cannot read")
    return model


def their_motion(path, fixed, starts, speeds, inertias):
    """`inertias`: by joint, in place of those of the robot's file where there are some."""
    model = parsed(path, inertias)
    if fixed:
        reference = pin.neutral(model)
        locked = [k for k, name in enumerate(model.names) if name in fixed]
        change = np.zeros(model.nv)
        for k in locked:
            change[model.joints[k].idx_v] = fixed[model.names[k]]
        model = pin.buildReducedModel(model, locked, pin.integrate(model, reference, change))
    if any(joint.nv != 1 for joint in list(model.joints)[1:]):
        raise LeftOut("has joints of more than one coordinate")
    names = [re.sub(r"[^A-Za-z0-9_.-]", "_", name) for name in list(model.names)[1:]]
    if set(names) != set(starts):
        raise LeftOut("names of joints differ")
    for k, name in enumerate(names):
        if inertias:
            model.inertias[k + 1] = inertias[name]
    index = {name: model.joints[k + 1].idx_v for k, name in enumerate(names)}
    data, neutral = model.createData(), pin.neutral(model)
    x, v = np.zeros(model.nv), np.zeros(model.nv)
    for name, place in index.items():
        x[place], v[place] = starts[name], speeds[name]
    zero = np.zeros(model.nv)

    def acceleration(x, v):
        return pin.aba(model, data, pin.integrate(model, neutral, x), v, zero).copy()

    h = RULE
    for _ in range(round(END / h)):
        a1 = acceleration(x, v)
        v2 = v + h / 2 * a1
        a2 = acceleration(x + h / 2 * v, v2)
        v3 = v + h / 2 * a2
        a3 = acceleration(x + h / 2 * v2, v3)
        v4 = v + h * a3
        a4 = acceleration(x + h * v3, v4)
        x, v = x + h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return np.array([x[index[name]] for name in starts])


class Speeds(dict):
    """Of each joint when first asked for, rad/s or m/s."""

    def __init__(self):
        super().__init__()
        self.random = np.random.default_rng(1)

    def __missing__(self, name):
        self[name] = round(float(self.random.uniform(-0.5, 0.5)), 3)
        return self[name]


def difference(program, path):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lines, fixed, repaired = converted(program, path, folder)
        speeds = Speeds()
        starts, ours = our_motion(program, lines, speeds, folder)
        theirs = their_motion(path, fixed, starts, speeds, inertias_of(lines) if repaired else {})
        if not np.isfinite(theirs).all():
            raise LeftOut("Pinocchio's motion is not finite")
        return float(np.max(np.abs(ours - theirs))), repaired


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda path: str(Path(path).resolve()))
    parser.add_argument("folders", nargs="+", type=Path)
    given = parser.parse_args()
    differences, left_out, repairs = [], 0, 0
    for path in distinct(given.folders):
        try:
            found, repaired = difference(given.program, path)
            differences.append(found)
            repairs += repaired
            print(f"{found:.1e}  {path}{' (repaired)' if repaired else ''}", flush=True)
        except Exception as why:  # Pinocchio's parser has errors of its own
            left_out += 1
            print(f"left out  {path}: {str(why).splitlines()[0][:150] if str(why) else type(why).__name__}", flush=True)
    print(f"\n{len(differences)} robots compared, {repairs} of them as repaired, {left_out} left out")
    print(f"{sum(d < 1e-6 for d in differences)} differ by less than 1e-6 after {END} s", end="")
    print(f"; median {np.median(differences):.1e}, largest {np.max(differences):.1e}" if differences else "")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Inverse dynamics of public robots against Pinocchio: forces in all joints at random positions, speeds, accelerations.

    python3 -m venv env && env/bin/pip install pin==4.1.0 example-robot-data==6.0.0
    env/bin/python bench/inverse_pinocchio.py build/release/mimbre env [FOLDER ...]

Robots are converted, and those left out chosen, as by urdf_pinocchio.py. Each has eight instants with positions up to
1 rad or m beside the start, speeds and accelerations up to 3. Prints for each robot the largest difference as a share
of its largest force, then the counts.
"""

import argparse
import csv
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin
from urdf_pinocchio import SCALAR, LeftOut, converted, inertias_of, parsed
from urdf_survey import distinct

INSTANTS = 8


def our_forces(program, lines, folder):
    """Starts by joint, the motion (instants x joints x 3) and the forces (instants x joints)."""
    starts = {}
    for line in lines:
        if joint := SCALAR.match(line):
            position = re.search(r", position: ([^,}]+)", line)
            starts[joint[1].strip('"')] = float(position[1]) if position else 0.0
        elif re.match(r"^  \S+: \{type: (floating|planar|spherical)", line):
            raise LeftOut("has joints of more than one coordinate")
    if not starts:
        raise LeftOut("has no moving joint")
    (folder / "run.yaml").write_text("\n".join([*lines, ""]))
    random = np.random.default_rng(1)
    motion = random.uniform(-1, 1, (INSTANTS, len(starts), 3)) * [1, 3, 3]
    motion[:, :, 0] += list(starts.values())
    names = [name + end for name in starts for end in ("", ".velocity", ".acceleration")]
    with open(folder / "motion.csv", "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["time", *names])
        for k in range(INSTANTS):
            table.writerow([k, *map(repr, motion[k].ravel().tolist())])
    command = [program, "inverse-dynamics", str(folder / "run.yaml"), "--motion", str(folder / "motion.csv")]
    done = subprocess.run(
        [*command, "-o", str(folder / "forces.csv")], capture_output=True, text=True, errors="replace"
    )
    if done.returncode:
        raise LeftOut("is not computed: " + done.stderr.strip().splitlines()[-1])
    with open(folder / "forces.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    return starts, motion, np.array([[float(row[name + ".force"]) for name in starts] for row in rows])


def their_forces(path, fixed, starts, motion, inertias):
    """`inertias`: by joint, in place of those of the robot's file where there are some."""
    model = parsed(path, inertias)
    if fixed:
        locked = [k for k, name in enumerate(model.names) if name in fixed]
        change = np.zeros(model.nv)
        for k in locked:
            change[model.joints[k].idx_v] = fixed[model.names[k]]
        model = pin.buildReducedModel(model, locked, pin.integrate(model, pin.neutral(model), change))
    if any(joint.nv != 1 for joint in list(model.joints)[1:]):
        raise LeftOut("has joints of more than one coordinate")
    names = [re.sub(r"[^A-Za-z0-9_.-]", "_", name) for name in list(model.names)[1:]]
    if set(names) != set(starts):
        raise LeftOut("names of joints differ")
    for k, name in enumerate(names):
        if inertias:
            model.inertias[k + 1] = inertias[name]
    places = [model.joints[names.index(name) + 1].idx_v for name in starts]
    data, forces = model.createData(), []
    for instant in motion:
        x, v, a = (np.zeros(model.nv) for _ in range(3))
        x[places], v[places], a[places] = instant.T
        forces.append(pin.rnea(model, data, pin.integrate(model, pin.neutral(model), x), v, a)[places])
    return np.array(forces)


def difference(program, path):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lines, fixed, repaired = converted(program, path, folder)
        starts, motion, ours = our_forces(program, lines, folder)
        theirs = their_forces(path, fixed, starts, motion, inertias_of(lines) if repaired else {})
        return float(np.max(np.abs(ours - theirs)) / np.max(np.abs(theirs))), len(starts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda path: str(Path(path).resolve()))
    parser.add_argument("folders", nargs="+", type=Path)
    given = parser.parse_args()
    differences, left_out = [], 0
    for path in distinct(given.folders):
        try:
            found, joints = difference(given.program, path)
            differences.append(found)
            print(f"{found:.1e}  {path} ({joints} joints)", flush=True)
        except Exception as why:  # Pinocchio's parser has errors of its own
            left_out += 1
            print(f"left out  {path}: {str(why).splitlines()[0][:150] if str(why) else type(why).__name__}", flush=True)
    print(f"\n{len(differences)} robots compared, {left_out} left out")
    if differences:
        print(f"median {np.median(differences):.1e}, largest {np.max(differences):.1e}")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Balls shot at surfaces at 1 to 10,000 radii a step: does any pass through without a word?

    bench/contact_shots.py build/release/mimbre [shots [first seed]]

Every shot is aimed so that the ball meets the surface: each kind of surface and other balls, a tenth of the ball's size
to ten times it, at rest or in flight and turning by up to a radian a step. A shot is silent where the ball flies on at
its velocity and nothing is said of the contact. It is wrong, against a solid at rest, where nothing is said and the
ball does not leave at 0.8 of the speed at which it came, along the direction of the impact, to a tenth. Prints a line for
every shot that is silent or wrong, then the counts.
"""

import argparse
import json
import random
import subprocess
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

KINDS = ("half_space", "box", "cylinder", "capsule", "sphere", "mesh", "heights", "ball")
RESTITUTION = 0.8


def solid_of(r, kind, size):
    """(surface, half of the thinnest way through it, how far it reaches)."""
    thin = size * 10 ** r.uniform(-1, 0)
    if kind == "half_space":
        return {"type": kind}, 0, 0
    if kind == "box":
        return {"type": kind, "size": [size, thin, size]}, thin / 2, size
    if kind == "cylinder":
        return {"type": kind, "radius": size / 2, "length": thin}, thin / 2, size
    if kind == "capsule":
        return {"type": kind, "radius": thin / 2, "length": size}, thin / 2, size
    if kind == "sphere":
        return {"type": kind, "radius": size / 2}, size / 2, size
    if kind == "mesh":
        corners = [[size, size, size], [size, -size, -size], [-size, size, -size], [-size, -size, size]]
        triangles = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
        return {"type": kind, "vertices": corners, "triangles": triangles}, size / 3**0.5, 2 * size
    if kind == "heights":
        heights = [[r.uniform(0, thin / 4) for _ in range(4)] for _ in range(4)]
        return {"type": kind, "at": [-1.5 * size, -1.5 * size, 0], "spacing": [size, size], "heights": heights}, 0, 0
    return None, size / 2, size


def direction(r, up=False):
    v = np.array([r.gauss(0, 1) for _ in range(3)])
    v /= np.linalg.norm(v)
    if up:  # not along the ground
        v[2] = max(abs(v[2]), 0.3)
        v /= np.linalg.norm(v)
    return v


def shot(r):
    kind = r.choice(KINDS)
    radius, h = 10 ** r.uniform(-3, 0), 10 ** r.uniform(-3, -1.5)
    ratio = 10 ** r.uniform(0, 4)  # radii a step
    speed, size = ratio * radius / h, 10 ** r.uniform(-1, 1) * radius
    surface, core, reach = solid_of(r, kind, size)
    ground = kind in ("half_space", "heights")
    moves = kind == "ball" or (not ground and r.random() < 0.5)
    velocity = speed * (-direction(r, True) if ground else direction(r))
    target = r.uniform(0, 0.6) * speed * direction(r) if moves else np.zeros(3)
    spin = 10 ** r.uniform(-2, 0) / h * direction(r) if moves else np.zeros(3)
    relative = velocity - target
    along = relative / np.linalg.norm(relative)
    beside = np.cross(along, direction(r))
    beside /= np.linalg.norm(beside)
    away = 1.2 * (reach + radius) + (4 * radius + size if ground else 0)
    time = max(r.uniform(0.3, 5.7) * h, away / np.linalg.norm(relative))
    off = r.uniform(0, 0.9) * (core + radius)
    start = (0 if ground else off) * beside - time * relative
    start = start.tolist()
    joints = {
        "flies": {
            "type": "floating",
            "between": ["ground", "ball"],
            "at": start,
            "velocity": [*velocity.tolist(), 0, 0, 0],
        },
        "solid": {"type": "floating" if moves else "fixed", "between": ["ground", "solid"]},
    }
    if moves:
        joints["solid"]["velocity"] = [*target.tolist(), *spin.tolist()]
    spheres = [{"on": "ball", "radius": radius}]
    stiffness = float(relative @ relative) / (0.2 * min(radius, radius if ground else size)) ** 2
    contact = {"spheres": spheres, "stiffness": stiffness, "restitution": RESTITUTION}
    model = {
        "mimbre": 1,
        "gravity": [0, 0, 0],
        "bodies": {
            "ball": {"mass": 1, "com": start, "inertia": [0.4 * radius**2] * 3},
            "solid": {"mass": 100, "com": [0, 0, 0], "inertia": [100 * size**2] * 3},
        },
        "joints": joints,
        "contacts": {"touch": contact},
        "outputs": [{"name": f"v{c}", "velocity": "ball", "component": c} for c in "xyz"],
        "simulation": {"step": h, "end": float((np.ceil(time / h) + 3) * h), "output_interval": h},
    }
    if kind == "ball":
        spheres.append({"on": "solid", "radius": size / 2})
        contact["among"] = True
    else:
        model["surfaces"] = {"face": {"on": "solid"} | surface}
        contact["surfaces"] = "face"
    return kind, ratio, moves, model


def judged(program, seed):
    """(kind, "silent", "wrong", "warned" or "right", a line of text)."""
    r = random.Random(f"shot {seed}")
    kind, ratio, moves, model = shot(r)
    formulation = r.choice(("relative", "relative", "relative", "natural"))
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "shot.yaml"
        path.write_text(json.dumps(model))
        command = [program, "run", str(path), "--json", "-q", "--formulation", formulation]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    line = f"seed {seed}: {kind}, {ratio:.4g} radii a step, {formulation}"
    if done.returncode:
        return kind, "warned", f"{line}: {done.stderr.strip()[:300]}"
    summary = json.loads(done.stdout)
    of_contact = [text for text in summary["warnings"] if text.startswith("contact 'touch'")]
    if of_contact:
        return kind, "warned", f"{line}: {of_contact[0][:300]}"
    before = np.array(model["joints"]["flies"]["velocity"][:3])
    after = np.array([summary["outputs"][f"v{c}"] for c in "xyz"])
    change = after - before
    if np.linalg.norm(change) <= 1e-3 * np.linalg.norm(before):
        return kind, "silent", line
    normal = change / np.linalg.norm(change)
    left = -(after @ normal) / (before @ normal)
    if not moves and kind != "heights" and abs(left - RESTITUTION) > 0.1 * RESTITUTION:
        return kind, "wrong", f"{line}: leaves at {left:.4f} of the speed"
    return kind, "right", line


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda path: str(Path(path).resolve()))
    parser.add_argument("shots", nargs="?", type=int, default=1000)
    parser.add_argument("first", nargs="?", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--all", action="store_true", help="print every shot")
    given = parser.parse_args()
    counts = Counter()
    with ThreadPoolExecutor(given.jobs) as pool:
        seeds = range(given.first, given.first + given.shots)
        for kind, verdict, line in pool.map(lambda seed: judged(given.program, seed), seeds):
            counts[kind, verdict] += 1
            if given.all or verdict in ("silent", "wrong"):
                print(f"{verdict:7} {line}", flush=True)
    verdicts = ("right", "warned", "wrong", "silent")
    print(f"\n{'surface':11}" + "".join(f"{v:>8}" for v in verdicts))
    for kind in KINDS:
        print(f"{kind:11}" + "".join(f"{counts[kind, v]:8}" for v in verdicts))
    print(f"{'all':11}" + "".join(f"{sum(counts[k, v] for k in KINDS):8}" for v in verdicts))


if __name__ == "__main__":
    main()

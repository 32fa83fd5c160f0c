#!/usr/bin/env python3
"""The energy balance of random models must close with the order of the rule, over jumps, too.

    bench/balance_table.py build/release/mimbre [--models 500] [--first 0] [--step 0.001] [--fine 1.25e-5] [--jobs 2]

Each random model (random_models.py) gets elements with forces that jump: by events, sampled signals, relays, time,
inputs from a table (held or in a line) and tunable parameters, and some joints get drives. It runs with the given
step, a half and a quarter of it, and with the fine one; at the same instants in each the imbalance
(`energy.numerical`) is taken, and its largest size divided by the energy at play: between the highest energy and the
lowest potential, with what drives, loads and roads turned over. Over a jump within a step velocities are off for a
few steps, and the balance with them: what counts is what lasts over four of these instants. Models in which a drive
and loops determine the same motion are left out. Prints the orders, the
imbalances, and the worst seeds; `--seed N` prints a model and its input instead. Needs h5py.
"""

import argparse
import csv
import json
import math
import random
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np
from random_models import SCALAR, random_model

GRID = 0.02  # s; what is sampled or played jumps at multiples of it
END = 0.4
CLOSED = 1e-6  # of the energy at play: closed at the fine step
ROUND_OFF = 1e-9  # of it: without an order
NOTHING = 1e-6  # J, at play
LASTING = 4  # instants


class Jumps:
    """Adds what jumps to a model."""

    def __init__(self, model, seed):
        self.model = model
        self.r = random.Random(f"jumps {seed}")
        self.rigid = [name for name, body in model["bodies"].items() if "flexible" not in body]
        self.start = {name: self.r.uniform(-1, 1) for name in ("u", "p", "w")}

    def add(self, section, name, content):
        names = self.model.setdefault(section, {})
        names[f"{name}{len(names)}"] = content

    def vector(self, size):
        return [self.r.uniform(-size, size) for _ in range(3)]

    def direction(self):
        v = [self.r.gauss(0, 1) for _ in range(3)]
        length = math.sqrt(sum(x * x for x in v))
        return [x / length for x in v]

    def point(self, body):
        if body == "ground":
            return self.vector(1.5)
        content = self.model["bodies"][body]
        if "flexible" in content:
            return list(content["flexible"]["nodes"]["root"])
        return [x + y for x, y in zip(content["com"], self.vector(0.3), strict=True)]

    def body(self):
        return self.r.choice(list(self.model["bodies"]))

    def two(self):
        second = self.body()
        return [self.r.choice([name for name in ("ground", *self.model["bodies"]) if name != second]), second]

    def joint(self):
        """A joint with one coordinate that is free to move; None: there is none."""
        free = [
            name
            for name, joint in self.model["joints"].items()
            if joint["type"] in SCALAR and "drive" not in joint and joint.get("cut") != "always"
        ]
        return self.r.choice(free) if free else None

    def turns(self, joint):
        return self.model["joints"][joint]["type"] == "revolute"

    def signals(self):
        """Inputs u, which an event sets, p and w, which the table does; s, sampled; relay."""
        start = self.start
        self.model.setdefault("inputs", {}).update(
            {"u": start["u"], "p": start["p"], "w": {"start": start["w"], "hold": "linear"}}
        )
        self.model.setdefault("signals", {}).update(
            {
                "s": {"value": f"sin({self.r.uniform(10, 30)}*t) + 0.5*u", "every": GRID},
                "relay": {"hysteresis": f"sin({self.r.uniform(10, 30)}*t)", "rises_at": 0.3, "falls_at": -0.2},
            }
        )
        event = {"when": "t", "crosses": self.r.uniform(0.05, 0.35), "set": {"u": self.r.uniform(-1, 1)}}
        self.model.setdefault("events", {})["jump"] = event

    def factor(self):
        """About 1 in size; most may jump."""
        time = self.r.uniform(0.1, 0.3)
        jumps = ["u", "p", "w", "s", "(relay - 0.4)", "(u + s)", f"(t < {time:.5g} ? 1 : -0.5)"]
        return self.r.choice([*jumps, "sin(9*t)"])

    def size(self, low, high):
        return f"{self.r.uniform(low, high):.4g}*{self.factor()}"

    def load(self):
        body = self.body()
        content = {"on": body, "at": self.point(body), "force": self.vector(5), "follower": self.r.random() < 0.5}
        if body in self.rigid:
            content["moment"] = self.vector(0.5)
        self.add("loads", "jumping", content | {"scale": self.factor()})

    def jet(self):
        pair = [self.r.choice(["ground", *self.rigid]), self.r.choice(self.rigid)]
        if pair[0] != pair[1]:
            about = self.r.random() < 0.5
            law = {"about": self.direction(), "torque": self.size(0.2, 1)}
            if not about:
                law = {"along": self.direction(), "force": self.size(1, 5)}
            self.add("actuators", "jet", {"between": pair, "at": self.point(pair[1])} | law)

    def on_joint(self):
        joint = self.joint()
        if joint is None:
            return
        what = "torque" if self.turns(joint) else "force"
        kind = self.r.choice(["actuator", "motor", "drive", "friction", "torsion"])
        if kind == "actuator":
            self.add("actuators", "push", {"joint": joint, what: self.size(0.3, 2)})
        elif kind == "friction":
            law = {"sticking": 0.01, "stribeck": 0.3, "static_ratio": 1.3, "viscous": 0.05, "settling": 0.01}
            self.add("frictions", "brake", {"joint": joint, what: f"0.5*(1.2 + 0.5*{self.factor()})"} | law)
        elif kind == "torsion":
            law = {"stiffness": self.r.uniform(5, 30), "damping": 0.3, "rest": f"0.2*{self.factor()}"}
            self.add("torsion_springs", "bar", {"coordinates": [{"joint": joint}]} | law)
        elif kind == "motor":
            law = {"ratio": 3, "inertia": 1e-3, "constant": 0.2, "resistance": 0.8, "drag": 1e-3, "efficiency": 0.9}
            self.add("motors", "dc", {"joint": joint, "voltage": self.size(3, 6)} | law)
        else:
            law = {"ratio": 2, "curve": {"table": [[0, 0.5], [30, 0.2]]}, "command": self.size(0.5, 0.9)}
            self.add("motors", "drive", {"joint": joint} | law)

    def cable(self):
        pair = self.two()
        at = [self.point(body) for body in pair]
        law = {"axial_stiffness": self.r.uniform(50, 200), "damping": 0.5}
        law["length"] = f"{0.9 * math.dist(*at):.5g} + 0.1*{self.factor()}"
        self.add("cables", "winch", {"over": pair, "at": at} | law)

    def spring(self):
        pair = self.two()
        at = [self.point(body) for body in pair]
        law = {"force": f"{self.r.uniform(20, 100):.4g}*(l - 0.5) + 0.5*v*l + {self.size(2, 5)}"}
        if self.r.random() < 0.5:
            name = f"k{len(self.model.get('parameters', {}))}"
            self.model.setdefault("parameters", {})[name] = {"value": self.r.uniform(20, 60), "tunable": True}
            event = {"when": "t", "crosses": self.r.uniform(0.1, 0.3), "set": {name: self.r.uniform(20, 60)}}
            self.add("events", "stiffer", event)
            law = {"force": f"{name}*(l - 0.5)"}
        self.add("springs", "law", {"between": pair, "at": at} | law)

    def drag(self):
        body = self.body()
        wind = [5, 0, f"3*{self.factor()}"]
        content = {"on": body, "at": self.point(body), "area": 1, "coefficients": [0.4, 0.8, 1.2], "wind": wind}
        self.add("drags", "gust", content)

    def drive(self):
        joint = self.joint()
        loops = self.model.get("constraints") or any("cut" in joint for joint in self.model["joints"].values())
        acts = any(
            content.get("joint") == joint
            for section in ("actuators", "motors", "frictions", "stops")
            for content in self.model.get(section, {}).values()
        )
        if joint is None or acts or loops:
            return
        content = self.model["joints"][joint]
        content.pop("velocity", None)
        content["drive"] = {"position": f"{self.r.uniform(0.1, 0.5)}*sin({self.r.uniform(2, 8)}*t)"}

    def road(self):
        """Those under tyres may move."""
        if self.model.get("tyres") and self.r.random() < 0.5:
            self.model["roads"] = {"road": {"over": "time", "height": f"0.02*{self.factor()}"}}

    def all(self):
        self.signals()
        if self.r.random() < 0.4:
            self.drive()
        self.road()
        kinds = [self.load, self.on_joint, self.on_joint, self.cable, self.spring, self.drag]
        if self.rigid:
            kinds += [self.jet, self.jet]
        for _ in range(self.r.randint(2, 4)):
            self.r.choice(kinds)()
        # A cost that is fixed leaves iterations where they are.
        self.model["simulation"].pop("fixed_cost", None)
        return self.model

    def table(self):
        """Of the inputs that the host plays."""
        last = [self.start["p"], self.start["w"]]
        rows = [[0, *last]]
        for k in range(3):
            last[self.r.randrange(2)] = self.r.uniform(-1, 1)
            rows.append([GRID * (3 + 4 * k + self.r.randrange(4)), *last])
        return rows


def jumping_model(seed):
    """A model and the table of its input."""
    jumps = Jumps(random_model(seed, end=END), seed)
    model = jumps.all()
    return model, jumps.table()


def write(seed, folder):
    model, table = jumping_model(seed)
    (folder / "model.yaml").write_text(json.dumps(model, indent=1))
    with open(folder / "input.csv", "w", newline="") as file:
        csv.writer(file).writerows([["t", "p", "w"], *table])


def imbalance(program, folder, step, every):
    """By the energy at play; and what went wrong."""
    model = json.loads((folder / "model.yaml").read_text())
    model["simulation"] |= {"step": step, "output_interval": every}
    (folder / "now.yaml").write_text(json.dumps(model))
    command = [program, "run", "now.yaml", "-q", "-o", "run.h5", "--input", "input.csv"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        errors = [line for line in done.stderr.splitlines() if "warning" not in line]
        return math.nan, (errors or ["?"])[0]
    with h5py.File(folder / "run.h5") as file:
        names = [name.decode().rstrip("\0") for name in file["channel_names"][:]]
        columns = {
            name[len("energy.") :]: file["channels"][:, k] for k, name in enumerate(names) if name.startswith("energy.")
        }
    total = sum(columns[name] for name in ("kinetic", "gravitational", "elastic", "springs", "tyres"))
    works = columns["drive_work"] + columns["load_work"] + columns["road_work"]
    at_play = total.max() - (total - columns["kinetic"]).min() + np.abs(np.diff(works)).sum()
    if at_play < NOTHING:
        return math.nan, "nothing moves"
    size = np.abs(columns["numerical"])
    lasting = np.min([size[k : len(size) - LASTING + 1 + k] for k in range(LASTING)], axis=0)
    return lasting.max() / at_play, ""


def contradiction(program, folder):
    """A drive of a motion that loops hold, too: where they contradict each other there is no motion."""
    model = json.loads((folder / "model.yaml").read_text())
    done = subprocess.run([program, "check", "model.yaml", "--json"], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        return ""
    redundant = json.loads(done.stdout)["redundant"]
    driven = [name for name, joint in model["joints"].items() if "drive" in joint and name in redundant]
    return f"the drive of joint '{driven[0]}' and loops determine a motion twice" if driven else ""


def attack(program, seed, steps, every):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write(seed, folder)
        if error := contradiction(program, folder):
            return seed, [], error
        found = [imbalance(program, folder, step, every) for step in steps]
    return seed, [one for one, _ in found], next((error for _, error in found if error), "")


def order(values):
    """Of the imbalances at a step, its half and its quarter."""
    if min(values[:3]) < ROUND_OFF:
        return math.nan
    return math.log2(values[0] / values[2]) / 2


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda path: str(Path(path).resolve()))
    parser.add_argument("--models", type=int, default=500)
    parser.add_argument("--first", type=int, default=0, help="seed")
    parser.add_argument("--step", type=float, default=0.001)
    parser.add_argument("--fine", type=float, default=1.25e-5)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--seed", type=int, help="print the model of this seed and its input")
    given = parser.parse_args()
    if given.seed is not None:
        model, table = jumping_model(given.seed)
        print(json.dumps(model, indent=1), *table, sep="\n")
        return 0
    steps = [given.step, given.step / 2, given.step / 4, given.fine]
    seeds = range(given.first, given.first + given.models)
    rows, stopped = [], []
    with ThreadPoolExecutor(given.jobs) as pool:
        for seed, values, error in pool.map(lambda seed: attack(given.program, seed, steps, given.step), seeds):
            if error:
                stopped.append((seed, error))
                print(f"seed {seed}: {error}", file=sys.stderr, flush=True)
            else:
                rows.append((seed, values, order(values)))
                print(
                    f"seed {seed}: " + " ".join(f"{value:.2e}" for value in values) + f" order {order(values):.2f}",
                    flush=True,
                )
    if not rows:
        return 1
    print(f"\n{len(rows)} of {given.models} random models ran to their end; at steps of", *steps, "s:")
    for k, step in enumerate(steps):
        values = np.array([values[k] for _, values, _ in rows])
        print(
            f"{step:9.3g} s: imbalance over the energy at play, median {np.median(values):.1e}, 95 % "
            f"{np.quantile(values, 0.95):.1e}, most {values.max():.1e}; under {CLOSED:g} in {(values < CLOSED).sum()}"
        )
    orders = np.array([one for _, _, one in rows if math.isfinite(one)])
    counts = Counter(min(int(2 * max(one, 0)), 6) for one in orders)
    print(f"order, median {np.median(orders):.2f} of {len(orders)} (others are at round-off):")
    print(*(f"  {k / 2:g} to {k / 2 + 0.5:g}: {counts[k]}" for k in sorted(counts)), sep="\n")
    open_seeds = [seed for seed, values, _ in rows if values[-1] >= CLOSED]
    projected = sum(jumping_model(seed)[0]["simulation"].get("inertia") == "projection" for seed in open_seeds)
    print(f"not under {CLOSED:g} at the fine step: {len(open_seeds)}, of which {projected} with inertia by projection")
    worst = sorted(rows, key=lambda row: -row[1][-1])[:10]
    print("worst at the fine step:", *(f"{seed} ({values[-1]:.1e})" for seed, values, _ in worst))
    return 0 if all(values[-1] < CLOSED for _, values, _ in rows) else 1


if __name__ == "__main__":
    sys.exit(main())

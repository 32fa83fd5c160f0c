#!/usr/bin/env python3
"""Attacks generated code: random models (random_models.py), whose code makes the same steps as the library.

usage: code_attack.py PROGRAM [FIRST] [COUNT]     with the project's Python environment, which has h5py

Of each model the code is made, compiled with all warnings, -O1 and the address and undefined behaviour sanitizers,
and run beside `mimbre run --fixed-cost`. Printed are models whose outputs differ by more than 1e-7 of their largest
value or 1 before one of the two stops, and how often which reason refused one. Models with impacts are counted apart.
"""

import json
import re
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np
from random_models import random_model

TOLERANCE = 1e-7
STEP, END = 0.005, 0.2
MAIN = """#include <stdio.h>
#include "code.h"
static code model;
int main(void) {
  int k, i, status = CODE_OK;
  code_init(&model);
  for (k = 0; k <= %d; ++k) {
    for (i = 0; i < CODE_OUTPUTS; ++i) printf("%%.17g ", code_get_output(&model, i));
    printf("\\n");
    if (status == CODE_ENDED) break;
    status = code_step(&model);
    if (status > CODE_UNCONVERGED && status != CODE_ENDED) break;
  }
  return 0;
}
"""
FLAGS = "-std=c99 -O1 -g -Wall -Wextra -Wpedantic -Werror -fsanitize=address,undefined -fno-sanitize-recover=undefined"


def model_of(seed):
    model = random_model(seed, step=STEP, end=END)
    for name in ("formulation", "formalism", "integrator", "inertia"):
        model["simulation"].pop(name, None)
    if "wanted" in model.get("signals", {}) and "actuators" in model:
        # Relays that switch each other, and an event at the last one.
        model["signals"]["first"] = {"hysteresis": "wanted + jitter", "rises_at": 0.05, "falls_at": -0.05}
        model["signals"]["second"] = {"hysteresis": "first + 0.1*late", "rises_at": 0.6, "falls_at": 0.3, "high": -2}
        for actuator in model["actuators"].values():
            for force in {"torque", "force"} & set(actuator):
                actuator[force] = f"{actuator[force]} + 0.1*second + 0.2*first"
        model.setdefault("events", {})["switched"] = {"when": "second", "crosses": -1}
    model["simulation"] |= {"step": STEP, "end": END, "output_interval": STEP, "formulation": "relative"}
    return model


def reason(text):
    """A message without names and numbers."""
    line = next((x for x in text.splitlines() if "error" in x), text.splitlines()[-1] if text else "none")
    return re.sub(r"'[^']*'|[-\d.e]*\d", "…", line.split("error: ")[-1])[:110]


def compare(program, seed):
    """(what happened, the difference)"""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = folder / "model.yaml"
        path.write_text(json.dumps(model_of(seed)))
        made = subprocess.run(
            [program, "generate", path, "-o", folder, "--name", "code"], capture_output=True, text=True
        )
        if made.returncode:
            return "refused: " + reason(made.stderr), 0
        (folder / "main.c").write_text(MAIN % round(END / STEP))
        command = f"cc {FLAGS} main.c code.c -o code -lm"
        compiled = subprocess.run(command.split(), cwd=folder, capture_output=True, text=True)
        if compiled.returncode:
            return "DOES NOT COMPILE: " + reason(compiled.stderr), np.inf
        code = subprocess.run([folder / "code"], capture_output=True, text=True)
        if code.returncode:
            return "FAILS: " + (code.stderr.splitlines() or ["?"])[-1][:100], np.inf
        run = [program, "run", path, "-q", "--fixed-cost", "-o", folder / "run.h5"]
        library = subprocess.run(run, capture_output=True, text=True)
        if not (folder / "run.h5").exists():
            return "library: " + reason(library.stderr), 0
        with h5py.File(folder / "run.h5") as file:
            names = [x.decode() for x in file["channel_names"][()]]
            channels = file["channels"][()]
        header = (folder / "code.h").read_text()
        outputs = re.findall(r"#define CODE_OUT_\w+ \d+ /\* ([^,]*),", header)
        rows = np.array([[float(x) for x in line.split()] for line in code.stdout.splitlines()])
        most, steps = 0.0, min(len(rows), len(channels))
        for k, output in enumerate(outputs):
            known = [x for x in (output, "signal." + output) if x in names]
            if not known or not rows.size:
                continue
            expected, found = channels[:steps, names.index(known[0])], rows[:steps, k]
            both = np.isfinite(expected) & np.isfinite(found)
            if both.any():
                most = max(most, float(np.abs(expected - found)[both].max() / max(1, np.abs(expected[both]).max())))
        what = "compared" if len(rows) == len(channels) else "compared as far as it went"
        kinds = {"contacts", "stops", "tyres", "frictions"} & set(json.loads(path.read_text()))
        return what + (" with impacts" if kinds else ""), most


def main():
    program = str(Path(sys.argv[1]).resolve())
    first, count = int(sys.argv[2]) if len(sys.argv) > 2 else 0, int(sys.argv[3]) if len(sys.argv) > 3 else 100
    happened, worst = Counter(), []
    with ThreadPoolExecutor(2) as pool:
        for seed, (what, difference) in enumerate(
            pool.map(lambda s: compare(program, s), range(first, first + count)), first
        ):
            happened[what] += 1
            worst.append((difference, seed, what))
            if difference > TOLERANCE or what[:2].isupper():
                print(f"seed {seed}: {what}, {difference:.1e}", flush=True)
    for what, times in happened.most_common():
        print(f"{times:5d} {what}")
    for what in sorted({w for _, _, w in worst if w.startswith("compared")}):
        of = sorted(d for d, _, w in worst if w == what)
        print(f"{what}: median {of[len(of) // 2]:.1e}, nine of ten {of[len(of) * 9 // 10]:.1e}, largest {of[-1]:.1e}")


if __name__ == "__main__":
    main()

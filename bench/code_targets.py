#!/usr/bin/env python3
"""Generated code by other compilers and for other machines: clang, 64-bit ARM, the sanitizers, valgrind, beside gcc's.

usage: code_targets.py PROGRAM [MODEL ...]     models: paths in examples/, without .yaml

Each model's code is compiled with -std=c99 and all warnings as errors, and moves for a second. Printed are the symbols
that it leaves undefined, and by how much outputs differ from gcc's at the end, by their size or 1. Tools that are not
there are left out (Debian: clang gcc-aarch64-linux-gnu qemu-user valgrind)."""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
MODELS = (
    "tutorial/pendulum",
    "double-four-bar/mechanism",
    "iltis/suspension",
    "iltis/vehicle",
    "iltis/drive",
    "iltis/brake-in-bend",
    "solar-array/model",
    "wind-turbine/model",
    "washing-machine/model",
)
MAIN = """#include <stdio.h>
#include "code.h"
static code model;
int main(void) {
  const long steps = (long)(1.0/CODE_STEP + 0.5);
  long k;
  code_init(&model);
  for (k = 0; k < steps; ++k)
    if (code_step(&model) > CODE_UNCONVERGED) return 1;
  for (k = 0; k < CODE_OUTPUTS; ++k) printf("%.17g ", code_get_output(&model, (int)k));
  return 0;
}
"""
STRICT = "-std=c99 -Wall -Wextra -Wpedantic -Werror -O1"
# Name, compiler, flags, and what runs the program.
TARGETS = (
    ("gcc", "gcc", "", ""),
    ("clang", "clang", "", ""),
    ("ARM", "aarch64-linux-gnu-gcc", "-static", "qemu-aarch64"),
    ("sanitizers", "gcc", "-g -fsanitize=address,undefined -fno-sanitize-recover=all", ""),
    ("valgrind", "gcc", "-g", "valgrind -q --error-exitcode=9"),
)


def outputs_of(folder: Path, compiler: str, flags: str, runner: str) -> list[float]:
    command = f"{compiler} {STRICT} {flags} main.c code.c -o program -lm"
    subprocess.run(command.split(), cwd=folder, check=True)
    done = subprocess.run([*runner.split(), "./program"], cwd=folder, check=True, capture_output=True, text=True)
    return [float(word) for word in done.stdout.split()]


def undefined_symbols(folder: Path) -> str:
    subprocess.run([*f"gcc {STRICT} -c code.c -o code.o".split()], cwd=folder, check=True)
    listed = subprocess.run(["nm", "-u", "code.o"], cwd=folder, check=True, capture_output=True, text=True).stdout
    return " ".join(sorted(line.split()[-1] for line in listed.splitlines()))


def main() -> None:
    program, *models = sys.argv[1:]
    program = str(Path(program).resolve())
    targets = [t for t in TARGETS if all(shutil.which(word.split()[0]) for word in (t[1], t[3]) if word)]
    for model in models or MODELS:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            command = [program, "generate", EXAMPLES / f"{model}.yaml", "-o", folder, "--name", "code"]
            subprocess.run(command, check=True, capture_output=True)
            (folder / "main.c").write_text(MAIN)
            found = {target: outputs_of(folder, *rest) for target, *rest in targets}
            first = found.pop("gcc")
            off = {
                target: max(abs(a - b) / max(1, abs(a)) for a, b in zip(first, values, strict=True))
                for target, values in found.items()
            }
            print(model, len(first), "outputs;", undefined_symbols(folder), flush=True)
            print("   ", ", ".join(f"{target} {value:.1e}" for target, value in off.items()), flush=True)


if __name__ == "__main__":
    main()

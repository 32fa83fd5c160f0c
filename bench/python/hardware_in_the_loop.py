#!/usr/bin/env python3
"""The driven Iltis in the loop with a controller by UDP: its C (examples/hardware-in-the-loop) and the library (`mimbre
live`) in turn, with the same priority and processor.

    build/python-env/bin/python bench/python/hardware_in_the_loop.py build/release/mimbre --seconds 60 --rounds 3

Prints the times of a step by the wall clock and how late steps began. SCHED_FIFO has to be permitted (root has it)."""

import argparse
import json
import math
import re
import subprocess
import tempfile
import threading
from pathlib import Path
from typing import Any

from mimbre.exchange import UdpPeer

REPOSITORY = Path(__file__).resolve().parents[2]


def drive(port: int, stop: threading.Event) -> None:
    """Answers each step's outputs: turns, accelerates and brakes."""
    with UdpPeer(("127.0.0.1", port), timeout=20) as peer:
        while not stop.is_set() and (got := peer.receive()) is not None:
            t = got.time
            inputs = {"steering": 0.1 * math.sin(0.7 * t), "throttle": 0.2 if t % 20 < 15 else 0.0}
            peer.send(inputs | {"brake": 0.1 if t % 20 > 17 else 0.0}, answers=got.sequence)


def with_driver(command: list[str], port: int) -> str:
    stop = threading.Event()
    driver = threading.Thread(target=drive, args=(port, stop))
    driver.start()
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    stop.set()
    driver.join()
    return done.stdout


def times_of_loop(text: str) -> dict[str, list[float]]:
    out = {}
    for line in text.splitlines():
        if found := re.match(r"(.*?) +median (\S+) +99.99 % (\S+) +worst (\S+) ms", line):
            out[found[1]] = [float(found[k]) for k in (2, 3, 4)]
    return out


def times_of_live(text: str) -> dict[str, list[float]]:
    monitor: dict[str, Any] = json.loads(text[text.index("{") :])["monitor"]
    names = {"computation of a step": "computation", "delay of a step's start": "latency"}
    return {name: [1e3 * monitor[of][figure] for figure in ("median", "p9999", "worst")] for name, of in names.items()}


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--priority", type=int, default=50)
    parser.add_argument("--cpu", type=int, default=1)
    parser.add_argument("--port", type=int, default=9017)
    parser.add_argument("--flags", default="-O2")
    given = parser.parse_args()
    model = REPOSITORY / "examples/iltis/drive.yaml"
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [given.program, "generate", model, "--name", "model", "-o", folder], check=True, capture_output=True
        )
        loop = f"{folder}/loop"
        source = REPOSITORY / "examples/hardware-in-the-loop/loop.c"
        flags = [*given.flags.split(), f"-I{REPOSITORY / 'include'}", f"-I{folder}"]
        subprocess.run(["cc", *flags, source, f"{folder}/model.c", "-o", loop, "-lm"], check=True)
        common = [str(given.port), str(given.priority), str(given.cpu), str(given.seconds)]
        of_loop = [loop, *[x for pair in zip(("-u", "-p", "-c", "-d"), common, strict=True) for x in pair]]
        options = ("--udp", "--priority", "--cpu", "--duration")
        of_live = [given.program, "live", str(model), "--no-open", "--json"]
        of_live += [x for pair in zip(options, common, strict=True) for x in pair]
        found: dict[str, list[dict[str, list[float]]]] = {"code": [], "library": []}
        for _ in range(given.rounds):
            found["code"].append(times_of_loop(with_driver(of_loop, given.port)))
            found["library"].append(times_of_live(with_driver(of_live, given.port)))
    steps = round(given.rounds * given.seconds / 1e-3)
    print(f"ms, {steps} steps of each: the mean of {given.rounds} medians and of 99.99 %, the worst of all\n")
    print("| | median | 99.99 % | worst |\n| --- | --- | --- | --- |")
    for what in ("computation of a step", "delay of a step's start"):
        for who, runs in found.items():
            rows = [run[what] for run in runs]
            mean = [sum(row[k] for row in rows) / len(rows) for k in (0, 1)]
            print(f"| {what}, {who} | {mean[0]:.3f} | {mean[1]:.3f} | {max(row[2] for row in rows):.3f} |")


if __name__ == "__main__":
    main()

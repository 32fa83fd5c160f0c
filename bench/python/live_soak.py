#!/usr/bin/env python3
"""Drives a model against the clock for long, with two viewers, of which one is stopped midway, and tells how the steps
kept their time before and after it, beside the idle machine.

    python3 bench/python/live_soak.py examples/iltis/drive.yaml --seconds 600 --step 0.001 --priority 50 --cpu 1

Further words go to `mimbre live`. Where the model has inputs steering, throttle and brake a driver turns, accelerates
and brakes; needs no package.

With `--again 5` what was driven is computed five times more, as fast as it goes, by the package `mimbre` (with the
parameters of the model's file): the least CPU time of a step over them is its own, and not what the machine adds to one
or another of them."""

import argparse
import base64
import json
import math
import os
import random
import signal
import socket
import struct
import subprocess
import sys
import time
from typing import Any
from urllib.parse import urlparse
from urllib.request import urlopen


class Viewer:
    """A WebSocket to the server, as a page would have it."""

    def __init__(self, url: str) -> None:
        there = urlparse(url)
        self.wire = socket.create_connection((there.hostname, there.port), timeout=30)
        key = base64.b64encode(random.randbytes(16)).decode()
        self.wire.sendall(
            f"GET /ws?{there.query} HTTP/1.1\r\nHost: {there.netloc}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n".encode()
        )
        self.buffer = b""
        while b"\r\n\r\n" not in self.buffer:
            self.buffer += self.wire.recv(4096)
        self.buffer = self.buffer.split(b"\r\n\r\n", 1)[1]

    def _take(self, count: int) -> bytes:
        while len(self.buffer) < count:
            got = self.wire.recv(65536)
            if not got:
                raise ConnectionError("the server has closed")
            self.buffer += got
        taken, self.buffer = self.buffer[:count], self.buffer[count:]
        return taken

    def receive(self) -> tuple[int, bytes]:
        head = self._take(2)
        size = head[1] & 0x7F
        if size == 126:
            size = struct.unpack(">H", self._take(2))[0]
        elif size == 127:
            size = struct.unpack(">Q", self._take(8))[0]
        opcode, payload = head[0] & 15, self._take(size)
        if opcode == 9:
            self._send(10, payload)
        return opcode, payload

    def _send(self, opcode: int, payload: bytes) -> None:
        mask = random.randbytes(4)
        size = bytes([0x80 | len(payload)]) if len(payload) < 126 else bytes([0xFE]) + struct.pack(">H", len(payload))
        self.wire.sendall(bytes([0x80 | opcode]) + size + mask + bytes(b ^ mask[k % 4] for k, b in enumerate(payload)))

    def say(self, **message: object) -> None:
        self._send(1, json.dumps(message).encode())


def look_on(url: str) -> None:
    viewer, pictures, begin = Viewer(url), 0, time.monotonic()
    try:
        while True:
            pictures += viewer.receive()[0] == 2
    except OSError:
        print(f"viewer: {pictures / (time.monotonic() - begin):.1f} pictures a second", file=sys.stderr)


def drive(url: str, seconds: float) -> None:
    """Turns, accelerates and brakes; a wish for another input is said at most 30 times a second."""
    viewer = Viewer(url)
    viewer.say(do="control", take=True)
    inputs = {
        one["name"]
        for one in json.load(urlopen(url.replace("/?", "/scene?") if "?" in url else url + "scene"))["inputs"]
    }
    phases = [random.uniform(0, 6) for _ in range(3)]
    begin = said = time.monotonic()
    while time.monotonic() - begin < seconds:
        viewer.receive()
        t = time.monotonic() - begin
        if time.monotonic() - said < 1 / 30 or not {"steering", "throttle", "brake"} <= inputs:
            continue
        said = time.monotonic()
        steering = 0.35 * math.sin(0.31 * t + phases[0]) + 0.2 * math.sin(1.1 * t + phases[1])
        brake = 0.6 if math.sin(0.17 * t + phases[2]) > 0.92 else 0.0
        viewer.say(do="inputs", values={"steering": steering, "throttle": 0.0 if brake else 0.35, "brake": brake})


def own_times(model: str, method: dict[str, Any], driven: dict[str, Any], seconds: float, times: int) -> list[float]:
    """CPU time of each step, s, the least of several runs with the inputs that were driven."""
    import mimbre

    compiled = mimbre.Model.from_file(model)
    least: list[float] = []
    for _ in range(times):
        simulation = compiled.simulation(**method)
        changes = sorted(
            (when, name, value)
            for name, track in driven["tracks"].items()
            for when, value in zip(track["times"], track["values"], strict=True)
        )
        inputs = {name: simulation.input(name) for name in driven["tracks"]}
        taken, change, half = [], 0, simulation.step_size / 2
        while simulation.time < seconds - half:
            while change < len(changes) and changes[change][0] <= simulation.time + half:
                _, name, value = changes[change]
                inputs[name].value = value
                change += 1
            begin = time.thread_time_ns()
            simulation.step()
            taken.append(1e-9 * (time.thread_time_ns() - begin))
        least = [min(pair) for pair in zip(least, taken, strict=True)] if least else taken
    return least


def figures(status: dict[str, dict[str, float]]) -> str:
    told = []
    for what in ("computation", "cpu", "latency"):
        of = status[what]
        told.append(f"{what} {1e3 * of['median']:.3f} / {1e3 * of['p9999']:.3f} / {1e3 * of['worst']:.3f}")
    return ", ".join(told)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model")
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--program", default="build/release/mimbre")
    parser.add_argument("--again", type=int, default=0)
    parser.add_argument("--look-on", action="store_true", help=argparse.SUPPRESS)
    a, further = parser.parse_known_args()
    if a.look_on:
        look_on(a.model)
        return 0
    words = [a.program, "live", a.model, "--duration", str(a.seconds), "--no-open", "--json", *further]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        url = process.stdout.readline().strip()
        status = url.replace("/?", "/status?") if "?" in url else url + "status"
        inputs_of = status.replace("/status", "/inputs")
        viewers = [subprocess.Popen([sys.executable, __file__, url, "--look-on"]) for _ in range(2)]
        driven: dict[str, Any] = {"tracks": {}}
        try:
            drive(url, a.seconds / 2)
            print("ms, median / 99.99 % / worst, both viewers:", figures(json.load(urlopen(status))), flush=True)
            os.kill(viewers[1].pid, signal.SIGSTOP)
            drive(url, a.seconds / 2 - 3)
            driven = json.load(urlopen(inputs_of))
        except (OSError, ConnectionError):
            pass  # its time is over
        summary = json.loads(process.stdout.read())
        for viewer in viewers:
            viewer.send_signal(signal.SIGCONT)
            viewer.wait(20)
    monitor = summary["monitor"]
    print("ms, median / 99.99 % / worst, to the end:  ", figures(monitor))
    if "idle" in summary:
        print("ms, the idle machine:                      ", figures(summary["idle"]), f"{summary['idle']['overruns']}")
    print(f"steps {monitor['steps']}, overruns {monitor['overruns']}, {summary['granted']}, {summary['worst_case']}")
    print(f"worst of CPU over its median: {monitor['cpu']['worst'] / monitor['cpu']['median']:.2f}")
    if a.again:
        keys = ("step", "formulation", "max_iterations", "substeps", "fixed_cost")
        method = {key: summary["resolved"][key] for key in keys}
        own = sorted(own_times(a.model, method, driven, summary["time"], a.again))
        median, p9999, worst = own[len(own) // 2], own[int(0.9999 * len(own))], own[-1]
        print(f"ms, a step's own, least of {a.again}: {1e3 * median:.4f} / {1e3 * p9999:.4f} / {1e3 * worst:.4f}")
        print(f"worst of its own over the median: {worst / median:.2f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

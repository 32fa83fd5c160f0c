"""Runs of the program mimbre."""

import csv
import json
import os
import pathlib
import subprocess
import tempfile

import numpy as np
from runner import Runner


class Program:
    def __init__(self, path: pathlib.Path, folder: pathlib.Path):
        self.path, self.folder = path.resolve(), folder
        self.version = self.call("--version").split()[-1]

    def call(self, *arguments: str) -> str:
        done = subprocess.run([self.path, *arguments], cwd=self.folder, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"mimbre {' '.join(arguments)}: {done.stderr.strip()[-300:]}")
        return done.stdout

    def outputs(self, model: str, columns: list[str], times: np.ndarray, options: list[str]) -> np.ndarray:
        """The columns of the model's table at these times."""
        with tempfile.NamedTemporaryFile(suffix=".csv") as table:
            self.call("run", model, "-q", "--csv", table.name, "--until", str(times[-1]), *options)
            with open(table.name, newline="") as file:
                rows = list(csv.DictReader(file))
        t = [float(row["t"]) for row in rows]
        return np.array([np.interp(times, t, [float(row[column]) for row in rows]) for column in columns]).T

    def seconds(self, model: str, until: float, options: list[str]) -> float:
        """CPU time of the stepping loop, the least of three runs in one process."""
        answer = self.call("bench", model, "--json", "--runs", "3", "--until", str(until), *options)
        return min(json.loads(answer)["models"][0]["cpu_seconds_of_runs"])

    def loading(self, model: str, *options: str) -> float:
        """CPU time of the whole program for a single step, without that step: its start, the file, the model."""
        before = os.times()
        answer = self.call("run", model, "-q", "--json", "--step", "1e-4", "--until", "1e-4", *options)
        after = os.times()
        spent = after.children_user + after.children_system - before.children_user - before.children_system
        return spent - json.loads(answer)["cpu_seconds"]

    def runner(
        self, model: str, columns: list[str], times: np.ndarray, options: str, steps: tuple[float, ...]
    ) -> Runner:
        def with_step(step: float) -> list[str]:
            return [*options.split(), "--step", repr(step)]

        return Runner(
            "mimbre",
            self.version,
            options or "default",
            steps,
            lambda step: self.outputs(model, columns, times, with_step(step)),
            lambda step: self.seconds(model, float(times[-1]), with_step(step)),
        )

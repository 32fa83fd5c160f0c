"""What a run of a sweep costs beside the steps of its solver: CPU time of this thread, runs of the flexible vehicle of
8 s, in turn; the median, and the median of the ratios to the steps of the run beside it."""

import statistics
import time
from collections.abc import Callable
from functools import partial

import mimbre
from mimbre import ensemble

REPEATS = 15
OUTPUTS = {"one output, of motion": ["chassis.z"], "one, of forces": ["tyre.front_left.force"], "the model's 13": None}

model = mimbre.Model.from_file("examples/iltis/vehicle.yaml")
rows = {
    f"row of a sweep, {name}": ensemble._study(model, [], [{}], outputs, ["max", "rms"], None, None, {})[0].row
    for name, outputs in OUTPUTS.items()
}


def cpu(work: Callable[[], object]) -> float:
    """ms"""
    start = time.thread_time()
    work()
    return (time.thread_time() - start) * 1e3


def once() -> dict[str, float]:
    run: list[mimbre.Run] = []
    whole = cpu(lambda: run.append(model.run()))
    times = {
        "steps of Model.run, by its summary": run[0].summary["cpu_seconds"] * 1e3,
        "Model.run, all channels": whole,
    }
    return times | {name: cpu(partial(row, 0, {})) for name, row in rows.items()}


repeats = [once() for _ in range(REPEATS)]
steps = next(iter(repeats[0]))
print(f"{'':40} {'CPU ms':>8} {'over steps':>11}")
for name in repeats[0]:
    median = statistics.median(times[name] for times in repeats)
    print(f"{name:40} {median:8.1f} {statistics.median(times[name] / times[steps] for times in repeats):11.3f}")

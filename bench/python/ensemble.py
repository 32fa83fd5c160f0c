"""2000 runs of the flexible vehicle over heights of stairs and damping, by threads and by a cluster of Dask with three
worker processes, of which one is killed midway: throughput, CPU time of a run, memory, and whether all rows are the
same. The scheduler is a process of its own here.

    python bench/python/ensemble.py [ROWS] [SECONDS OF DRIVING]"""

import itertools
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

import mimbre
import numpy as np
import xarray as xr
from distributed import Client

ROWS = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
UNTIL = float(sys.argv[2]) if len(sys.argv) > 2 else 8.0
FEW = max(ROWS // 10, 1)
WORKERS = 3

model = mimbre.Model.from_file("examples/iltis/vehicle.yaml")
rows = [
    dict(zip(("stairs", "damping"), map(float, pair), strict=True))
    for pair in itertools.product(np.linspace(0.05, 0.2, max(ROWS // 40, 1)), np.linspace(0.5, 2, 40))
][:ROWS]


def memory(process: int, peak: bool = False) -> float:
    """MB of a process: now, or the most that it ever had."""
    status = Path(f"/proc/{process}/status").read_text(encoding="ascii")
    return int(status.split("VmHWM:" if peak else "VmRSS:")[1].split()[0]) / 1024


def by_threads(threads: int, some: list[dict[str, float]]) -> tuple[xr.Dataset, float]:
    before = memory(os.getpid())
    wall, cpu = time.perf_counter(), time.process_time()
    data = mimbre.sweep(model, some, outputs=["chassis.z"], reduce=["max", "rms"], until=UNTIL, workers=threads)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    print(
        f"{threads} thread{'s' if threads > 1 else ' '}: {len(some):5} runs, {len(some) / wall:6.1f} a second, "
        f"{cpu / len(some) * 1e3:6.1f} CPU ms a run, {cpu / wall:4.2f} cores, memory {before:.0f} → "
        f"{memory(os.getpid()):.0f} MB",
        flush=True,
    )
    return data, len(some) / wall


def by_dask() -> xr.Dataset:
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        environment = {**os.environ, "OMP_NUM_THREADS": "1"}

        def start(*arguments: str) -> subprocess.Popen[bytes]:
            log = stack.enter_context((folder / "log").open("ab"))
            process = subprocess.Popen(
                [sys.executable, "-m", *arguments, "--scheduler-file", str(folder / "scheduler.json")],
                stdout=log,
                stderr=log,
                env=environment,
            )
            stack.callback(process.wait)
            stack.callback(process.terminate)
            return process

        scheduler = start("distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard")
        workers = [
            start("distributed.cli.dask_worker", "--nthreads", "1", "--no-nanny", "--no-dashboard")
            for _ in range(WORKERS)
        ]
        client = stack.enter_context(Client(scheduler_file=str(folder / "scheduler.json")))
        client.wait_for_workers(WORKERS)
        before = memory(scheduler.pid)
        counts: list[int] = []

        def kill(done: int, total: int) -> None:
            counts.append(done)
            if done > total // 2 and workers[0].poll() is None:
                workers[0].send_signal(signal.SIGKILL)
                workers[0].wait()

        wall = time.perf_counter()
        data = mimbre.sweep(
            model, rows, outputs=["chassis.z"], reduce=["max", "rms"], until=UNTIL, executor=client, progress=kill
        )
        wall = time.perf_counter() - wall
        assert workers[0].returncode == -signal.SIGKILL
        print(
            f"Dask, {WORKERS} processes, one killed midway: {len(rows)} runs, {len(rows) / wall:.1f} a second; "
            f"scheduler's memory {before:.0f} → {memory(scheduler.pid):.0f} MB, at most "
            f"{memory(scheduler.pid, peak=True):.0f} MB"
        )
        assert counts == sorted(counts), "a row was counted twice"
        assert counts[-1] == len(rows), "a row was lost"
    return data


if __name__ == "__main__":
    alone = [by_threads(1, rows[::10][:FEW])[1], by_threads(2, rows[::10][:FEW])[1], by_threads(1, rows[::10][:FEW])[1]]
    print(f"2 threads make {2 * alone[1] / (alone[0] + alone[2]):.2f} times the runs of one")
    threads, _ = by_threads(2, rows)
    dask = by_dask()
    well = [int((data.status == "ok").sum()) for data in (threads, dask)]
    print(f"rows that ended well: {well[0]} by threads, {well[1]} by Dask")
    xr.testing.assert_identical(threads, dask)
    print("the same to the bit")

"""What is known of a simulation that ran against the clock."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Literal

Overrun = Literal["catch_up", "skip_output", "slow_down", "stop"]


@dataclass(frozen=True)
class Timings:
    """Of all steps, s."""

    median: float
    p99: float
    """99 per cent took no longer."""
    p9999: float
    """99.99 per cent took no longer."""
    worst: float


@dataclass(frozen=True)
class RealTime:
    """How the steps of `Simulation.real_time` kept their time."""

    steps: int
    computation: Timings
    """Of a step, by the wall clock."""
    cpu: Timings
    """That a step took of the processor."""
    latency: Timings
    """How late a step began."""
    overruns: dict[str, int]
    """Steps that were not ready in time: their "count", and by cause: latency, preemption, page_faults, parts,
    iterations, computation."""
    late_steps: int
    """That began late for overruns before them."""
    granted: dict[str, str]
    """What the system granted: memory, scheduling, processor."""
    worst_case: str
    """What bounds the work of a step."""
    message: str
    """Why it ended; empty: its time was over."""

    @classmethod
    def from_json(cls, text: str) -> RealTime:
        told = json.loads(text)
        return cls(
            told["steps"],
            Timings(**told["computation"]),
            Timings(**told["cpu"]),
            Timings(**told["latency"]),
            told["overruns"],
            told["late_steps"],
            told["granted"],
            told["worst_case"],
            told["message"],
        )

"""One way to integrate a model: a code with its settings, at several steps."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Runner:
    code: str
    version: str
    settings: str
    steps: tuple[float | None, ...]  # None: a task without steps
    # Outputs of a run at this step: a row an instant, a column a component.
    outputs: Callable[[float | None], np.ndarray]
    # CPU time of the stepping loop of one run at this step, or of the whole task, s.
    seconds: Callable[[float | None], float]
    # Step of its own converged run; None: the case's reference is its own.
    finest: float | None = None


@dataclass(frozen=True)
class Case:
    name: str
    what: str  # whose error, over which time
    unit: str
    reference: np.ndarray  # the outputs of mimbre's converged run
    runners: list[Runner]
    loading: dict[str, Callable[[], float]] | None = None  # CPU time from the data to a model ready to step, s, by code


def difference(outputs: np.ndarray, reference: np.ndarray) -> float:
    """Mean over the instants of the length of the difference."""
    return float(np.linalg.norm(outputs - reference, axis=1).mean())


def end_only(run: Callable[[float], tuple[np.ndarray, float]]) -> dict[str, Callable]:
    """`outputs` and `seconds` of a run that returns the outputs at its end, and its CPU time."""
    return {"outputs": lambda step: np.atleast_2d(run(step)[0]), "seconds": lambda step: run(step)[1]}


def optional(peers: list[Callable[[], list[Runner]]]) -> list[Runner]:
    """The runners of the peers that are installed."""
    runners = []
    for peer in peers:
        try:
            runners += peer()
        except ModuleNotFoundError as missing:
            print(f"left out, as it is not installed: {missing.name}", flush=True)
    return runners

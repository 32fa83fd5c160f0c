"""The classical rule of Runge and Kutta for a library that has accelerations and no integrator."""

import time
from collections.abc import Callable

import numpy as np

Acceleration = Callable[[np.ndarray, np.ndarray], np.ndarray]


def rk4(acceleration: Acceleration, q: np.ndarray, v: np.ndarray, step: float, steps: int) -> np.ndarray:
    """Coordinates at the end; joints of one coordinate each."""
    for _ in range(steps):
        a1 = acceleration(q, v).copy()
        v2 = v + step / 2 * a1
        a2 = acceleration(q + step / 2 * v, v2).copy()
        v3 = v + step / 2 * a2
        a3 = acceleration(q + step / 2 * v2, v3).copy()
        v4 = v + step * a3
        a4 = acceleration(q + step * v3, v4)
        q = q + step / 6 * (v + 2 * v2 + 2 * v3 + v4)
        v = v + step / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
    return q


def evaluation_seconds(acceleration: Acceleration, q: np.ndarray, v: np.ndarray, evaluations: int) -> float:
    """CPU time of the evaluations alone, as a loop in another language than Python would need at least."""
    begin = time.process_time()
    for _ in range(evaluations):
        acceleration(q, v)
    return time.process_time() - begin

"""A moment as an image, by Matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from .simulation import Simulation


class Picture:
    """Draws moments of a simulation as lines, seen along an axis; what was drawn once stays in the image."""

    def __init__(self, view: str, size: tuple[int, int] = (480, 360)) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self._columns = ["xyz".index(axis) for axis in view]
        self._figure = Figure(figsize=(size[0] / 100, size[1] / 100), dpi=100)
        self._canvas: Any = FigureCanvasAgg(self._figure)
        self._axes: Any = self._figure.add_subplot()
        self._labels = [f"{axis}, m" for axis in view]
        self._low, self._high = np.full(2, np.inf), np.full(2, -np.inf)

    def image(self, simulation: Simulation) -> npt.NDArray[np.uint8]:
        """Height × width × 3."""
        from matplotlib.collections import LineCollection

        axes = self._axes
        axes.clear()
        for k, (_, ends) in enumerate(simulation.lines()):
            flat = np.asarray(ends)[:, self._columns]
            axes.add_collection(LineCollection(_pairs(flat), colors=f"C{k % 10}"))
            if len(flat):
                self._low = np.minimum(self._low, flat.min(axis=0))
                self._high = np.maximum(self._high, flat.max(axis=0))
        if np.isfinite(self._low).all():
            margin = 0.1 * max(float((self._high - self._low).max()), 1e-6)
            axes.set_xlim(self._low[0] - margin, self._high[0] + margin)
            axes.set_ylim(self._low[1] - margin, self._high[1] + margin)
        axes.set_aspect("equal", adjustable="box")
        axes.set_xlabel(self._labels[0])
        axes.set_ylabel(self._labels[1])
        axes.set_title(f"{simulation.time:.2f} s", loc="left")
        self._canvas.draw()
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()


def _pairs(ends: npt.NDArray[np.float64]) -> Sequence[npt.NDArray[np.float64]]:
    return list(ends.reshape(-1, 2, 2))

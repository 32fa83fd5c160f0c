"""What a run gives: channels by name, a summary, pictures."""

from __future__ import annotations

import html
import json
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _checks, _core
from .errors import InputError

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas as pd
    import xarray as xr

Floats = npt.NDArray[np.float64]


class Channel(np.ndarray[tuple[Any, ...], np.dtype[np.float64]]):
    """The history of a channel: an array that knows its name, unit and meaning. Slices know them too; what is computed
    of it is a plain array."""

    name: str
    unit: str
    meaning: str

    def __array_finalize__(self, source: object) -> None:
        self.name = getattr(source, "name", "")
        self.unit = getattr(source, "unit", "")
        self.meaning = getattr(source, "meaning", "")

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        return array[()] if return_scalar or array.ndim == 0 else np.asarray(array)


class Run(Mapping[str, Channel]):
    """A run: `run["chassis.z"]` is the history of a channel at the instants `run.time`. Arrays are the run's own
    memory, without a copy, and cannot be written to. A name that is not there raises UnknownName. Runs can be pickled.

    Example:
        ```python
        run = mimbre.Model.from_file("vehicle.yaml").run()
        print(run["chassis.z"].max(), run["chassis.z"].unit)
        run.to_pandas().to_csv("vehicle.csv")
        run.report("vehicle.html")
        ```
    """

    def __init__(self, results: _core.Results, measured: str = "") -> None:
        self._results = results
        self._columns = {name: k for k, (name, _, _) in enumerate(results.channels)}
        self._measured = measured

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> Run:
        """The run in a results file (HDF5) that this package or `mimbre run` wrote; InputError where it is none."""
        return cls(_core.read_results(_checks.path("path", path)))

    # Channels

    def __getitem__(self, name: str) -> Channel:
        column = self._columns[_checks.known("channel", name, self._columns)]
        channel = self._results.column(column).view(Channel)
        channel.name, channel.unit, channel.meaning = self._results.channels[column]
        return channel

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        time = self.time
        end = f"{time[-1]:g}" if len(time) else "0"
        return f"<mimbre.Run {self.title!r}: {len(time)} instants to {end} s, {len(self)} channels>"

    @property
    def time(self) -> Floats:
        """The instants of all channels, s."""
        return self._results.time

    @property
    def units(self) -> dict[str, str]:
        """The channels' units, by name."""
        return {name: unit for name, unit, _ in self._results.channels}

    @property
    def meanings(self) -> dict[str, str]:
        """What the channels are, by name."""
        return {name: meaning for name, _, meaning in self._results.channels}

    @property
    def energy(self) -> dict[str, Channel]:
        """The terms of the energy balance over time, J."""
        return {name.removeprefix("energy."): self[name] for name in self if name.startswith("energy.")}

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies, for `poses`."""
        return self._results.bodies

    def poses(self, body: str) -> Floats:
        """Position (m) and quaternion (w x y z) of a body's frame, instants × 7, global."""
        bodies = self.bodies
        return np.asarray(self._results.poses[:, bodies.index(_checks.known("body", body, bodies)), :])

    @property
    def modes(self) -> Floats:
        """Amplitudes of all flexible bodies one after another, instants × modes: m, rad, or factors of shapes."""
        return self._results.modes

    # What it was

    @property
    def title(self) -> str:
        """The model's title."""
        return self._results.title

    @property
    def step(self) -> float:
        """The step, s."""
        return self._results.step

    @property
    def summary(self) -> dict[str, Any]:
        """How it ended, steps, iterations, largest violations, energies and outputs at the end, warnings; of a run that
        was made here also what it took, in seconds. Empty where a file's run was killed."""
        text = self._measured or self._results.summary_json
        summary: dict[str, Any] = json.loads(text) if text else {}
        return summary

    @property
    def warnings(self) -> list[str]:
        """What was suspicious about the run."""
        warnings: list[str] = self.summary.get("warnings", [])
        return warnings

    @property
    def options(self) -> dict[str, Any]:
        """Parameters and options that the run was made with."""
        options: dict[str, Any] = json.loads(self._results.options_json or "{}")
        return options

    @property
    def model_text(self) -> str:
        """The text of the model file."""
        return self._results.model_text

    # Elsewhere

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the results file that `mimbre run` would have written (docs/results-format.md)."""
        self._results.write(_checks.path("path", path))

    def __reduce__(self) -> tuple[Any, ...]:
        with tempfile.TemporaryDirectory(prefix="mimbre-") as folder:
            file = Path(folder, "run.h5")
            self.save(file)
            return _unpickled, (file.read_bytes(), self._measured)

    def to_pandas(self) -> pd.DataFrame:
        """A table with the channels as columns, by time; `attrs["units"]` has their units."""
        import pandas as pd

        table = pd.DataFrame({name: np.asarray(self[name]) for name in self}, index=pd.Index(self.time, name="time"))
        table.attrs["units"] = self.units
        return table

    def to_xarray(self) -> xr.Dataset:
        """A data set over `time`; each channel has `units` and `long_name`."""
        import xarray as xr

        return xr.Dataset(
            {
                name: ("time", np.asarray(self[name]), {"units": unit, "long_name": meaning})
                for name, unit, meaning in self._results.channels
            },
            coords={"time": ("time", self.time, {"units": "s", "long_name": "time"})},
            attrs={"title": self.title, "step": self.step},
        )

    def export(
        self,
        folder: str | os.PathLike[str],
        *,
        instants: int = 500,
        progress: Callable[[float], object] | None = None,
    ) -> str:
        """Writes motion, deflection and stress for ParaView (VTK) into a folder, as `mimbre export`, at no more than
        `instants` instants. Returns the name of the file to open. `progress` is called with the share that is done."""
        most = _checks.number("instants", instants)
        if most != int(most) or not 2 <= most <= 1_000_000:
            raise InputError(f"instants: is {most:g}; a whole number from 2 to 1000000 is needed")
        return self._results.export_vtk(_checks.path("folder", folder), int(most), _checks.callback(progress))

    # Pictures

    def plot(self, *names: str, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes:
        """Draws channels over time.

        Args:
            *names: of channels; without any the model's outputs.
            ax: Matplotlib's axes to draw on; default: new ones.

        Returns:
            The axes.
        """
        import matplotlib.pyplot as plt

        chosen = [self[name] for name in names or self.summary.get("outputs", {})]
        axes = plt.subplots()[1] if ax is None else ax
        units = {channel.unit for channel in chosen}
        for channel in chosen:
            axes.plot(
                self.time,
                channel,
                label=channel.name if len(units) == 1 else f"{channel.name}, {channel.unit}",
            )
        axes.set_xlabel("time, s")
        if len(units) == 1:
            axes.set_ylabel(units.pop())
        if chosen:
            axes.legend()
        return axes

    def report(self, path: str | os.PathLike[str]) -> None:
        """Writes the page of the run: animation, plots, summary, in one file for any browser."""
        self._results.write_report(_checks.path("path", path))

    def show(self, height: int = 700) -> Page:
        """The same page inside a notebook (Jupyter, JupyterLab, VS Code), `height` pixels high."""
        return Page(self._results.report(), height)


def _unpickled(content: bytes, measured: str) -> Run:
    with tempfile.TemporaryDirectory(prefix="mimbre-") as folder:
        file = Path(folder, "run.h5")
        file.write_bytes(content)
        return Run(_core.read_results(str(file)), measured)


class Page:
    """A page of HTML that a notebook shows in a frame of its own."""

    def __init__(self, text: str, height: int) -> None:
        self.text = text
        self.height = height

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.text)}" width="100%" height="{self.height}" '
            'style="border: none" allowfullscreen></iframe>'
        )

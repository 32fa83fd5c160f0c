"""What is known of a sweep's runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .study import NOT_RUN, Floats, Row, Study, Value, words

if TYPE_CHECKING:
    import xarray as xr

#: Of each output its unit and meaning.
Units = dict[str, tuple[str, str]]


def reduction_name(one: str | Callable[[Any], Any]) -> str:
    return one if isinstance(one, str) else getattr(one, "__name__", repr(one))


class Table:
    """The rows of a sweep so far."""

    def __init__(self, study: Study, count: int) -> None:
        self.study = study
        self.status = np.zeros(count, np.uint8)
        self.messages = [""] * count
        self.time: Floats | None = None
        self.values: Floats | None = None
        if study.reduce is not None:
            self._allocate(len(study.reduce))

    def _allocate(self, last: int) -> None:
        self.values = np.full((len(self.status), len(self.study.outputs), last), np.nan)

    def take(self, row: Row) -> bool:
        """Whether it is new: what is done again, as a worker died that had done it, counts once."""
        if self.status[row.index] != NOT_RUN or row.status == NOT_RUN:
            return False
        self.status[row.index] = row.status
        self.messages[row.index] = row.message
        if row.values is None:
            return True
        if row.time is not None:
            if self.time is None:
                self.time = row.time
                self._allocate(len(row.time))
            elif not np.array_equal(self.time, row.time):
                self.status[row.index] = words.index("failed")
                self.messages[row.index] = "its instants are others than those of the first run; give step= and until="
                return True
        assert self.values is not None
        self.values[row.index] = row.values
        return True

    def ended_well(self) -> list[int]:
        rows: list[int] = np.flatnonzero(self.status == words.index("ok")).tolist()
        return rows

    def forget(self, index: int) -> None:
        """It is to be run again."""
        self.status[index] = NOT_RUN

    def dataset(
        self, names: Sequence[str], grid: dict[str, list[Value]] | None, rows: list[dict[str, Value]], units: Units
    ) -> xr.Dataset:
        import xarray as xr

        if self.values is None:  # no run ended well
            self._allocate(0)
            self.time = np.zeros(0)
        assert self.values is not None
        dims = list(grid) if grid is not None else ["run"]
        shape = tuple(map(len, grid.values())) if grid is not None else (len(rows),)
        coordinates: dict[str, Any] = (
            {name: np.array(values) for name, values in grid.items()}
            if grid is not None
            else {name: ("run", np.array([row[name] for row in rows])) for name in names}
        )
        last: list[str] = []
        if self.study.reduce is None:
            last = ["time"]
            coordinates["time"] = ("time", self.time, {"units": "s"})
        elif len(self.study.reduce) > 1:
            last = ["reduction"]
            coordinates["reduction"] = [reduction_name(one) for one in self.study.reduce]
        # What a function makes of a history may be of another unit.
        kept = self.study.reduce is None or all(isinstance(one, str) for one in self.study.reduce)
        variables: dict[str, Any] = {}
        for k, name in enumerate(self.study.outputs):
            values = self.values[:, k, :] if last else self.values[:, k, 0]
            unit, meaning = units[name]
            attributes = {"units": unit, "long_name": meaning} if kept else {"long_name": meaning}
            variables[name] = (dims + last, values.reshape(shape + values.shape[1:]), attributes)
        variables["status"] = (dims, np.array(words)[self.status].reshape(shape))
        variables["message"] = (dims, np.array(self.messages, dtype=np.str_).reshape(shape))
        attributes = {"title": self.study.model.title}
        if self.study.reduce is not None and len(self.study.reduce) == 1:
            attributes["reduction"] = reduction_name(self.study.reduce[0])
        return xr.Dataset(variables, coordinates, attributes)

"""The file of a sweep: HDF5, written while it runs."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import InputError
from .study import LOST, NOT_RUN, words

if TYPE_CHECKING:
    from .table import Table

MESSAGE = 400  # bytes of a text


class Store:
    """Rows of a sweep in a file. It is made whole, under another name first, and once more when it is known how long
    histories are; after that only numbers in their places change, a row's status last. So a sweep that is killed leaves
    a good file, of which the rows that have a status are done."""

    def __init__(self, path: str, study: Mapping[str, str], parameters: Mapping[str, list[Any]]) -> None:
        self.path = Path(path)
        self._study = study
        self._parameters = parameters
        self._file: Any = None

    def read(self, table: Table) -> bool:
        """Takes the rows that are there, if the file is, and returns whether it is. Refuses that of another study."""
        import h5py

        if not self.path.exists():
            return False
        try:
            self._file = h5py.File(self.path, "r+")
            there = {name: str(self._file.attrs[f"study.{name}"]) for name in self._study}
        except (OSError, KeyError) as error:
            self.close()
            raise InputError(f"store: {self.path} cannot be used as a sweep's file: {error}") from None
        other = [name for name, value in self._study.items() if there[name] != value]
        if other:
            self.close()
            raise InputError(
                f"store: {self.path} is of another study: there {', '.join(other)} "
                f"{'are others' if len(other) > 1 else 'is another'}; give another file's name, or remove it"
            )
        status = self._file["status"][:]
        status[status == LOST] = NOT_RUN
        table.status[:] = status
        table.messages[:] = [text.decode(errors="ignore") for text in self._file["message"][:]]
        if "values" in self._file:
            table.values = self._file["values"][:]
        if "time" in self._file:
            table.time = self._file["time"][:]
        return True

    def write(self, table: Table, rows: Iterable[int]) -> None:
        """Writes these rows, and all where the file is not there yet, or had no place for values."""
        if self._file is None or ("values" not in self._file and table.values is not None):
            self.close()
            self._create(table)
            rows = np.flatnonzero(table.status != NOT_RUN).tolist()
        for row in rows:
            if table.values is not None:
                self._file["values"][row] = table.values[row]
            self._file["message"][row] = table.messages[row].encode()[:MESSAGE]
        self._file.flush()
        for row in rows:
            self._file["status"][row] = table.status[row]
        self._file.flush()

    def _create(self, table: Table) -> None:
        import h5py

        count = len(table.status)
        unfinished = self.path.with_name(self.path.name + ".new")
        with h5py.File(unfinished, "w") as file:
            for name, value in self._study.items():
                file.attrs[f"study.{name}"] = value
            file.attrs["status"] = ", ".join(f"{number} {word}" for number, word in enumerate(words))
            file.attrs["outputs"] = np.array([name.encode() for name in table.study.outputs])
            file["status"] = np.zeros(count, np.uint8)
            file["message"] = np.zeros(count, f"S{MESSAGE}")
            if table.values is not None:
                file["values"] = np.full_like(table.values, np.nan)
            for name, values in self._parameters.items():
                column = np.array(values)
                file[f"parameters/{name}"] = (
                    column if column.dtype.kind in "biuf" else np.char.encode(column.astype(str))
                )
            if table.time is not None:
                file["time"] = table.time
        os.replace(unfinished, self.path)
        self._file = h5py.File(self.path, "r+")

    def close(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None

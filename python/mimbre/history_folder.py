"""Histories of a sweep's runs, each in a file that its worker writes, so that nobody has to hold them all."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import InputError

if TYPE_CHECKING:
    from . import _core


@dataclass(frozen=True)
class HistoryFolder:
    """A folder with `run-000012.h5` and so on: `time` (s), the outputs by name, and the parameters as attributes."""

    folder: str

    @classmethod
    def of(cls, folder: str, known: range) -> HistoryFolder:
        """Made where it is not there. Refuses a folder with files of rows that are not `known` to the sweep."""
        path = Path(folder).absolute()
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"histories: {folder} is no folder, and cannot be made one: {error.strerror}") from None
        for unfinished in path.glob(".run-*.h5.*"):  # of workers that were killed
            unfinished.unlink(missing_ok=True)
        made = cls(str(path))
        if made.rows() - set(known):
            raise InputError(
                f"histories: {folder} has runs of another sweep; give an empty folder, or the store= that goes with it"
            )
        return made

    def rows(self) -> set[int]:
        """Those whose file is there."""
        return {int(file.stem.removeprefix("run-")) for file in Path(self.folder).glob("run-[0-9]*.h5")}

    def path(self, index: int) -> Path:
        return Path(self.folder, f"run-{index:06}.h5")

    def write(self, index: int, parameters: Mapping[str, Any], outputs: Sequence[str], found: _core.Histories) -> None:
        """Whole or not at all, so that of a worker that is killed no half file stays."""
        import h5py

        target = self.path(index)
        unfinished = target.with_name(f".{target.name}.{os.getpid()}")
        with h5py.File(unfinished, "w") as file:
            for name, value in parameters.items():
                file.attrs[name] = value
            file["time"] = found.time
            for name, history in zip(outputs, found.values, strict=True):
                file[name] = history
        os.replace(unfinished, target)

"""Files that a model was read from, besides its own."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from .errors import InputError

#: bytes; larger files have not changed where their times have not.
_LARGE = 1 << 20


@dataclass(frozen=True)
class _Content:
    size: int
    time: int  # ns, of the last change
    digest: bytes

    @staticmethod
    def of(path: Path, known: _Content | None = None) -> _Content | None:
        """None: it cannot be read."""
        try:
            status = path.stat()
            stamp = (status.st_size, status.st_mtime_ns)
            if known and known.size > _LARGE and (known.size, known.time) == stamp:
                return known
            digest = hashlib.sha256()
            with path.open("rb") as file:
                while part := file.read(_LARGE):
                    digest.update(part)
            return _Content(*stamp, digest.digest())
        except OSError:
            return None


class ReadFiles:
    """Where they are, wherever the process goes, and what was in them."""

    def __init__(self, paths: Iterable[str], before: ReadFiles | None = None) -> None:
        """`before`: of a model that was read from some of them, and they have not changed since."""
        known = before._contents if before else {}
        places = [Path(os.path.normpath(Path(path).absolute())) for path in paths]
        self._contents: dict[Path, _Content | None] = {path: known.get(path) or _Content.of(path) for path in places}

    @property
    def paths(self) -> list[Path]:
        return list(self._contents)

    def refuse_changes(self) -> None:
        """Raises InputError where one is not what it was."""
        changed = []
        for path, was in self._contents.items():
            now = _Content.of(path, was)
            if now is None or was is None or now.digest != was.digest:
                changed.append(f"{path}{'' if now else ' (it cannot be read)'}")
        if changed:
            raise InputError(
                f"the model names files that have changed since it was read: {', '.join(changed)}; read it again"
            )

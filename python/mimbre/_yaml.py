"""Python values as the text of a model file, and where in Python each line of it was given."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ._checks import described
from .errors import Diagnostic, InputError

WIDTH = 110
_plain = re.compile(r"[A-Za-z_$][A-Za-z0-9_.$/-]*")
_other_meaning = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}  # in YAML, as numbers have


@dataclass(frozen=True)
class Place:
    """A line of a Python file."""

    file: str
    line: int


class Writer:
    """Lines of YAML, each with the place that it comes from. `special` turns objects that are no plain values into
    such, or returns None."""

    def __init__(self, special: Callable[[object], object | None]) -> None:
        self.lines: list[str] = []
        self.places: list[Place | None] = []
        self._special = special

    @property
    def text(self) -> str:
        return "\n".join(self.lines) + "\n"

    def add(self, key: str, value: object, indent: int = 0, place: Place | None = None, what: str = "") -> None:
        """`key: value`, in one line where there is room. `what`: for messages."""
        self._add(" " * indent + scalar(key) + ":", value, indent, place, what or key)

    def item(self, value: object, indent: int, place: Place | None, what: str) -> None:
        """`- value`, in one line."""
        self._line(" " * indent + "- " + self._flow(value, place, what), place)

    def section(self, key: str) -> None:
        self._line(key + ":", None)

    def _add(self, head: str, value: Any, indent: int, place: Place | None, what: str) -> None:
        value = self._value(value, place, what)
        line = f"{head} {self._flow(value, place, what)}"
        # Lists of numbers stay in a line, however long it is.
        nested = isinstance(value, Mapping) or (isinstance(value, list) and any(isinstance(v, Mapping) for v in value))
        if len(line) <= WIDTH or not value or not nested:
            return self._line(line, place)
        self._line(head, place)
        if isinstance(value, Mapping):
            for key, inner in value.items():
                self._add(
                    " " * (indent + 2) + scalar(_word(key, place, what)) + ":",
                    inner,
                    indent + 2,
                    place,
                    f"{what}: {key}",
                )
        else:
            for inner in value:
                self._line(
                    " " * (indent + 2) + "- " + self._flow(self._value(inner, place, what), place, what),
                    place,
                )
        return None

    def _line(self, line: str, place: Place | None) -> None:
        self.lines.append(line)
        self.places.append(place)

    def _flow(self, value: object, place: Place | None, what: str) -> str:
        value = self._value(value, place, what)
        if isinstance(value, Mapping):
            entries = (
                f"{scalar(_word(key, place, what))}: {self._flow(inner, place, f'{what}: {key}')}"
                for key, inner in value.items()
            )
            return "{" + ", ".join(entries) + "}"
        if isinstance(value, list):
            return "[" + ", ".join(self._flow(inner, place, what) for inner in value) + "]"
        return scalar(value)

    def _value(self, value: object, place: Place | None, what: str) -> Any:
        """A text, a finite number, a flag, None, a list or a mapping."""
        if isinstance(value, np.ndarray | np.generic):
            value = value.tolist()
        if value is None or isinstance(value, str | bool | int | Mapping | list):
            return value
        if isinstance(value, float):
            if math.isfinite(value):
                return value
            raise error(place, f"{what}: is {value}; a finite number is needed")
        if isinstance(value, tuple):
            return list(value)
        special = self._special(value)
        if special is None:
            raise error(place, f"{what}: {described(value)} is no number, text, list or map of these")
        return special


def _word(key: object, place: Place | None, what: str) -> str:
    if not isinstance(key, str):
        raise error(place, f"{what}: a key is a text, not {described(key)}")
    return key


def scalar(value: object) -> str:
    """A value that is no list and no mapping."""
    if isinstance(value, str):
        plain = _plain.fullmatch(value) and value.lower() not in _other_meaning
        return value if plain else json.dumps(value, ensure_ascii=False)
    return json.dumps(value)  # the shortest digits that give a number back


def error(place: Place | None, message: str) -> InputError:
    return InputError([Diagnostic(place.file if place else "", place.line if place else 0, 0, message)])


def in_python(
    diagnostics: tuple[Diagnostic, ...] | list[Diagnostic], file: str, places: list[Place | None]
) -> Iterator[Diagnostic]:
    """Diagnostics of the text called `file` as those of the Python lines that it comes from."""
    for d in diagnostics:
        place = places[d.line - 1] if d.file == file and 0 < d.line <= len(places) else None
        if place:
            yield Diagnostic(place.file, place.line, 0, d.message)
        elif d.file == file:
            yield Diagnostic("", 0, 0, d.message)
        else:
            yield d

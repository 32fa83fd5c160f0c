"""Arguments of people, checked before the library sees them."""

from __future__ import annotations

import math
import numbers
import os
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from ._core import did_you_mean
from .errors import InputError, UnknownName


def number(name: str, value: object) -> float:
    """A finite number, of Python or NumPy."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    if not isinstance(value, numbers.Real) or isinstance(value, bool):
        raise InputError(f"{name}: a number is needed, not {described(value)}")
    try:
        result = float(value)
    except OverflowError:
        raise InputError(f"{name}: is too large; a number within ±{sys.float_info.max:.3g} is needed") from None
    if not math.isfinite(result):
        raise InputError(f"{name}: is {result}; a finite number is needed")
    return result


def whole(name: str, value: object) -> int:
    """A whole number, of Python or NumPy."""
    result = number(name, value)
    if result != int(result):
        raise InputError(f"{name}: is {result}; a whole number is needed")
    return int(result)


def given(name: str, value: object) -> float | None:
    """A finite number, or nothing."""
    return None if value is None else number(name, value)


def array(name: str, value: Any, dimensions: int = 1) -> npt.NDArray[np.float64]:
    """Finite numbers in so many dimensions."""
    try:
        result = np.asarray(value, dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name}: an array of numbers is needed, not {described(value)}") from None
    if result.ndim != dimensions:
        raise InputError(f"{name}: an array of {dimensions} dimensions is needed, not of shape {result.shape}")
    if not np.isfinite(result).all():
        raise InputError(f"{name}: entry {np.argmax(~np.isfinite(result))} is not finite")
    return result


def text(name: str, value: object) -> str:
    if not isinstance(value, str):
        raise InputError(f"{name}: a text is needed, not {described(value)}")
    if not _writable(value):
        raise InputError(f"{name}: {value!r} is no text that can be written: it has zero bytes or lone surrogates")
    return value


def _writable(text: str) -> bool:
    return "\0" not in text and not any("\ud800" <= letter <= "\udfff" for letter in text)


def flag(name: str, value: object) -> bool:
    """True or False."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{name}: True or False is needed, not {described(value)}")
    return bool(value)


def path(name: str, value: object) -> str:
    """A file's name, as text or as a pathlib.Path."""
    if not isinstance(value, str | os.PathLike):
        raise InputError(f"{name}: a file's name is needed, not {described(value)}")
    return text(name, os.fspath(value))


def mapping(name: str, value: object, wanted: str) -> dict[str, Any]:
    """By names; `wanted`: what would be right."""
    if not isinstance(value, Mapping):
        raise InputError(f"{name}: {wanted} is needed, not {described(value)}")
    return {text(name, key): one for key, one in value.items()}


def names(name: str, value: object) -> list[str]:
    """A list of names, or one."""
    if isinstance(value, str):
        return [text(name, value)]
    if not isinstance(value, Iterable) or getattr(value, "ndim", 1) == 0:
        raise InputError(f"{name}: a list of names is needed, not {described(value)}")
    return [text(name, one) for one in value]


def pair(name: str, value: object, wanted: str) -> tuple[Any, Any]:
    """Two things; `wanted`: what would be right."""
    if not isinstance(value, tuple | list | np.ndarray) or getattr(value, "ndim", 1) == 0 or len(value) != 2:
        raise InputError(f"{name}: {wanted} is needed, not {described(value)}")
    return value[0], value[1]


Called = TypeVar("Called", bound="Callable[..., object] | None")


def callback(progress: Called) -> Called:
    """A function that receives the progress of long work, or nothing."""
    if progress is not None and not callable(progress):
        raise InputError(f"progress: a function is needed, not {described(progress)}")
    return progress


def known(what: str, name: object, names: Iterable[str]) -> str:
    """One of the names that there are."""
    all_names = list(names)
    if isinstance(name, str) and name in all_names:
        return name
    near = did_you_mean(name, all_names) if isinstance(name, str) and _writable(name) else ""
    there = ", ".join(all_names[:20]) + (", …" if len(all_names) > 20 else "")
    error = UnknownName(f"there is no {what} {name!r}{near}; there {'are: ' + there if there else 'is none'}")
    raise error


def described(value: object) -> str:
    shown = repr(value)
    return f"{shown[:60]}{'…' if len(shown) > 60 else ''} ({type(value).__name__})"

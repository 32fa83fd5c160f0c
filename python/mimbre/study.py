"""What each run of a sweep is: the same for threads, processes and other machines."""

from __future__ import annotations

import hashlib
import pickle
import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _core
from .errors import InputError, SimulationError
from .model import Model, _inputs
from .simulation import checked_method

if TYPE_CHECKING:
    from .history_folder import HistoryFolder
    from .method import Method
    from .model import Input

Value = float | int | str | bool
Floats = npt.NDArray[np.float64]

#: What a history becomes, by name.
reductions: dict[str, Callable[[Any], Any]] = {
    "max": np.max,
    "min": np.min,
    "mean": np.mean,
    "rms": lambda history: np.sqrt(np.mean(np.square(history))),
    "last": lambda history: history[-1],
}

#: How a row ended. A store has their numbers.
NOT_RUN, OK, FAILED, REJECTED, LOST = range(5)
words = ("not run", "ok", "failed", "rejected", "lost")


@dataclass
class Row:
    """A run of a sweep, reduced."""

    index: int
    status: int
    message: str = ""
    values: Floats | None = None  #: outputs × reductions, or outputs × instants
    time: Floats | None = None  #: the instants, where histories are kept


@dataclass
class Study:
    """All that a worker must know. It is pickled once; a process keeps it, with the models that it compiled."""

    model: Model
    outputs: list[str]
    reduce: list[str | Callable[[Any], Any]] | None  #: None: whole histories
    live: dict[str, tuple[float, float]]  #: what is set without compiling anew, with its range
    inputs: Mapping[str, Input]
    until: float | None
    method: Method
    histories: HistoryFolder | None = None
    _variants: OrderedDict[tuple[tuple[str, Value], ...], _Variant] = field(default_factory=OrderedDict)
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _pickled: bytes = b""

    def compiled_with(self, parameters: Mapping[str, Value]) -> dict[str, Value]:
        """Those that need a model of their own; texts, which the model file's rules make numbers of, too."""
        return {name: value for name, value in parameters.items() if name not in self.live or isinstance(value, str)}

    def __post_init__(self) -> None:
        self._tables, self._functions = _inputs(self.inputs)
        self._method = checked_method(self.method)

    def row(self, index: int, parameters: Mapping[str, Value], stop: _core.Stop | None = None) -> Row:
        """Runs one, unless it is to stop. What goes wrong is in the row."""
        stop = stop or _core.Stop()
        if stop.is_set:
            return Row(index, NOT_RUN)
        try:
            found = self._run(parameters, stop)
            if found.status == "interrupted":
                return Row(index, NOT_RUN)
            if found.status != "ok":
                return Row(index, FAILED, found.message)
            if self.histories is not None:
                self.histories.write(index, parameters, self.outputs, found)
            if self.reduce is None:
                found.pad()
            return Row(index, OK, "", self._reduced(found), np.array(found.time) if self.reduce is None else None)
        except InputError as error:
            return Row(index, REJECTED, str(error))
        except SimulationError as error:
            return Row(index, FAILED, str(error))
        except Exception as error:
            return Row(index, FAILED, f"{type(error).__name__}: {error}")

    def _run(self, parameters: Mapping[str, Value], stop: _core.Stop) -> _core.Histories:
        """Of the outputs alone."""
        tables = list(self._tables)
        for name, (low, high) in self.live.items():
            value = parameters[name]
            if isinstance(value, str):
                continue
            if not low <= value <= high:
                raise InputError(f"{name}: is {value!r}; a number from {low:g} to {high:g} is needed")
            tables.append((name, [0.0], [float(value)]))
        compiled = self.variant(self.compiled_with(parameters))._compiled
        return _core.histories(compiled, self._method, self.until, tables, self._functions, self.outputs, stop)

    def variant(self, parameters: dict[str, Value]) -> Model:
        """The model with these, compiled once, by the thread that needs it first; the last few are kept."""
        if not parameters:
            return self.model
        key = tuple(sorted(parameters.items()))
        with self._lock:
            variant = self._variants.pop(key, None) or _Variant()
            self._variants[key] = variant
            while len(self._variants) > 32:
                self._variants.popitem(last=False)
        with variant.lock:
            if variant.model is None:
                variant.model = self.model._with(parameters)
            return variant.model

    def _reduced(self, found: _core.Histories) -> Floats:
        if self.reduce is None:
            return np.array(found.values)
        functions = [reductions[one] if isinstance(one, str) else one for one in self.reduce]
        return np.array([[float(function(history)) for function in functions] for history in found.values])

    def __reduce__(self) -> tuple[Any, ...]:
        if not self._pickled:
            parts = (
                self.model,
                self.outputs,
                self.reduce,
                self.live,
                dict(self.inputs),
                self.until,
                self.method,
                self.histories,
            )
            self._pickled = _pickler()(parts)
        return _known, (hashlib.sha256(self._pickled).digest(), self._pickled)


@dataclass
class _Variant:
    lock: threading.Lock = field(default_factory=threading.Lock)
    model: Model | None = None


def run_rows(study: Study, rows: Sequence[tuple[int, Mapping[str, Value]]]) -> list[Row]:
    """What a worker does: a task that may be done again, with the same result."""
    return [study.row(index, parameters) for index, parameters in rows]


_last: dict[bytes, Study] = {}
_last_lock = threading.Lock()


def _known(digest: bytes, pickled: bytes) -> Study:
    """The study in a worker's process, which has one at a time."""
    with _last_lock:
        if digest not in _last:
            _last.clear()
            _last[digest] = Study(*pickle.loads(pickled))
        return _last[digest]


def _pickler() -> Callable[[Any], bytes]:
    """cloudpickle, which knows functions of notebooks too, comes with Dask."""
    try:
        from cloudpickle import dumps
    except ImportError:
        return pickle.dumps
    function: Callable[[Any], bytes] = dumps
    return function

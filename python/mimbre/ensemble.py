"""Many runs of a model: over grids, lists and samples of its parameters."""

from __future__ import annotations

import concurrent.futures as futures
import contextlib
import hashlib
import itertools
import json
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _checks, _core
from .errors import InputError, SweepInterrupted
from .history_folder import HistoryFolder
from .model import Model, read_inputs
from .simulation import checked_method
from .store import Store
from .study import LOST, NOT_RUN, Row, Study, Value, reductions, run_rows
from .table import Table, Units, reduction_name

if TYPE_CHECKING:
    import pandas as pd
    import scipy.stats.qmc
    import xarray as xr
    from typing_extensions import Unpack

    from .method import Method
    from .model import Inputs

    Reduction = str | Callable[[Any], Any]
    Parameters = (
        Mapping[str, Value | Sequence[Value] | npt.NDArray[Any]]
        | Sequence[Mapping[str, Value]]
        | tuple[Sequence[str], npt.ArrayLike]
        | pd.DataFrame
    )


def samples(
    sampler: scipy.stats.qmc.QMCEngine, count: int, ranges: Mapping[str, tuple[float, float]]
) -> list[dict[str, float]]:
    """Points of a sampler in the ranges of parameters, for `sweep`.

    Args:
        sampler: of scipy.stats.qmc (Sobol, LatinHypercube, …), with as many dimensions as there are ranges.
        count: how many points.
        ranges: by the parameter's name its least and its largest value.

    Returns:
        A dictionary of the parameters for each point.

    Example:
        ```python
        points = mimbre.samples(scipy.stats.qmc.Sobol(2), 256, {"stairs": (0.05, 0.2), "speed": (3, 8)})
        ```
    """
    given = _checks.mapping("ranges", ranges, "names with (least, largest)")
    bounds = {name: _checks.pair(f"ranges: {name}", low_high, "(least, largest)") for name, low_high in given.items()}
    lows, highs = ([_checks.number(f"ranges: {name}", both[side]) for name, both in bounds.items()] for side in (0, 1))
    if not hasattr(sampler, "random"):
        raise InputError(f"sampler: one of scipy.stats.qmc is needed, not {_checks.described(sampler)}")
    number = _checks.number("count", count)
    if number != int(number) or number < 0:
        raise InputError(f"count: is {number:g}; a whole number from 0 is needed")
    points = np.asarray(sampler.random(int(number)))
    if points.shape != (number, len(bounds)):
        raise InputError(f"samples: the sampler has {points.shape[-1]} dimensions, and there are {len(bounds)} ranges")
    return [
        dict(zip(bounds, map(float, low_to_high), strict=True))
        for low_to_high in lows + points * np.subtract(highs, lows)
    ]


def sweep(
    model: Model | str | os.PathLike[str],
    parameters: Parameters,
    *,
    outputs: Sequence[str] | None = None,
    reduce: Reduction | Sequence[Reduction] = "last",
    inputs: Inputs | None = None,
    until: float | None = None,
    workers: int | None = None,
    executor: Any = None,
    store: str | os.PathLike[str] | None = None,
    histories: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int], object] | None = None,
    **method: Unpack[Method],
) -> xr.Dataset:
    """Runs a model, or that of a file, for many values of its parameters, on all cores.

    Args:
        model: a model, or a model file.
        parameters: names with lists of values, of which each combination is run; a list of dictionaries (as of
            `samples`), a table of pandas, or (names, array of runs × names), of which each row is run. Tunable
            parameters and inputs are set without compiling the model anew.
        outputs: channels; default: the model's outputs.
        reduce: what is kept of each channel's history: "max", "min", "mean", "rms", "last", or a function of the
            history; of several there is a dimension `reduction`. "history" keeps all instants.
        inputs: of all runs, as `Model.run` takes them.
        until: end of each run, s; default: the model's end.
        workers: so many threads; default: one for each core.
        executor: a Dask Client or an executor of concurrent.futures that does the work in the place of threads.
        store: an HDF5 file that is written while the sweep runs; where it is there, only what is not in it is run.
        histories: a folder where who makes a run writes its outputs at all instants, in a file of its own; other
            machines must have it at the same place.
        progress: is called with how many runs are done, and how many there are.
        **method: step and method of all runs, see `Method`.

    Returns:
        A data set with the channels as variables and the parameters as coordinates: of a grid as dimensions of their
            own, else over `run`. A run that fails is a row with its `status` and `message`, and NaN.

    Raises:
        InputError: what would be wrong for every run, as a name that is not there.
        SweepInterrupted: Ctrl-C; `error.data` has what was done.

    Example:
        ```python
        data = mimbre.sweep("vehicle.yaml", {"stairs": [0.05, 0.1, 0.2]}, outputs=["chassis.z"], reduce="max")
        data["chassis.z"].sel(stairs=0.1)
        ```
    """
    model = model if isinstance(model, Model) else Model.from_file(model)
    if progress is not None and not callable(progress):
        raise InputError(f"progress: a function is needed, not {_checks.described(progress)}")
    names, grid, rows = _rows(parameters)
    study, units = _study(model, names, rows, outputs, reduce, inputs, until, method)
    threads = _threads(workers, executor)
    table = Table(study, len(rows))
    file = None
    if store is not None:
        columns = {name: [row[name] for row in rows] for name in names}
        file = Store(_checks.path("store", store), _fingerprint(study, rows), columns)

    def take(done: list[Row]) -> None:
        new = [row.index for row in done if table.take(row)]
        if file is not None and new:
            file.write(table, new)
        if progress is not None:
            progress(int(np.count_nonzero(table.status != NOT_RUN)), len(rows))

    try:
        begun = file is not None and file.read(table)
        if histories is not None:
            known = range(len(rows)) if begun else range(0)
            study.histories = HistoryFolder.of(_checks.path("histories", histories), known)
            for index in set(table.ended_well()) - study.histories.rows():
                table.forget(index)
        if file is not None and not begun:  # at once, so that it knows the histories that workers write
            file.write(table, ())
        waiting = [(index, row) for index, row in enumerate(rows) if table.status[index] == NOT_RUN]
        # Those of one model one after another, so that it need not be kept for long.
        waiting.sort(
            key=lambda item: sorted((name, str(value)) for name, value in study.compiled_with(item[1]).items())
        )
        if executor is None:
            _by_threads(study, waiting, take, threads)
        else:
            _by_executor(study, waiting, take, executor)
    except KeyboardInterrupt:
        done = int(np.count_nonzero(table.status != NOT_RUN))
        data = table.dataset(names, grid, rows, units)
        raise SweepInterrupted(f"interrupted after {done} of {len(rows)} runs", data) from None
    finally:
        if file is not None:
            file.close()
    return table.dataset(names, grid, rows, units)


# Who does it

_Waiting = list[tuple[int, dict[str, Value]]]
_Take = Callable[[list[Row]], None]


def _threads(workers: int | None, executor: Any) -> int:
    if workers is None:
        return len(os.sched_getaffinity(0))
    if not isinstance(workers, int | np.integer) or isinstance(workers, bool) or workers < 1:
        raise InputError(f"workers: a number of threads from 1 is needed, not {_checks.described(workers)}")
    if executor is not None:
        raise InputError("workers: an executor has its own; give one of both")
    return int(workers)


def _by_threads(study: Study, waiting: _Waiting, take: _Take, threads: int) -> None:
    """Over one constant model; runs leave the interpreter to each other."""
    stop = _core.Stop()
    queue = deque(waiting)
    with futures.ThreadPoolExecutor(threads, "mimbre-sweep") as pool:
        running: set[futures.Future[Row]] = set()
        try:
            while queue or running:
                while queue and len(running) < 2 * threads:
                    running.add(pool.submit(study.row, *queue.popleft(), stop))
                done, running = futures.wait(running, return_when=futures.FIRST_COMPLETED)
                take([future.result() for future in done])
        except BaseException:
            stop.set()
            for future in running:
                future.cancel()
            take([future.result() for future in futures.wait(running).done if not future.cancelled()])
            raise


def _by_executor(study: Study, waiting: _Waiting, take: _Take, executor: Any) -> None:
    """In tasks of some rows, a few at a time, so that neither a scheduler nor a network has much to hold. The rows of a
    task that is lost, as its worker died, are tried again one by one, each at most three times."""
    workers = getattr(executor, "_max_workers", None) or 8
    if hasattr(executor, "get_executor"):  # a Dask Client
        workers = sum(executor.ncores().values()) or 8
        executor = executor.get_executor(pure=False)
    if not isinstance(executor, futures.Executor):
        raise InputError(
            f"executor: a Dask Client or an executor of concurrent.futures is needed, not {_checks.described(executor)}"
        )
    size = min(max(len(waiting) // (8 * workers), 1), 32)
    queue = deque((waiting[k : k + size], 3) for k in range(0, len(waiting), size))
    running: dict[futures.Future[list[Row]], tuple[_Waiting, int]] = {}

    def lost(chunk: _Waiting, tries: int, error: BaseException) -> None:
        if tries > 0:
            queue.extend(([item], tries) for item in chunk)
        else:
            message = f"its worker was lost: {type(error).__name__}: {error}"
            take([Row(index, LOST, message) for index, _ in chunk])

    try:
        while queue or running:
            while queue and len(running) < 2 * workers:
                chunk, tries = queue.popleft()
                try:
                    running[executor.submit(run_rows, study, chunk)] = (chunk, tries)
                except (RuntimeError, OSError) as error:  # an executor that has come to its end
                    lost(chunk, 0, error)
            if not running:
                continue
            for future in futures.wait(running, return_when=futures.FIRST_COMPLETED).done:
                chunk, tries = running.pop(future)
                try:
                    rows = future.result()
                except (Exception, futures.CancelledError) as error:
                    lost(chunk, tries - 1, error)
                else:
                    take(rows)
    finally:
        for future in running:
            future.cancel()


# What is asked for


def _rows(parameters: Any) -> tuple[list[str], dict[str, list[Value]] | None, list[dict[str, Value]]]:
    """Names, the values of a grid, and the parameters of each run."""
    if hasattr(parameters, "to_dict") and hasattr(parameters, "columns"):
        parameters = parameters.to_dict("records")
    if isinstance(parameters, Mapping):
        grid = {_name_of(name): _values(name, values) for name, values in parameters.items()}
        return list(grid), grid, [dict(zip(grid, row, strict=True)) for row in itertools.product(*grid.values())]
    if isinstance(parameters, tuple) and len(parameters) == 2:
        names = _checks.names("parameters", parameters[0])
        try:
            points = np.asarray(parameters[1])
        except ValueError:  # rows of different lengths
            points = np.empty(0)
        if points.ndim != 2 or points.shape[1] != len(names):
            raise InputError(
                f"parameters: an array of runs × {len(names)} is needed for {', '.join(names)}, not one of shape "
                f"{points.shape}"
            )
        parameters = [dict(zip(names, row, strict=True)) for row in points.tolist()]
    if not isinstance(parameters, Sequence) or not all(isinstance(row, Mapping) for row in parameters):
        raise InputError(
            "parameters: names with lists of values, as {'stairs': [0.1, 0.2]}, or a list of dictionaries are needed, "
            f"not {_checks.described(parameters)}"
        )
    rows = [{_name_of(name): _value(name, value) for name, value in row.items()} for row in parameters]
    names = list(rows[0]) if rows else []
    for k, row in enumerate(rows):
        if row.keys() != rows[0].keys():
            raise InputError(f"parameters: run {k} has {', '.join(row)}, and run 0 has {', '.join(names)}")
    return names, None, rows


def _name_of(name: object) -> str:
    return _checks.text("parameters", name)


def _values(name: str, values: Any) -> list[Value]:
    single = isinstance(values, str | bytes) or not hasattr(values, "__iter__") or getattr(values, "ndim", 1) == 0
    return [_value(name, value) for value in ([values] if single else values)]


def _value(name: object, value: object) -> Value:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, str | bool):
        return value
    number = _checks.number(f"parameters: {name}", value)
    return value if isinstance(value, int) else number


def _study(
    model: Model,
    names: list[str],
    rows: list[dict[str, Value]],
    outputs: Sequence[str] | None,
    reduce: Any,
    inputs: Inputs | None,
    until: float | None,
    method: Method,
) -> tuple[Study, Units]:
    """Checks what would be wrong for every run."""
    simulation = model.simulation(**method)
    until = _checks.given("until", until)
    _core.check_run(model._compiled, checked_method(method), until)
    values = read_inputs(inputs, model)
    for name in values:
        _checks.known("input or tunable parameter", name, model.inputs)
        if name in names:
            raise InputError(f"inputs: {name!r} is one of the parameters; it can have one value only")
    handles = {name: simulation.input(name) for name in names if name in model.inputs}
    live = {name: (handle.min, handle.max) for name, handle in handles.items()}
    chosen = model.outputs if outputs is None else _checks.names("outputs", outputs)
    for name in chosen:
        _checks.known("channel", name, simulation.channel_names())
    if not chosen:
        raise InputError("outputs: the model has none; give the names of channels")
    study = Study(model, chosen, _reductions(reduce), live, values, until, method)
    others = {"status", "message"}
    if study.reduce is None:
        others.add("time")
    elif len(study.reduce) > 1:
        others.add("reduction")
    for name in names:
        if name in others:
            raise InputError(
                f"parameters: {name!r} is the name of something else in the data set; name the parameter otherwise in "
                "the model"
            )
    if rows and study.compiled_with(rows[0]):
        model._read.refuse_changes()
        with names_alone():
            study.variant(study.compiled_with(rows[0]))
    taken = {"status", "message", "run", "time", "reduction", *names}
    for name in chosen:
        if name in taken:
            raise InputError(
                f"outputs: {name!r} is the name of something else in the data set; name the output otherwise"
            )
    channels = {name: simulation.channel(name) for name in chosen}
    return study, {name: (channel.unit, channel.meaning) for name, channel in channels.items()}


@contextlib.contextmanager
def names_alone() -> Iterator[None]:
    """Of what is wrong with a run, raises what is wrong with every run: that the model has no parameter of a name."""
    try:
        yield
    except InputError as error:
        if any("there is no parameter" in diagnostic.message for diagnostic in error.diagnostics):
            raise


def _reductions(reduce: Any) -> list[Reduction] | None:
    if isinstance(reduce, str) and reduce == "history":
        return None
    if not isinstance(reduce, Iterable) and not callable(reduce):
        raise InputError(f"reduce: a name or a function of a history is needed, not {_checks.described(reduce)}")
    chosen = [reduce] if isinstance(reduce, str) or callable(reduce) else list(reduce)
    for one in chosen:
        if isinstance(one, str):
            _checks.known("reduction", one, reductions)
        elif not callable(one):
            raise InputError(f"reduce: a name or a function of a history is needed, not {_checks.described(one)}")
    if not chosen or len({reduction_name(one) for one in chosen}) < len(chosen):
        raise InputError("reduce: names of reductions are needed, each once")
    return chosen


def _fingerprint(study: Study, rows: list[dict[str, Value]]) -> dict[str, str]:
    """What makes a study another one. Functions count by their names."""

    def text(value: object) -> str:
        return reduction_name(value) if callable(value) else repr(value)

    _, files = study.model._files()
    content = [study.model._text, sorted(study.model.parameters.items())]
    content += [(name, hashlib.sha256(data).hexdigest()) for name, data in sorted(files.items())]
    inputs = {
        name: [np.asarray(part).tolist() for part in value] if isinstance(value, tuple) else text(value)
        for name, value in study.inputs.items()
    }
    return {
        "model": _digest(content),
        "parameters": _digest(rows),
        "outputs": _digest(study.outputs),
        "reduce": _digest(None if study.reduce is None else [text(one) for one in study.reduce]),
        "inputs": _digest(inputs),
        "until": repr(study.until),
        "method": json.dumps(dict(study.method), sort_keys=True, default=repr),
        "version": _core.version(),
    }


def _digest(value: object) -> str:
    return hashlib.sha256(json.dumps(value).encode()).hexdigest()

"""`mimbre sweep`: the runs of a study's file."""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import time
from collections import Counter
from typing import TYPE_CHECKING, Any

from .errors import Diagnostic, InputError, SweepInterrupted
from .study_file import read_study

if TYPE_CHECKING:
    import xarray as xr

# As those of the program (docs/commands.md).
DONE, BAD_INPUT, BAD_USAGE, FAILED, WARNED = range(5)

_epilog = """\
The table, or with --json the same as JSON, goes to the standard output; errors and the progress line go to the
standard error. With a store (`store` in the file, or --store) rows are kept as they are done: the same command goes on
from there.
Exit codes: 0 done, 1 the study or its model is bad, 2 wrong use, 3 interrupted or no run ended well, 4 not every run
ended well, where --strict was given.
Example:
  mimbre sweep examples/iltis/study.yaml --store study.h5"""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> Any:
        _say(f"error: {message}")
        print("'mimbre sweep --help' prints more", file=sys.stderr)
        sys.exit(BAD_USAGE)


def _say(message: str) -> None:
    print(f"mimbre: {message}", file=sys.stderr)


def _threads(text: str) -> int:
    count = int(text) if text.isdecimal() else 0
    if count < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is no number of threads from 1")
    return count


def sweep_command(arguments: list[str]) -> int:
    """Returns the exit code."""
    parser = _Parser(
        prog="mimbre sweep",
        description="Run a model for many values of its parameters",
        epilog=_epilog,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("study", metavar="STUDY", help="the study's file (YAML, docs/study-file.md)")
    parser.add_argument("--store", metavar="FILE.h5", help="file that the rows go to, instead of the study's")
    parser.add_argument("--workers", metavar="N", type=_threads, help="threads; default: one for each core")
    parser.add_argument("--json", action="store_true", help="the rows as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress line and no table")
    parser.add_argument("--strict", action="store_true", help="exit code 4 where not every run ended well")
    given = parser.parse_args(arguments)
    try:
        return _run(given)
    except BrokenPipeError:  # who reads has read enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _report([Diagnostic("", 0, 0, "the standard output cannot be written: Broken pipe")], False, FAILED)
    except InputError as error:
        return _report(error.diagnostics, given.json, BAD_INPUT)
    except OSError as error:
        return _report([Diagnostic(error.filename or "", 0, 0, error.strerror or str(error))], given.json, FAILED)
    except KeyboardInterrupt:  # while the model is read
        return _report([Diagnostic("", 0, 0, "interrupted before any run")], given.json, FAILED)


def _report(errors: Any, as_json: bool, code: int) -> int:
    for d in errors:
        if d.file:
            place = ":".join([d.file, *(str(number) for number in (d.line, d.column) if number > 0)])
            print(f"{place}: error: {d.message}", file=sys.stderr)
        else:
            _say(f"error: {d.message}")
    if as_json:
        found = []
        for d in errors:
            at: dict[str, Any] = {"message": d.message}
            if d.file:
                at["file"] = d.file
            if d.line > 0:
                at.update(line=d.line, column=d.column)
            found.append(at)
        _print_json({"command": "sweep", "status": "error", "errors": found})
    return code


def _run(given: argparse.Namespace) -> int:
    from .ensemble import sweep

    study = read_study(given.study)
    if given.store is not None:
        study.arguments["store"] = given.store
    if given.workers is not None:
        study.arguments["workers"] = given.workers
    line = _Line(not given.quiet and sys.stderr.isatty())
    message = ""
    try:
        data = sweep(study.model, study.parameters, progress=line.show, **study.arguments)
    except SweepInterrupted as interrupted:
        data = interrupted.data
        message = str(interrupted)
        if "store" in study.arguments:
            message += f"; the same command goes on from {study.arguments['store']}"
    finally:
        line.clear()
    statuses = Counter(str(status) for status in data.status.values.flat)
    if message:
        _say(f"error: {message}")
    for status, count in statuses.items():
        if status in ("failed", "rejected", "lost"):
            both = zip(data.message.values.flat, data.status.values.flat, strict=True)
            example = next(message for message, one in both if one == status)
            _say(f"warning: {count} of {data.status.size} runs {status}; for example: {example}")
    if given.json:
        _print_json(_answer(data, "interrupted" if message else "ok"))
    elif not given.quiet:
        _print(_table(data))
    if message or not statuses["ok"]:
        return FAILED
    return WARNED if given.strict and statuses["ok"] < data.status.size else DONE


class _Line:
    """How far it is, on a terminal."""

    def __init__(self, shown: bool) -> None:
        self._shown = shown
        self._first: tuple[float, int] | None = None
        self._last = 0.0

    def show(self, done: int, runs: int) -> None:
        now = time.monotonic()
        if self._first is None:
            self._first = (now, done)
        if not self._shown or now < self._last + 0.1:
            return
        self._last = now
        start, before = self._first
        rest = f", {(now - start) / (done - before) * (runs - done):.0f} s left" if done > before else ""
        print(f"\r\033[K{done} of {runs} runs{rest}", end="", file=sys.stderr, flush=True)

    def clear(self) -> None:
        if self._last:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def _parameters(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data.coords if name not in ("time", "reduction")]


def _outputs(data: xr.Dataset) -> list[str]:
    return [str(name) for name in data if name not in ("status", "message")]


def _rows(data: xr.Dataset) -> list[dict[str, Any]]:
    """Parameters, values, status and message of each run. Whole histories are left out."""
    names = _parameters(data)
    runs = [str(dim) for dim in data.status.dims]
    flat = data.drop_dims("time") if "time" in data.dims else data
    flat = flat.stack(_runs=runs) if runs != ["run"] else flat.rename({"run": "_runs"})
    reductions = [str(one) for one in flat["reduction"].values] if "reduction" in flat.dims else None
    rows = []
    columns = {name: flat[name].values for name in names}
    values = {name: flat[name].transpose("_runs", ...).values for name in _outputs(flat)}
    for k in range(data.status.size):
        row: dict[str, Any] = {"parameters": {name: columns[name].item(k) for name in names}}
        row["status"] = str(flat["status"].values[k])
        if flat["message"].values[k]:
            row["message"] = str(flat["message"].values[k])
        row["values"] = {
            name: dict(zip(reductions, map(float, of[k]), strict=True))
            if reductions is not None
            else {str(data.attrs["reduction"]): float(of[k])}
            for name, of in values.items()
        }
        rows.append(row)
    return rows


def _answer(data: xr.Dataset, status: str) -> dict[str, Any]:
    return {
        "command": "sweep",
        "status": status,
        "title": data.attrs["title"],
        "runs": int(data.status.size),
        "units": {name: data[name].attrs.get("units", "") for name in _outputs(data)},
        "rows": _rows(data),
    }


def _print_json(answer: object) -> None:
    def finite(value: Any) -> Any:  # JSON has no other numbers
        if isinstance(value, dict):
            return {key: finite(one) for key, one in value.items()}
        if isinstance(value, list):
            return [finite(one) for one in value]
        return None if isinstance(value, float) and not math.isfinite(value) else value

    _print(json.dumps(finite(answer), indent=2, ensure_ascii=False, allow_nan=False))


def _print(text: str) -> None:
    print(text, flush=True)


def _table(data: xr.Dataset) -> str:
    def shown(value: Any) -> str:
        return f"{value:.6g}" if isinstance(value, float) else str(value)

    rows = _rows(data)
    units = {name: data[name].attrs.get("units", "") for name in _outputs(data)}
    head = _parameters(data)
    for name, values in rows[0]["values"].items() if rows else ():
        unit = f", {units[name]}" if units[name] not in ("", "1") else ""
        head += [f"{name} {reduction}{unit}" for reduction in values]
    lines = [[*head, "status"]]
    for row in rows:
        values = [shown(value) for of in row["values"].values() for value in of.values()]
        lines.append([*map(shown, row["parameters"].values()), *values, row["status"]])
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join([cell.rjust(width) for cell, width in zip(line[:-1], widths[:-1], strict=True)] + [line[-1]]).rstrip()
        for line in lines
    )

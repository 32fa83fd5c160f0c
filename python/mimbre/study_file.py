"""The file of a study: which runs `mimbre sweep` makes (docs/study-file.md)."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np

from . import _checks, _core
from .ensemble import names_alone, samples
from .errors import Diagnostic, InputError
from .model import Model
from .simulation import Method, checked_method
from .study import Value, reductions

VERSION = 1
SAMPLERS = ("latin-hypercube", "sobol")
MOST_RUNS = 1_000_000
_keys = (
    "study",
    "model",
    "set",
    "grid",
    "list",
    "samples",
    "inputs",
    "outputs",
    "reduce",
    "until",
    "step",
    "method",
    "store",
    "histories",
    "workers",
)
_methods = ("formulation", "inertia", "formalism", "integrator", "rho", "xi", "tolerance", "accuracy", "max_iterations", "substeps")


@dataclass
class StudyFile:
    """What a study's file asks `mimbre.sweep` for."""

    model: Model
    parameters: dict[str, list[Value]] | list[dict[str, Value]]
    #: Further arguments of `sweep`.
    arguments: dict[str, Any]


def read_study(path: str | os.PathLike[str]) -> StudyFile:
    """Reads a study's file, and the model that it names. Raises InputError with every mistake that was found."""
    file = _checks.path("path", path)
    try:
        text = Path(file).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is no text in UTF-8"
        raise InputError([Diagnostic(file, 0, 0, f"the study cannot be read: {reason}")]) from None
    if not text.strip():
        raise InputError([Diagnostic(file, 1, 1, "the file is empty; a study starts with 'study: 1'")])
    return _Reader(file).study(_Node.of("study", _core.yaml(text, file)))


@dataclass
class _Node:
    """A value of the file, its place, and what messages call it."""

    what: str
    kind: str  #: "null", "scalar", "list" or "map"
    line: int
    column: int
    content: Any

    @classmethod
    def of(cls, what: str, tree: Any) -> _Node:
        return cls(what, *tree)

    def items(self) -> list[_Node]:
        """Of a list; of anything else itself."""
        return [_Node.of(self.what, item) for item in self.content] if self.kind == "list" else [self]

    def entries(self) -> Iterator[tuple[str, _Node]]:
        """Of a map; the place of each is that of its value."""
        for key, _, _, tree in self.content:
            yield key, _Node.of(f"{self.what}: {key}", tree)

    def shown(self) -> str:
        return {"null": "nothing", "scalar": "a single value", "list": "a list", "map": "a map of keys"}[self.kind]


@dataclass
class _Reader:
    """Reads on after a mistake, so that all are reported."""

    file: str
    errors: list[Diagnostic] = field(default_factory=list)
    #: Where the parameters of runs are named first.
    named: dict[str, _Node] = field(default_factory=dict)

    def add(self, node: _Node, message: str) -> None:
        self.errors.append(Diagnostic(self.file, node.line, node.column, f"{node.what}: {message}"))

    @contextmanager
    def mistakes_at(self, node: _Node) -> Iterator[None]:
        """What is wrong within is wrong there, where it is not in another file."""
        try:
            yield
        except InputError as error:
            for d in error.diagnostics:
                self.errors.append(d if d.file else Diagnostic(self.file, node.line, node.column, d.message))

    def throw(self) -> None:
        if self.errors:
            raise InputError(sorted(self.errors, key=lambda d: (d.file != self.file, d.line, d.column)))

    # Values

    def fields(self, node: _Node, known: Sequence[str]) -> dict[str, _Node]:
        if node.kind == "null":
            return {}
        if node.kind != "map":
            self.add(node, f"keys are needed here ({', '.join(known)}), this is {node.shown()}")
            return {}
        for key, line, column, _ in node.content:
            if key not in known:
                near = _core.did_you_mean(key, list(known))
                self.errors.append(
                    Diagnostic(
                        self.file,
                        line,
                        column,
                        f"{node.what}: unknown key '{key}'{near}; known: {', '.join(known)}",
                    )
                )
        return {key: value for key, value in node.entries() if value.kind != "null"}

    def number(self, node: _Node, seconds: bool = False) -> float | None:
        found = _core.number(node.content, seconds) if node.kind == "scalar" else None
        if found is None:
            shown = f"'{node.content}'" if node.kind == "scalar" else node.shown()
            self.add(node, f"a number{' of seconds' if seconds else ''} is needed, this is {shown}")
        return found

    def seconds(self, node: _Node | None, wanted: str, right: Callable[[float], bool]) -> float | None:
        time = None if node is None else self.number(node, seconds=True)
        if node is not None and time is not None and not right(time):
            self.add(node, f"{time:g} s is no such time; it must be {wanted}")
        return time

    def count(self, node: _Node, least: int, most: int) -> int | None:
        number = self.number(node)
        if number is None:
            return None
        if number != int(number) or not least <= number <= most:
            self.add(node, f"{number:g} is not a whole number from {least} to {most}")
            return None
        return int(number)

    def text(self, node: _Node) -> str | None:
        if node.kind != "scalar":
            self.add(node, f"a name or word is needed, this is {node.shown()}")
            return None
        return str(node.content)

    def choice(self, node: _Node, choices: Sequence[str]) -> str | None:
        text = self.text(node)
        if text is None or text in choices:
            return text
        near = _core.did_you_mean(text, list(choices))
        self.add(node, f"'{text}' is not one of {', '.join(choices)}{near}")
        return None

    def value(self, node: _Node) -> Value | None:
        """Of a parameter: a number, or a text as the model file would have it."""
        text = self.text(node)
        if text is None:
            return None
        if text in ("true", "false"):
            return text == "true"
        try:
            return int(text)
        except ValueError:
            number = _core.number(text)
            return text if number is None else number

    def range(self, node: _Node) -> tuple[float, float] | None:
        if node.kind != "list" or len(node.content) != 2:
            self.add(node, "a range is needed, for example [0.05, 0.2]")
            return None
        low, high = (self.number(item) for item in node.items())
        if low is None or high is None:
            return None
        if not low < high:
            self.add(node, f"the range ends at {high:g}, which is not above {low:g}")
            return None
        return low, high

    # Sections

    def study(self, top: _Node) -> StudyFile:
        if top.kind == "map" and "mimbre" in dict(top.entries()):
            self.add(top, "this is a model's file; a study's names it, as model: vehicle.yaml")
            self.throw()
        given = self.fields(top, _keys)
        if "study" not in given:
            self.add(top, "'study: 1' is missing, the version of the format")
        elif self.value(given["study"]) != VERSION:
            self.add(given["study"], f"version {given['study'].content} is not known; this program reads 1")
        parameters = self.parameters(top, given)
        arguments: dict[str, Any] = {
            "reduce": self.reduce(given.get("reduce")),
            "until": self.seconds(given.get("until"), "0 or more", lambda time: time >= 0),
            "step": self.seconds(given.get("step"), "above 0", lambda time: time > 0),
            "workers": self.count(given["workers"], 1, 10_000) if "workers" in given else None,
        }
        for key in ("store", "histories"):
            if key in given and (text := self.text(given[key])) is not None:
                arguments[key] = Path(self.file).parent / text
        for key, node in self.fields(given["method"], _methods).items() if "method" in given else ():
            arguments[key] = self.text(node) if key in _methods[:4] else self.number(node)
        if "model" not in given:
            self.add(top, "'model' is missing; for example model: vehicle.yaml")
        # A model takes long to read; what is wrong up to here is told at once.
        self.throw()
        model = self.model(given)
        self.known_parameters(model)
        arguments["inputs"] = self.inputs(given.get("inputs"), model)
        arguments["outputs"] = self.outputs(given.get("outputs"), model)
        method = {key: arguments[key] for key in ("step", *_methods) if arguments.get(key) is not None}
        for key, value in method.items():
            with self.mistakes_at(given["step" if key == "step" else "method"]):
                checked_method(cast(Method, {key: value}))
        self.throw()
        with self.mistakes_at(given.get("method", given.get("step", top))):
            model.simulation(**cast(Method, method))
        self.throw()
        with self.mistakes_at(given.get("step", given.get("until", top))):
            _core.check_run(model._compiled, checked_method(cast(Method, method)), arguments["until"])
        self.throw()
        return StudyFile(model, parameters, {key: value for key, value in arguments.items() if value is not None})

    def known_parameters(self, model: Model) -> None:
        """Whether the model has what the runs differ in: all of it at once, and one by one only to find where."""
        nodes = {name: node for name, node in self.named.items() if name not in model.inputs}
        if not nodes:
            return
        values: dict[str, Value] = {}
        for name, node in nodes.items():
            value = self.value(node) if node.kind == "scalar" else None
            values[name] = 0 if value is None else value
        try:
            with names_alone():
                model._with(values)
        except InputError:
            for name, node in nodes.items():
                with self.mistakes_at(node), names_alone():
                    model._with({name: values[name]})

    def model(self, given: dict[str, _Node]) -> Model:
        node = given["model"]
        values = {}
        for name, setting in self.map(given.get("set")):
            value = self.value(setting)
            if value is not None:
                values[name] = value
        path = Path(self.file).parent / (self.text(node) or "")
        if not path.is_file():
            self.add(node, f"there is no file '{path}'")
        self.throw()
        with self.mistakes_at(given.get("set", node)):
            return Model.from_file(path, **values)
        self.throw()
        raise AssertionError

    def map(self, node: _Node | None) -> Iterator[tuple[str, _Node]]:
        if node is None:
            return
        if node.kind != "map":
            self.add(node, f"names with values are needed, this is {node.shown()}")
            return
        yield from node.entries()

    def parameters(self, top: _Node, given: dict[str, _Node]) -> dict[str, list[Value]] | list[dict[str, Value]]:
        ways = [given[key] for key in ("grid", "list", "samples") if key in given]
        if len(ways) != 1:
            self.add(
                ways[1] if ways else top,
                "one of 'grid', 'list' and 'samples' is needed; for example grid: {stairs: [0.1, 0.2]}",
            )
            return []
        if "grid" in given:
            return self.grid(given["grid"])
        before = len(self.errors)
        rows = self.rows(given["list"]) if "list" in given else self.samples(given["samples"])
        if not rows and len(self.errors) == before:
            self.add(ways[0], "there is no run in it")
        return rows

    def grid(self, node: _Node) -> dict[str, list[Value]]:
        grid: dict[str, list[Value]] = {}
        for name, values in self.map(node):
            self.named[name] = values
            if values.kind == "map":
                grid[name] = self.evenly(values)
            else:
                grid[name] = [value for item in values.items() if (value := self.value(item)) is not None]
            if not grid[name]:
                self.add(values, "a list of values is needed, or {from: 0, to: 1, count: 5}")
        if np.prod([float(len(values)) for values in grid.values()]) > MOST_RUNS:
            self.add(node, f"these are more than {MOST_RUNS} runs")
        return grid

    def evenly(self, node: _Node) -> list[Value]:
        given = self.fields(node, ("from", "to", "count"))
        if not {"from", "to", "count"} <= given.keys():
            self.add(node, "from, to and count are needed, as in {from: 0, to: 1, count: 5}")
            return [0.0]
        low, high = self.number(given["from"]), self.number(given["to"])
        count = self.count(given["count"], 1, MOST_RUNS)
        if low is None or high is None or count is None:
            return [0.0]
        return [float(value) for value in np.linspace(low, high, count)]

    def rows(self, node: _Node) -> list[dict[str, Value]]:
        rows: list[dict[str, Value]] = []
        if node.kind == "scalar":
            return self.table(node)
        if node.kind != "list":
            self.add(node, "a list is needed, for example [{stairs: 0.1}, {stairs: 0.2}], or the name of a CSV file")
            return rows
        for item in node.items():
            at = dict(self.map(item))
            self.named = {**at, **self.named}
            rows.append({name: value for name, one in at.items() if (value := self.value(one)) is not None})
            if rows[-1].keys() != rows[0].keys():
                self.add(item, f"has {', '.join(rows[-1])}, and the first of the list {', '.join(rows[0])}")
        return rows

    def table(self, node: _Node) -> list[dict[str, Value]]:
        """Of a CSV file: a line of names, then a run in each line."""
        path = Path(self.file).parent / node.content
        try:
            with path.open(newline="", encoding="utf-8-sig") as file:
                reader = csv.reader(file)
                lines = [(reader.line_num, line) for line in reader if line]
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            self.add(node, f"the table '{path}' cannot be read: {error}")
            return []
        first, head = lines[0] if lines else (1, [])
        names = [name.strip() for name in head]
        for name in {name: None for name in names if names.count(name) > 1}:
            self.errors.append(Diagnostic(str(path), first, 1, f"the name '{name}' stands twice in the first line"))
        self.named = {name: _Node(node.what, "map", node.line, node.column, []) for name in names}
        rows = []
        for number, line in lines[1:]:
            if len(line) != len(names):
                self.errors.append(
                    Diagnostic(str(path), number, 1, f"{len(line)} cells, and {len(names)} names in the first line")
                )
                break
            cells = [
                _Node(f"list: {name}", "scalar", number, 1, cell.strip())
                for name, cell in zip(names, line, strict=True)
            ]
            rows.append(
                {
                    name: value
                    for name, cell in zip(names, cells, strict=True)
                    if (value := self.value(cell)) is not None
                }
            )
        return rows

    def samples(self, node: _Node) -> list[dict[str, Value]]:
        known = ("sampler", "count", "seed", "ranges")
        given = self.fields(node, known)
        for key, example in zip(known, ("latin-hypercube", "100", "1", "{stairs: [0.05, 0.2]}"), strict=True):
            if key not in given:
                self.add(node, f"'{key}' is missing; for example {key}: {example}")
        if len(given) < len(known):
            return []
        self.named = dict(self.map(given["ranges"]))
        ranges = {name: found for name, at in self.named.items() if (found := self.range(at)) is not None}
        sampler = self.choice(given["sampler"], SAMPLERS)
        count = self.count(given["count"], 1, MOST_RUNS)
        seed = self.count(given["seed"], 0, 2**63 - 1)
        if sampler is None or count is None or seed is None or not ranges:
            return []
        from scipy.stats import qmc

        if sampler == "sobol" and count & (count - 1):
            self.add(given["count"], f"Sobol's points are even for powers of two alone; take {1 << count.bit_length()}")
            return []
        engine = (qmc.Sobol if sampler == "sobol" else qmc.LatinHypercube)(len(ranges), rng=np.random.default_rng(seed))
        return [dict(row) for row in samples(engine, count, ranges)]

    def reduce(self, node: _Node | None) -> str | list[str] | None:
        if node is None:
            return None
        names = [self.choice(item, (*reductions, "history")) for item in node.items()]
        found = [name for name in names if name is not None]
        if len(set(found)) < len(found):
            self.add(node, "each reduction is needed once")
        if "history" in found and len(found) > 1:
            self.add(node, "'history' keeps everything, and stands alone")
        return "history" if found == ["history"] else found

    def inputs(self, node: _Node | None, model: Model) -> dict[str, Any]:
        inputs: dict[str, Any] = {}
        for name, value in self.map(node):
            with self.mistakes_at(value):
                _checks.known("input or tunable parameter", name, model.inputs)
            if value.kind != "map":
                inputs[name] = self.number(value)
                continue
            given = self.fields(value, ("times", "values"))
            columns = [
                [self.number(item, seconds=key == "times") for item in given[key].items()] if key in given else []
                for key in ("times", "values")
            ]
            if not columns[0] or len(columns[0]) != len(columns[1]):
                self.add(value, "as many times as values are needed, as in {times: [0, 1], values: [0, 5]}")
            inputs[name] = (columns[0], columns[1])
        return inputs

    def outputs(self, node: _Node | None, model: Model) -> list[str] | None:
        if node is None:
            return None
        channels = model.simulation().channel_names()
        chosen = []
        for item in node.items():
            name = self.text(item)
            if name is None:
                continue
            with self.mistakes_at(item):
                chosen.append(_checks.known("channel", name, channels))
        return chosen

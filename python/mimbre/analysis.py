"""What can be asked of models, runs and bodies beside a run: the program's other commands, with their answers as
objects."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from . import _checks, _core
from .errors import InputError
from .reduction import ReducedBody
from .run import Floats, Run
from .simulation import Method, checked_method, compiled

if TYPE_CHECKING:
    from typing import Literal

    from typing_extensions import Unpack

    from .model import Model

stress_components = ("xx", "yy", "zz", "xy", "yz", "zx")


@dataclass(frozen=True)
class Equilibrium:
    """A model at rest: `equilibrium["chassis.z"]` is an output there."""

    outputs: dict[str, float]
    units: dict[str, str]
    iterations: int
    residual: float
    stable: bool  #: no small disturbance grows
    warnings: list[str]

    def __getitem__(self, name: str) -> float:
        return self.outputs[_checks.known("output", name, self.outputs)]


def static(model: Model, **method: Unpack[Method]) -> Equilibrium:
    """The static equilibrium, as `mimbre static`. Raises SimulationError where none is found."""
    found = _core.static_equilibrium(compiled(model), checked_method(method))
    outputs = {name: value for name, value, _ in found.outputs}
    units = {name: unit for name, _, unit in found.outputs}
    return Equilibrium(outputs, units, found.iterations, found.residual, found.stable, found.warnings)


@dataclass(frozen=True)
class Apart:
    """How far a channel lies apart in the two formulations, at the shortest step that was made."""

    unit: str
    max_difference: float
    scale: float  #: that differences are measured by
    time: float  #: of the largest, s
    agrees: bool


@dataclass(frozen=True)
class Verification:
    """A model in both formulations."""

    agree: bool
    verdict: str
    refinement_ratio: float | None  #: of the differences, with half the step: about 4
    channels: dict[str, Apart]
    failures: list[str]
    warnings: list[str]


def verify(
    model: Model,
    *,
    until: float | None = None,
    refine: bool = True,
    progress: Callable[[float], object] | None = None,
    **method: Unpack[Method],
) -> Verification:
    """Runs the model in both formulations and compares them, as `mimbre verify`; `refine`: at shorter steps too.
    `progress` is called with the time, s, that the run at hand has reached; there are two to six runs."""
    if "formulation" in method:
        raise InputError("verify: is of both formulations; leave 'formulation' out")
    end, refined = _checks.given("until", until), _checks.flag("refine", refine)
    found = _core.verify(compiled(model), checked_method(method), end, refined, _checks.callback(progress))
    channels = {channel[0]: Apart(*channel[1:]) for channel in found.channels}
    return Verification(found.agree, found.verdict, found.ratio, channels, found.failures, found.warnings)


@dataclass(frozen=True)
class Difference:
    """Of a channel of two runs."""

    unit: str
    max_difference: float
    mean_difference: float
    time: float  #: of the largest, s
    amplitude: float  #: largest value in the first

    @property
    def relative(self) -> float:
        """The largest difference, of the amplitude."""
        if self.amplitude == 0:
            return 0.0 if self.max_difference == 0 else float("inf")
        return self.max_difference / self.amplitude


def report(runs: Mapping[str, Run | str | os.PathLike[str]], path: str | os.PathLike[str]) -> None:
    """Writes a page that draws runs, or results files, over each other, as `mimbre report A.h5 B.h5`; the first is what
    the others are compared to, the names are their labels."""
    if not isinstance(runs, Mapping):
        raise InputError(
            f"runs: names with runs are needed, {{'before': a, 'after': b}}, not {_checks.described(runs)}"
        )
    labelled = [(_checks.text("runs", label), _run(f"run '{label}'", run)._results) for label, run in runs.items()]
    _core.write_comparison(labelled, _checks.path("path", path))


def compare(a: Run | str | os.PathLike[str], b: Run | str | os.PathLike[str]) -> dict[str, Difference]:
    """The differences of two runs, or results files, in the channels that both have, as `mimbre compare`; `a` is the
    reference."""
    first, second = _run("a", a), _run("b", b)
    found = _core.compare(first._results, second._results)
    if not found:
        raise InputError("compare: the runs have no channel in common")
    units = first.units
    return {name: Difference(units[name], *values) for name, *values in found}


@dataclass(frozen=True)
class HotSpot:
    """Where a body was stressed most, Pa, body axes."""

    node: int  #: in the file of the mesh
    position: tuple[float, float, float]  #: m
    von_mises: float
    time: float  #: s
    stress: dict[str, float]  #: xx, yy, zz, xy, yz, zx


def stress(
    run: Run | str | os.PathLike[str],
    bodies: Sequence[str] | None = None,
    *,
    spots: int = 5,
    apart: float | None = None,
) -> dict[str, list[HotSpot]]:
    """Where and when the bodies of a run were stressed most, descending, as `mimbre stress`. `apart`: least distance
    between spots, m."""
    most, distance = _checks.number("spots", spots), _checks.given("apart", apart) or 0.0
    if most != int(most) or not 1 <= most <= 1000:
        raise InputError(f"spots: is {most:g}; a whole number from 1 to 1000 is needed")
    if distance < 0:
        raise InputError(f"apart: is {distance:g} m; it cannot be below 0")
    found = _core.stress(_run("run", run)._results, int(most), distance)
    if not found:
        raise InputError("stress: no body has stress modes; reduce its finite elements (mimbre.reduce), and run again")
    if bodies is not None:
        names = [bodies] if isinstance(bodies, str) else bodies
        found = {name: found[name] for name in (_checks.known("body with stress", name, found) for name in names)}
    return {name: [_spot(*values) for values in list_of] for name, list_of in found.items()}


def _spot(node: int, position: Floats, von_mises: float, time: float, values: Sequence[float]) -> HotSpot:
    x, y, z = (float(value) for value in position)
    return HotSpot(node, (x, y, z), von_mises, time, dict(zip(stress_components, values, strict=True)))


@dataclass(frozen=True, eq=False)
class StressHistory:
    """The stress of a body's surface over a run."""

    time: Floats  #: s
    nodes: list[int]  #: in the file of the mesh
    positions: Floats  #: nodes × 3, undeformed, body axes, m
    stress: Floats  #: instants × nodes × 6: xx, yy, zz, xy, yz, zx, body axes, Pa

    @property
    def von_mises(self) -> Floats:
        """Instants × nodes, Pa."""
        xx, yy, zz, xy, yz, zx = np.moveaxis(self.stress, 2, 0)
        shear = xy**2 + yz**2 + zx**2
        squares: Floats = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * shear
        return np.sqrt(squares)


def stress_history(run: Run | str | os.PathLike[str], body: str, nodes: Sequence[int] | None = None) -> StressHistory:
    """The stress of a body over a run, at `nodes` of its mesh or (default) at all of its surface."""
    results = _run("run", run)._results
    there = {name: (first, modes) for name, first, modes in results.stressed_bodies}
    first, modes = there[_checks.known("body with stress", body, there)]
    points, labels, shapes = results.body_stress(body)
    shapes = shapes.reshape(len(points), 6, modes)
    if nodes is not None:
        rows = {label: row for row, label in enumerate(labels)}
        missing = [node for node in nodes if node not in rows]
        if missing:
            raise InputError(f"nodes: {missing[0]!r} is not on the surface of '{body}', which has {len(labels)} nodes")
        chosen = [rows[node] for node in nodes]
        points, shapes, labels = points[chosen], shapes[chosen], [labels[row] for row in chosen]
    amplitudes = results.modes[:, first : first + modes]
    return StressHistory(np.array(results.time), labels, points, np.einsum("tm,ncm->tnc", amplitudes, shapes))


@dataclass(frozen=True)
class Mode:
    """A candidate of a selection."""

    name: str
    frequency: float  #: Hz
    participation: float  #: error where it alone is dropped


@dataclass(frozen=True)
class Selection:
    """A body with as few modes as its mechanism needs."""

    body: ReducedBody
    kept: list[Mode]
    dropped: list[Mode]
    estimated_error: float
    achieved_error: float
    candidates: int
    runs: int  #: of the mechanism


def select(
    model: Model,
    body: str,
    *,
    error: float = 0.01,
    keep: Literal["combinations", "modes"] = "combinations",
    pre: Literal["candidates", "rigid"] = "candidates",
    until: float | None = None,
    progress: Callable[[str, float], object] | None = None,
    **method: Unpack[Method],
) -> Selection:
    """Makes a body with the fewest modes whose deflections are within `error` (a ratio) of those with all, as `mimbre
    select`. `progress` is called with what is being done and how much of it is. Raises SimulationError where no
    selection reaches the error."""
    share, end = _checks.number("error", error), _checks.given("until", until)
    if not 0 < share <= 1:
        raise InputError(f"error: is {share:g}; a ratio above 0 and up to 1 is needed")
    if end is not None and end <= 0:
        raise InputError(f"until: is {end:g} s; a time above 0 is needed")
    found = _core.select(
        compiled(model),
        checked_method(method),
        _checks.known("body", body, model.bodies),
        share,
        _checks.known("way to keep modes", keep, ("combinations", "modes")) == "combinations",
        _checks.known("ranking", pre, ("candidates", "rigid")) == "rigid",
        end,
        _checks.callback(progress),
    )
    kept, dropped = ([Mode(*mode) for mode in modes] for modes in (found.kept, found.dropped))
    errors = (found.estimated_error, found.achieved_error)
    return Selection(ReducedBody(found.body), kept, dropped, *errors, found.candidates, found.runs)


def convert(
    source: ReducedBody | str | os.PathLike[str], target: str | os.PathLike[str], *, stress: bool = True
) -> ReducedBody:
    """Writes a reduced body in the format of the target's ending, .h5, .fem or .sid, as `mimbre convert`; the body."""
    body = source if isinstance(source, ReducedBody) else ReducedBody.open(source)
    if not stress:
        body = ReducedBody(_core.without_stress(body._compiled))
    body.save(target)
    return body


def _run(name: str, run: object) -> Run:
    return run if isinstance(run, Run) else Run.open(_checks.path(name, run))

"""What can be asked of models, runs and bodies beside a run: the program's other commands, with their answers as
objects."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from . import _checks, _core
from .errors import InputError
from .method import Method
from .reduction import ReducedBody
from .run import Floats, Run
from .simulation import checked_method, compiled

if TYPE_CHECKING:
    from typing import Literal

    from typing_extensions import Unpack

    from .model import Model

stress_components = ("xx", "yy", "zz", "xy", "yz", "zx")


@dataclass(frozen=True)
class Equilibrium:
    """A model at rest: `equilibrium["chassis.z"]` is an output there."""

    outputs: dict[str, float]
    """Values of the model's outputs, by name."""
    units: dict[str, str]
    """Their units."""
    iterations: int
    """That finding it took."""
    residual: float
    """Residual of the equations, relative."""
    stable: bool
    """No small disturbance grows."""
    warnings: list[str]
    """What was suspicious."""

    def __getitem__(self, name: str) -> float:
        return self.outputs[_checks.known("output", name, self.outputs)]


def static(model: Model, **method: Unpack[Method]) -> Equilibrium:
    """The static equilibrium, as `mimbre static`.

    Args:
        model: a Model.
        **method: see `Method`.

    Returns:
        The outputs at rest, and whether the rest is stable.

    Raises:
        SimulationError: none was found.

    Example:
        ```python
        rest = mimbre.static(model)
        print(rest["chassis.z"], rest.units["chassis.z"], rest.stable)
        ```
    """
    found = _core.static_equilibrium(compiled(model), checked_method(method))
    outputs = {name: value for name, value, _ in found.outputs}
    units = {name: unit for name, _, unit in found.outputs}
    return Equilibrium(outputs, units, found.iterations, found.residual, found.stable, found.warnings)


@dataclass(frozen=True)
class Apart:
    """How far a channel lies apart in the two formulations, at the shortest step that was made."""

    unit: str
    """Of the channel."""
    max_difference: float
    """The largest difference, in that unit."""
    scale: float
    """What differences are measured by, in that unit."""
    time: float
    """Of the largest difference, s."""
    agrees: bool
    """Whether they are near enough."""


@dataclass(frozen=True)
class Verification:
    """A model in both formulations."""

    agree: bool
    """Whether the formulations agree in all channels."""
    verdict: str
    """The same in a sentence."""
    refinement_ratio: float | None
    """How many times smaller differences are with half the step: about 4."""
    channels: dict[str, Apart]
    """How far each channel lies apart, by name."""
    failures: list[str]
    """Runs that failed, and how."""
    warnings: list[str]
    """What was suspicious."""


def verify(
    model: Model,
    *,
    until: float | None = None,
    refine: bool = True,
    progress: Callable[[float], object] | None = None,
    **method: Unpack[Method],
) -> Verification:
    """Runs the model in both formulations and compares them, as `mimbre verify`.

    Args:
        model: a Model.
        until: end of the runs, s; default: the model's.
        refine: at shorter steps too.
        progress: is called with the time, s, that the run at hand has reached; there are two to six runs.
        **method: see `Method`.

    Returns:
        Whether they agree, and how far each channel lies apart.
    """
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
    """Of the channel."""
    max_difference: float
    """The largest difference, in that unit."""
    mean_difference: float
    """The mean of the differences' sizes, in that unit."""
    time: float
    """Of the largest difference, s."""
    amplitude: float
    """The largest size of a value in the first run, in that unit."""
    interpolation_error: float = 0
    """How far values that are interpolated between instants may be off, about, in that unit; 0: none are."""

    @property
    def relative(self) -> float:
        """The largest difference, of the amplitude."""
        if self.amplitude == 0:
            return 0.0 if self.max_difference == 0 else float("inf")
        return self.max_difference / self.amplitude


def report(runs: Mapping[str, Run | str | os.PathLike[str]], path: str | os.PathLike[str]) -> None:
    """Writes a page that draws runs over each other, as `mimbre report A.h5 B.h5`.

    Args:
        runs: at least two, or results files, by their labels; the first is what the others are compared to.
        path: of the page, .html.

    Raises:
        InputError: fewer than two runs, or none of their channels in common.

    Example:
        ```python
        mimbre.report({"10 ms": model.run(step=0.01), "1 ms": model.run(step=0.001)}, "steps.html")
        ```
    """
    if not isinstance(runs, Mapping):
        raise InputError(
            f"runs: names with runs are needed, {{'before': a, 'after': b}}, not {_checks.described(runs)}"
        )
    labelled = [(_checks.text("runs", label), _run(f"run '{label}'", run)._results) for label, run in runs.items()]
    _core.write_comparison(labelled, _checks.path("path", path))


def compare(a: Run | str | os.PathLike[str], b: Run | str | os.PathLike[str]) -> dict[str, Difference]:
    """The differences of two runs in the channels that both have in the same unit, as `mimbre compare`. A warning names
    those whose units differ.

    Args:
        a: the reference, a Run or a results file.
        b: the other.

    Returns:
        By the channel's name how far they differ.

    Raises:
        InputError: the runs have no channel in common, or a file is none of results.

    Example:
        ```python
        fine, coarse = model.run(step=0.005), model.run(step=0.01)
        print(mimbre.compare(fine, coarse)["angle"].max_difference)
        ```
    """
    first, second = _run("a", a), _run("b", b)
    found = _core.compare(first._results, second._results)
    units, others = first.units, second.units
    differ = [
        f"'{name}' ({units[name]} and {others[name]})" for name in units if others.get(name, units[name]) != units[name]
    ]
    not_compared = f"not compared, as their units differ: {', '.join(differ)}"
    if not found:
        raise InputError("compare: the runs have no channel in common" + (f"; {not_compared}" if differ else ""))
    if differ:
        warnings.warn(not_compared, stacklevel=2)
    return {name: Difference(units[name], *values) for name, *values in found}


@dataclass(frozen=True)
class HotSpot:
    """Where a body was stressed most, Pa, body axes."""

    node: int
    """Its number in the file of the mesh."""
    position: tuple[float, float, float]
    """m"""
    von_mises: float
    """Pa"""
    time: float
    """s"""
    stress: dict[str, float]
    """xx, yy, zz, xy, yz, zx, Pa"""


def stress(
    run: Run | str | os.PathLike[str],
    bodies: Sequence[str] | None = None,
    *,
    spots: int = 5,
    apart: float | None = None,
) -> dict[str, list[HotSpot]]:
    """Where and when the bodies of a run were stressed most, as `mimbre stress`.

    Args:
        run: a Run or a results file.
        bodies: names; default: all that have stress modes.
        spots: how many of each body, 1 to 1000.
        apart: least distance between spots, m.

    Returns:
        By the body's name its spots, the highest stress first.

    Raises:
        InputError: no body has stress modes, or one of the names is not there.

    Example:
        ```python
        worst = mimbre.stress(run, ["arm"], spots=1)["arm"][0]
        print(worst.node, worst.von_mises, worst.time)
        ```
    """
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
    """What it is called."""
    frequency: float
    """Hz"""
    participation: float
    """The error where it alone is dropped, a ratio."""


@dataclass(frozen=True)
class Selection:
    """A body with as few modes as its mechanism needs."""

    body: ReducedBody
    """With the modes that were kept."""
    kept: list[Mode]
    """Modes that it has."""
    dropped: list[Mode]
    """Modes that it has not."""
    estimated_error: float
    """As foreseen, a ratio."""
    achieved_error: float
    """In a run of the mechanism with the new body, a ratio."""
    candidates: int
    """How many modes there were."""
    runs: int
    """How many runs of the mechanism it took."""


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
    """Makes a body with the fewest modes that a mechanism needs, as `mimbre select`.

    Args:
        model: the mechanism, with a body of many modes.
        body: its name there.
        error: how far its deflections may be from those with all modes, a ratio above 0 up to 1.
        keep: "combinations" of modes, or "modes" as they are.
        pre: how they are ranked: by runs with the "candidates", or with a "rigid" body.
        until: end of the runs, s; default: the model's.
        progress: is called with what is being done and how much of it is, 0 to 1.
        **method: see `Method`.

    Returns:
        The body, and what was kept and dropped.

    Raises:
        InputError: there is no such body, or an option does not fit.
        SimulationError: no choice reaches the error.
    """
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


@dataclass(frozen=True)
class InertiaTerm:
    """A term of flexible bodies' inertia, and what a model is without it in all of them."""

    name: str
    estimate: float
    """Its share in what inertia does in a step, a ratio."""
    error: float
    """The largest of an output, by its range; infinite where the run fails."""
    cost: float
    """Time of a step, by that with all terms; NaN where it was not measured."""


@dataclass(frozen=True)
class InertiaChoice:
    """Which terms of flexible bodies' inertia a model can do without."""

    neglected: dict[str, list[str]]
    """The choice: names of terms by body."""
    error: float
    """Of the choice: the largest of an output, by its range."""
    worst: str
    """The output that has it; empty without an error."""
    cost: float
    """Time of a step, by that with all terms; NaN where it was not measured."""
    terms: list[InertiaTerm]
    """Each term, neglected in all bodies."""
    runs: int
    """How many runs of the model it took."""
    notes: list[str]
    """What else is in errors and times, as of bodies that fly freely."""


def inertia_terms(
    model: Model,
    *,
    error: float = 1e-3,
    outputs: Sequence[str] = (),
    until: float | None = None,
    measure: bool = False,
    progress: Callable[[str, float], object] | None = None,
    **method: Unpack[Method],
) -> InertiaChoice:
    """Finds the terms of flexible bodies' inertia that a model can do without, as `mimbre terms`.

    Args:
        model: with flexible bodies.
        error: how far an output may be off, by its range in the run; a ratio above 0 up to 1.
        outputs: names of channels; default: the model's outputs, or the coordinates of its joints.
        until: end of the runs, s; default: the model's.
        measure: the time of a step, too.
        progress: is called with what is being done and how much of it is, 0 to 1.
        **method: see `Method`.

    Returns:
        The choice, for `ModelBuilder.neglect_inertia` or the section `neglected_inertia` of a model file.

    Raises:
        InputError: there is no flexible body, its inertia is `projection`, no output moves, or one is unknown.
        SimulationError: the run with all terms fails.
    """
    share, end = _checks.number("error", error), _checks.given("until", until)
    if not 0 < share <= 1:
        raise InputError(f"error: is {share:g}; a ratio above 0 and up to 1 is needed")
    if end is not None and end <= 0:
        raise InputError(f"until: is {end:g} s; a time above 0 is needed")
    names = [_checks.text("output", name) for name in outputs]
    found = _core.inertia_terms(
        compiled(model), checked_method(method), share, names, end, measure, _checks.callback(progress)
    )
    terms = [InertiaTerm(*term) for term in found.terms]
    return InertiaChoice(
        dict(found.neglected), found.error, found.worst, found.cost, terms, found.runs, list(found.notes)
    )


def convert(
    source: ReducedBody | str | os.PathLike[str], target: str | os.PathLike[str], *, stress: bool = True
) -> ReducedBody:
    """Writes a reduced body in another format, as `mimbre convert`.

    Args:
        source: a ReducedBody or a file of one.
        target: the file to write; its ending selects the format: .h5, .fem (MBDyn) or .sid.
        stress: with its stress modes, where the format has them.

    Returns:
        The body.

    Raises:
        InputError: the source is no reduced body, or there is no format of that ending.
    """
    body = source if isinstance(source, ReducedBody) else ReducedBody.open(source)
    if not stress:
        body = ReducedBody(_core.without_stress(body._compiled))
    body.save(target)
    return body


def _run(name: str, run: object) -> Run:
    return run if isinstance(run, Run) else Run.open(_checks.path(name, run))

"""Prescribed motions: where drives move a mechanism, and the forces that make a motion."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, cast

from . import _checks, _core
from .errors import InputError
from .run import Floats, Run
from .simulation import compiled

if TYPE_CHECKING:
    import numpy.typing as npt

    from .model import Model

    Kind = Literal["dead_centre", "change_point", "limit", "reversal"]
    #: A table's file, or the times and the positions of joint coordinates by their names. In place of positions
    #: alone, a coordinate may have (positions, velocities, accelerations).
    Motion = str | os.PathLike[str] | tuple[npt.ArrayLike, Mapping[str, npt.ArrayLike]]


@dataclass(frozen=True)
class SpecialPosition:
    """A position in which the mechanism is singular, or in which a coordinate turns back."""

    kind: Kind
    """dead_centre: the drives do not determine the motion. change_point: the mechanism can continue in another
    way. limit: the drive cannot go further, because loops do not close. reversal: a coordinate turns back, which is a
    dead centre for a drive of that coordinate."""
    time: float
    """s."""
    joint: str
    """The coordinate concerned."""
    position: float
    """Of this coordinate, m or rad."""
    driven: float
    """Coordinate of the first drive, m or rad."""
    text: str
    """The same in words."""


@dataclass(frozen=True)
class Kinematics:
    """The motion that drives alone prescribe. Columns are joint coordinates: `found.of("slide")` is one position."""

    time: Floats
    """Instants, s, as far as the motion goes."""
    names: list[str]
    """Joint coordinates, by column."""
    position: Floats
    """Instants × coordinates, m or rad."""
    velocity: Floats
    """Likewise, m/s or rad/s."""
    acceleration: Floats
    """Likewise, m/s² or rad/s²."""
    regularity: Floats
    """Least singular value of the scaled Jacobian of all equations, by instant; 0 in a singular position."""
    coordinates: int
    """Of the joints."""
    equations: int
    """Of loops and constraints, without drives."""
    mobility: int
    """Independent motions that loops and constraints leave."""
    drives: int
    """Coordinates that drives prescribe."""
    free: int
    """Independent motions that no drive prescribes."""
    free_joints: list[str]
    """Joints that take part in these."""
    redundant: int
    """Equations that repeat others."""
    redundant_names: list[str]
    """Joints and constraints that have them."""
    special: list[SpecialPosition]
    """Singular positions and reversals, in the order of time."""
    complete: bool
    """The motion reaches its end; otherwise `special` contains the limit."""
    warnings: list[str]
    """Suspicious properties of the model."""
    run: Run
    """Channels of positions, velocities and accelerations, and poses, as of a run."""

    def of(self, name: str) -> Floats:
        """Positions of one coordinate, by instant, m or rad."""
        return self.position[:, self.names.index(_checks.known("coordinate", name, self.names))]


def kinematics(
    model: Model,
    *,
    start: float = 0,
    end: float | None = None,
    steps: int = 200,
    inputs: Mapping[str, float] | None = None,
) -> Kinematics:
    """Positions, velocities and accelerations that the drives prescribe, as `mimbre kinematics`.

    Args:
        model: a Model.
        start: s.
        end: s; default: the model's.
        steps: intervals between these.
        inputs: values of inputs and tunable parameters, by name.

    Returns:
        The motion, the mobility, redundant equations and singular positions on the way.

    Raises:
        InputError: an option does not fit, or the model cannot be assembled.
    """
    found = _core.kinematics(
        compiled(model),
        _checks.number("start", start),
        _checks.given("end", end),
        _checks.whole("steps", steps),
        _inputs(inputs),
    )
    return Kinematics(
        found.time,
        found.names,
        found.position,
        found.velocity,
        found.acceleration,
        found.regularity,
        found.coordinates,
        found.equations,
        found.mobility,
        found.drives,
        found.free,
        found.free_joints,
        found.redundant,
        found.redundant_names,
        [
            SpecialPosition(cast("Kind", kind), time, joint, position, driven, text)
            for kind, time, joint, position, driven, text in found.special
        ],
        found.complete,
        found.warnings,
        Run(found.results),
    )


@dataclass(frozen=True)
class InverseDynamics:
    """Forces that make a motion: `found["shoulder"]` is the history of one."""

    time: Floats
    """Instants, s."""
    names: list[str]
    """Joint coordinates along which the forces act, by column."""
    units: list[str]
    """Of the forces: N or N m."""
    position: Floats
    """Instants × coordinates, m or rad."""
    velocity: Floats
    """Likewise, m/s or rad/s."""
    acceleration: Floats
    """Likewise, m/s² or rad/s²."""
    force: Floats
    """Likewise, N or N m: positive where the force drives the coordinate forward."""
    free: int
    """Independent motions that nothing prescribes."""
    redundant: int
    """Forces that are not needed: the result is then the smallest set of forces."""
    residual: float
    """The largest share of the forces that the sought forces do not balance."""
    warnings: list[str]
    """Suspicious properties of the model."""
    run: Run
    """All channels, joint reactions among them, and poses, as of a run."""

    def __getitem__(self, name: str) -> Floats:
        return self.force[:, self.names.index(_checks.known("coordinate", name, self.names))]


def inverse_dynamics(
    model: Model,
    motion: Motion | None = None,
    *,
    smooth: float = 0,
    forces: Sequence[str] = (),
    flexible: Literal["dynamic", "quasistatic"] = "dynamic",
    step: float | None = None,
    start: float = 0,
    end: float | None = None,
    steps: int = 200,
    inputs: Mapping[str, float] | None = None,
) -> InverseDynamics:
    """Forces along joint coordinates that make a motion, in trees and loops, as `mimbre inverse-dynamics`.

    Args:
        model: a Model.
        motion: a table's file, or times and coordinates by name; default: the motion of the drives. Between the
            instants a coordinate is a spline of degree 5.
        smooth: s; the smoothing spline halves motions of this period; default: none.
        forces: joint coordinates along which forces act; default: those that are prescribed.
        flexible: flexible bodies, and joints held by springs, follow by their dynamics, or are in balance at each
            instant as if they were at rest in the motion.
        step: step of `dynamic`, s; default: the model's.
        start: s, without a table.
        end: s, without a table; default: the model's.
        steps: intervals between these.
        inputs: values of inputs and tunable parameters, by name.

    Returns:
        The forces, with all channels of the motion.

    Raises:
        InputError: an option or the motion does not fit the model.
        SimulationError: the motion or the balance cannot be made; the message has the time.

    Example:
        ```python
        found = model.inverse_dynamics((time, {"shoulder": angle}))
        torque = found["shoulder"]
        ```
    """
    if flexible not in ("dynamic", "quasistatic"):
        raise InputError(f"flexible: 'dynamic' or 'quasistatic' is needed, not {_checks.described(flexible)}")
    file: str | None = None
    times: list[float] = []
    columns: list[tuple[str, list[float], list[float], list[float]]] = []
    if isinstance(motion, str | os.PathLike):
        file = _checks.path("motion", motion)
    elif motion is not None:
        wanted = "a table's file, or times and coordinates by name,"
        given, by_name = _checks.pair("motion", motion, wanted)
        times = _checks.array("motion", given).tolist()
        columns = [_column(name, values) for name, values in _checks.mapping("motion", by_name, wanted).items()]
        if not columns:
            raise InputError("motion: has no joint coordinate")
    found = _core.inverse_dynamics(
        compiled(model),
        file,
        times,
        columns,
        _checks.number("smooth", smooth),
        _checks.names("forces", forces),
        flexible == "quasistatic",
        0.0 if step is None else _checks.number("step", step),
        _checks.number("start", start),
        _checks.given("end", end),
        _checks.whole("steps", steps),
        _inputs(inputs),
    )
    return InverseDynamics(
        found.time,
        found.names,
        found.units,
        found.position,
        found.velocity,
        found.acceleration,
        found.force,
        found.free,
        found.redundant,
        found.residual,
        found.warnings,
        Run(found.results),
    )


def _inputs(inputs: Mapping[str, float] | None) -> dict[str, float]:
    given = _checks.mapping("inputs", {} if inputs is None else inputs, "a mapping of names to values")
    return {name: _checks.number(f"inputs: {name}", value) for name, value in given.items()}


def _column(name: str, values: npt.ArrayLike) -> tuple[str, list[float], list[float], list[float]]:
    """Positions alone, or three histories."""
    if isinstance(values, tuple):
        if len(values) != 3:
            raise InputError(f"motion: {name}: (positions, velocities, accelerations) is needed, not {len(values)}")
        first, second, third = (_checks.array(f"motion: {name}", one).tolist() for one in values)
        return name, first, second, third
    return name, _checks.array(f"motion: {name}", values).tolist(), [], []

"""Linear models about a point, modes, and modes over a parameter (docs/linear-analyses.md)."""

from __future__ import annotations

import importlib
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, overload

import numpy as np
import numpy.typing as npt

from . import _checks, _core
from .errors import InputError
from .simulation import checked_method, compiled

if TYPE_CHECKING:
    from typing import Any

    from scipy.signal import StateSpace
    from typing_extensions import Unpack

    from .method import Method
    from .model import Model

    #: Where a model is linearised: a word, or a time of a run in s. None: the equilibrium where there is one, else
    #: steady motion, else the start.
    Point = Literal["equilibrium", "steady", "start"] | float | None

Floats = npt.NDArray[np.float64]
Complexes = npt.NDArray[np.complex128]
Integers = npt.NDArray[np.int64]

_words = ("equilibrium", "steady", "start")
_conditions = ("speed", "lateral_acceleration", "yaw_rate", "radius")
_speeds = {"rad/s": 1.0, "rpm": math.pi / 30, "Hz": 2 * math.pi}


@dataclass(frozen=True, eq=False)
class LinearModel:
    """ẋ = A x + B u, o = C x + D u about a point; x, u and o are differences from their values there. SI, radians.

    Example:
        ```python
        linear = mimbre.Model.from_file("car.yaml").linearise()
        print(np.linalg.eigvals(linear.A))
        ```
    """

    title: str
    """Of the model."""
    point: str
    """In words: "equilibrium", "steady motion", "start", "t = 0.3 s"."""
    A: Floats
    """states × states"""
    B: Floats
    """states × inputs"""
    C: Floats
    """outputs × states"""
    D: Floats
    """outputs × inputs"""
    mass: Floats
    """Of the motion alone, M ÿ + C ẏ + K y = 0; with rolling, M ṡ + C s + K y = 0."""
    damping: Floats
    """C, with gyroscopic terms."""
    stiffness: Floats
    """K, with the terms of loads, prestress and constraint forces."""
    states: list[str]
    """Names of x: `coordinates` positions y, then `speeds` velocities s, then states of elements and signals."""
    inputs: list[str]
    """Names of u."""
    outputs: list[str]
    """Names of o."""
    state_units: list[str]
    """Their units."""
    input_units: list[str]
    """Their units."""
    output_units: list[str]
    """Their units."""
    input_values: list[float]
    """At the point."""
    output_values: list[float]
    """At the point."""
    coordinates: int
    """How many states are positions."""
    speeds: int
    """How many states are velocities: as many, or fewer where wheels roll without slip."""
    notes: list[str]
    """What was done with delays, sampled signals and laws of the user."""
    warnings: list[str]
    """No equilibrium, coefficients that vary along the motion."""
    _core: _core.LinearModel

    def response(self, frequencies: npt.ArrayLike) -> Complexes:
        """Frequency responses C (iω − A)⁻¹ B + D: frequencies × outputs × inputs.

        Args:
            frequencies: in Hz.
        """
        omega = 2 * np.pi * _checks.array("frequencies", frequencies)
        size = len(self.A)
        shifted = 1j * omega[:, None, None] * np.eye(size) - self.A
        gained: Complexes = self.C @ np.linalg.solve(shifted, np.broadcast_to(self.B, (len(omega), *self.B.shape)))
        return gained + self.D

    def to_scipy(self) -> StateSpace[Any, Any, Any]:
        """A `scipy.signal.StateSpace`. Needs SciPy.

        Raises:
            InputError: the model has no inputs or no outputs, without which SciPy has no such object.
        """
        from scipy.signal import StateSpace

        for what, names in ("inputs", self.inputs), ("outputs", self.outputs):
            if not names:
                raise InputError(f"to_scipy: the model has no {what}; scipy.signal.StateSpace needs at least one")
        return StateSpace(self.A, self.B, self.C, self.D)

    def to_control(self) -> Any:
        """A `control.StateSpace` with the names of states, inputs and outputs. Needs the package control."""
        control = importlib.import_module("control")

        return control.ss(
            self.A,
            self.B,
            self.C,
            self.D,
            states=_unique(self.states),
            inputs=_unique(self.inputs),
            outputs=_unique(self.outputs),
            name=self.title or None,
        )

    def save(self, path: str | os.PathLike[str], frequencies: npt.ArrayLike = ()) -> None:
        """Writes the model to a file, as `mimbre linearise -o`.

        Args:
            path: ends with .h5, .mat or .json; or with .html, for a page of Bode plots.
            frequencies: in Hz, of responses that are written too; a page needs two or more, ascending.

        Raises:
            InputError: the format is unknown; or of a page, the model has no inputs or no outputs, or there are no
                frequencies.
        """
        file = _checks.path("path", path)
        if not file.endswith((".h5", ".mat", ".json", ".html")):
            raise InputError(f"save: {file!r} ends with no format that is known: .html, .h5, .mat or .json")
        wanted = _checks.array("frequencies", frequencies)
        if file.endswith(".html") and (len(wanted) < 2 or wanted[0] <= 0 or not (np.diff(wanted) > 0).all()):
            raise InputError("save: a page of Bode plots needs two frequencies or more, above 0 and ascending")
        self._core.save(file, wanted.tolist())


@dataclass(frozen=True, eq=False)
class EigenMode:
    """A mode about a point: an eigenvalue λ of A with Im λ ≥ 0."""

    kind: str
    """"rigid" (λ = 0), "real" or "oscillating"."""
    value: complex
    """λ, 1/s"""
    from_ground: complex
    """λ as seen from the ground where the whole mechanism turns (`Modes.turning`): of a whirling mode in axes of the
    shaft λ ± iΩ. Not a number where the ground sees two frequencies. Else λ."""
    frequency: float
    """|λ|/2π, Hz"""
    damping: float
    """The damping ratio −Re λ/|λ|."""
    grows: bool
    """Re λ > 0 beyond round-off."""
    multiplier: complex
    """Where coefficients repeat after T (`Modes.period`): e^{λT}, by which the motion grows over a period. Else 0."""
    whirl: float
    """1: forward, −1: backward, 0: neither."""
    blades: dict[str, float]
    """Of three equal blades or more: the shares of the waves that they are in (collective, differential, forward,
    backward, as seen from the hub), largest first; empty where blades hardly move."""
    text: str
    """What it consists of, in words."""
    shape: Complexes
    """By relative velocity coordinate, `Modes.coordinates`."""
    coordinates: dict[str, float]
    """Shares of the kinetic energy, by joint coordinate or modal amplitude."""
    bodies: dict[str, float]
    """Shares of the kinetic energy, by body."""
    elastic: dict[str, float]
    """Shares of the elastic energy, by force element or flexible body."""


@dataclass(frozen=True, eq=False)
class Modes(Sequence[EigenMode]):
    """The modes about a point, rigid ones first, then by |λ|: `modes[0].frequency`, `len(modes)`."""

    point: str
    """In words."""
    coordinates: list[str]
    """Names of the relative velocity coordinates."""
    modes: list[EigenMode]
    """All of them."""
    turning: float
    """Angular speed of the whole mechanism about one fixed axis, rad/s; 0: it does not turn so."""
    period: float
    """T, s, after which coefficients that vary along the motion repeat; λ are then Floquet's exponents. Else 0."""
    notes: list[str]
    """What was done with delays, sampled signals and laws of the user."""
    warnings: list[str]
    """No equilibrium, coefficients that vary along the motion."""
    _core: _core.LinearisedModes

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the modes to a file, as `mimbre modes -o`.

        Args:
            path: ends with .html, for a page in which the modes are animated, or with .h5.
        """
        file = _checks.path("path", path)
        if not file.endswith((".html", ".h5")):
            raise InputError(f"save: {file!r} ends with no format that is known: .html or .h5")
        self._core.save(file)

    def save_vtk(self, folder: str | os.PathLike[str]) -> str:
        """Writes each mode over one period as VTK files for ParaView, as `mimbre modes --vtk`.

        Returns:
            The name of the first series; there is one for each mode.
        """
        return self._core.save_vtk(_checks.path("folder", folder))

    @overload
    def __getitem__(self, index: int) -> EigenMode: ...
    @overload
    def __getitem__(self, index: slice) -> list[EigenMode]: ...
    def __getitem__(self, index: int | slice) -> EigenMode | list[EigenMode]:
        return self.modes[index]

    def __len__(self) -> int:
        return len(self.modes)

    def __iter__(self) -> Iterator[EigenMode]:
        return iter(self.modes)

    @property
    def values(self) -> Complexes:
        """λ of all modes, 1/s."""
        return np.array([mode.value for mode in self.modes], dtype=np.complex128)


@dataclass(frozen=True, eq=False)
class ModeBranch:
    """A mode over the parameter."""

    name: str
    """What it consists of where it is first seen."""
    values: Complexes
    """λ by value of the parameter, 1/s (from the ground, `EigenMode.from_ground`); not a number where it is not."""
    whirl: Floats
    """1: forward, −1: backward, 0: neither."""
    half_of: Integers
    """Number of the branch with the other half of the pair, of which this one has the conjugate; −1: it has none."""


@dataclass(frozen=True)
class CriticalSpeed:
    """A speed of which a mode has an order as its frequency."""

    branch: int
    """Number of the branch."""
    value: float
    """Of the parameter."""
    order: float
    """Of the speed."""
    frequency: float
    """rad/s"""


@dataclass(frozen=True)
class Onset:
    """Where a mode begins or ceases to grow."""

    branch: int
    """Number of the branch."""
    value: float
    """Of the parameter."""
    frequency: float
    """rad/s"""
    grows: bool
    """Whether it grows from there on."""


@dataclass(frozen=True)
class Meeting:
    """Where two real modes become one oscillating pair, or a pair becomes two real modes."""

    first: int
    """Number of the branch that has the pair."""
    second: int
    """Number of the other branch."""
    value: float
    """Of the parameter."""
    real: float
    """λ there, 1/s."""
    parts: bool
    """Whether the pair becomes two real modes."""


@dataclass(frozen=True, eq=False)
class CampbellDiagram:
    """Modes followed by their shapes over a parameter."""

    parameter: str
    """Its name."""
    values: Floats
    """Of the parameter."""
    branches: list[ModeBranch]
    """The modes."""
    criticals: list[CriticalSpeed]
    """Critical speeds, where the parameter is a speed."""
    onsets: list[Onset]
    """Where modes begin or cease to grow."""
    meetings: list[Meeting]
    """Where real modes meet or part."""
    warnings: list[str]
    """What was suspicious."""


def _unique(names: list[str]) -> list[str]:
    """Names without the dots that the package control reads as SYSTEM.SIGNAL, each once."""
    seen: dict[str, int] = {}
    out = []
    for name in names:
        plain = name.replace(".", "_")
        seen[plain] = seen.get(plain, 0) + 1
        out.append(plain if seen[plain] == 1 else f"{plain}_{seen[plain]}")
    return out


def _point(at: object) -> tuple[str, float]:
    if at is None:
        return "automatic", 0.0
    if isinstance(at, str):
        return _checks.known("point", at, _words), 0.0
    time = _checks.number("at", at)
    if time < 0:
        raise InputError(f"at: is {time:g} s; a time from 0 on is needed, or one of: {', '.join(_words)}")
    return "time", time


def _driving(hold: object, find: object, body: object) -> _core.TrimConditions:
    """Conditions of steady driving."""
    conditions = _core.TrimConditions()
    held = _checks.mapping("hold", {} if hold is None else hold, "a number for each condition")
    for name, value in held.items():
        conditions.hold(_checks.known("condition of steady driving", name, _conditions), _checks.number(name, value))
    conditions.find = _checks.names("find", () if find is None else find)
    conditions.body = "" if body is None else _checks.text("body", body)
    return conditions


def _driven_point(
    at: object, hold: object, find: object, body: object
) -> tuple[str, float, _core.TrimConditions | None]:
    """A point, and the conditions if it is steady driving."""
    word, time = _point(at)
    if hold is None and find is None and body is None:
        return word, time, None
    driving = _driving(hold, find, body)
    if word not in ("automatic", "steady"):
        raise InputError(f"at: is {at!r}; hold, find and body are those of steady driving, at='steady'")
    return word, time, driving


def _inputs(inputs: object) -> dict[str, float]:
    given = _checks.mapping("inputs", inputs or {}, "a number for each name")
    return {name: _checks.number(f"inputs: {name}", value) for name, value in given.items()}


def _order(delay_order: object) -> int:
    order = _checks.whole("delay_order", delay_order)
    if not 1 <= order <= 8:
        raise InputError(f"delay_order: is {order}; 1 to 8 are possible")
    return order


def _most(most: object) -> int:
    if most is None:
        return 0
    count = _checks.whole("most", most)
    if count < 1:
        raise InputError(f"most: is {count}; a number of modes from 1 on is needed, or None for all")
    return count


def linearise(
    model: Model,
    *,
    at: Point = None,
    hold: Mapping[str, float] | None = None,
    find: Sequence[str] | None = None,
    body: str | None = None,
    inputs: Mapping[str, float] | None = None,
    delay_order: int = 4,
    **method: Unpack[Method],
) -> LinearModel:
    """The linear model about a point, as `mimbre linearise`; see `Model.linearise`."""
    word, time, driving = _driven_point(at, hold, find, body)
    found = _core.linearise(
        compiled(model), checked_method(method), word, time, _inputs(inputs), _order(delay_order), driving
    )
    (states, state_units), (given, input_units), (outputs, output_units) = (
        ([name for name, _ in names], [unit for _, unit in names])
        for names in (found.states, found.inputs, found.outputs)
    )
    return LinearModel(
        title=found.title,
        point=found.point,
        A=found.a,
        B=found.b,
        C=found.c,
        D=found.d,
        mass=found.mass,
        damping=found.damping,
        stiffness=found.stiffness,
        states=states,
        inputs=given,
        outputs=outputs,
        state_units=state_units,
        input_units=input_units,
        output_units=output_units,
        input_values=found.input_values,
        output_values=found.output_values,
        coordinates=found.coordinates,
        speeds=found.speeds,
        notes=found.notes,
        warnings=found.warnings,
        _core=found,
    )


def modes(
    model: Model,
    *,
    at: Point = None,
    hold: Mapping[str, float] | None = None,
    find: Sequence[str] | None = None,
    body: str | None = None,
    most: int | None = None,
    solver: Literal["automatic", "dense", "sparse"] = "automatic",
    inputs: Mapping[str, float] | None = None,
    delay_order: int = 4,
    **method: Unpack[Method],
) -> Modes:
    """The modes about a point, as `mimbre modes`; see `Model.modes`."""
    word, time, driving = _driven_point(at, hold, find, body)
    found = _core.modes(
        compiled(model),
        checked_method(method),
        word,
        time,
        _inputs(inputs),
        _order(delay_order),
        _most(most),
        _checks.known("solver of modes", solver, ("automatic", "dense", "sparse")),
        driving,
    )
    listed = [
        EigenMode(
            kind=m.kind,
            value=m.value,
            from_ground=m.from_ground,
            frequency=m.frequency,
            damping=m.damping,
            grows=m.grows,
            multiplier=m.multiplier,
            whirl=m.whirl,
            blades=dict(m.blades),
            text=m.text,
            shape=m.shape,
            coordinates=dict(m.coordinates),
            bodies=dict(m.bodies),
            elastic=dict(m.elastic),
        )
        for m in found.modes
    ]
    names = [name for name, _ in found.coordinates]
    return Modes(found.point, names, listed, found.turning, found.period, found.notes, found.warnings, found)


@dataclass(frozen=True)
class Trim:
    """Steady driving: `trim.inputs["steering"]` is what the input must be, `trim["rack"]` an output."""

    body: str
    """Whose motion it is."""
    speed: float
    """Of its origin along the plane across gravity, m/s."""
    yaw_rate: float
    """To the left, rad/s."""
    lateral_acceleration: float
    """Yaw rate times speed, m/s²."""
    sideslip: float
    """From the x axis of the body to its velocity, to the left, rad."""
    inputs: dict[str, float]
    """Those that were found."""
    outputs: dict[str, float]
    """Values of the model's outputs, by name."""
    units: dict[str, str]
    """Their units."""

    def __getitem__(self, name: str) -> float:
        return self.outputs[_checks.known("output", name, self.outputs)]


def trim(
    model: Model,
    *,
    find: Sequence[str],
    speed: float | None = None,
    lateral_acceleration: float | None = None,
    yaw_rate: float | None = None,
    radius: float | None = None,
    body: str | None = None,
    inputs: Mapping[str, float] | None = None,
) -> Trim:
    """Inputs of steady driving, as `mimbre trim`; see `Model.trim`."""
    given = zip(_conditions, (speed, lateral_acceleration, yaw_rate, radius), strict=True)
    conditions = _driving({name: value for name, value in given if value is not None}, find, body)
    found = _core.trim(compiled(model), conditions, _inputs(inputs))
    outputs = {name: value for name, value, _ in found.outputs}
    units = {name: unit for name, _, unit in found.outputs}
    return Trim(
        found.body,
        found.speed,
        found.yaw_rate,
        found.lateral_acceleration,
        found.sideslip,
        found.inputs,
        outputs,
        units,
    )


def _is_parameter(model: Model, name: str, value: float) -> bool:
    """Whether its file has such a parameter."""
    try:
        model._with({name: value})
    except InputError as error:
        return f"there is no parameter '{name}'" not in str(error)
    return True


def _varied(
    model: Model, name: str, value: float, driving: _core.TrimConditions | None, held: set[str]
) -> tuple[Literal["parameter", "input", "condition"], str]:
    """What `campbell` varies: "hold.NAME" is a held condition, "model.NAME" an input or a parameter. NAME alone is what
    the model has, else a condition; refused where the model has it and it is held, too."""
    if name.startswith("hold."):
        return "condition", _checks.known("condition of steady driving", name.removeprefix("hold."), _conditions)
    plain = name.removeprefix("model.")
    kind: Literal["parameter", "input"] = "input" if plain in model.inputs else "parameter"
    if plain != name or driving is None or plain not in _conditions:
        return kind, plain
    if kind == "parameter" and not _is_parameter(model, plain, value):
        return "condition", plain
    if plain in held:
        raise InputError(
            f"{plain}: the model has {'an' if kind == 'input' else 'a'} {kind} {plain!r}, and hold names that "
            f"condition; write 'hold.{plain}' for the condition, 'model.{plain}' for the {kind} of the model"
        )
    return kind, plain


def campbell(
    model: Model,
    parameter: str,
    values: npt.ArrayLike,
    *,
    speed: Literal["rad/s", "rpm", "Hz"] | None = None,
    orders: Sequence[float] = (1.0,),
    at: Point = None,
    hold: Mapping[str, float] | None = None,
    find: Sequence[str] | None = None,
    body: str | None = None,
    most: int | None = None,
    inputs: Mapping[str, float] | None = None,
    delay_order: int = 4,
    **method: Unpack[Method],
) -> CampbellDiagram:
    """Modes over a parameter, as `mimbre modes --over`; see `Model.campbell`."""
    word, time, driving = _driven_point(at, hold, find, body)
    name = _checks.text("parameter", parameter)
    wanted = _checks.array("values", values)
    if len(wanted) < 2 or not (np.diff(wanted) > 0).all():
        raise InputError("values: two or more values, each larger than the one before, are needed")
    unit = 0.0 if speed is None else _speeds[_checks.known("unit of speed", speed, _speeds)]
    held = compiled(model)
    kind, name = _varied(model, name, float(wanted[0]), driving, set(hold or ()))
    if kind == "condition":
        word, time, driving = _driven_point(at, {**(hold or {}), name: float(wanted[0])}, find, body)
    elif kind == "input" and driving is not None and name in driving.find:
        raise InputError(f"{parameter}: find looks for this input")

    def model_at(value: float) -> _core.Model:
        return compiled(model._with({name: value})) if kind == "parameter" else held

    found = _core.campbell(
        model_at,
        wanted.tolist(),
        name,
        unit,
        _checks.array("orders", orders).tolist(),
        checked_method(method),
        word,
        time,
        _inputs(inputs),
        name if kind == "input" else "",
        name if kind == "condition" else "",
        _most(most),
        _order(delay_order),
        driving,
    )
    return CampbellDiagram(
        name,
        np.array(found.values),
        [
            ModeBranch(text, np.array(lambdas), np.array(whirl), np.array(half_of, dtype=np.int64))
            for text, lambdas, whirl, half_of in found.branches
        ],
        [CriticalSpeed(*one) for one in found.criticals],
        [Onset(*one) for one in found.onsets],
        [Meeting(*one) for one in found.meetings],
        found.warnings,
    )

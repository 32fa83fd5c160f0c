"""Force laws that are functions: of Python, asked once a step, or compiled, inside the iteration."""

from __future__ import annotations

import ctypes
from _ctypes import CFuncPtr
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from . import _checks, _core
from .errors import InputError

if TYPE_CHECKING:
    from . import words

#: What `add_law` takes: a function of Python, of ctypes or of Numba, or an address.
Function = Callable[..., Any] | int

law_signature = f"void(float64, float64, {', '.join(['CPointer(float64)'] * 10)})"
"""For `numba.cfunc(mimbre.law_signature)`: time, step, x, v, signals, states → force, stiffness, damping, next, stored,
dissipating."""


@dataclass(frozen=True, eq=False)
class Law:
    """A force law of a builder: what stands where an expression could."""

    name: str
    function: Any
    address: int | None  #: of a compiled one
    signals: tuple[str, ...]
    states: tuple[float, ...]
    stores: bool
    between_frames: bool  #: six components at once

    @property
    def like(self) -> str:
        """Equal of laws that do the same."""
        return repr((id(self.function), self.address, self.signals, self.states, self.stores, self.between_frames))

    def made(self) -> _core.UserLaw:
        signals, states = list(self.signals), list(self.states)
        if self.address is None:
            return _core.sampled_law(self.name, self.function, signals, states)
        return _core.compiled_law(self.address, self.function, signals, states, self.stores)

    def __deepcopy__(self, memo: dict[int, Any]) -> Law:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        if self.address is not None:
            raise InputError(
                f"law '{self.name}': is compiled, and stands at an address of this process; another one has to build "
                "the model itself"
            )
        return Law, (
            self.name,
            self.function,
            self.address,
            self.signals,
            self.states,
            self.stores,
            self.between_frames,
        )


class Where(TypedDict, total=False):
    """Where a law acts: on a coordinate of a joint, or between two points, along their line, along or about an axis; a
    wrench between two frames, in axes `x`, `y`, `z` of the first."""

    joint: str
    coordinate: int
    between: words.Between
    at: Sequence[Any]
    along: words.Vector
    about: words.Vector
    x: words.Vector
    y: words.Vector
    z: words.Vector


#: A law where a model has it: the instance of a subsystem ("front_left.", or "" for the model), and the law.
Placed = tuple[str, Law]


def placed(laws: Sequence[Placed]) -> list[_core.PlacedLaw]:
    return [
        _core.PlacedLaw("bushing" if law.between_frames else "actuator", instance, law.name, law.made())
        for instance, law in laws
    ]


def refuse_in_file(laws: Sequence[Placed]) -> None:
    if laws:
        names = ", ".join(f"'{instance}{law.name}'" for instance, law in laws)
        raise InputError(f"to_yaml: a model file cannot hold a law that is a function: {names}")


def law(
    name: str,
    function: object,
    signals: Sequence[str],
    states: Sequence[float],
    stores: bool,
    between_frames: bool,
) -> Law:
    """Checks what a builder was given."""
    address = _address(function)
    if address is None and not callable(function):
        raise InputError(f"a function, of Python or a compiled one, is needed, not {_checks.described(function)}")
    if isinstance(signals, str):
        raise InputError(f"signals: a list of names is needed, not {_checks.described(signals)}")
    stored = _checks.flag("stores", stores)
    if address is None and stored:
        raise InputError("stores: belongs to compiled laws; what a function of Python does counts as work")
    names = tuple(_checks.text("signals", signal) for signal in signals)
    values = tuple(_checks.array("states", states).tolist())
    return Law(name, function, address, names, values, stored, between_frames)


def _address(function: Any) -> int | None:
    """Of a compiled function; None of one of Python."""
    if isinstance(function, CFuncPtr):
        address = ctypes.cast(function, ctypes.c_void_p).value or 0
    elif isinstance(function, int) and not isinstance(function, bool):
        address = function
    elif isinstance(getattr(function, "address", None), int):  # of Numba
        address = function.address
    else:
        return None
    if not _executable(address):
        raise InputError(f"there is no function at the address {address:#x}")
    return int(address)


def _executable(address: int) -> bool:
    for line in Path("/proc/self/maps").read_text(encoding="ascii", errors="replace").splitlines():
        span, rights = line.split()[:2]
        first, end = (int(number, 16) for number in span.split("-"))
        if "x" in rights and first <= address < end:
            return True
    return False

"""A model in motion, step by step."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypedDict, get_args

import numpy as np
import numpy.typing as npt

from . import _checks, _core
from .errors import InputError
from .real_time import Overrun, RealTime

if TYPE_CHECKING:
    from typing import Literal

    from typing_extensions import Self, Unpack

    from .model import Model


class Method(TypedDict, total=False):
    """How a model is computed, in place of the model's settings: further arguments of `run`, `simulation`, `static` and
    others (docs/model-file.md, `simulation`)."""

    step: float
    """s"""
    formulation: Literal["relative", "natural"]
    """Coordinates."""
    inertia: Literal["integrals", "projection", "projection_translations"]
    """Of flexible bodies."""
    formalism: Literal["index3", "index1", "baumgarte", "penalty", "index1_augmented", "independent"]
    """How constraints enter the equations."""
    integrator: Literal["generalized_alpha", "newmark", "hht", "conserve", "rk4", "dopri853"]
    """How steps are made."""
    rho: float
    """Of generalized_alpha (0 to 1) and hht (0.5 to 1): spectral radius, 1 damps nothing."""
    xi: float
    """Of newmark: 0, the trapezoidal rule, or less, which damps."""
    tolerance: float
    """Of the iterations of a step, relative."""
    accuracy: float
    """Of dopri853: error of each part of a step, relative to the mechanism's size; without it steps have no parts."""
    max_iterations: int
    """Of a step, or of each of its parts."""
    substeps: int
    """Parts in which a step is made again that an impact made inaccurate; 1: never."""
    fixed_cost: bool
    """For real time: each step is made once, and taken as it is after `max_iterations`."""


_checked: dict[str, Callable[[str, object], Any]] = {
    **dict.fromkeys(("step", "rho", "xi", "tolerance", "accuracy"), _checks.number),
    **dict.fromkeys(("max_iterations", "substeps"), _checks.whole),
    "fixed_cost": _checks.flag,
    **dict.fromkeys(("formulation", "inertia", "formalism", "integrator"), _checks.text),
}


def checked_method(method: Method) -> _core.Method:
    given: dict[str, Any] = {}
    for name, value in method.items():
        if name not in _checked:
            near = _core.did_you_mean(name, list(_checked))
            raise InputError(f"there is no option {name!r}{near}; there are: {', '.join(_checked)}")
        if value is not None:
            given[name] = _checked[name](name, value)
    return _core.method(**given)


def compiled(model: object) -> _core.Model:
    """What a model holds, or the error of what is none."""
    held = getattr(model, "_compiled", None)
    if not isinstance(held, _core.Model):
        raise InputError(f"model: a mimbre.Model is needed, not {_checks.described(model)}")
    return held


class Simulation(_core.Simulation):
    """A compiled model in motion. One thread at a time may use it; any number of simulations share a model.

    `step()` and `step_until()` leave the interpreter to other threads. What is asked for by name at every step is
    faster by handle: `throttle = sim.input("throttle")`, then `throttle.value = 0.5`; `z = sim.channel("chassis.z")`,
    then `z.value`; or many at once by `input_array` and `channel_array`.

    Args:
        model: what moves.
        inputs: what inputs and tunable parameters start with, by name, in place of the model's values; its
            equilibrium is that with them.
        **method: step and method in place of the model's, see `Method`.

    Raises:
        InputError: an option or an input that does not exist or does not fit, or no start was found.
        SimulationError: of `step` that it failed.

    Example:
        ```python
        sim = model.simulation(step=0.001)
        torque, angle = sim.input("torque"), sim.channel("angle")
        for _ in range(1000):
            torque.value = -20 * angle.value
            sim.step()
        ```
    """

    def __init__(self, model: Model, *, inputs: Mapping[str, float] | None = None, **method: Unpack[Method]) -> None:
        given = {} if inputs is None else _checks.mapping("inputs", inputs, "names with numbers")
        starts = {
            _checks.text("inputs", name): _checks.number(f"input {name!r}", value) for name, value in given.items()
        }
        super().__init__(compiled(model), checked_method(method), starts)
        self._model = model
        self._inputs = starts
        self._method = method

    @property
    def model(self) -> Model:
        """What moves."""
        return self._model

    def real_time(
        self,
        duration: float | None = None,
        *,
        each_step: Callable[[], object] | None = None,
        speed: float = 1,
        overrun: Overrun = "catch_up",
        lock_memory: bool = True,
        priority: int = 0,
        processor: int = -1,
        spin: float = 0,
        page: bool = False,
        port: int = 0,
        address: str = "127.0.0.1",
        token: str | None = None,
        record: str | os.PathLike[str] | None = None,
    ) -> RealTime:
        """Makes steps that begin at given times of the clock, for `duration` simulated seconds or until Ctrl-C, and
        returns how each kept its time.

        Args:
            duration: s, simulated; None: until Ctrl-C.
            each_step: called after each step. It reads from a `channel_array` and writes into an `input_array`;
                what it raises ends the loop. It takes the interpreter's time, some microseconds at least.
            speed: simulated seconds in one of the clock.
            overrun: when a step was not ready when the next one was due: the next ones begin at once
                ("catch_up"), the same without pictures and rows ("skip_output"), the clock is set back
                ("slow_down"), or it ends ("stop").
            lock_memory: memory stays in place, where that is permitted.
            priority: 1 to 99, of SCHED_FIFO, where that is permitted; 0: none.
            processor: the steps stay on it; -1: any.
            spin: s before a step in which is waited without sleeping.
            page: serves a page that shows and drives it; its address is printed.
            port: of the page; 0: one that is free.
            address: of the page; other than the loopback interface's, others can reach it, and need the token.
            token: what a viewer has to know; default: nothing, or a random one where others can reach the page.
            record: results file (HDF5).

        Raises:
            SimulationError: a step failed, or was not ready and overrun is "stop".
            InputError: an option that cannot be.

        Example:
            ```python
            sim = model.simulation(step=0.001)
            torque, angle = sim.input_array(["torque"]), sim.channel_array(["angle"])

            def controller():
                torque[0] = -20 * angle[0]

            kept = sim.real_time(10, each_step=controller)
            print(kept.computation.p9999, kept.overruns)
            ```
        """
        policies = get_args(Overrun)
        _checks.known("overrun", overrun, policies)
        told = self.clocked(
            math.inf if duration is None else _checks.number("duration", duration),
            _checks.number("speed", speed),
            policies.index(overrun),
            _checks.flag("lock_memory", lock_memory),
            _checks.whole("priority", priority),
            _checks.whole("processor", processor),
            _checks.number("spin", spin),
            each_step,
            _checks.whole("port", port) if page else None,
            _checks.text("address", address),
            _token(token),
            "" if record is None else _checks.path("record", record),
            lambda url: print(url, flush=True),
        )
        return RealTime.from_json(told)

    def pose(self, body: str) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Position (3, m) and rotation matrix (3 × 3, its columns the frame's axes) of a body's frame now, global."""
        position, rotation = self.pose_parts(_checks.text("body", body))
        return np.array(position), np.array(rotation).reshape(3, 3)

    def clone(self) -> Self:
        """Another simulation in the same state: both go on to the same bits. What was written into an `input_array`
        since the last step is not in it."""
        other = type(self)(self._model, inputs=self._inputs, **self._method)
        other.restore(self.save())
        return other

    def __copy__(self) -> Self:
        return self.clone()

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self.clone()

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (type(self), self._model, self._inputs, self._method, self.save())

    def __repr__(self) -> str:
        return f"<mimbre.Simulation of {self._model.title!r} at t = {self.time:g} s>"


def _token(given: str | None) -> str:
    token = "" if given is None else _checks.text("token", given)
    if given is not None and not token:
        raise InputError("token: is empty; None where nobody is to be asked for one")
    return token


def _unpickled(
    kind: type[Simulation], model: Model, inputs: Mapping[str, float], method: Method, state: bytes
) -> Simulation:
    simulation = kind(model, inputs=inputs, **method)
    simulation.restore(state)
    return simulation

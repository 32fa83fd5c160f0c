"""What is learnt on a model, and one try at it: the ground of mimbre.gym, which knows nothing of Gymnasium."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _checks
from .errors import InputError
from .model import Model
from .study import Value

if TYPE_CHECKING:
    from .method import Method
    from .simulation import Simulation

Floats = npt.NDArray[np.float64]
Bounds = tuple[float, float]

#: How a value is drawn as an episode begins: a tuple (low, high), one of a list, or by a function of the generator.
Draw = tuple[float, float] | list[Value] | Callable[[np.random.Generator], Value]


class Moment:
    """What a reward is made of: what is seen after the steps of an action, and this action."""

    __slots__ = ("_simulation", "action", "observation")

    def __init__(self, simulation: Simulation, observation: Floats, action: Floats) -> None:
        self._simulation = simulation
        self.observation = observation
        self.action = action

    @property
    def time(self) -> float:
        """s"""
        return self._simulation.time

    def __getitem__(self, channel: str) -> float:
        """Any channel of the model."""
        return self._simulation.channel(channel).value


#: A number of each moment: by a function, or a channel of the model (a signal is `"signal.NAME"`).
Number = Callable[[Moment], float] | str


@dataclass(frozen=True)
class Task:
    """What is done, seen and wanted."""

    model: Model
    method: Method
    actions: Mapping[str, Bounds]  #: inputs
    observations: Mapping[str, Bounds]  #: channels
    reward: Number
    terminate: Number | None
    failure_reward: float  #: where a step cannot be computed
    skip: int  #: steps of an action
    limit: int | None  #: actions of an episode
    draws: Mapping[str, Draw]  #: parameters and inputs
    step: float  #: s
    live: Mapping[str, Bounds]  #: inputs and tunable parameters, which need no model of their own

    def drawn(self, random: np.random.Generator, given: Mapping[str, object]) -> dict[str, Value]:
        """The values of an episode, `given` ones in place of those that are drawn. All are drawn, so that a given value
        does not change the others."""
        if not isinstance(given, Mapping):
            raise InputError(f"options: names with values are needed, not {_checks.described(given)}")
        values = {name: _one(name, draw, random) for name, draw in self.draws.items()}
        for name, value in given.items():
            if name in self.actions:
                raise InputError(f"options: {name!r} is an action")
            values[name] = _plain(name, value)
        for name, value in values.items():
            self.check(name, value)
        return values

    def check(self, name: str, value: object) -> None:
        """Whether an input or tunable parameter may have it."""
        low, high = self.live.get(name, (-math.inf, math.inf))
        if name in self.live and not low <= _checks.number(name, value) <= high:
            raise InputError(f"{name}: is {value!r}; a number from {low:g} to {high:g} is needed")


#: Observation, reward, whether it is over (ended, out of time), what else there is to say.
Outcome = tuple[Floats, float, bool, bool, dict[str, Any]]


class Episode:
    """A simulation that is begun again and again."""

    simulation: Simulation
    inputs: Floats  #: the actions' memory, which counts from the next step on

    def __init__(self, task: Task) -> None:
        self.task = task
        self._seen = [*task.observations, *(one for one in (task.reward, task.terminate) if isinstance(one, str))]
        self._of(task.model, {})
        self._start = self.simulation.save()
        self._own = True

    def _of(self, model: Model, inputs: Mapping[str, float]) -> None:
        self.simulation = model.simulation(inputs=inputs, **self.task.method)
        self._connect()

    def _connect(self) -> None:
        self.inputs = self.simulation.input_array(list(self.task.actions))
        self._channels = self.simulation.channel_array(self._seen)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name not in ("inputs", "_channels")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """A copy has memory of its own, which its own simulation looks at."""
        vars(self).update(state)
        self._connect()

    def begin(self, values: Mapping[str, Value]) -> tuple[Floats, dict[str, Any]]:
        """Starts anew with these parameters and inputs; what is seen then. Equilibria, events and what is sampled at
        the start depend on them, so that the start of other values is of no use."""
        task = self.task
        compiled = {name: value for name, value in values.items() if name not in task.live}
        live = {name: float(value) for name, value in values.items() if name in task.live}
        if values or not self._own:
            self._of(task.model._with(compiled) if compiled else task.model, live)
            self._own = not values
        else:
            self.simulation.restore(self._start)
        self._made = 0
        return self.observation(), ({"parameters": dict(values)} if values else {})

    def observation(self) -> Floats:
        return self._channels[: len(self.task.observations)].copy()

    def outcome(self, failure: str, action: Floats) -> Outcome:
        """Of the steps after `begin`, or of those since; `failure`: what went wrong with them."""
        task = self.task
        self._made += 1
        observation = self.observation()
        if failure:
            return observation, task.failure_reward, True, False, {"failure": failure}
        channel = len(task.observations)
        if isinstance(task.reward, str):
            reward = float(self._channels[channel])
            channel += 1
        else:
            reward = _number("reward", task.reward, Moment(self.simulation, observation, action))
        over = self.simulation.stopped
        if isinstance(task.terminate, str):
            over |= bool(self._channels[channel] != 0)
        elif task.terminate is not None:
            over |= bool(task.terminate(Moment(self.simulation, observation, action)))
        return observation, reward, over, task.limit is not None and self._made >= task.limit, {}


def task(
    model: Model,
    actions: Sequence[str] | Mapping[str, Bounds],
    observations: Sequence[str] | Mapping[str, Bounds],
    reward: Number,
    terminate: Number | None,
    failure_reward: float,
    time_limit: float | None,
    skip: int,
    randomise: Mapping[str, Draw] | None,
    method: Method,
) -> Task:
    """Checks what a user gave."""
    if not isinstance(model, Model):
        raise InputError(f"model: a mimbre.Model or a model file is needed, not {_checks.described(model)}")
    simulation = model.simulation(**method)
    ranges = {name: (simulation.input(name).min, simulation.input(name).max) for name in model.inputs}
    channels = simulation.channel_names()
    inputs = _bounded("actions", actions)
    for name, bounds in inputs.items():
        _checks.known("input or tunable parameter", name, ranges)
        low, high = bounds or ranges[name]
        if not (math.isfinite(low) and math.isfinite(high)):
            raise InputError(
                f"actions: the input {name!r} has no range; give it one in the model (range: [low, high]) or here, as "
                f"{{{name!r}: (low, high)}}"
            )
        inputs[name] = (low, high)
    seen = _bounded("observations", observations)
    for name in seen:
        _checks.known("channel", name, channels)
    for what, one in (("reward", reward), ("terminate", terminate)):
        if isinstance(one, str):
            _checks.known("channel", one, channels)
        elif not callable(one) and (one is not None or what == "reward"):
            raise InputError(f"{what}: a function or a channel's name is needed, not {_checks.described(one)}")
    count = _checks.number("skip", skip)
    if count != int(count) or count < 1:
        raise InputError(f"skip: is {count:g}; a whole number from 1 is needed")
    limit = None
    if time_limit is not None:
        limit = round(_checks.number("time_limit", time_limit) / (count * simulation.step_size))
        if limit < 1:
            raise InputError(
                f"time_limit: is {time_limit:g} s; at least the {count * simulation.step_size:g} s of an "
                "action are needed"
            )
    if randomise is not None and not isinstance(randomise, Mapping):
        raise InputError(f"randomise: names with ranges are needed, not {_checks.described(randomise)}")
    made = Task(
        model,
        method,
        {name: bounds for name, bounds in inputs.items() if bounds},
        {name: bounds or (-math.inf, math.inf) for name, bounds in seen.items()},
        reward,
        terminate,
        _checks.number("failure_reward", failure_reward),
        int(count),
        limit,
        dict(randomise or {}),
        simulation.step_size,
        ranges,
    )
    for name, draw in made.draws.items():
        if name in made.actions:
            raise InputError(f"randomise: {name!r} is an action")
        for value in draw if isinstance(draw, tuple | list) else ():
            made.check(name, value)
    Episode(made).begin(made.drawn(np.random.default_rng(0), {}))  # says what is wrong with them now
    return made


def _bounded(what: str, given: Any) -> dict[str, Bounds | None]:
    """Names, with their bounds where these are given."""
    if isinstance(given, Mapping):
        result: dict[str, Bounds | None] = {}
        for name, bounds in given.items():
            pair = bounds if isinstance(bounds, Sequence | np.ndarray) and len(bounds) == 2 else ("", "")
            low, high = (float(end) if isinstance(end, float | int | np.number) else math.nan for end in pair)
            if not low < high:
                raise InputError(f"{what}: {name!r}: (low, high) is needed, not {_checks.described(bounds)}")
            result[_checks.text(what, name)] = (low, high)
    elif isinstance(given, str) or not isinstance(given, Sequence):
        raise InputError(f"{what}: a list of names is needed, not {_checks.described(given)}")
    else:
        result = dict.fromkeys(_checks.text(what, name) for name in given)
        if len(result) < len(given):
            raise InputError(f"{what}: a name stands there twice")
    if not result:
        raise InputError(f"{what}: at least one is needed")
    return result


def _one(name: str, draw: Draw, random: np.random.Generator) -> Value:
    if callable(draw):
        return _plain(name, draw(random))
    if isinstance(draw, list) and draw:
        return _plain(name, draw[int(random.integers(len(draw)))])
    if isinstance(draw, tuple) and len(draw) == 2:
        low, high = (_checks.number(f"randomise: {name}", end) for end in draw)
        return float(random.uniform(low, high))
    raise InputError(
        f"randomise: {name}: (low, high), a list of values or a function of a generator is needed, not "
        f"{_checks.described(draw)}"
    )


def _plain(name: str, value: object) -> Value:
    if isinstance(value, np.generic):
        value = value.item()
    return value if isinstance(value, str | bool | int) else _checks.number(name, value)


def _number(what: str, function: Callable[[Moment], float], moment: Moment) -> float:
    value = function(moment)
    if not isinstance(value, float | int | np.floating | np.integer) or not math.isfinite(value):
        raise ValueError(f"{what}: at t = {moment.time:g} s its function gave {value!r}; a finite number is needed")
    return float(value)

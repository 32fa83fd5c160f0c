"""Models as environments of Gymnasium, one, or many at once by threads; `gymnasium` has to be installed.

env = mimbre.gym.make(
    "cart.yaml", actions=["force"], observations=["x", "angle"], reward=lambda now: -now["angle"] ** 2, time_limit=5
)
observation, info = env.reset(seed=1)
observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from . import _checks, _core
from .episode import Bounds, Draw, Episode, Floats, Moment, Number, Outcome, Task, task
from .errors import InputError
from .model import Model
from .picture import Picture
from .simulation import Simulation

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .method import Method

__all__ = ["Env", "Moment", "VectorEnv", "make", "make_vec"]

Bools = npt.NDArray[np.bool_]


def make(
    model: Model | str | os.PathLike[str],
    *,
    actions: Sequence[str] | Mapping[str, Bounds],
    observations: Sequence[str] | Mapping[str, Bounds],
    reward: Number,
    terminate: Number | None = None,
    failure_reward: float = 0.0,
    time_limit: float | None = None,
    skip: int = 1,
    randomise: Mapping[str, Draw] | None = None,
    render_mode: str | None = None,
    view: str = "xz",
    **method: Unpack[Method],
) -> Env:
    """An environment of a model, or of a model file.

    actions: inputs and tunable parameters, with the ranges of the model or {"force": (-10, 10)} narrower ones.
    observations: channels; as {"angle": (-4, 4)} their space has bounds.
    reward: a function of a Moment (`now.observation`, `now.action`, `now.time`, `now["any.channel"]`), or the name of a
        channel, as "signal.reward" of a signal of the model, which costs no Python.
    terminate: likewise; an episode ends where it is not 0. It also ends, terminated, at an event of the model with
        `stop: true`, in the midst of an action.
    failure_reward: of an action whose steps cannot be computed. Ends the episode; `info["failure"]` has the reason.
    time_limit: s, after which an episode is truncated.
    skip: steps of the simulation for one action.
    randomise: parameters and inputs that are drawn as an episode begins: (low, high), one of a list, or a function of
        the random generator. Inputs and tunable parameters are set; for others the model is compiled anew.
        `reset(options={"k": 2})` sets them; `info["parameters"]` has them.
    render_mode: "rgb_array", drawn by Matplotlib; `view`: its axes, to the right and up.
    method: step, formulation, integrator, … of `Model.simulation`."""
    what = _task(
        model, actions, observations, reward, terminate, failure_reward, time_limit, skip, randomise, dict(method)
    )
    return Env(what, render_mode, view)


def make_vec(
    model: Model | str | os.PathLike[str],
    num_envs: int,
    *,
    actions: Sequence[str] | Mapping[str, Bounds],
    observations: Sequence[str] | Mapping[str, Bounds],
    reward: Number,
    terminate: Number | None = None,
    failure_reward: float = 0.0,
    time_limit: float | None = None,
    skip: int = 1,
    randomise: Mapping[str, Draw] | None = None,
    autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
    threads: int | None = None,
    **method: Unpack[Method],
) -> VectorEnv:
    """So many environments of one model, stepped by threads (default: one for each core) without the interpreter. They
    give what `gymnasium.vector.SyncVectorEnv` of single ones gives, to the bit, however many threads there are. What is
    not explained here is as for `make`."""
    what = _task(
        model, actions, observations, reward, terminate, failure_reward, time_limit, skip, randomise, dict(method)
    )
    return VectorEnv(
        what,
        _whole("num_envs", num_envs),
        AutoresetMode(autoreset_mode),
        len(os.sched_getaffinity(0)) if threads is None else _whole("threads", threads),
    )


class Env(gymnasium.Env[Floats, Floats]):
    """One simulation of a model; see `make`."""

    def __init__(self, task: Task, render_mode: str | None, view: str) -> None:
        modes = ["rgb_array"]
        if render_mode is not None:
            _checks.known("render mode", render_mode, modes)
        if not isinstance(view, str) or len(view) != 2 or len(set(view) & set("xyz")) != 2:
            raise InputError(f"view: two of the axes x, y, z are needed, as 'xz', not {_checks.described(view)}")
        self.metadata = {"render_modes": modes, "render_fps": max(round(1 / (task.step * task.skip)), 1)}
        self.render_mode = render_mode
        self.action_space = _space(task.actions)
        self.observation_space = _space(task.observations)
        self._task = task
        self._episode = Episode(task)
        self._view = view
        self._picture: Picture | None = None
        self._begun = False

    @property
    def simulation(self) -> Simulation:
        """Of the episode."""
        return self._episode.simulation

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Floats, dict[str, Any]]:
        """Begins an episode. `options`: values of parameters and inputs, in place of those that are drawn."""
        super().reset(seed=seed)
        self._begun = True
        return self._episode.begin(self._task.drawn(self.np_random, options or {}))

    def step(self, action: Floats) -> Outcome:
        """Does it, keeping it within its space."""
        if not self._begun:
            raise gymnasium.error.ResetNeeded("the environment is stepped before it is reset")
        done = _actions(action, self.action_space)
        self._episode.inputs[:] = done
        (failure,) = _core.step_all([self._episode.simulation], self._task.skip)
        return self._episode.outcome(failure, done)

    def render(self) -> Any:
        if self.render_mode is None:
            return None
        if self._picture is None:
            self._picture = Picture(self._view)
        return self._picture.image(self._episode.simulation)


class VectorEnv(gymnasium.vector.VectorEnv[Floats, Floats, npt.NDArray[Any]]):
    """Many simulations of a model; see `make_vec`."""

    def __init__(self, task: Task, num_envs: int, autoreset_mode: AutoresetMode, threads: int) -> None:
        self.num_envs = num_envs
        self.metadata = {"render_modes": [], "autoreset_mode": autoreset_mode}
        self.single_action_space, self.single_observation_space = _space(task.actions), _space(task.observations)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._task = task
        self._mode = autoreset_mode
        self._episodes = [Episode(task) for _ in range(num_envs)]
        self._random: list[np.random.Generator | None] = [None] * num_envs
        self._threads = min(threads, num_envs)
        self._pool = ThreadPoolExecutor(self._threads, "mimbre-gym") if self._threads > 1 else None
        self._observations = np.zeros((num_envs, len(task.observations)))
        self._over: Bools | None = None  # which episodes have ended; None: none was begun

    def reset(
        self, *, seed: int | np.integer[Any] | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begins episodes, with a seed for each, or one and those that follow it. `options`: as for one; with
        "reset_mask" those that it selects."""
        alone = isinstance(seed, int | np.integer)
        seeds: Any = [int(seed) + k for k in range(self.num_envs)] if alone else seed  # type: ignore[arg-type]
        if seeds is not None and len(seeds) != self.num_envs:
            raise InputError(f"seed: {self.num_envs} are needed, one for each environment, not {len(seeds)}")
        if options is not None and not isinstance(options, Mapping):
            raise InputError(f"options: names with values are needed, not {_checks.described(options)}")
        values = dict(options or {})
        mask = np.asarray(values.pop("reset_mask", np.ones(self.num_envs, dtype=np.bool_)))
        if mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or (self._over is None and not mask.all()):
            raise InputError(f"reset_mask: {self.num_envs} truth values are needed, at first all true")
        if self._over is None:
            self._over = np.zeros(self.num_envs, dtype=np.bool_)
        infos: dict[str, Any] = {}
        for k in np.flatnonzero(mask).tolist():
            if seeds is not None and seeds[k] is not None:
                self._random[k] = seeding.np_random(seeds[k])[0]
            infos = self._begin(k, infos, values)
        self._over[mask] = False
        return self._observations.copy(), infos

    def step(self, actions: Floats) -> tuple[Floats, npt.NDArray[Any], Bools, Bools, dict[str, Any]]:
        """Does one action in each; an episode that ended is begun again by the autoreset mode."""
        if self._over is None:
            raise gymnasium.error.ResetNeeded("the environments are stepped before they are reset")
        done = _actions(actions, self.action_space)
        rewards = np.zeros(self.num_envs)
        terminated, truncated = np.zeros((2, self.num_envs), dtype=np.bool_)
        infos: dict[str, Any] = {}
        if self._mode is AutoresetMode.DISABLED and self._over.any():
            raise gymnasium.error.ResetNeeded("episodes have ended; reset them: options={'reset_mask': ...}")
        going = np.flatnonzero(~self._over).tolist()
        failures = dict(zip(going, self._stepped(going, done), strict=True))
        for k in range(self.num_envs):
            if k not in failures:
                infos = self._begin(k, infos, {})
                continue
            outcome = self._episodes[k].outcome(failures[k], done[k])
            self._observations[k], rewards[k], terminated[k], truncated[k], info = outcome
            if self._mode is AutoresetMode.SAME_STEP and (terminated[k] or truncated[k]):
                infos = self._add_info(infos, {"final_obs": outcome[0], "final_info": info}, k)
                info = {}
                infos = self._begin(k, infos, {})
            infos = self._add_info(infos, info, k)
        self._over = (terminated | truncated) & (self._mode is not AutoresetMode.SAME_STEP)
        return self._observations.copy(), rewards, terminated, truncated, infos

    def _begin(self, k: int, infos: dict[str, Any], values: Mapping[str, object]) -> dict[str, Any]:
        random = self._random[k]
        if random is None:
            random = self._random[k] = seeding.np_random()[0]
        self._observations[k], info = self._episodes[k].begin(self._task.drawn(random, values))
        return self._add_info(infos, info, k)

    def _stepped(self, which: Sequence[int], actions: Floats) -> list[str]:
        """What went wrong with each of these."""
        for k in which:
            self._episodes[k].inputs[:] = actions[k]
        simulations: list[_core.Simulation] = [self._episodes[k].simulation for k in which]
        if self._pool is None:
            return _core.step_all(simulations, self._task.skip)
        share = -(-len(simulations) // self._threads) or 1
        parts = [simulations[k : k + share] for k in range(0, len(simulations), share)]
        results = self._pool.map(_core.step_all, parts, [self._task.skip] * len(parts))
        return [failure for part in results for failure in part]

    def close_extras(self, **_: Any) -> None:
        if self._pool is not None:
            self._pool.shutdown()


def _task(model: Model | str | os.PathLike[str], *said: Any) -> Task:
    return task(model if isinstance(model, Model) else Model.from_file(model), *said)


def _space(bounds: Mapping[str, Bounds]) -> gymnasium.spaces.Box[np.float64]:
    low, high = np.array(list(bounds.values())).T
    return gymnasium.spaces.Box(low, high, dtype=np.float64)


def _actions(given: object, space: gymnasium.spaces.Space[Any]) -> Floats:
    assert isinstance(space, gymnasium.spaces.Box)
    values = _checks.array("action", given, len(space.shape))
    if values.shape != space.shape:
        raise InputError(f"action: an array of shape {space.shape} is needed, not of {values.shape}")
    return np.clip(values, space.low, space.high)


def _whole(what: str, given: object) -> int:
    value = _checks.number(what, given)
    if value != int(value) or value < 1:
        raise InputError(f"{what}: is {value:g}; a whole number from 1 is needed")
    return int(value)

"""Equilibria under loads that grow: buckling loads, and what becomes of a mechanism beyond them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from . import _checks, _core
from .errors import InputError
from .run import Floats
from .simulation import compiled

if TYPE_CHECKING:
    from .model import Model


@dataclass(frozen=True)
class BucklingMode:
    """A factor of the loads at which the equilibrium ceases to be stable."""

    factor: float
    """Of the given loads; negative: in the opposite direction."""
    text: str
    """Coordinates with their shares of the elastic energy."""
    shape: dict[str, float]
    """By coordinate, of an elastic energy of 1 J."""


@dataclass(frozen=True)
class Buckling:
    """Buckling loads: `buckling[0].factor` is the one nearest to zero."""

    loads: list[str]
    """That grow together: names, or "gravity"."""
    modes: list[BucklingMode]
    """Those nearest to zero first."""
    nonlinear: float
    """Share of the stiffness that is not linear in the loads, at a hundredth of the first factor."""
    warnings: list[str]
    """What was suspicious."""

    def __getitem__(self, number: int) -> BucklingMode:
        return self.modes[number]

    def __len__(self) -> int:
        return len(self.modes)


@dataclass(frozen=True)
class SpecialEquilibrium:
    """A limit point or a bifurcation of a path."""

    point: int
    """Its place among the points of the branch."""
    kind: str
    """ "limit": the factor is largest or smallest there; "bifurcation": another path crosses."""
    moving: str
    """Coordinates with their shares of the motion there."""


@dataclass(frozen=True)
class PathBranch:
    """Equilibria one after the other: `branch["tip.z"]` are the values of an output."""

    parent: int
    """The branch that it leaves; -1: none."""
    leaves_at: float
    """Factor there."""
    sense: int
    """1: along the motion at the bifurcation, -1: against it, 0: no branch."""
    factors: Floats
    """Of the loads."""
    outputs: dict[str, Floats]
    """Values of the model's outputs, by name; of its joints' coordinates where it has none."""
    unstable: list[int]
    """By point: in how many independent directions the stiffness is negative; 0: stable."""
    special: list[SpecialEquilibrium]
    """Limit points and bifurcations."""
    end: str
    """Why there are no more points; empty: the last factor is reached."""

    def __getitem__(self, name: str) -> Floats:
        return self.outputs[_checks.known("output", name, self.outputs)]


@dataclass(frozen=True)
class EquilibriumPath:
    """Equilibria under growing loads: `path[0]` is the branch that begins with the first factor."""

    loads: list[str]
    """That grow together: names, or "gravity"."""
    branches: list[PathBranch]
    """The first, then those of bifurcations."""
    units: dict[str, str]
    """Of the outputs."""
    warnings: list[str]
    """What was suspicious."""

    def __getitem__(self, number: int) -> PathBranch:
        return self.branches[number]

    def __len__(self) -> int:
        return len(self.branches)


def buckling(
    model: Model, *, loads: Sequence[str] = (), count: int = 3, inputs: Mapping[str, float] | None = None
) -> Buckling:
    """See `Model.buckling`."""
    most = _checks.whole("count", count)
    if most < 1:
        raise InputError(f"count: is {most}; at least 1 is needed")
    found = _core.buckling(compiled(model), _checks.names("loads", loads), most, _values(inputs))
    modes = [
        BucklingMode(factor, text, dict(zip(found.coordinates, shape.tolist(), strict=True)))
        for factor, text, shape in found.modes
    ]
    return Buckling(found.loads, modes, found.nonlinear, found.warnings)


def equilibrium_path(
    model: Model,
    *,
    loads: Sequence[str] = (),
    start: float = 0,
    end: float = 1,
    points: int = 200,
    bifurcations: int = 1,
    inputs: Mapping[str, float] | None = None,
    progress: Callable[[float, int], object] | None = None,
) -> EquilibriumPath:
    """See `Model.equilibrium_path`."""
    most, followed = _checks.whole("points", points), _checks.whole("bifurcations", bifurcations)
    if followed < 0:
        raise InputError(f"bifurcations: is {followed}; 0 or more are needed")
    found = _core.equilibrium_path(
        compiled(model),
        _checks.names("loads", loads),
        _checks.number("start", start),
        _checks.number("end", end),
        most,
        followed,
        _values(inputs),
        _checks.callback(progress),
    )
    shown = [(k, *found.channels[k]) for k in found.shown]
    branches = []
    for branch in found.branches:
        values = branch.values
        outputs = {name: np.ascontiguousarray(values[:, k]) for k, name, _ in shown}
        special = [
            SpecialEquilibrium(point, "limit" if limit else "bifurcation", moving)
            for point, limit, moving in branch.special
        ]
        branches.append(
            PathBranch(
                branch.parent,
                branch.leaves_at,
                branch.sense,
                branch.factors,
                outputs,
                branch.unstable,
                special,
                branch.end,
            )
        )
    return EquilibriumPath(found.loads, branches, {name: unit for _, name, unit in shown}, found.warnings)


def _values(inputs: Mapping[str, float] | None) -> dict[str, float]:
    given = _checks.mapping("inputs", inputs or {}, "a number for each name")
    return {name: _checks.number(f"inputs: {name}", value) for name, value in given.items()}

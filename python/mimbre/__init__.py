"""Flexible multibody systems in real time.

    model = mimbre.Model.from_file("pendulum.yaml")
    run = model.run(until=5)
    run["angle"], run.time

SI units and radians throughout."""

from . import _isolation as _isolation  # before anybody else uses the compiled module
from ._core import version as _version
from .analysis import (
    Apart,
    Difference,
    Equilibrium,
    HotSpot,
    InertiaChoice,
    InertiaTerm,
    Mode,
    Selection,
    StressHistory,
    Verification,
    compare,
    convert,
    inertia_terms,
    report,
    select,
    static,
    stress,
    stress_history,
)
from .builder import ModelBuilder, Subsystem
from .ensemble import samples, sweep
from .equilibria import Buckling, BucklingMode, EquilibriumPath, PathBranch, SpecialEquilibrium
from .errors import Diagnostic, InputError, Interrupted, SimulationError, SweepInterrupted, UnknownName
from .laws import law_signature
from .linear import CampbellDiagram, CriticalSpeed, EigenMode, LinearModel, Meeting, ModeBranch, Modes, Onset, Trim
from .model import Model
from .motion import InverseDynamics, Kinematics, SpecialPosition
from .reduction import Check, Interface, ReducedBody, reduce
from .run import Channel, Run
from .simulation import Simulation

__version__ = _version()

__all__ = [
    "Apart",
    "Buckling",
    "BucklingMode",
    "CampbellDiagram",
    "Channel",
    "Check",
    "CriticalSpeed",
    "Diagnostic",
    "Difference",
    "EigenMode",
    "Equilibrium",
    "EquilibriumPath",
    "HotSpot",
    "InertiaChoice",
    "InertiaTerm",
    "InputError",
    "Interface",
    "Interrupted",
    "InverseDynamics",
    "Kinematics",
    "LinearModel",
    "Meeting",
    "Mode",
    "ModeBranch",
    "Model",
    "ModelBuilder",
    "Modes",
    "Onset",
    "PathBranch",
    "ReducedBody",
    "Run",
    "Selection",
    "Simulation",
    "SimulationError",
    "SpecialEquilibrium",
    "SpecialPosition",
    "StressHistory",
    "Subsystem",
    "SweepInterrupted",
    "Trim",
    "UnknownName",
    "Verification",
    "compare",
    "convert",
    "inertia_terms",
    "law_signature",
    "reduce",
    "report",
    "samples",
    "select",
    "static",
    "stress",
    "stress_history",
    "sweep",
]

"""Exudyn's solvers without files, sensors and messages; the CPU time of their steps."""

import sys
import time

sys.exudynFast = True  # its build without checks of ranges, with AVX2

import exudyn as exu  # noqa: E402

VERSION = exu.__version__
exu.config.suppressWarnings = True


def settings(
    end: float,
    step: float,
    *,
    rho: float = 0.9,
    tolerance: float = 1e-8,
    sparse: bool = True,
    modified: bool = True,
) -> exu.SimulationSettings:
    chosen = exu.SimulationSettings()
    steps = chosen.timeIntegration
    steps.numberOfSteps, steps.endTime, steps.verboseMode = round(end / step), end, 0
    steps.generalizedAlpha.spectralRadius = rho
    steps.newton.useModifiedNewton = modified
    steps.newton.relativeTolerance, steps.newton.absoluteTolerance = tolerance, 1e-2 * tolerance
    chosen.solution.file.write = False
    chosen.solution.sensors.active = False
    chosen.parallel.numberOfThreads = 1
    solvers = exu.LinearSolverType
    chosen.linearSolver.solverType = solvers.EigenSparse if sparse else solvers.EXUdense
    chosen.linearSolver.reuseAnalyzedPattern = sparse
    return chosen


def implicit(mbs: exu.MainSystem, chosen: exu.SimulationSettings) -> float:
    """Steps by generalised-alpha; their CPU time."""
    return steps_of(exu.MainSolverImplicitSecondOrder(), mbs, chosen)


def explicit(mbs: exu.MainSystem, chosen: exu.SimulationSettings, rule: str) -> float:
    """Steps by an explicit rule; their CPU time."""
    chosen.timeIntegration.explicitIntegration.dynamicSolverType = getattr(exu.DynamicSolverType, rule)
    return steps_of(exu.MainSolverExplicit(), mbs, chosen)


def steps_of(solver: object, mbs: exu.MainSystem, chosen: exu.SimulationSettings) -> float:
    solver.InitializeSolver(mbs, chosen)
    begin = time.process_time()
    try:
        done = solver.SolveSteps(mbs, chosen)
    except MemoryError:  # where a step has diverged
        done = False
    seconds = time.process_time() - begin
    solver.FinalizeSolver(mbs, chosen)
    if not done:
        raise RuntimeError("Exudyn's solver failed")
    return seconds

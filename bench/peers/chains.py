"""Open chains of rigid links in all codes."""

import importlib
from collections.abc import Callable
from functools import partial

import numpy as np
from chain import chain
from loading import timed
from program import Program
from runner import Case, Runner, end_only, optional

EXACT = ["--integrator", "dopri853", "--accuracy", "1e-12", "--step", "0.01"]
END = {10: 2.0, 100: 0.5, 1000: 0.1, 10000: 0.01}  # s
STEPS = {
    10: (0.04, 0.02, 0.01, 0.005, 0.002),
    100: (0.05, 0.02, 0.01, 0.005, 0.0025),
    1000: (0.01, 0.005, 0.0025),
    10000: (0.005, 0.0025),
}


def case(program: Program, n: int) -> Case:
    name, end, steps = f"chain-{n}.yaml", END[n], STEPS[n]
    (program.folder / name).write_text(chain(n))
    columns, times = ["x", "y", "z"], np.array([end])
    exact = program.outputs(name, columns, times, EXACT if n <= 1000 else ["--step", "6.25e-4"])

    def own(options: str, steps: tuple[float, ...]) -> Runner:
        return program.runner(name, columns, times, options, steps)

    if n > 1000:
        return longest(program, n, exact, own("", steps))
    runners = [own("", steps), own("--integrator rk4", steps)]
    long = tuple(step for step in (0.2, 0.1, 0.05, 0.025, 0.0125) if step <= end)
    runners.append(own("--integrator dopri853", long))
    runners += [own(f"--integrator dopri853 --accuracy {a}", (min(end, 0.1),)) for a in ("1e-4", "1e-6", "1e-8")]
    peers = (in_exudyn, in_mujoco, in_pinocchio, in_drake)
    runners += optional([lambda peer=peer: peer(n, end, steps) for peer in peers])
    return finished(program, n, exact, runners)


def longest(program: Program, n: int, exact: np.ndarray, own: Runner) -> Case:
    """Exudyn's steps take many seconds, MuJoCo's compiler minutes, and Pinocchio's data has full matrices."""
    runners = [own, *optional([lambda: in_drake(n, END[n], STEPS[n])])]
    return finished(program, n, exact, runners)


def finished(program: Program, n: int, exact: np.ndarray, runners: list[Runner]) -> Case:
    loading = {"mimbre": lambda: program.loading(f"chain-{n}.yaml")}
    for code in dict.fromkeys(runner.code for runner in runners if runner.code != "mimbre"):
        build = importlib.import_module(f"chain_in_{code.lower()}").build
        loading[code] = lambda build=build: timed(lambda: build(n))
    what = f"position of the tip after {END[n]:g} s"
    return Case(f"chain of {n} links", what, "m", exact, runners, loading if n >= 1000 else None)


def finest(n: int, steps: tuple[float, ...]) -> float:
    """Step of a peer's own converged run; of the longest chains, where it takes long, half the shortest."""
    return min(steps) / (2 if n >= 1000 else 4)


def in_exudyn(n: int, end: float, steps: tuple[float, ...]) -> list[Runner]:
    import chain_in_exudyn
    import exudyn_solver

    def runner(settings: str, steps: tuple[float, ...], fine: float, run: Callable) -> Runner:
        return Runner("Exudyn", exudyn_solver.VERSION, settings, steps, **end_only(run), finest=fine)

    few = (max(steps),) if n == 1000 else steps  # a step of its tree takes long
    fine = max(steps) / 2 if n == 1000 else finest(n, steps)
    sparse = n > 10
    tree = runner(
        f"kinematic tree, RK44, {'sparse' if sparse else 'dense'}",
        few,
        fine,
        lambda h: chain_in_exudyn.run(n, "RK44", end, h, sparse=sparse),
    )
    runners = [tree]
    if n < 1000:
        higher = partial(chain_in_exudyn.run, n, "RK67", end, sparse=sparse)
        runners.append(runner(f"kinematic tree, RK67, {'sparse' if sparse else 'dense'}", few, fine, higher))
    # Three angles are faster, but singular in positions that only the longest chain does not reach.
    rotation = "RotationRxyz" if n == 1000 else "RotationEulerParameters"
    for tolerance in (1e-3, 1e-5):
        options = {"rho": 0.9, "tolerance": tolerance}
        said = f"generalised-alpha 0.9, modified Newton, tolerance {tolerance:g}"
        if n == 10:
            run = partial(chain_in_exudyn.run, n, "generalised-alpha", end, sparse=False, **options)
            runners.append(runner(f"kinematic tree, {said}, dense", steps, finest(n, steps), run))
        run = partial(chain_in_exudyn.run_bodies, n, rotation, end, **options)
        runners.append(runner(f"bodies and joints, {rotation}, {said}, sparse", steps, finest(n, steps), run))
    return runners


def in_mujoco(n: int, end: float, steps: tuple[float, ...]) -> list[Runner]:
    import chain_in_mujoco

    model = chain_in_mujoco.build(n)

    def runner(integrator: str) -> Runner:
        both = end_only(lambda step: chain_in_mujoco.run(model, integrator, end, step))
        return Runner("MuJoCo", chain_in_mujoco.VERSION, integrator, steps, **both, finest=finest(n, steps))

    return [runner(integrator) for integrator in (["RK4"] if n == 1000 else ["RK4", "Euler", "implicitfast"])]


def in_pinocchio(n: int, end: float, steps: tuple[float, ...]) -> list[Runner]:
    import chain_in_pinocchio

    if n > 100:  # the data of 1000 links takes more than 9 GB
        return []
    model = chain_in_pinocchio.build(n)
    return [
        Runner(
            "Pinocchio",
            chain_in_pinocchio.VERSION,
            "aba, RK4: time of the evaluations alone",
            steps,
            lambda step: chain_in_pinocchio.tip(model, end, step)[None],
            lambda step: chain_in_pinocchio.seconds(model, end, step),
            finest(n, steps),
        )
    ]


def in_drake(n: int, end: float, steps: tuple[float, ...]) -> list[Runner]:
    import chain_in_drake

    plant = chain_in_drake.build(n)

    def runner(scheme: str) -> Runner:
        both = end_only(lambda step: chain_in_drake.run(plant, n, scheme, end, step))
        return Runner("Drake", chain_in_drake.VERSION, f"continuous, {scheme}", steps, **both, finest=finest(n, steps))

    return [runner("runge_kutta3"), runner("runge_kutta5")]

"""Ladders of four-bar loops in all codes."""

import importlib

import numpy as np
from ladder_model import exact, model_file
from loading import timed
from program import Program
from runner import Case, Runner, difference, end_only, optional

END = {2: 5.0, 10: 1.0, 100: 1.0, 1000: 0.5}  # s
STEPS = (0.01, 0.005, 0.0025)
LONG = (0.1, 0.05, 0.02, 0.01)  # of rules of a higher order


def case(program: Program, n: int) -> Case:
    name, times = f"ladder-{n}.yaml", np.array([END[n]])
    (program.folder / name).write_text(model_file(n))
    columns = ["x", "y"]
    reference = exact(n, END[n])
    if n < 1000:
        fine = program.outputs(name, columns, times, ["--step", "2e-4"])
        print(f"ladder of {n}: mimbre with steps of 0.2 ms differs from the equation of the angle by", end=" ")
        print(f"{difference(fine, reference):.1e} m", flush=True)
    options = ("", "--formulation natural") if n < 1000 else ("",)
    runners = [program.runner(name, columns, times, option, STEPS) for option in options]
    for rule, steps in (("rk4", LONG), ("dopri853", LONG[:2])):
        runners.append(program.runner(name, columns, times, f"--integrator {rule}", steps if n < 1000 else LONG[:2]))
    peers = (in_exudyn, in_mujoco, in_pinocchio, in_drake)
    runners += optional([lambda peer=peer: peer(n) for peer in peers])
    loading = {"mimbre": lambda: program.loading(name)}
    for code in {runner.code for runner in runners} & {"Exudyn", "MuJoCo"}:
        build = importlib.import_module(f"ladder_in_{code.lower()}").build
        loading[code] = lambda build=build: timed(lambda: build(n))
    title = "double four-bar mechanism" if n == 2 else f"ladder of {n} four-bar loops"
    what = f"position of the last head after {END[n]:g} s"
    return Case(title, what, "m", reference, runners, loading if n == 1000 else None)


def in_exudyn(n: int) -> list[Runner]:
    import exudyn_solver
    import ladder_in_exudyn

    def runner(rho: float, tolerance: float) -> Runner:
        options = {"rho": rho, "tolerance": tolerance, "sparse": n > 2}
        said = f"generalised-alpha {rho}, modified Newton, tolerance {tolerance:g}, {'sparse' if n > 2 else 'dense'}"
        both = end_only(lambda step: ladder_in_exudyn.run(n, END[n], step, **options))
        finest = min(STEPS) / 4
        return Runner("Exudyn", exudyn_solver.VERSION, said, STEPS, **both, finest=finest)

    return [runner(rho, tolerance) for rho in (0.6, 0.9) for tolerance in (1e-5, 1e-3)]


def in_mujoco(n: int) -> list[Runner]:
    import ladder_in_mujoco

    model = ladder_in_mujoco.build(n)

    def runner(integrator: str, steps: tuple[float, ...], ratio: float) -> Runner:
        both = end_only(lambda step: ladder_in_mujoco.run(model, integrator, END[n], step, ratio))
        said = f"{integrator}, soft loops with a time constant of {ratio:g} steps and an impedance of 0.9999"
        return Runner("MuJoCo", ladder_in_mujoco.VERSION, said, steps, **both, finest=min(steps) / 4)

    chosen = [("RK4", LONG[2:] if n < 1000 else LONG[1:3]), ("Euler", (*LONG[1:3], *STEPS))]
    return [runner(integrator, steps, ratio) for integrator, steps in chosen for ratio in (2.0, 4.0)]


def in_pinocchio(n: int) -> list[Runner]:
    import ladder_in_pinocchio

    if n > 100:  # an evaluation takes the cube of the loops
        return []
    ladder = ladder_in_pinocchio.Ladder(n)
    steps = LONG[:3] if n == 100 else LONG
    return [
        Runner(
            "Pinocchio",
            ladder_in_pinocchio.VERSION,
            "constraintDynamics, Baumgarte 20/s, RK4: time of the evaluations alone",
            steps,
            lambda step: ladder.position(END[n], step)[None],
            lambda step: ladder.seconds(END[n], step),
            min(steps) / (2 if n == 100 else 4),
        )
    ]


def in_drake(n: int) -> list[Runner]:
    import ladder_in_drake

    if n > 100:
        return []
    steps = STEPS if n < 100 else STEPS[:2]
    both = end_only(lambda step: ladder_in_drake.run(n, END[n], step))
    said = "discrete, SAP, ball constraints, which are nearly rigid"
    return [Runner("Drake", ladder_in_drake.VERSION, said, steps, **both, finest=min(steps) / 4)]

"""The spin-up beam in the plane in mimbre and Exudyn."""

import pathlib

import numpy as np
from program import Program
from runner import Case, Runner, optional

MODEL = str(pathlib.Path(__file__).resolve().parents[2] / "examples/spin-up-beam/beam-2d.yaml")
END, STEPS = 20.0, (0.02, 0.01, 0.005)
TIMES = np.arange(1, 201) * (END / 200)


def case(program: Program) -> Case:
    columns = ["tip.ux", "tip.uy"]
    fine = "--set method=ancf --set elements=40 --step 2e-3 --tolerance 1e-8"
    reference = program.outputs(MODEL, columns, TIMES, fine.split())
    methods = ["method=foreshortening", "method=ancf", "method=nonlinear_beam"]
    runners = [program.runner(MODEL, columns, TIMES, f"--set {method}", STEPS) for method in methods]
    runners.append(program.runner(MODEL, columns, TIMES, "", STEPS))
    runners += optional([in_exudyn])
    return Case("spin-up beam in the plane", f"displacement of the tip, mean over {END:g} s", "m", reference, runners)


def in_exudyn() -> list[Runner]:
    import beam_in_exudyn
    import exudyn_solver

    def runner(elements: int, rho: float, tolerance: float) -> Runner:
        options = {"rho": rho, "tolerance": tolerance, "sparse": False, "modified": False}
        return Runner(
            "Exudyn",
            exudyn_solver.VERSION,
            f"{elements} ANCF cables, generalised-alpha {rho}, full Newton, tolerance {tolerance:g}, dense",
            STEPS,
            lambda step: beam_in_exudyn.displacements(elements, TIMES, step, **options),
            lambda step: beam_in_exudyn.seconds(elements, END, step, **options),
            min(STEPS) / 4,
        )

    settings = [(10, rho, tolerance) for rho in (0.6, 0.9) for tolerance in (1e-5, 1e-3)]
    return [runner(*chosen) for chosen in (*settings, (20, 0.9, 1e-5))]

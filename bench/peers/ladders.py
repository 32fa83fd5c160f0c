"""Ladders of four-bar loops in mimbre and Exudyn."""

import numpy as np
from ladder_model import exact, model_file
from loading import timed
from program import Program
from runner import Case, Runner, difference, end_only, optional

END = {2: 5.0, 10: 1.0, 100: 1.0, 1000: 0.5}  # s
STEPS = (0.01, 0.005, 0.0025)


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
    runners += optional([lambda: in_exudyn(n)])
    loading = {"mimbre": lambda: program.loading(name)}
    if runners[-1].code == "Exudyn":
        from ladder_in_exudyn import build

        loading["Exudyn"] = lambda: timed(lambda: build(n))
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

"""The vehicle on stairs, all rigid, its links without mass, in mimbre and Exudyn."""

import pathlib

import numpy as np
from program import Program
from runner import Case, Runner, optional

MODEL = str(pathlib.Path(__file__).resolve().parents[2] / "examples/iltis/vehicle.yaml")
RIGID = "--set arms=rigid --set links=rigid --set rods=rigid --set massless_links=true"
TIMES = np.arange(500, 801) * 0.01  # the last three seconds, after the last stair
STEPS = (0.02, 0.01, 0.005, 0.002)


def case(program: Program, stairs: float) -> Case:
    options, columns = f"{RIGID} --set stairs={stairs}", ["chassis.z"]
    reference = program.outputs(MODEL, columns, TIMES, [*options.split(), "--step", "1e-4"])
    runners = [program.runner(MODEL, columns, TIMES, options, STEPS)]
    runners += optional([lambda: in_exudyn(stairs)])
    name = f"rigid vehicle on stairs of {stairs:g} m"
    return Case(name, "height of the chassis, mean over the last 3 of 8 s", "m", reference, runners)


def in_exudyn(stairs: float) -> list[Runner]:
    import exudyn_solver
    import vehicle_in_exudyn

    def runner(rho: float, tolerance: float) -> Runner:
        options = {"rho": rho, "tolerance": tolerance}
        return Runner(
            "Exudyn",
            exudyn_solver.VERSION,
            f"distances for links, generalised-alpha {rho}, modified Newton, tolerance {tolerance:g}, sparse",
            STEPS,
            lambda step: vehicle_in_exudyn.heights(stairs, TIMES, step, **options),
            lambda step: vehicle_in_exudyn.seconds(stairs, float(TIMES[-1]), step, **options),
            min(STEPS) / 4,
        )

    return [runner(rho, tolerance) for rho in (0.3, 0.9) for tolerance in (1e-5, 1e-3)]

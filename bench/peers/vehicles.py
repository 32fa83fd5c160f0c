"""The Iltis on stairs and its single suspension in mimbre and Exudyn, rigid or flexible."""

import pathlib

import numpy as np
from program import Program
from runner import Case, Runner, optional

MODELS = pathlib.Path(__file__).resolve().parents[2] / "examples/iltis"
RIGID = "--set arms=rigid --set links=rigid --set rods=rigid --set massless_links=true"
ON_STAIRS = np.arange(500, 801) * 0.01  # the last three seconds, after the last stair
SUSPENSION = np.arange(1, 501) * 0.01
STEPS = (0.02, 0.01, 0.005, 0.002)
FINE = ["--step", "1e-4"]


def case(program: Program, stairs: float, flexible: bool) -> Case:
    options = f"--set stairs={stairs}" if flexible else f"{RIGID} --set stairs={stairs}"
    name = f"{'flexible' if flexible else 'rigid'} vehicle on stairs of {stairs:g} m"
    what = "height of the chassis, mean over the last 3 of 8 s"
    return compared(program, "vehicle.yaml", options, ON_STAIRS, name, what, flexible, stairs)


def suspension(program: Program, flexible: bool) -> Case:
    name = f"{'flexible' if flexible else 'rigid'} suspension, the road drops by 0.2 m"
    what = "height of the chassis, mean over 5 s"
    return compared(program, "suspension.yaml", "" if flexible else RIGID, SUSPENSION, name, what, flexible, None)


def compared(
    program: Program,
    file: str,
    options: str,
    times: np.ndarray,
    name: str,
    what: str,
    flexible: bool,
    stairs: float | None,
) -> Case:
    model, columns = str(MODELS / file), ["chassis.z"]
    reference = program.outputs(model, columns, times, [*options.split(), *FINE])
    runners = [program.runner(model, columns, times, options, STEPS)]
    runners += optional([lambda: in_exudyn(times, flexible, stairs)])
    return Case(name, what, "m", reference, runners)


def in_exudyn(times: np.ndarray, flexible: bool, stairs: float | None) -> list[Runner]:
    """The vehicle, or without stairs the single suspension."""
    import exudyn_solver
    import vehicle_in_exudyn as exudyn

    def build() -> object:
        if stairs is None:
            return exudyn.single_suspension(flexible)
        return exudyn.on_stairs(stairs, flexible)

    bodies = "reduced bodies in floating frames" if flexible else "distances for links"
    sparse = stairs is not None

    def runner(rho: float, tolerance: float) -> Runner:
        options = {"rho": rho, "tolerance": tolerance, "sparse": sparse}
        said = f"generalised-alpha {rho}, modified Newton, tolerance {tolerance:g}, {'sparse' if sparse else 'dense'}"
        return Runner(
            "Exudyn",
            exudyn_solver.VERSION,
            f"{bodies}, {said}",
            STEPS,
            lambda step: exudyn.heights(build(), times, step, **options),
            lambda step: exudyn.seconds(build(), float(times[-1]), step, **options),
            min(STEPS) / 4,
        )

    radii = (0.3, 0.6) if flexible else (0.3, 0.6, 0.9)  # with 0.9 no flexible run comes to its end
    return [runner(rho, tolerance) for rho in radii for tolerance in (1e-5, 1e-3)]

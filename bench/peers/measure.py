"""Errors and times of a case: all runners in turn, round by round."""

import math

from runner import Case, Runner, difference

SLOW = 3.0  # s: a run that takes longer is timed once


def measured(case: Case, rounds: int) -> list[dict]:
    rows = []
    pairs = [(runner, step) for runner in case.runners for step in runner.steps]
    own = {id(runner): converged(runner) for runner in case.runners}
    for runner, step in pairs:
        row = {"case": case.name, "code": runner.code, "version": runner.version, "settings": runner.settings}
        row |= {"step": step, "cpu_seconds": math.inf, "error": None, "error_own": None}
        try:
            outputs = runner.outputs(step)
            row["error"] = difference(outputs, case.reference)
            reference = case.reference if runner.finest is None else own[id(runner)]
            row["error_own"] = None if reference is None or step is None else difference(outputs, reference)
        except RuntimeError as error:
            print(f"{case.name}, {runner.code}, {runner.settings}, {step}: {error}", flush=True)
        rows.append(row)
    for runner, row in zip([runner for runner, _ in pairs], rows, strict=True):
        finite = row["error"] is not None and math.isfinite(row["error"])
        row["error"], row["error_own"] = (row["error"], row["error_own"]) if finite else (None, None)
        row["runner"] = runner
    show_least_errors(case, rows)
    for _ in range(rounds):
        for row in rows:
            if row["error"] is not None and not (SLOW < row["cpu_seconds"] < math.inf):
                row["cpu_seconds"] = min(row["cpu_seconds"], row["runner"].seconds(row["step"]))
    for row in rows:
        del row["runner"]
        row["cpu_seconds"] = row["cpu_seconds"] if math.isfinite(row["cpu_seconds"]) else None
    return rows + loaded(case, rounds)


def show_least_errors(case: Case, rows: list[dict]) -> None:
    """That all codes approach the same motion is seen before they are timed."""
    print(f"{case.name}: least error of the {case.what}, {case.unit}")
    for runner in case.runners:
        errors = [row["error"] for row in rows if row["runner"] is runner and row["error"] is not None]
        least = f"{min(errors):.1e}" if errors else "no run"
        print(f"  {runner.code}, {runner.settings}: {least}", flush=True)


def converged(runner: Runner) -> object:
    """The outputs of its own converged run, or None where that fails."""
    if runner.finest is None:
        return None
    try:
        return runner.outputs(runner.finest)
    except RuntimeError:
        return None


def loaded(case: Case, rounds: int) -> list[dict]:
    """Least CPU time of loading the model."""
    versions = {runner.code: runner.version for runner in case.runners}
    empty = {"settings": "from the data to a model ready to step", "step": None, "error": None, "error_own": None}
    loads = case.loading or {}
    least = {code: min(load() for _ in range(rounds)) for code, load in loads.items()}
    return [
        {"case": f"{case.name}, loading", "code": code, "version": versions[code], "cpu_seconds": seconds} | empty
        for code, seconds in least.items()
    ]

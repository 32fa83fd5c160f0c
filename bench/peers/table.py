"""The measurements as Markdown."""

import math


def table(rows: list[dict]) -> str:
    lines = []
    for case in dict.fromkeys(row["case"] for row in rows):
        mine = [row for row in rows if row["case"] == case]
        lines += ["", f"### {case[0].upper()}{case[1:]}", "", *one_case(mine)]
        if any(row["step"] is not None for row in mine):
            lines += ["", *equal_error(mine, "error")]
            lines += ["", *equal_error(mine, "error_own")]
    return "\n".join(lines[1:]) + "\n"


def one_case(rows: list[dict]) -> list[str]:
    lines = ["| code | settings | step, s | CPU, ms | error | own error |", "| --- | --- | ---: | ---: | ---: | ---: |"]
    for row in rows:
        step = "" if row["step"] is None else f"{row['step']:g}"
        numbers = f"{milliseconds(row['cpu_seconds'])} | {number(row['error'])} | {number(row['error_own'])}"
        lines.append(f"| {row['code']} {row['version']} | {row['settings']} | {step} | {numbers} |")
    return lines


def milliseconds(seconds: float | None) -> str:
    return "failed" if seconds is None else f"{1e3 * seconds:.3g}"


def number(value: float | None) -> str:
    return "" if value is None else f"{value:.1e}"


def equal_error(rows: list[dict], which: str) -> list[str]:
    """CPU time of each code's best runs at equal errors or own errors, interpolated along its lower envelope."""
    curves = {code: envelope([row for row in rows if row["code"] == code], which) for code in codes(rows)}
    reached = [error for curve in curves.values() for error, _ in curve]
    if not reached:
        return []
    targets = [
        10.0**k for k in range(math.floor(math.log10(max(reached))), math.floor(math.log10(min(reached))) - 1, -1)
    ]
    name = "an error" if which == "error" else "an own error"
    lines = [f"| CPU, ms, at {name} of | {' | '.join(f'{target:.0e}' for target in targets)} |"]
    lines.append(f"| --- |{' ---: |' * len(targets)}")
    for code, curve in curves.items():
        lines.append(f"| {code} | {' | '.join(milliseconds_at(curve, target) for target in targets)} |")
    return lines


def codes(rows: list[dict]) -> list[str]:
    return list(dict.fromkeys(row["code"] for row in rows))


def envelope(rows: list[dict], which: str) -> list[tuple[float, float]]:
    """Errors, falling, with CPU times: the runs that no other run beats in both."""
    curve: list[tuple[float, float]] = []
    points = [(row["cpu_seconds"], row[which]) for row in rows if row["cpu_seconds"] and row[which]]
    for seconds, error in sorted(points):
        if not curve or error < curve[-1][0]:
            curve.append((error, seconds))
    return curve


def milliseconds_at(curve: list[tuple[float, float]], target: float) -> str:
    """Between two runs by their logarithms; a run that is more accurate than needed counts as it is."""
    if not curve or target < curve[-1][0]:
        return "–"
    if target >= curve[0][0]:
        return milliseconds(curve[0][1])
    k = next(k for k in range(1, len(curve)) if curve[k][0] <= target)
    (coarse, less), (fine, more) = curve[k - 1], curve[k]
    part = math.log(coarse / target) / math.log(coarse / fine)
    return milliseconds(less * (more / less) ** part)

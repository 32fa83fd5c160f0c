"""Modes of a rotor over its speed: a Campbell diagram with names of the modes, whirl and critical speeds.

python rotor.py [--picture campbell.png]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import mimbre
import numpy as np


def diagram(model: mimbre.Model, rpm: np.ndarray) -> mimbre.CampbellDiagram:
    """The modes in steady rotation, as seen from the ground."""
    return model.campbell("rpm", rpm, speed="rpm", at="steady", most=10)


def table(found: mimbre.CampbellDiagram) -> str:
    """The frequencies at the first and the last speed, and the critical speeds."""
    lines = [f"rad/s at {found.values[0]:.0f} and {found.values[-1]:.0f} rpm:"]
    for branch in found.branches:
        first, last = branch.values[0].imag, branch.values[-1].imag
        if np.isnan(last) or last <= 0:
            continue
        whirl = "forward" if branch.whirl[-1] > 0.5 else "backward" if branch.whirl[-1] < -0.5 else "-"
        lines.append(f"{first:10.2f} {last:10.2f}  {whirl:9s}{branch.name}")
    for critical in found.criticals:
        lines.append(f"critical: {critical.value:.0f} rpm, {found.branches[critical.branch].name}")
    return "\n".join(lines)


def draw(found: mimbre.CampbellDiagram, path: Path) -> None:
    """Frequencies over the speed, and the line on which both are the same."""
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots()
    for branch in found.branches:
        axes.plot(found.values, np.abs(branch.values.imag), label=branch.name[:40])
    axes.plot(found.values, found.values * np.pi / 30, "k--", label="speed")
    axes.set(xlabel="rpm", ylabel="rad/s")
    axes.legend(fontsize=6)
    figure.savefig(path, dpi=150)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--picture", type=Path)
    arguments = parser.parse_args()
    model = mimbre.Model.from_file(Path(__file__).parents[1] / "rotor/two-discs.yaml")
    found = diagram(model, np.linspace(0, 4000, 21))
    print(table(found))
    if arguments.picture:
        draw(found, arguments.picture)


if __name__ == "__main__":
    main()

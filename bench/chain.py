#!/usr/bin/env python3
"""Writes an open chain of N rigid links of 1 m on revolute joints, in turn about y and z, as a model file. With
--springs a spring with a damper joins each link to the third after it.

bench/chain.py N [--springs] > chain.yaml
"""

import sys

MASS, CENTRE, INERTIA = 1.0, 0.5, (0.01, 0.09, 0.09)  # of each link, which lies along x; about its centre


def axis(i: int) -> list[int]:
    return [0, 1, 0] if i % 2 == 0 else [0, 0, 1]


def speed(i: int) -> float:
    """Of joint i at the start, rad/s."""
    return round(0.1 * ((7 * i) % 5 - 2), 1)


def spring(i: int) -> str:
    """From link i − 3 to link i, above both."""
    return (
        f"  spring_{i}: {{between: [link_{i - 3}, link_{i}], at: [[{i - 2.5}, 0, 0.2], [{i + 0.5}, 0, 0.2]], "
        "elastic: {stiffness: 100, zero: 3}, damping: 2}"
    )


def chain(n: int, springs: bool = False) -> str:
    lines = ["mimbre: 1", "bodies:"]
    lines += [f"  link_{i}: {{mass: {MASS}, com: [{i + CENTRE}, 0, 0], inertia: {list(INERTIA)}}}" for i in range(n)]
    lines.append("joints:")
    for i in range(n):
        inner = "ground" if i == 0 else f"link_{i - 1}"
        lines.append(
            f"  joint_{i}: {{type: revolute, between: [{inner}, link_{i}], at: [{i}, 0, 0], axis: {axis(i)}, "
            f"velocity: {speed(i)}}}"
        )
    if springs:
        lines += ["springs:", *(spring(i) for i in range(3, n))]
    tips = [f"{{name: {c}, position: link_{n - 1}, at: [{n}, 0, 0], component: {c}}}" for c in "xyz"]
    lines.append(f"outputs: [{', '.join(tips)}]")
    lines.append("simulation: {step: 0.005, end: 0.1}")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(chain(int(sys.argv[1]), "--springs" in sys.argv), end="")

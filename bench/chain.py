#!/usr/bin/env python3
"""Writes an open chain of N rigid links of 1 m on revolute joints, in turn about y and z, as a model file.

bench/chain.py N > chain.yaml
"""

import sys

n = int(sys.argv[1])
print("mimbre: 1\nbodies:")
for i in range(n):
    print(f"  link_{i}: {{mass: 1, com: [{i + 0.5}, 0, 0], inertia: [0.01, 0.09, 0.09]}}")
print("joints:")
for i in range(n):
    inner = "ground" if i == 0 else f"link_{i - 1}"
    axis = "[0, 1, 0]" if i % 2 == 0 else "[0, 0, 1]"
    velocity = round(0.1 * ((7 * i) % 5 - 2), 1)
    print(
        f"  joint_{i}: {{type: revolute, between: [{inner}, link_{i}], at: [{i}, 0, 0], axis: {axis}, "
        f"velocity: {velocity}}}"
    )
print(f"outputs: [{{name: tip, position: link_{n - 1}, at: [{n}, 0, 0], component: z}}]")
print("simulation: {step: 0.005, end: 0.1}")

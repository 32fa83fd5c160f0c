"""The Iltis over stairs of several heights, on all cores of the machine."""

import mimbre

data = mimbre.sweep(
    "examples/iltis/vehicle.yaml",
    {"stairs": [0.05, 0.1, 0.15]},
    outputs=["chassis.z"],
    reduce=["max", "rms"],
    until=1,
)
print(data["chassis.z"].to_pandas())

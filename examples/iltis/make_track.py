"""Makes track.crg, the track of drive.yaml: 240 m with a hill, five stairs, cobbles and a swell, and on the right a
bank that rises to 45°, to roll over on. OpenCRG, binary; needs Python alone.

    python3 examples/iltis/make_track.py"""

import math
import random
import struct
from itertools import pairwise
from pathlib import Path

begin, end, increment = -20.0, 220.0, 0.1
sections = (-18.0, -14.0, -13.0, -12.0, -11.0, -10.0, -9.0, -8.0, -2.0, 0.0, 2.0, 14.0)  # from right to left
profile = [
    (begin, 0), (30, 0), (45, 1.5), (55, 1.5), (75, 0),  # a hill
    (100, 0), (110, 0.5), (117, 0.5), (117, 0.4), (120, 0.4), (120, 0.3), (123, 0.3), (123, 0.2), (126, 0.2),
    (126, 0.1), (129, 0.1), (129, 0), (end, 0),  # a ramp, and five stairs down
]  # fmt: skip
stones = random.Random(1)


def along(x: float) -> float:
    height = 0.0
    for (x0, z0), (x1, z1) in pairwise(profile):
        if x0 <= x < x1:
            height = z0 + (z1 - z0) * (x - x0) / (x1 - x0)
    if 175 <= x <= 215:
        height += 0.04 * (1 - math.cos(2 * math.pi * (x - 175) / 8))  # a swell
    return height


def across(v: float) -> float:
    beside = max(0.0, -8 - v)  # on the bank
    return beside**2 / 12 if beside < 6 else beside - 3


def cobble(x: float) -> float:
    return stones.uniform(0, 0.015) if 150 <= x <= 165 and round(x / increment) % 2 == 0 else 0.0


def main() -> None:
    rows = round((end - begin) / increment) + 1
    data = b""
    for k in range(rows):
        x = begin + k * increment
        z = along(x)
        heights = [max(across(v), z) + (cobble(x) if abs(v) <= 2 else 0) for v in sections]
        data += struct.pack(f">{len(sections)}f", *heights)
    data += struct.pack(">f", math.nan) * (-len(data) % 80 // 4)
    head = [
        "$CT",
        "The track of the Iltis that is driven: made by make_track.py.",
        "$ROAD_CRG",
        f"REFERENCE_LINE_START_U   = {begin}",
        f"REFERENCE_LINE_START_X   = {begin}",
        "REFERENCE_LINE_START_Y   = 0.0",
        "REFERENCE_LINE_START_PHI = 0.0",
        f"REFERENCE_LINE_END_U     = {end}",
        f"REFERENCE_LINE_INCREMENT = {increment}",
        f"LONG_SECTION_V_RIGHT     = {sections[0]}",
        f"LONG_SECTION_V_LEFT      = {sections[-1]}",
        "$KD_Definition",
        "#:KRBI",
        f"U:reference line u,m,{begin},{increment}",
        *(f"D:long section at v = {v:.3f},m" for v in sections),
        "$" * 80,
    ]
    Path(__file__).with_name("track.crg").write_bytes("\n".join(head).encode() + b"\n" + data)


if __name__ == "__main__":
    main()

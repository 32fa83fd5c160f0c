#!/usr/bin/env python3
"""Writes the same bent, sloped and banked road in formats of OpenCRG: bend.crg (LRFI), bend_double.crg (LDFI),
bend_binary.crg (KRBI) and bend_binary_double.crg (KDBI). One height of it is missing."""
import math
import pathlib
import struct

here = pathlib.Path(__file__).parent
rows, du = 41, 0.5
v = [-2, -1.5, -1, -0.25, 0, 0.25, 1, 1.5, 2]


def row(i):
    u = i * du
    numbers = [0.3 + 0.9 * math.sin(0.15 * u), 0.04 * math.cos(0.2 * u), 0.02 * math.sin(0.3 * u)]
    heights = [0.05 * math.sin(u) * math.cos(2 * w) + 0.01 * w for w in v]
    if i == 20:
        heights[0] = math.nan
    return [math.nan if i == 0 and k != 1 else x for k, x in enumerate(numbers)] + heights


head = """$CT                                  ! comment text block
A bend with all that a reference line can have.
$!**********************************************************************
$ROAD_CRG                            ! crg road parameters
REFERENCE_LINE_START_U   = 100.0
REFERENCE_LINE_START_X   = 10.0
REFERENCE_LINE_START_Y   = -5.0
REFERENCE_LINE_START_Z   = 1.5
REFERENCE_LINE_START_PHI = 0.3
REFERENCE_LINE_END_U     = 120.0
REFERENCE_LINE_INCREMENT = 0.5
LONG_SECTION_V_RIGHT     = -2.0       ! with explicit definition below
LONG_SECTION_V_LEFT      = 2.0
$!**********************************************************************
$KD_Definition
#:FORMAT
U:reference line u,m,100,0.5
D:reference line phi,rad
D:reference line banking,m/m         ! lateral banking
D:reference line slope,m/m
""" + "".join(f"D:long section at v = {w:.3f},m\n" for w in v) + """$
* data
"""
separator = "$" * 80 + "\n"


def text(width, digits):
    out = ""
    for i in range(rows):
        fields = ["*missing*".rjust(width) if math.isnan(x) else f"{x:{width}.{digits}f}" for x in row(i)]
        per_line = 80 // width
        for k in range(0, len(fields), per_line):
            out += "".join(fields[k:k + per_line]) + "\n"
    return out


def binary(letter, size):
    data = b"".join(struct.pack(">" + letter, x) for i in range(rows) for x in row(i))
    return data + struct.pack(">" + letter, math.nan) * (-len(data) % 80 // size)


for name, kind, data in (("bend", "LRFI", text(10, 7).encode()), ("bend_double", "LDFI", text(20, 16).encode()),
                         ("bend_binary", "KRBI", binary("f", 4)), ("bend_binary_double", "KDBI", binary("d", 8))):
    (here / f"{name}.crg").write_bytes((head.replace("FORMAT", kind) + separator).encode() + data)

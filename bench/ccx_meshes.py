#!/usr/bin/env python3
"""Meshes of all kinds against CalculiX: the lowest elastic frequencies of free parts.

    bench/ccx_meshes.py [--program build/release/mimbre] [--ccx ccx] [--only NAME] [--keep FOLDER]

Makes every mesh, lets CalculiX (*FREQUENCY) and `mimbre reduce --free-modes` solve the same .inp, and prints the
largest difference of the first five elastic frequencies beside what is wanted of the kind: 0.1 % of quadratic
solids, 1 % of shells and beams. Beams have the torsion constant of CalculiX's bricks (--beam-torsion brick). Ends
with 1 where a mesh differs more than wanted.
"""

import argparse
import itertools
import json
import math
import re
import subprocess
import sys
import tempfile
from pathlib import Path

MODES = 5
STEEL = "*MATERIAL, NAME=STEEL\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7850\n"
ALU = "*MATERIAL, NAME=ALU\n*ELASTIC\n7e10, 0.33\n*DENSITY\n2700\n"
WOOD = (
    "*MATERIAL, NAME=WOOD\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n"
    "1.4e10, 9e8, 6e8, 0.3, 0.32, 0.4, 8e8, 7e8,\n1.2e8\n*DENSITY\n600\n"
)
CARBON = (
    "*MATERIAL, NAME=CARBON\n*ELASTIC, TYPE=ENGINEERING CONSTANTS\n"
    "1.35e11, 1e10, 1e10, 0.3, 0.3, 0.4, 5e9, 5e9,\n3.5e9\n*DENSITY\n1600\n"
)


class Mesh:
    """Nodes and elements with their numbers, and the cards behind them."""

    def __init__(self):
        self.nodes, self.elements, self.cards, self.number = [], [], [], {}
        self.ours, self.theirs = [], []  # cards of one side only
        self.materials = ""
        self.options = []  # of `mimbre reduce`

    def node(self, *x):
        key = tuple(round(v, 9) for v in x)
        if key not in self.number:
            self.nodes.append(x)
            self.number[key] = len(self.nodes)
        return self.number[key]

    def lone(self, *x):
        """A node that is not one with others at its place."""
        self.nodes.append(x)
        return len(self.nodes)

    def add(self, kind, set_name, *nodes):
        self.elements.append((kind, set_name, nodes))
        return len(self.elements)

    def card(self, *lines):
        self.cards += lines

    def solid(self, elements="E", material="STEEL", more=""):
        self.card(f"*SOLID SECTION, ELSET={elements}, MATERIAL={material}{more}")

    def text(self, modes, more):
        out = ["*NODE, NSET=ALLNODES"]
        out += [f"{k}, " + ", ".join(f"{v:.12g}" for v in x) for k, x in enumerate(self.nodes, 1)]
        label = 0
        for (kind, name), group in itertools.groupby(self.elements, lambda e: e[:2]):
            out.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
            for _, _, nodes in group:
                label += 1
                fields = [str(label), *map(str, nodes)]
                lines = [", ".join(fields[k : k + 10]) for k in range(0, len(fields), 10)]
                out.append(",\n".join(lines))
        out += [self.materials or STEEL, *self.cards, *more, "*STEP\n*FREQUENCY", str(modes + 8), "*END STEP", ""]
        return "\n".join(line.rstrip("\n") for line in out if line)


HEX = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
HEX_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
WEDGES = [(0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)]
WEDGE_EDGES = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
TETS = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
TET_EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]


def straight(x):
    return x


def block(mesh, kind, counts, size, shape=straight, name="E", origin=(0, 0, 0), keep=lambda _: True):
    """A block of elements, bent by `shape`; edges' middles lie on the bent edge."""
    quadratic = kind.startswith(("C3D20", "C3D15", "C3D10"))

    def at(corner):
        return tuple(o + s * c / n for o, s, c, n in zip(origin, size, corner, counts, strict=False))

    for cell in itertools.product(*map(range, counts)):
        if not keep(cell):
            continue
        corners = [tuple(c + d for c, d in zip(cell, step, strict=False)) for step in HEX]
        if kind.startswith(("C3D8", "C3D20")):
            parts, edges = [tuple(range(8))], HEX_EDGES
        elif kind.startswith(("C3D6", "C3D15")):
            parts, edges = WEDGES, WEDGE_EDGES
        else:
            parts, edges = TETS, TET_EDGES
        for part in parts:
            places = [at(corners[k]) for k in part]
            if quadratic:
                places += [tuple((a + b) / 2 for a, b in zip(places[i], places[j], strict=False)) for i, j in edges]
            mesh.add(kind, name, *(mesh.node(*shape(p)) for p in places))


def sheet(mesh, kind, counts, size, shape, name="E", lone=False):
    """Shells over size[0] × size[1]."""
    corners = 3 if kind[1] in "36" else 4
    quadratic = kind[1] in "68"

    def at(u, v):
        return (size[0] * u / counts[0], size[1] * v / counts[1], 0.0)

    for i, j in itertools.product(range(counts[0]), range(counts[1])):
        square = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
        if corners == 4:
            parts = [square]
        elif (i + j) % 2:
            parts = [[square[0], square[1], square[2]], [square[0], square[2], square[3]]]
        else:
            parts = [[square[0], square[1], square[3]], [square[1], square[2], square[3]]]
        for places in parts:
            full = list(places)
            if quadratic:
                sides = zip(places, places[1:] + places[:1], strict=True)
                full += [tuple((a + b) / 2 for a, b in zip(p, q, strict=True)) for p, q in sides]
            mesh.add(kind, name, *(mesh.node(*shape(p)) for p in full))


def line(mesh, kind, count, curve, name="B"):
    """Beams along curve(0…1)."""
    for k in range(count):
        ends = (k / count, (k + 1) / count)
        places = [ends[0], (ends[0] + ends[1]) / 2, ends[1]] if kind.startswith("B32") else ends
        mesh.add(kind, name, *(mesh.node(*curve(s)) for s in places))


def arc(radius, angle):
    """Bends a block along x onto an arc."""

    def shape(p):
        a = angle * p[0]
        return ((radius + p[1]) * math.sin(a), (radius + p[1]) * math.cos(a), p[2])

    return shape


def twisted(angle):
    def shape(p):
        c, s = math.cos(angle * p[0]), math.sin(angle * p[0])
        return (p[0], c * p[1] - s * p[2], s * p[1] + c * p[2])

    return shape


def flat(p):
    return p


def skew(p):
    return (p[0] + 0.4 * p[1], p[1], p[2])


def cylinder(radius):
    return lambda p: (p[0], radius * math.sin(p[1]), radius * math.cos(p[1]))


def cap(p):
    """A piece of a sphere of 0.5 m."""
    x, y = p[0] - 0.2, p[1] - 0.2
    return (x, y, math.sqrt(0.25 - x * x - y * y))


CASES = {}


def case(wanted, about=""):
    def keep(make):
        CASES[make.__name__] = (make, wanted, about)
        return make

    return keep


# Solids ---------------------------------------------------------------------------------------------------------


def solid_case(name, kind, wanted, counts, size, shape=straight, about=""):
    def make():
        mesh = Mesh()
        block(mesh, kind, counts, size, shape)
        mesh.solid()
        return mesh

    make.__name__ = name
    case(wanted, about)(make)


solid_case("c3d20r_beam", "C3D20R", 0.1, (8, 2, 2), (1, 0.1, 0.08))
solid_case("c3d20r_arc", "C3D20R", 0.1, (10, 2, 2), (0.6, 0.06, 0.05), arc(0.4, 2.5))
solid_case("c3d20r_twisted", "C3D20R", 0.1, (10, 3, 1), (0.8, 0.12, 0.02), twisted(1.9))
solid_case("c3d20_plate", "C3D20", 0.1, (6, 6, 1), (0.4, 0.3, 0.02))
solid_case("c3d20_twisted", "C3D20", 0.1, (10, 3, 1), (0.8, 0.12, 0.02), twisted(1.9))
solid_case("c3d15_arc", "C3D15", 0.1, (10, 2, 2), (0.6, 0.06, 0.05), arc(0.4, 2.5))
solid_case("c3d15_plate", "C3D15", 0.1, (6, 6, 1), (0.4, 0.3, 0.02))
solid_case("c3d10_beam", "C3D10", 0.1, (8, 2, 2), (1, 0.1, 0.08))
solid_case("c3d10_arc", "C3D10", 0.1, (10, 2, 2), (0.6, 0.06, 0.05), arc(0.4, 2.5))
solid_case("c3d4_block", "C3D4", 2, (10, 6, 4), (0.5, 0.3, 0.2), about="one point for the mass there")
solid_case("c3d6_arc", "C3D6", 3, (12, 4, 3), (0.6, 0.06, 0.05), arc(0.4, 2.5), "two points for the mass there")
solid_case(
    "c3d8_block", "C3D8", 3, (10, 6, 4), (0.5, 0.3, 0.2), about="selective integration there, incompatible modes here"
)
solid_case("c3d8i_beam", "C3D8I", 2, (16, 3, 3), (1, 0.1, 0.08), about="other incompatible modes there")


@case(0.1)
def mixed_bricks_and_wedges():
    mesh = Mesh()
    block(mesh, "C3D20R", (5, 2, 2), (0.5, 0.1, 0.08))
    block(mesh, "C3D15", (5, 2, 2), (0.5, 0.1, 0.08), origin=(0.5, 0, 0))
    mesh.solid()
    return mesh


@case(0.1)
def two_materials():
    mesh = Mesh()
    block(mesh, "C3D20R", (5, 2, 2), (0.5, 0.1, 0.08), name="LEFT")
    block(mesh, "C3D20R", (5, 2, 2), (0.5, 0.1, 0.08), origin=(0.5, 0, 0), name="RIGHT")
    mesh.materials = STEEL + ALU
    mesh.solid("LEFT")
    mesh.solid("RIGHT", "ALU")
    return mesh


@case(0.1)
def orthotropic_block():
    mesh = Mesh()
    block(mesh, "C3D20R", (8, 3, 2), (0.8, 0.2, 0.08))
    mesh.materials = WOOD
    mesh.card("*ORIENTATION, NAME=OR", "0.8, 0.6, 0, -0.6, 0.8, 0")
    mesh.solid(material="WOOD", more=", ORIENTATION=OR")
    return mesh


@case(0.1)
def orthotropic_ring():
    mesh = Mesh()
    block(mesh, "C3D20R", (10, 2, 2), (0.6, 0.06, 0.05), arc(0.4, 2.5))
    mesh.materials = WOOD
    mesh.card("*ORIENTATION, NAME=OR, SYSTEM=CYLINDRICAL", "0, 0, 0, 0, 0, 1")
    mesh.solid(material="WOOD", more=", ORIENTATION=OR")
    return mesh


@case(0.1)
def anisotropic_tetrahedra():
    mesh = Mesh()
    block(mesh, "C3D10", (6, 2, 2), (0.6, 0.12, 0.1))
    mesh.materials = WOOD
    mesh.card("*ORIENTATION, NAME=OR", "0.6, 0, 0.8, 0, 1, 0")
    mesh.solid(material="WOOD", more=", ORIENTATION=OR")
    return mesh


@case(0.1)
def point_masses():
    mesh = Mesh()
    block(mesh, "C3D20R", (8, 2, 2), (1, 0.1, 0.08))
    mesh.solid()
    for place in ((1, 0, 0), (1, 0.1, 0.08), (0.5, 0.1, 0)):
        mesh.add("MASS", "M", mesh.node(*place))
    mesh.card("*MASS, ELSET=M", "8.5")
    return mesh


def fork(mesh):
    """Two prongs on a foot."""
    block(mesh, "C3D20R", (10, 6, 1), (0.5, 0.12, 0.02), keep=lambda c: c[0] < 2 or c[1] in (0, 1, 4, 5))
    mesh.solid()


@case(0.1)
def spring_between_components():
    mesh = Mesh()
    fork(mesh)
    mesh.add("SPRING2", "S", mesh.node(0.5, 0, 0), mesh.node(0.5, 0.12, 0))
    mesh.card("*SPRING, ELSET=S", "2, 2", "400000.")
    return mesh


@case(0.1)
def spring_along_its_line():
    mesh = Mesh()
    fork(mesh)
    mesh.add("SPRINGA", "S", mesh.node(0.5, 0.04, 0.02), mesh.node(0.3, 0.08, 0))
    mesh.card("*SPRING, ELSET=S\n\n6000000.")
    return mesh


@case(0.1)
def equations():
    mesh = Mesh()
    fork(mesh)
    # A mass amid the two ends, held by them.
    amid = mesh.lone(0.5, 0.06, 0)
    mass_at(mesh, amid, 0.8)
    a, b = mesh.node(0.5, 0.04, 0), mesh.node(0.5, 0.08, 0)
    for k in (1, 2, 3):
        mesh.card("*EQUATION", "3", f"{a}, {k}, -0.5, {b}, {k}, -0.5, {amid}, {k}, 1.")
    return mesh


@case(0.1)
def rigid_body():
    mesh = Mesh()
    block(mesh, "C3D20R", (8, 2, 2), (1, 0.1, 0.08))
    mesh.solid()
    end = sorted({n for k, n in mesh.number.items() if k[0] >= 0.75})
    reference, rotation = mesh.lone(1.1, 0.05, 0.04), mesh.lone(1.1, 0.05, 0.04)
    mesh.card("*NSET, NSET=END", *(f"{n}," for n in end))
    mesh.card(f"*RIGID BODY, NSET=END, REF NODE={reference}, ROT NODE={rotation}")
    return mesh


def mass_at(mesh, reference, mass):
    mesh.add("MASS", "M", reference)
    mesh.card("*MASS, ELSET=M", str(mass))


def end_surface(mesh, x):
    """Faces of bricks at the largest x (S4 of the numbering used here is x = 1)."""
    faces = []
    for label, (kind, _, nodes) in enumerate(mesh.elements, 1):
        if kind.startswith(("C3D8", "C3D20")) and all(
            abs(mesh.nodes[nodes[k] - 1][0] - x) < 1e-9 for k in (1, 2, 5, 6)
        ):
            faces.append(f"{label}, S4")
    return faces


@case(0.1)
def coupling_kinematic():
    mesh = Mesh()
    block(mesh, "C3D20R", (8, 2, 2), (1, 0.1, 0.08))
    mesh.solid()
    reference = mesh.lone(1.2, 0.05, 0.04)
    mesh.card("*SURFACE, NAME=FACE", *end_surface(mesh, 1))
    mass_at(mesh, reference, 40)
    mesh.card(f"*COUPLING, REF NODE={reference}, SURFACE=FACE, CONSTRAINT NAME=C", "*KINEMATIC", "1, 3")
    return mesh


@case(0.1, "equations there, whose distributing couplings carry forces only")
def coupling_distributing():
    mesh = Mesh()
    block(mesh, "C3D20R", (8, 2, 2), (1, 0.1, 0.08))
    mesh.solid()
    end = sorted({n for k, n in mesh.number.items() if k[0] == 1})
    reference = mesh.lone(1, 0.05, 0.04)
    mass_at(mesh, reference, 40)
    for k in (1, 2, 3):
        # The first is eliminated, and CalculiX forgets the mass of what is.
        terms = [f"{n}, {k}, {-1 / len(end):.15f}" for n in end] + [f"{reference}, {k}, 1."]
        mesh.theirs += ["*EQUATION", str(len(terms)), *(", ".join(terms[i : i + 4]) for i in range(0, len(terms), 4))]
    mesh.add("MASS", "R", reference)
    mesh.ours += ["*DISTRIBUTING COUPLING, ELSET=R", *(f"{n}, 1." for n in end)]
    mesh.card("*MASS, ELSET=R", "0.")
    return mesh


def tied(kind_a, counts_a, kind_b, counts_b):
    """Two blocks whose meshes do not meet, one on the other."""
    mesh = Mesh()
    block(mesh, kind_a, counts_a, (0.5, 0.1, 0.08), name="A")
    first = len(mesh.elements)
    mesh.number = {}
    block(mesh, kind_b, counts_b, (0.5, 0.1, 0.08), name="B", origin=(0.5, 0, 0))
    slave = sorted({n for k, n in mesh.number.items() if abs(k[0] - 0.5) < 1e-9})
    mesh.solid("A")
    mesh.solid("B")
    mesh.card("*SURFACE, NAME=MASTER", *(f for f in end_surface(mesh, 0.5) if int(f.split(",")[0]) <= first))
    mesh.card("*NSET, NSET=NSLAVE", *(f"{n}," for n in slave))
    mesh.card("*SURFACE, NAME=SLAVE, TYPE=NODE", "NSLAVE,")
    mesh.card("*TIE, NAME=T, POSITION TOLERANCE=1e-3", "SLAVE, MASTER")
    return mesh


@case(0.1)
def tie_of_bricks():
    return tied("C3D20R", (5, 2, 2), "C3D20R", (6, 3, 3))


@case(0.1)
def tie_of_tetrahedra_on_bricks():
    return tied("C3D20R", (5, 2, 2), "C3D10", (6, 3, 3))


@case(2, "other incompatible modes there")
def tie_of_linear_bricks():
    return tied("C3D8I", (8, 3, 3), "C3D8I", (10, 4, 4))


# Shells ---------------------------------------------------------------------------------------------------------


def shell_case(name, kind, counts, size, shape, thickness, wanted=1, more="", about="", material=None):
    def make():
        mesh = Mesh()
        sheet(mesh, kind, counts, size, shape)
        mesh.materials = material or STEEL
        steel = "STEEL" if not material else material.split("NAME=")[1].split("\n")[0]
        mesh.card(f"*SHELL SECTION, ELSET=E, MATERIAL={steel}{more}", str(thickness))
        return mesh

    make.__name__ = name
    case(wanted, about)(make)


shell_case("s8r_square", "S8R", (8, 8), (0.5, 0.5), flat, 0.005)
shell_case("s8r_skew", "S8R", (10, 6), (0.6, 0.4), skew, 0.006)
shell_case("s8r_cylinder", "S8R", (8, 10), (0.4, 2.0), cylinder(0.2), 0.004)
shell_case("s8r_cap", "S8R", (8, 8), (0.4, 0.4), cap, 0.005)
shell_case("s8_square", "S8", (10, 10), (0.5, 0.5), flat, 0.01)
shell_case("s8_skew", "S8", (10, 8), (0.6, 0.4), skew, 0.01)
shell_case("s8_cylinder", "S8", (8, 12), (0.4, 2.0), cylinder(0.2), 0.01)
shell_case("s6_square", "S6", (10, 10), (0.5, 0.5), flat, 0.01)
shell_case("s6_cylinder", "S6", (10, 12), (0.4, 2.0), cylinder(0.2), 0.01)
shell_case("s4_square", "S4", (16, 16), (0.5, 0.5), flat, 0.01)
shell_case("s4_cylinder", "S4", (12, 24), (0.4, 2.0), cylinder(0.2), 0.01)
shell_case("s8r_offset", "S8R", (8, 10), (0.4, 2.0), cylinder(0.2), 0.01, more=", OFFSET=0.5")
shell_case("s4_offset", "S4", (12, 24), (0.4, 2.0), cylinder(0.2), 0.01, more=", OFFSET=-0.5")
shell_case("s8r_orthotropic", "S8R", (8, 8), (0.5, 0.4), flat, 0.01, more=", ORIENTATION=OR", material=CARBON)


def against(ours, theirs, wanted=1, about=""):
    """A mesh here against another one of the same part there."""
    name, kind, counts, size, shape, thickness = ours

    def make():
        meshes = []
        for k, c in ((kind, counts), theirs):
            mesh = Mesh()
            sheet(mesh, k, c, size, shape)
            mesh.card("*SHELL SECTION, ELSET=E, MATERIAL=STEEL", str(thickness))
            meshes.append(mesh)
        return tuple(meshes)

    make.__name__ = name
    case(wanted, about)(make)


against(("s4r_square", "S4R", (16, 16), (0.5, 0.5), flat, 0.01), ("S4", (16, 16)), 1, "S4 there, whose S4R folds")
against(("s3_square", "S3", (24, 24), (0.5, 0.5), flat, 0.01), ("S6", (12, 12)), 1, "S6 there, whose S3 is too stiff")
against(("s3_cylinder", "S3", (20, 40), (0.4, 2.0), cylinder(0.2), 0.01), ("S6", (10, 12)), 1, "S6 there")
against(("s4_skew", "S4", (24, 16), (0.6, 0.4), skew, 0.006), ("S8R", (10, 6)), 1, "S8R there")


def oriented(name):
    make, wanted, about = CASES[name]

    def more():
        mesh = make()
        mesh.cards.insert(0, "*ORIENTATION, NAME=OR\n0.8, 0.6, 0, -0.6, 0.8, 0")
        return mesh

    CASES[name] = (more, wanted, about)


oriented("s8r_orthotropic")


def layered(plies, shape=flat, size=(0.5, 0.4), counts=(8, 8)):
    """plies: thickness, material, angle in degrees."""
    mesh = Mesh()
    sheet(mesh, "S8R", counts, size, shape)
    mesh.materials = CARBON + ALU
    for angle in sorted({p[2] for p in plies}):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        mesh.card(f"*ORIENTATION, NAME=OR{angle}", f"{c:.12g}, {s:.12g}, 0, {-s:.12g}, {c:.12g}, 0")
    mesh.card("*SHELL SECTION, ELSET=E, COMPOSITE", *(f"{t}, , {m}, OR{a}" for t, m, a in plies))
    return mesh


@case(1)
def s8r_cross_ply():
    return layered([(0.0025, "CARBON", 0), (0.005, "CARBON", 90), (0.0025, "CARBON", 0)])


@case(1)
def s8r_unsymmetric_layers():
    return layered([(0.004, "CARBON", 30), (0.003, "CARBON", 90), (0.003, "ALU", 0)])


# Beams ----------------------------------------------------------------------------------------------------------


def beam_case(name, kind, count, curve, section, wanted=1, more="", about="", direction="0, 0, 1"):
    def make():
        mesh = Mesh()
        line(mesh, kind, count, curve)
        mesh.options = ["--beam-torsion", "brick"]
        shape, sizes = section
        mesh.card(f"*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION={shape}{more}", sizes, direction)
        return mesh

    make.__name__ = name
    case(wanted, about)(make)


def along_x(s):
    return (s, 0.0, 0.0)


def quarter(s):
    return (0.5 * math.sin(1.5 * s), 0.5 * math.cos(1.5 * s), 0.0)


beam_case("b32r_rectangle", "B32R", 20, along_x, ("RECT", "0.03, 0.02"))
beam_case("b32r_quarter", "B32R", 20, quarter, ("RECT", "0.02, 0.02"))
beam_case("b32r_quarter_rectangle", "B32R", 20, quarter, ("RECT", "0.03, 0.02"))
beam_case("b32r_quarter_flat", "B32R", 20, quarter, ("RECT", "0.01, 0.04"))
beam_case("b32r_quarter_pipe", "B32R", 20, quarter, ("PIPE", "0.01, 0.002"))
beam_case("b32r_circle", "B32R", 20, along_x, ("CIRC", "0.02, 0.02"), about="1.7 % more bending stiffness there")
beam_case("b31_rectangle", "B31", 60, along_x, ("RECT", "0.03, 0.02"))
beam_case(
    "b32r_offset",
    "B32R",
    20,
    quarter,
    ("RECT", "0.02, 0.02"),
    more=", OFFSET1=0.5, OFFSET2=-0.5",
)


def bow(offset, radius, counts):
    """Bending and torsion of a bow of beams, whose nodes lie on 0.5 m, against solids about `radius`."""
    beams, solids = Mesh(), Mesh()
    line(beams, "B32R", 20, quarter)
    beams.card(f"*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=RECT{offset}", "0.02, 0.02", "0, 0, 1")
    block(solids, "C3D20R", counts, (1, 0.02, 0.02), arc(radius - 0.01, 1.5))
    solids.solid()
    return beams, solids


@case(0.2, "C3D20R there")
def quarter_of_beams():
    return bow("", 0.5, (24, 2, 2))


@case(0.2, "the same, finer")
def quarter_of_beams_fine():
    return bow("", 0.5, (36, 4, 4))


@case(0.2, "C3D20R there, about the axis of the beams: 0.49 m")
def offset_of_beams():
    return bow(", OFFSET1=0.5, OFFSET2=-0.5", 0.49, (24, 2, 2))


@case(0.2, "the same, finer")
def offset_of_beams_fine():
    return bow(", OFFSET1=0.5, OFFSET2=-0.5", 0.49, (36, 4, 4))


# Both -----------------------------------------------------------------------------------------------------------


@case(1, "a rib of S8R there, since its nodes of beams are rigid blocks")
def plate_with_rib():
    beams, shells = Mesh(), Mesh()
    for mesh in (beams, shells):
        sheet(mesh, "S8R", (16, 16), (0.5, 0.4), flat)
        mesh.card("*SHELL SECTION, ELSET=E, MATERIAL=STEEL", "0.005")
    line(beams, "B32R", 16, lambda s: (0.25, 0.4 * s, 0.0))
    beams.card("*BEAM SECTION, ELSET=B, MATERIAL=STEEL, SECTION=RECT", "0.002, 0.02", "1, 0, 0")
    sheet(shells, "S8R", (16, 2), (0.4, 0.02), lambda p: (0.25, p[0], p[1] - 0.01), name="R")
    shells.card("*SHELL SECTION, ELSET=R, MATERIAL=STEEL", "0.002")
    return beams, shells


@case(1)
def folded_plate():
    mesh = Mesh()
    sheet(mesh, "S8R", (16, 12), (0.5, 0.2), flat)
    sheet(mesh, "S8R", (16, 12), (0.5, 0.2), lambda p: (p[0], 0.0, p[1]))
    mesh.card("*SHELL SECTION, ELSET=E, MATERIAL=STEEL", "0.005")
    return mesh


# ----------------------------------------------------------------------------------------------------------------


def of_calculix(ccx, folder, name):
    done = subprocess.run([ccx, name], cwd=folder, capture_output=True, text=True)
    frequencies = []
    for row in (folder / (name + ".dat")).read_text().splitlines():
        words = row.split()
        if len(words) == 5 and words[0].isdigit():
            frequencies.append(float(words[3]))
        elif frequencies and "P A R T" in row:
            break
    if not frequencies:
        raise RuntimeError("CalculiX: " + " ".join(re.findall(r"\*ERROR.*\n.*", done.stdout)[:2])[:160])
    largest = max(frequencies)
    return [f for f in frequencies if f > 1e-3 * largest]


def of_mimbre(program, path, mesh, modes):
    first = mesh.elements[0]
    nodes = path.with_suffix(".txt")
    nodes.write_text("\n".join(map(str, first[2][: 3 if first[0].startswith("C3D") else 1])))
    command = [program, "reduce", str(path), "--interface", f"end=nodes:{nodes}", "--no-cache"]
    command += [*mesh.options, "--json", "--modes", "4", "--free-modes", str(modes), "-o", str(path.with_suffix(".h5"))]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 4):
        errors = [row for row in done.stderr.splitlines() if "error" in row] or ["?"]
        raise RuntimeError(re.sub(r"^.*?error: ", "", errors[0])[:160])
    return [f for f in json.loads(done.stdout)["free_frequencies_hz"] if f]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/release/mimbre")
    parser.add_argument("--ccx", default="ccx")
    parser.add_argument("--only", help="meshes whose names contain this")
    parser.add_argument("--keep", type=Path, help="a folder for the files; else they are removed")
    parser.add_argument("--show", action="store_true", help="print both lists of frequencies")
    given = parser.parse_args()
    program = str(Path(given.program).resolve())
    missed = count = 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = given.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        print(f"{'mesh':30} {'Hz':>10} {'largest difference, %':>22} {'wanted':>7}")
        for name, (make, wanted, about) in CASES.items():
            if given.only and given.only not in name:
                continue
            count += 1
            mesh = make()
            mesh, other = mesh if isinstance(mesh, tuple) else (mesh, mesh)
            (folder / (name + ".inp")).write_text(other.text(MODES, other.theirs))
            try:
                theirs = of_calculix(given.ccx, folder, name)
                (folder / (name + ".inp")).write_text(mesh.text(MODES, mesh.ours))
                ours = of_mimbre(program, folder / (name + ".inp"), mesh, MODES)
            except (RuntimeError, OSError) as error:
                missed += 1
                print(f"{name:30} {error}", flush=True)
                continue
            pairs = list(zip(ours[:MODES], theirs, strict=False))
            worst = max((100 * abs(a / b - 1) for a, b in pairs), default=math.nan)
            late = not worst <= wanted
            missed += late
            print(
                f"{name:30} {theirs[0]:10.5g} {worst:22.3g} {wanted:7g}{'  MISSED' if late else ''}  {about}",
                flush=True,
            )
            if given.show:
                print("    ours    " + " ".join(f"{f:.6g}" for f in ours[:MODES]))
                print("    theirs  " + " ".join(f"{f:.6g}" for f in theirs[:MODES]))
    print(f"\n{count - missed} of {count} meshes are within what is wanted")
    return missed > 0


if __name__ == "__main__":
    sys.exit(main())

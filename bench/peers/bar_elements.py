"""Flexible bodies of Euler–Bernoulli bars: finite elements, and the modes of a body between its joints."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

YOUNG, POISSON, DENSITY = 2.1e11, 0.3, 7850.0
SHEAR = YOUNG / (2 * (1 + POISSON))


@dataclass(frozen=True)
class Section:
    area: float
    bending: float  # second moment of area
    torsion: float


def tube(outer: float, inner: float = 0.0) -> Section:
    """A round tube, or a round bar, from its diameters."""
    bending = np.pi / 64 * (outer**4 - inner**4)
    return Section(np.pi / 4 * (outer**2 - inner**2), bending, 2 * bending)


@dataclass
class Bars:
    """Coordinates: of each node three translations, then three rotations, in the axes of the points."""

    section: Section
    nodes: list[np.ndarray] = field(default_factory=list)
    elements: list[tuple[int, int]] = field(default_factory=list)

    def node(self, point: np.ndarray) -> int:
        self.nodes.append(np.array(point, dtype=float))
        return len(self.nodes) - 1

    def bar(self, first: int, last: int, count: int) -> list[int]:
        """Equal elements between two nodes; all nodes along them."""
        begin, end = self.nodes[first], self.nodes[last]
        line = [first, *(self.node(begin + (end - begin) * k / count) for k in range(1, count)), last]
        self.elements += list(pairwise(line))
        return line


def axes_of(direction: np.ndarray) -> np.ndarray:
    """Rows: unit vectors along and across."""
    x = direction / np.linalg.norm(direction)
    y = np.cross([0.0, 0, 1] if abs(x[2]) < 0.9 else [1.0, 0, 0], x)
    y /= np.linalg.norm(y)
    return np.array([x, y, np.cross(x, y)])


def element_matrices(section: Section, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and consistent mass in the element's axes."""
    stiffness, mass = np.zeros((12, 12)), np.zeros((12, 12))
    per_length = DENSITY * section.area
    couple, share = np.array([[1, -1], [-1, 1]]) / length, np.array([[2, 1], [1, 2]]) * length / 6
    for rows, rigidity, inertia in (
        ([0, 6], YOUNG * section.area, per_length),
        ([3, 9], SHEAR * section.torsion, DENSITY * section.torsion),
    ):
        stiffness[np.ix_(rows, rows)], mass[np.ix_(rows, rows)] = rigidity * couple, inertia * share
    bend = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    move = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    for rows, sign in (([1, 5, 7, 11], 1), ([2, 4, 8, 10], -1)):
        scale = np.array([1, sign * length, 1, sign * length])
        stiffness[np.ix_(rows, rows)] = YOUNG * section.bending / length**3 * bend * np.outer(scale, scale)
        mass[np.ix_(rows, rows)] = per_length * length / 420 * move * np.outer(scale, scale)
    return stiffness, mass


def local_displacement(x: float, length: float) -> np.ndarray:
    """3 x 12: displacement at the fraction x of an element, by its coordinates."""
    shape = np.zeros((3, 12))
    shape[0, [0, 6]] = 1 - x, x
    bending = [1 - 3 * x**2 + 2 * x**3, length * x * (1 - x) ** 2, 3 * x**2 - 2 * x**3, length * x**2 * (x - 1)]
    shape[1, [1, 5, 7, 11]] = bending
    shape[2, [2, 4, 8, 10]] = bending * np.array([1, -1, 1, -1])
    return shape


def dofs_of(element: tuple[int, int]) -> list[int]:
    return [6 * node + k for node in element for k in range(6)]


def matrices(bars: Bars) -> tuple[np.ndarray, np.ndarray]:
    size = 6 * len(bars.nodes)
    stiffness, mass = np.zeros((size, size)), np.zeros((size, size))
    for element in bars.elements:
        along = bars.nodes[element[1]] - bars.nodes[element[0]]
        turn = np.kron(np.eye(4), axes_of(along))
        local_stiffness, local_mass = element_matrices(bars.section, float(np.linalg.norm(along)))
        place = np.ix_(dofs_of(element), dofs_of(element))
        stiffness[place] += turn.T @ local_stiffness @ turn
        mass[place] += turn.T @ local_mass @ turn
    return stiffness, mass


def motion_at(bars: Bars, node: int, offset: np.ndarray) -> np.ndarray:
    """3 x all coordinates: displacement of a point rigidly joined to a node."""
    rows = np.zeros((3, 6 * len(bars.nodes)))
    rows[:, 6 * node : 6 * node + 3] = np.eye(3)
    rows[:, 6 * node + 3 : 6 * node + 6] = -skew(offset)
    return rows


def skew(v: np.ndarray) -> np.ndarray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


@dataclass(frozen=True)
class Modes:
    """A flexible body about its origin: points with masses, and the displacements of points by modes."""

    points: np.ndarray  # n x 3; the last ones are those without mass at which joints and forces take hold
    masses: np.ndarray  # n
    shapes: np.ndarray  # n x 3 x modes
    stiffness: np.ndarray  # modes x modes
    mass: np.ndarray  # modes x modes, consistent


def reduced(
    bars: Bars,
    origin: np.ndarray,
    clamped: list[int],
    static: list[np.ndarray],
    dynamic: int,
    ends: list[tuple[int, np.ndarray]],
) -> Modes:
    """Static modes: unit values of the rows `static`, one by one; dynamic modes: with all of them held at zero.

    `ends` are points rigidly joined to nodes: the node, and the offset from it.
    """
    stiffness, mass = matrices(bars)
    size, count = len(stiffness), len(static)
    free = [dof for dof in range(size) if dof // 6 not in clamped]
    inner, rows = np.ix_(free, free), np.array(static)[:, free]
    inner_stiffness, inner_mass = stiffness[inner], mass[inner]
    bordered = np.block([[inner_stiffness, rows.T], [rows, np.zeros((count, count))]])
    unit = np.vstack([np.zeros((len(free), count)), np.eye(count)])
    attached = np.linalg.solve(bordered, unit)[: len(free)]
    held = np.linalg.svd(rows)[2][count:].T  # a basis of the displacements with the rows at zero
    vibrating = held @ lowest_modes(held.T @ inner_stiffness @ held, held.T @ inner_mass @ held, dynamic)
    modes = np.zeros((size, count + dynamic))
    modes[free] = np.hstack([attached, vibrating])
    points, masses, shapes = lumped(bars, modes)
    for node, offset in ends:
        points.append(bars.nodes[node] + offset)
        masses.append(0.0)
        shapes.append(motion_at(bars, node, offset) @ modes)
    about = np.array(points) - origin
    return Modes(about, np.array(masses), np.array(shapes), modes.T @ stiffness @ modes, modes.T @ mass @ modes)


def lowest_modes(stiffness: np.ndarray, mass: np.ndarray, count: int) -> np.ndarray:
    lower = np.linalg.inv(np.linalg.cholesky(mass))
    return lower.T @ np.linalg.eigh(lower @ stiffness @ lower.T)[1][:, :count]


def lumped(bars: Bars, modes: np.ndarray) -> tuple[list, list, list]:
    """Mass at five Gauss points of every element, exact for products of its displacements."""
    nodes, weights = np.polynomial.legendre.leggauss(5)
    points, masses, shapes = [], [], []
    for element in bars.elements:
        begin, end = (bars.nodes[node] for node in element)
        axes, length = axes_of(end - begin), float(np.linalg.norm(end - begin))
        turned = np.kron(np.eye(4), axes) @ modes[dofs_of(element)]
        for x, weight in zip((nodes + 1) / 2, weights / 2, strict=True):
            points.append(begin * (1 - x) + end * x)
            masses.append(DENSITY * bars.section.area * length * weight)
            shapes.append(axes.T @ local_displacement(x, length) @ turned)
    return points, masses, shapes

"""The A-arm of examples/solid-arm: its mesh, and its matrices by elements of scikit-fem."""

import pathlib
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

PART = pathlib.Path(__file__).resolve().parents[2] / "examples/solid-arm"
YOUNG, POISSON, DENSITY = 2.1e11, 0.3, 7850.0
# Interfaces: name in the mesh, and reference point in mm; the body's frame moves with the first.
INTERFACES = {
    "front": (108.0, 0.0, 0.0),
    "rear": (-108.0, 0.0, 0.0),
    "ball": (0.0, 321.4603, 0.0),
    "seat": (75.0, 248.6166, -4.6668),
}

# The edges of Gmsh's tetrahedra are 01 12 02 03 23 13, those of scikit-fem's 01 12 02 03 13 23.
ORDER = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]


@dataclass(frozen=True)
class Part:
    file: pathlib.Path
    points: np.ndarray  # n x 3, mm
    tetrahedra: np.ndarray  # elements x 10, order of Gmsh
    groups: dict[str, np.ndarray]  # nodes of each interface, from 0


def mesh(folder: pathlib.Path, size: float | None) -> pathlib.Path:
    """The mesh that lies beside the part, or a finer one of this size of elements, mm, by Gmsh."""
    if size is None:
        return PART / "arm.msh"
    try:
        import gmsh
    except OSError as missing:  # a library of the system's
        raise ImportError(f"gmsh: {missing}") from missing
    file = folder / f"arm-{size:g}.msh"
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.open(str(PART / "arm.geo"))
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    gmsh.model.mesh.optimize("HighOrder")
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
    gmsh.write(str(file))
    gmsh.finalize()
    return file


def read(file: pathlib.Path) -> Part:
    """Of Gmsh's format 2.2 the nodes, the tetrahedra of second order and the groups of triangles."""
    lines = file.read_text().splitlines()

    def section(name: str) -> list[str]:
        start = lines.index(f"${name}")
        return lines[start + 2 : start + 2 + int(lines[start + 1])]

    names = {int(words[1]): words[2].strip('"') for words in map(str.split, section("PhysicalNames"))}
    nodes = [line.split() for line in section("Nodes")]
    place = {int(words[0]): k for k, words in enumerate(nodes)}
    tetrahedra, groups = [], {name: set() for name in INTERFACES}
    for numbers in ([int(word) for word in line.split()] for line in section("Elements")):
        corners = [place[node] for node in numbers[3 + numbers[2] :]]
        if numbers[1] == 11:
            tetrahedra.append(corners)
        elif names.get(numbers[3]) in groups:
            groups[names[numbers[3]]].update(corners)
    points = np.array([[float(word) for word in words[1:]] for words in nodes])
    return Part(file, points, np.array(tetrahedra), {name: np.array(sorted(group)) for name, group in groups.items()})


def matrices(part: Part) -> tuple[csr_matrix, csr_matrix]:
    """Stiffness and mass in SI units, rows: x, y, z of the first node, then of the next."""
    from skfem import Basis, ElementTetP2, ElementVector, MeshTet2
    from skfem.models.elasticity import lame_parameters, linear_elasticity
    from skfem.models.general import BilinearForm

    quadratic = MeshTet2(1e-3 * part.points.T, part.tetrahedra[:, ORDER].T, sort_t=False)
    # Four points of integration for the stiffness, as is usual.
    elastic, basis = (Basis(quadratic, ElementVector(ElementTetP2()), intorder=order) for order in (2, 5))

    @BilinearForm
    def inertia(u, v, w):
        return DENSITY * sum(u[i] * v[i] for i in range(3))

    stiffness = linear_elasticity(*lame_parameters(YOUNG, POISSON)).assemble(elastic)
    mass = inertia.assemble(basis)
    # Each coordinate of the basis is found again among the nodes by its place and direction.
    rows = rows_of(part, basis)
    return stiffness[rows][:, rows].tocsr(), mass[rows][:, rows].tocsr()


def rows_of(part: Part, basis: object) -> np.ndarray:
    """The basis' coordinate of x, y, z of each node."""
    vertices, edges = basis.nodal_dofs, basis.edge_dofs
    rows = np.full((len(part.points), 3), -1)
    corners = basis.mesh.t
    rows[part.tetrahedra[:, :4]] = np.moveaxis(vertices[:, corners], 0, -1).transpose(1, 0, 2)
    local = basis.mesh.t2e
    rows[part.tetrahedra[:, ORDER][:, 4:]] = np.moveaxis(edges[:, local], 0, -1).transpose(1, 0, 2)
    if (rows < 0).any():
        raise RuntimeError(f"{part.file}: a node belongs to no tetrahedron")
    return rows.ravel()

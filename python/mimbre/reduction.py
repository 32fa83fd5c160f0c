"""Bodies that bend, from finite elements: files, matrices, meshes."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _checks, _core
from .errors import InputError

if TYPE_CHECKING:
    Nodes = str | npt.ArrayLike

Floats = npt.NDArray[np.float64]

_motions = ("x", "y", "z", "rx", "ry", "rz")
_bases = ("craig_bampton", "free_interface", "krylov", "attachment", "modal_truncation")
_mass_matrices = ("consistent", "lumped")
_beam_torsions = ("section", "brick")
_frames = ("tangent", "centre_of_mass", "mean_axis")
_units = {"SI": (1.0, 1.0, 1.0), "mm": (1e-3, 1e3, 1.0), "in": (0.0254, 175.126835, 1.0)}


class Check(NamedTuple):
    """A line of a validation report."""

    name: str
    """What was checked."""
    passed: bool
    """Whether it is so."""
    detail: str
    """By which figures."""


@dataclass(frozen=True)
class Interface:
    """Where a joint or a force takes hold of a body: nodes that are tied to a point."""

    nodes: Nodes
    """`set:NAME`, `group:NAME`, `nodes:FILE`, `box(x0,y0,z0, x1,y1,z1)`, `cylinder(px,py,pz, ax,ay,az, r)`, or the
    nodes' labels (of arrays: their row numbers)."""
    tie: Literal["rigid", "mean"] = "rigid"
    """The nodes move as one rigid body with the point (RBE2), or it moves as they do in the mean (RBE3)."""
    point: npt.ArrayLike | None = None
    """3, in the file's unit of length; default: the mean of the nodes."""
    axes: npt.ArrayLike | None = None
    """3 × 3, columns are its x, y and z in body axes; default: those of the body."""
    free: Iterable[str] = ()
    """Motions of x y z rx ry rz that a joint leaves free: no static modes, dynamic modes have them."""
    held: Iterable[str] = ()
    """Motions that never happen."""


class ReducedBody:
    """A body that moves with a few modes: `reduce` makes one, a model takes it.

    Example:
        ```python
        arm = mimbre.ReducedBody.open("arm.h5")
        m.add_body("arm", reduced=arm, frame={"at": [0, 0, 0]})
        ```
    """

    def __init__(self, compiled: _core.ReducedBody, reduction: _core.Reduction | None = None) -> None:
        self._compiled = compiled
        self._reduction = reduction

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> ReducedBody:
        """Reads .h5 (docs/reduced-body-format.md), MBDyn's .fem, or .sid; InputError where it is none."""
        return cls(_core.read_body(_checks.path("path", path)))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes it, by the ending: .h5, .fem, .sid; InputError of any other."""
        self._compiled.save(_checks.path("path", path))

    def report(self, path: str | os.PathLike[str]) -> None:
        """Writes a page with its validation report and its modes, animated."""
        self._compiled.write_report(_checks.path("path", path))

    @property
    def name(self) -> str:
        """What it calls itself."""
        return self._compiled.name

    @property
    def mass(self) -> float:
        """kg"""
        return self._compiled.mass

    @property
    def modes(self) -> int:
        """How many modes it has, n."""
        return self._compiled.modes

    @property
    def mode_names(self) -> list[str]:
        """Of the n modes, in the order of the matrices."""
        return self._compiled.mode_names

    @property
    def mass_matrix(self) -> Floats:
        """Of the modal amplitudes, n × n."""
        return self._compiled.mass_matrix

    @property
    def stiffness(self) -> Floats:
        """Of the modal amplitudes, n × n."""
        return self._compiled.stiffness

    @property
    def damping(self) -> Floats:
        """Of the modal amplitudes, n × n."""
        return self._compiled.damping

    @property
    def nodes(self) -> Floats:
        """Points of its picture, nodes × 3, body axes, m."""
        return self._compiled.nodes.T

    @property
    def shapes(self) -> Floats:
        """Displacements of these points, nodes × 3 × modes."""
        shapes = self._compiled.node_shapes
        return shapes.reshape(-1, 3, shapes.shape[1])

    @property
    def labels(self) -> list[int]:
        """Of these points in the file of their mesh, or their row numbers in arrays; empty: unknown."""
        return list(self._compiled.node_labels)

    @property
    def stress(self) -> Floats | None:
        """Of these points by the modes, nodes × 6 × modes: xx yy zz xy yz zx, body axes, Pa; None: unknown."""
        return _by_points(self._compiled.stress)

    @property
    def strain(self) -> Floats | None:
        """Likewise; shear strains twice the tensor's entries."""
        return _by_points(self._compiled.strain)

    @property
    def frames(self) -> dict[str, Floats]:
        """Where joints and forces can take hold: positions, body axes, m."""
        return self._compiled.frames

    @property
    def checks(self) -> list[Check]:
        """The validation report of its reduction."""
        return [Check(*check) for check in self._compiled.checks]

    @property
    def passed(self) -> bool:
        """Whether all checks of the validation report are passed."""
        return all(check.passed for check in self.checks)

    @property
    def frequencies(self) -> Floats:
        """Of the dynamic modes with interfaces held, Hz; of a body that was made here."""
        return self._made().frequencies

    @property
    def free_frequencies(self) -> Floats:
        """Elastic modes of the full model, free, Hz; of a body that was made here."""
        return self._made().free_frequencies

    @property
    def reduced_free_frequencies(self) -> Floats:
        """The same of the reduced body."""
        return self._made().reduced_free_frequencies

    @property
    def effective_mass(self) -> Floats:
        """Of the dynamic modes: % of the mass in x y z, of the moments of inertia in rx ry rz; modes × 6."""
        return self._made().effective_mass

    def _made(self) -> _core.Reduction:
        if self._reduction is None:
            raise InputError("the body was read from a file, which has its modes but not the full model's frequencies")
        return self._reduction

    def __deepcopy__(self, memo: dict[int, Any]) -> ReducedBody:
        return self  # nothing of it changes

    def __reduce__(self) -> tuple[Any, ...]:
        raise TypeError("a ReducedBody is saved with save(path), not pickled")

    def __repr__(self) -> str:
        return f"<mimbre.ReducedBody {self.name!r}: {self.modes} modes, {self.mass:g} kg>"


def _by_points(rows: Floats) -> Floats | None:
    return rows.reshape(-1, 6, rows.shape[1]) if rows.size else None


def reduce(
    source: str | os.PathLike[str] | Any = None,
    *,
    interfaces: Mapping[str, Interface | Nodes],
    stiffness: Any = None,
    mass: Any = None,
    nodes: Any = None,
    dofs: Any = None,
    materials: Mapping[str, tuple[float, float, float]] | tuple[float, float, float] | None = None,
    thickness: Mapping[str, float] | float = 0.0,
    density: Mapping[str, float] | float | None = None,
    units: Literal["SI", "mm", "in"] = "SI",
    name: str | None = None,
    modes: int = 10,
    basis: Literal["craig_bampton", "free_interface", "krylov", "attachment", "modal_truncation"] = "craig_bampton",
    frame: Literal["tangent", "centre_of_mass", "mean_axis"] = "tangent",
    max_frequency: float = 0.0,
    krylov_frequency: float = 0.0,
    effective_mass: float = 0.0,
    mass_matrix: Literal["consistent", "lumped"] = "consistent",
    beam_torsion: Literal["section", "brick"] = "section",
    damping: float = 0.0,
    geometric_stiffness: bool = False,
    free_modes: int = 10,
    loads: Mapping[str, tuple[Nodes, npt.ArrayLike]] | None = None,
    user_modes: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    stress: Any = None,
    stress_nodes: str | os.PathLike[str] | Iterable[int] | None = None,
    progress: Callable[[str, float], object] | None = None,
) -> ReducedBody:
    """Reduces a finite-element model to a body, with a validation report; as `mimbre reduce` (docs/finite-elements.md).

    The model is a file, a meshio mesh, or matrices of SciPy. Ctrl-C ends the reduction at the next stage.

    Args:
        source: a file (.msh, .inp, .mtx, .npz, .pch …), with `mass`, `nodes` and `dofs` as files where it needs them;
            or a meshio mesh (its `cell_sets` or blocks make the groups, its `point_sets` the node sets).
        interfaces: by name an Interface, or its nodes; a tangent frame moves with the first.
        stiffness: in place of a source a SciPy matrix, full symmetric and free, rows × rows.
        mass: likewise; of a file that has none, a file.
        nodes: points × 3, m; of a file that has none, a file.
        dofs: rows × 2, node and direction (0-2 displacements, 3-5 rotations) of each; default: 3 or 6 a node, in their
            order; of a file that has none, a file.
        materials: Young's modulus (Pa), Poisson's ratio, density (kg/m³), of all or by group.
        thickness: of shells without one, of all or by group, in the mesh's unit of length.
        density: of a file's materials without one, of all or by their names, kg/m³.
        units: of the file: "SI", "mm" (mm, N, t) or "in" (in, lbf).
        name: of the body; default: the file's.
        modes: how many dynamic modes, 0 to 1000.
        basis: "craig_bampton", "free_interface", "krylov", "attachment" or "modal_truncation".
        frame: what the body's frame moves with: "tangent" (the first interface), "centre_of_mass" or "mean_axis".
        max_frequency: all dynamic modes up to this, Hz, in place of `modes`.
        krylov_frequency: about which the Krylov basis matches the response, Hz.
        effective_mass: only those dynamic modes that reach this share of the body's mass, %.
        mass_matrix: "consistent", or "lumped": masses at the nodes of solids and beams.
        beam_torsion: the torsion constant of an .inp file's beams: of the "section", or of the "brick" into which
            CalculiX expands it.
        damping: β of C = β K, s.
        geometric_stiffness: tension and compression change the stiffness.
        free_modes: how many free modes of full and reduced model the validation report compares.
        loads: by name nodes and a force (3, N) that is spread on them: how it deflects the body becomes a mode.
        user_modes: dofs (rows × 2) and shapes (rows × modes).
        stress: of another program, stress by displacements, a SciPy matrix or an .npz file of one: rows xx yy zz xy yz
            zx of each node, columns as those of the stiffness matrix. Bodies of elements have theirs without it.
        stress_nodes: the nodes of its rows, labels or a file of them; default: all, in order.
        progress: is called with what is being done and how much of it is, 0 to 1.

    Returns:
        The body, with `checks`, `passed` and frequencies.

    Raises:
        InputError: the model, an interface or an option is bad: what, and what would be right.

    Example:
        ```python
        arm = mimbre.reduce(
            "arm.msh", materials=(2.1e11, 0.3, 7850), modes=10,
            interfaces={"front": "group:front", "ball": "group:ball"},
        )
        print(arm.passed, arm.frequencies)
        ```
    """
    if not isinstance(interfaces, Mapping) or not interfaces:
        raise InputError("interfaces: at least one is needed, as {'pivot': 'set:pivot'}")
    options = _core.ReductionOptions()
    options.basis = _index("basis", basis, _bases)
    options.frame = _index("frame", frame, _frames)
    options.mass_matrix = _index("mass_matrix", mass_matrix, _mass_matrices)
    options.modes = _count("modes", modes)
    options.free_modes = _count("free_modes", free_modes)
    options.max_frequency = _at_least_0("max_frequency", max_frequency)
    options.krylov_frequency = _at_least_0("krylov_frequency", krylov_frequency)
    options.effective_mass = _at_least_0("effective_mass", effective_mass)
    options.damping = _at_least_0("damping", damping)
    options.geometric_stiffness = _checks.flag("geometric_stiffness", geometric_stiffness)
    options.interfaces = [_interface(_checks.text("interfaces", key), value) for key, value in interfaces.items()]
    options.loads = [
        (key, _selection(f"load {key!r}", where), _vector(f"load {key!r}", force))
        for key, (where, force) in (
            (key, _checks.pair(f"load {key!r}", load, "(nodes, force)"))
            for key, load in _checks.mapping(
                "loads", {} if loads is None else loads, "names with (nodes, force)"
            ).items()
        )
    ]
    if user_modes is not None:
        which, shapes = _checks.pair("user_modes", user_modes, "(dofs, shapes)")
        options.user_dofs = _dofs("user_modes", which)
        options.user_shapes = np.asfortranarray(_checks.array("user_modes: shapes", shapes, 2))
    options.report = _checks.callback(progress)
    if stress is None and stress_nodes is not None:
        raise InputError("stress_nodes: belongs to `stress`, which is not given")
    torsion = _index("beam_torsion", beam_torsion, _beam_torsions)
    model, given_name = _model(
        source, stiffness, mass, nodes, dofs, _materials(materials), thickness, density, torsion, units
    )
    if stress is not None:
        options.stress = _stress(model, stress, stress_nodes, _units[units])
    reduction = _core.reduce(model, options, given_name if name is None else _checks.text("name", name))
    return ReducedBody(reduction.body, reduction)


def _model(
    source: Any,
    stiffness: Any,
    mass: Any,
    nodes: Any,
    dofs: Any,
    materials: dict[str, tuple[float, float, float]],
    thickness: Any,
    density: Any,
    torsion: int,
    units: str,
) -> tuple[_core.FeModel, str]:
    """The finite-element model, and what it may be called."""
    factors = _units[_checks.known("unit system", units, _units)]
    if isinstance(source, str | os.PathLike):
        given = (mass, nodes, dofs)
        names = ("mass", "nodes", "dofs")
        a, b, c = ("" if file is None else _checks.path(name, file) for name, file in zip(names, given, strict=True))
        densities = _by_name("density", density)
        depths = {k: factors[0] * t for k, t in _by_name("thickness", thickness or None).items()}
        path = _checks.path("source", source)
        return _core.read_fe(path, a, b, c, materials, densities, depths, torsion, factors), Path(source).stem
    if density is not None:
        raise InputError("density: is for a file's materials; those of a mesh have their own")
    if torsion != 0:
        raise InputError("beam_torsion: is for the beams of an .inp file")
    if source is not None:
        return _mesh(source, materials, thickness), "body"
    if stiffness is None or mass is None or nodes is None:
        raise InputError("reduce: a file, a mesh, or stiffness, mass and nodes are needed")
    points = np.asfortranarray(_checks.array("nodes", nodes, 2))
    if points.shape[1] != 3:
        raise InputError(f"nodes: three coordinates each are needed, not {points.shape[1]}")
    k, m = _sparse("stiffness", stiffness), _sparse("mass", mass)
    if dofs is None:
        per_node, rest = divmod(k.shape[0], len(points)) if len(points) else (0, 1)
        if rest or per_node not in (3, 6):
            raise InputError(
                f"dofs: {k.shape[0]} rows are not 3 or 6 for each of {len(points)} nodes; specify of which "
                "node and direction each is"
            )
        dofs = np.stack(np.divmod(np.arange(k.shape[0]), per_node), axis=1)
    return _core.fe_from_matrices(k, m, points, _dofs("dofs", dofs)), "body"


def _mesh(mesh: Any, materials: dict[str, tuple[float, float, float]], thickness: Any) -> _core.FeModel:
    """The model of a mesh as meshio has it. Blocks of points and lines only make node sets."""
    try:
        points, blocks = mesh.points, mesh.cells
    except AttributeError:
        raise InputError(f"reduce: a file's name or a meshio mesh is needed, not {_checks.described(mesh)}") from None
    groups, sets = (
        [],
        {name: np.asarray(nodes).tolist() for name, nodes in getattr(mesh, "point_sets", {}).items()},
    )
    points = _checks.array("points", points, 2)
    if points.shape[1] != 3:
        raise InputError(f"points: three coordinates each are needed, not {points.shape[1]}")
    names = ["" for _ in blocks]
    for name, members in getattr(mesh, "cell_sets", {}).items():
        for k, cells in enumerate(members):
            if cells is None or not len(cells):
                continue
            sets[name] = sorted(
                {*sets.get(name, []), *np.unique(blocks[k].data[np.asarray(cells, dtype=int)]).tolist()}
            )
            if len(cells) == len(blocks[k].data):
                names[k] = name
    solid = any(block.type.startswith(("tetra", "hexahedron", "wedge")) for block in blocks)
    for name, block in zip(names, blocks, strict=True):
        if block.type in ("vertex", "line", "line3") or (solid and block.type.startswith(("triangle", "quad"))):
            continue
        depth = thickness.get(name, 0.0) if isinstance(thickness, Mapping) else thickness
        groups.append((block.type, name, np.asarray(block.data).ravel().tolist(), _checks.number("thickness", depth)))
    return _core.fe_from_mesh(np.asfortranarray(points), groups, materials, sets)


def _stress(model: _core.FeModel, stress: Any, nodes: Any, units: tuple[float, float, float]) -> _core.StressMatrix:
    """The library reads it as SciPy writes it."""
    with tempfile.TemporaryDirectory(prefix="mimbre-") as folder:
        matrix, table = Path(folder, "stress.npz"), Path(folder, "nodes.csv")
        if isinstance(stress, str | os.PathLike):
            matrix = Path(_checks.path("stress", stress))
        else:
            import scipy.sparse

            scipy.sparse.save_npz(matrix, _finite("stress", stress), compressed=False)
        if isinstance(nodes, str | os.PathLike):
            table = Path(_checks.path("stress_nodes", nodes))
        elif nodes is not None:
            labels = _selection("stress_nodes", np.asarray(nodes))
            table.write_text("\n".join(map(str, labels)), encoding="ascii")
        try:
            return _core.read_stress(model, str(matrix), "" if nodes is None else str(table), units)
        except InputError as error:
            if Path(folder) not in (matrix.parent, table.parent):
                raise
            raise InputError("\n".join(f"stress: {wrong.message}" for wrong in error.diagnostics)) from None


def _interface(name: str, given: object) -> tuple[Any, ...]:
    interface = given if isinstance(given, Interface) else Interface(given)  # type: ignore[arg-type]
    what = f"interface {name!r}"
    motions = [0] * 6
    for words, kind in ((interface.free, 1), (interface.held, 2)):
        for word in words.split(",") if isinstance(words, str) else words:
            k = _index(what, word, _motions)
            if motions[k] not in (0, kind):
                raise InputError(f"{what}: {word} is free and held at once")
            motions[k] = kind
    axes = None if interface.axes is None else np.asfortranarray(_checks.array(f"{what}: axes", interface.axes, 2))
    if axes is not None and (
        axes.shape != (3, 3) or not np.allclose(axes.T @ axes, np.eye(3), atol=1e-9) or np.linalg.det(axes) < 0
    ):
        raise InputError(f"{what}: axes are the columns of a 3 × 3 rotation matrix")
    point = None if interface.point is None else _vector(f"{what}: point", interface.point)
    return (
        name,
        _selection(what, interface.nodes),
        _index(f"{what}: tie", interface.tie, ("rigid", "mean")) == 1,
        point,
        axes,
        motions,
    )


def _table(given: object) -> npt.NDArray[Any]:
    """Empty where rows are of different lengths."""
    try:
        return np.asarray(given)
    except ValueError:
        return np.empty(0)


def _selection(what: str, nodes: object) -> str | list[int]:
    if isinstance(nodes, str):
        return _checks.text(what, nodes)
    labels = _table(nodes)
    if labels.ndim != 1 or not len(labels) or not np.issubdtype(labels.dtype, np.integer):
        raise InputError(
            f"{what}: a selection such as 'set:NAME', or a list of nodes' numbers is needed, "
            f"not {_checks.described(nodes)}"
        )
    return [int(label) for label in labels]


def _dofs(what: str, given: object) -> list[tuple[int, int]]:
    dofs = _table(given)
    if dofs.ndim != 2 or dofs.shape[1] != 2 or not np.issubdtype(dofs.dtype, np.integer):
        raise InputError(
            f"{what}: rows of two whole numbers are needed, node and direction, not {_checks.described(given)}"
        )
    if dofs.size and (np.abs(dofs) >= 2**31).any():
        raise InputError(f"{what}: numbers below 2**31 are needed")
    return [(int(node), int(direction)) for node, direction in dofs]


def _sparse(what: str, given: Any) -> Any:
    """Symmetric, as the library takes it."""
    matrix = _finite(what, given)
    difference = abs(matrix - matrix.T).max() if matrix.shape[0] == matrix.shape[1] and matrix.nnz else 0.0
    if matrix.shape[0] != matrix.shape[1] or difference > 1e-9 * abs(matrix).max():
        raise InputError(f"{what}: a symmetric matrix is needed, full (both triangles)")
    return matrix


def _finite(what: str, given: Any) -> Any:
    """A SciPy matrix by columns, of finite numbers."""
    import scipy.sparse

    try:
        matrix = scipy.sparse.csc_matrix(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{what}: a SciPy matrix is needed, not {_checks.described(given)}") from None
    if not np.isfinite(matrix.data).all():
        raise InputError(f"{what}: has entries that are not finite")
    matrix.sum_duplicates()
    return matrix


def _materials(given: Any) -> dict[str, tuple[float, float, float]]:
    named = given if isinstance(given, Mapping) else {} if given is None else {"": given}
    materials = {}
    for name, values in named.items():
        numbers = _checks.array(f"material {name!r}", values)
        if len(numbers) != 3:
            raise InputError(f"material {name!r}: Young's modulus, Poisson's ratio and density are needed")
        materials[_checks.text("materials", name)] = (numbers[0].item(), numbers[1].item(), numbers[2].item())
    return materials


def _by_name(what: str, given: Any) -> dict[str, float]:
    named = given if isinstance(given, Mapping) else {} if given is None else {"": given}
    return {_checks.text(what, name): _checks.number(what, value) for name, value in named.items()}


def _vector(what: str, given: object) -> Floats:
    vector = _checks.array(what, given)
    if len(vector) != 3:
        raise InputError(f"{what}: three numbers are needed, not {len(vector)}")
    return vector


def _index(what: str, word: object, words: tuple[str, ...]) -> int:
    return words.index(_checks.known(f"{what}:", word, words))


def _count(what: str, given: object) -> int:
    value = _checks.number(what, given)
    if value != int(value) or not 0 <= value <= 1000:
        raise InputError(f"{what}: is {value:g}; a whole number from 0 to 1000 is needed")
    return int(value)


def _at_least_0(what: str, given: object) -> float:
    value = _checks.number(what, given)
    if value < 0:
        raise InputError(f"{what}: is {value:g}; it cannot be below 0")
    return value

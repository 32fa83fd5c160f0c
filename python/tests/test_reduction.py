"""Bodies from finite elements: from a mesh's file, from arrays, from matrices, the same each time."""

from __future__ import annotations

import json

import mimbre
import numpy as np
import pytest
import scipy.sparse
from conftest import program

STEEL = (2.1e11, 0.3, 7850.0)


def bar(length=0.5, width=0.02, n=(8, 2, 2)):
    """A bar along x of bricks: points and cells."""
    axes = [np.linspace(0, length, n[0] + 1), *(np.linspace(-width / 2, width / 2, k + 1) for k in n[1:])]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape([k + 1 for k in n])
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = np.stack(
        [number[tuple(slice(c, c + k) for c, k in zip(corner, n, strict=True))].ravel() for corner in corners],
        axis=-1,
    )
    return points, cells


class Mesh:
    """What mimbre.reduce needs of a meshio mesh."""

    class Block:
        def __init__(self, kind, data):
            self.type, self.data = kind, data

    def __init__(self, points, cells):
        self.points, self.cells = points, [self.Block("hexahedron", cells)]
        self.point_sets = {
            "root": np.flatnonzero(points[:, 0] == 0),
            "tip": np.flatnonzero(points[:, 0] == points[:, 0].max()),
        }
        self.cell_sets = {"all": [np.arange(len(cells))]}


@pytest.fixture(scope="module")
def mesh():
    return Mesh(*bar())


def reduced(source, **options):
    return mimbre.reduce(source, interfaces={"root": "set:root", "tip": "set:tip"}, materials=STEEL, modes=4, **options)


def test_a_bar_weighs_and_bends_as_its_closed_form_says(mesh):
    body = reduced(mesh, name="bar", free_modes=4)
    assert body.passed, [check for check in body.checks if not check.passed]
    assert body.mass == pytest.approx(7850 * 0.5 * 0.02**2, rel=1e-9)
    assert set(body.frames) == {"root", "tip"}
    assert body.frames["tip"] == pytest.approx([0.5, 0, 0], abs=1e-12)
    assert body.modes == len(body.mode_names) == len(body.stiffness)
    assert body.shapes.shape[1:] == (3, body.modes)
    # Clamped at both ends: λ₁ = 4.730; bricks without bubbles are a little stiff.
    first = 4.730**2 * np.sqrt(2.1e11 * 0.02**2 / 12 / 7850) / 0.5**2 / (2 * np.pi)
    assert body.frequencies[0] == pytest.approx(first, rel=0.2)
    assert body.frequencies[0] > first * 0.97
    assert body.free_frequencies[:4] == pytest.approx(body.reduced_free_frequencies[:4], rel=0.02)


def test_a_mesh_in_the_plane_is_refused(mesh):
    with pytest.raises(mimbre.InputError, match="points: three coordinates each are needed, not 2"):
        reduced(Mesh(mesh.points[:, :2], mesh.cells[0].data))


@pytest.mark.parametrize("name", ["../arm", "left/arm", "..", ".arm", "", "Träger 1", "x" * 300])
def test_a_body_s_name_does_not_say_where_it_is_written(mesh, tmp_path, name):
    m = mimbre.ModelBuilder()
    body = reduced(mesh, name=name)
    for place in ("one", "other"):
        m.add_body(place, reduced=body, frame={"at": [0, 0, 0]})
        m.add_joint(f"pin_of_{place}", type="fixed", between=["ground", f"{place}.root"])
    m.compile()
    folder = tmp_path / "below"
    folder.mkdir()
    m.to_yaml(folder / "model.yaml")
    assert [path.name for path in tmp_path.iterdir()] == ["below"]
    (written,) = folder.glob("*.h5")
    assert not written.name.startswith(".")
    mimbre.Model.from_file(folder / "model.yaml")


def test_a_file_gives_what_the_program_makes(examples, tmp_path):
    path = examples / "solid-arm/arm.msh"
    interfaces = {"front": "group:front", "ball": "group:ball"}
    options = [f"--interface={name}={nodes}" for name, nodes in interfaces.items()]
    made = tmp_path / "arm.h5"
    answer = program("reduce", path, "--material=2.1e11,0.3,7850", *options, "--no-cache", "--json", "-o", made, code=4)
    model = json.loads(answer)
    body = mimbre.reduce(path, interfaces=interfaces, materials=STEEL, name="arm")
    body.save(tmp_path / "python.h5")
    assert body.frequencies == pytest.approx(model["frequencies_hz"], rel=1e-12)
    assert (tmp_path / "python.h5").read_bytes() == (tmp_path / "arm.h5").read_bytes()
    again = mimbre.ReducedBody.open(tmp_path / "arm.h5")
    assert np.array_equal(again.stiffness, body.stiffness)
    with pytest.raises(mimbre.InputError, match="read from a file"):
        _ = again.frequencies


def assembled(points, cells):
    """Mass and stiffness of eight-node bricks with sides along the axes, by 2 × 2 × 2 points, in SciPy; with the
    incompatible modes 1 - ξ² (Wilson, Taylor), which let bricks bend."""
    signs = np.array([(x, y, z) for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], dtype=float)
    E, nu, density = STEEL
    C = np.diag([2, 2, 2, 1, 1, 1]) * E / (2 * (1 + nu))
    C[:3, :3] += E * nu / ((1 + nu) * (1 - 2 * nu))
    sides = np.ptp(points[cells[0]], axis=0)
    k, m = np.zeros((33, 33)), np.zeros((24, 24))
    for gauss in signs / np.sqrt(3):
        f = 1 + signs * gauss
        gradient = np.zeros((3, 11))
        for i in range(3):
            gradient[i, :8] = signs[:, i] * f[:, (i + 1) % 3] * f[:, (i + 2) % 3] / 8 * 2 / sides[i]
            gradient[i, 8 + i] = -2 * gauss[i] * 2 / sides[i]
        B = np.zeros((6, 33))
        for i, j in ((0, 1), (1, 2), (2, 0)):
            B[i, i::3] = gradient[i]
            B[3 + i, i::3], B[3 + i, j::3] = gradient[j], gradient[i]
        N = np.kron(f.prod(axis=1) / 8, np.eye(3))
        k += B.T @ C @ B * sides.prod() / 8
        m += density * N.T @ N * sides.prod() / 8
    k = k[:24, :24] - k[:24, 24:] @ np.linalg.solve(k[24:, 24:], k[24:, :24])
    rows = (3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), 24)
    where = np.repeat(rows, 24, axis=1).ravel(), np.tile(rows, (1, 24)).ravel()
    size = 3 * len(points)
    return tuple(scipy.sparse.coo_matrix((np.tile(e.ravel(), len(cells)), where), (size, size)).tocsr() for e in (k, m))


def test_matrices_of_scipy_give_the_body_of_the_mesh(mesh):
    points, cells = mesh.points, mesh.cells[0].data
    k, m = assembled(points, cells)
    nodes = {name: mesh.point_sets[name] for name in ("root", "tip")}
    from_matrices = mimbre.reduce(stiffness=k, mass=m, nodes=points, interfaces=nodes, modes=4)
    from_mesh = reduced(mesh)
    assert from_matrices.frequencies == pytest.approx(from_mesh.frequencies, rel=1e-6)
    assert from_matrices.mass == pytest.approx(from_mesh.mass, rel=1e-9)

    # In any order of the rows, and said so.
    order = np.random.default_rng(1).permutation(k.shape[0])
    dofs = np.stack(np.divmod(order, 3), axis=1)
    shuffled = mimbre.reduce(
        stiffness=k[order][:, order],
        mass=m[order][:, order],
        nodes=points,
        dofs=dofs,
        interfaces=nodes,
        modes=4,
    )
    assert np.allclose(shuffled.stiffness, from_matrices.stiffness, rtol=1e-9)


def test_matrices_are_those_of_their_files(mesh, tmp_path):
    """A body from SciPy's matrices in memory is the one of the files that SciPy writes."""
    points, cells = mesh.points, mesh.cells[0].data
    k, m = assembled(points, cells)
    scipy.sparse.save_npz(tmp_path / "k.npz", scipy.sparse.csc_matrix(k))
    scipy.sparse.save_npz(tmp_path / "m.npz", scipy.sparse.csc_matrix(m))
    np.savetxt(tmp_path / "nodes.csv", np.column_stack([np.arange(len(points)), points]), delimiter=",", fmt="%.17g")
    nodes = {name: mesh.point_sets[name] for name in ("root", "tip")}
    here = mimbre.reduce(stiffness=k, mass=m, nodes=points, interfaces=nodes, modes=4)
    files = mimbre.reduce(
        tmp_path / "k.npz", mass=tmp_path / "m.npz", nodes=tmp_path / "nodes.csv", interfaces=nodes, modes=4
    )
    assert np.allclose(here.stiffness, files.stiffness, rtol=1e-10)
    assert here.frequencies == pytest.approx(files.frequencies, rel=1e-10)


def stress_along(points):
    """Axial stress by the difference to the next node along the bar: none of it in rigid motions."""
    count = len(points)
    rows = {tuple(np.round(point, 9)): k for k, point in enumerate(points)}
    step = np.diff(np.unique(points[:, 0]))[0]
    stress = scipy.sparse.lil_matrix((6 * count, 3 * count))
    for k, point in enumerate(points):
        sign = 1 if point[0] + step < points[:, 0].max() + 1e-9 else -1
        other = rows[tuple(np.round(point + sign * step * np.eye(3)[0], 9))]
        stress[6 * k, 3 * other] = STEEL[0] / (sign * step)
        stress[6 * k, 3 * k] = -STEEL[0] / (sign * step)
    return stress.tocsr()


def test_stress_of_another_program(mesh, tmp_path):
    """A matrix of SciPy, in memory or in its file, of all nodes or of some."""
    points, cells = mesh.points, mesh.cells[0].data
    k, m = assembled(points, cells)
    nodes = {name: mesh.point_sets[name] for name in ("root", "tip")}
    stress = stress_along(points)

    def made(**keys):
        return mimbre.reduce(stiffness=k, mass=m, nodes=points, interfaces=nodes, modes=4, **keys)

    assert made().stress is None
    body = made(stress=stress)
    assert [check.passed for check in body.checks if check.name == "stress matrix"] == [True]
    count = len(points)
    assert body.stress.shape == (count, 6, body.modes)
    assert body.strain is None
    moved = stress @ body.shapes.reshape(3 * count, body.modes)
    assert np.allclose(body.stress.reshape(6 * count, body.modes), moved, atol=1e-9 * np.abs(moved).max())
    scipy.sparse.save_npz(tmp_path / "s.npz", stress)
    assert np.array_equal(made(stress=tmp_path / "s.npz").stress, body.stress)
    some = [17, 4]
    part = made(stress=stress.tolil().reshape(count, -1).tocsr()[some].reshape(12, 3 * count), stress_nodes=some)
    assert part.labels == some
    assert np.allclose(part.stress, body.stress[some], rtol=1e-9, atol=1e-6)
    for wrong, said in (
        ({"stress": stress[:-1]}, "stress: has 485 rows where the model's 81 nodes need 486"),
        ({"stress": stress[:, :-1]}, "stress: has 242 columns where the model has 243 dofs"),
        ({"stress": np.nan * stress}, "stress: has entries that are not finite"),
        ({"stress": stress[:12], "stress_nodes": [1, 1]}, "node 1 is there twice"),
        ({"stress_nodes": [1]}, "which is not given"),
        ({"stress": "stress.txt"}, "is no sparse matrix by its name"),
    ):
        with pytest.raises(mimbre.InputError, match=said):
            made(**wrong)


def cantilever(body):
    m = mimbre.ModelBuilder("Cantilever", gravity=[0, 0, 0])
    m.add_body("beam", reduced=body, frame={"at": [0, 0, 0]})
    m.add_joint("wall", type="fixed", between=["ground", "beam.root"])
    m.add_load("push", on="beam.tip", force=[0, 0, 1], scale="10*(1 - cos(20*t))")
    m.add_output("tip", deflection="beam.tip", along=[0, 0, 1])
    m.set_simulation(step=1e-3, end=0.1)
    return m


def test_a_body_goes_into_a_model(mesh, tmp_path):
    m = cantilever(reduced(mesh, name="bar", damping=1e-5))
    model = m.compile()
    run = model.run()
    # Slow against the beam's first frequency: F l³ / 3 E I, in the bricks' own stiffness.
    slow = 10 * (1 - np.cos(20 * run.time)) * 0.5**3 / (3 * 2.1e11 * 0.02**4 / 12)
    assert run["tip"][-1] == pytest.approx(slow[-1], rel=0.2)
    m.to_yaml(tmp_path / "model.yaml")
    read = mimbre.Model.from_file(tmp_path / "model.yaml")
    assert read.simulation().fingerprint == model.simulation().fingerprint
    assert np.array_equal(read.run()["tip"], run["tip"])


def test_interfaces_have_ties_and_motions(mesh):
    tip = mimbre.Interface("set:tip", tie="mean", point=[0.5, 0, 0.01], free="ry", held=["rx"])
    body = mimbre.reduce(mesh, interfaces={"root": "set:root", "tip": tip}, materials=STEEL, modes=0)
    assert body.modes == 4
    assert body.frames["tip"] == pytest.approx([0.5, 0, 0.01])
    for wrong, said in (
        (mimbre.Interface("set:tip", free="ry", held="ry"), "free and held at once"),
        (mimbre.Interface("set:tip", tie="rigidd"), "did you mean 'rigid'?"),
        (mimbre.Interface("set:tipp"), "tip"),
        (mimbre.Interface([10**9]), "there is no node 1000000000"),
        (mimbre.Interface("set:tip", axes=np.ones((3, 3))), "rotation matrix"),
    ):
        with pytest.raises(mimbre.InputError, match=r".") as told:
            mimbre.reduce(mesh, interfaces={"root": "set:root", "tip": wrong}, materials=STEEL)
        assert said in str(told.value)


def test_progress_is_told_and_may_stop(mesh):
    stages = []
    reduced(mesh, progress=lambda stage, done: stages.append(stage))
    assert len(set(stages)) > 1

    def stop(stage, done):
        raise TimeoutError("enough")

    with pytest.raises(TimeoutError, match="enough"):
        reduced(mesh, progress=stop)


def test_bases_and_mass_matrices(mesh):
    few = reduced(mesh, free_modes=0)
    attached = reduced(mesh, basis="attachment", free_modes=0)
    truncated = reduced(mesh, basis="modal_truncation", free_modes=0)
    assert (few.modes, attached.modes, truncated.modes) == (10, 10, 16)
    lumped = reduced(mesh, mass_matrix="lumped", free_modes=0)
    assert lumped.mass == pytest.approx(few.mass, rel=1e-12)
    assert (lumped.frequencies < few.frequencies).all()
    with pytest.raises(mimbre.InputError, match="consistent, lumped"):
        reduced(mesh, mass_matrix="lump")


def test_beams_twist_as_the_bricks_of_calculix(mesh, tmp_path):
    """A square bar whose sections cannot warp: torsion waves have the speed of shear waves."""
    lines = ["*NODE", *(f"{k + 1}, {k / 40}, 0, 0" for k in range(41)), "*ELEMENT, TYPE=B32R, ELSET=E"]
    lines += [f"{k + 1}, {2 * k + 1}, {2 * k + 2}, {2 * k + 3}" for k in range(20)]
    lines += ["*MATERIAL, NAME=S", "*ELASTIC", "2.1e11, 0.3", "*DENSITY", "7850"]
    lines += ["*BEAM SECTION, ELSET=E, MATERIAL=S, SECTION=RECT", "0.1, 0.1", "0, 0, 1", ""]
    deck = tmp_path / "bar.inp"
    deck.write_text("\n".join(lines))

    def nearest(torsion):
        body = mimbre.reduce(deck, interfaces={"end": [1]}, modes=2, free_modes=7, beam_torsion=torsion)
        return np.abs(body.free_frequencies / (np.sqrt(2.1e11 / 2.6 / 7850) / 2) - 1).min()

    assert nearest("brick") < 3e-4
    assert nearest("section") > 0.02
    for source, torsion, said in ((mesh, "brick", "an .inp file"), (deck, "bricks", "did you mean 'brick'")):
        with pytest.raises(mimbre.InputError, match=said):
            mimbre.reduce(source, interfaces={"end": [1]}, beam_torsion=torsion)

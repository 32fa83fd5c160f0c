"""The reduction of a solid part to interface modes and ten dynamic modes, in mimbre and Exudyn."""

import json
import os
import time

import numpy as np
import solid_model
from program import Program
from runner import Case, Runner, optional
from scipy.sparse import save_npz

MODES = 10
MATERIAL = f"{solid_model.YOUNG!r},{solid_model.POISSON!r},{solid_model.DENSITY!r}"


def case(program: Program, size: float | None) -> Case:
    """From the mesh beside the part, or from one with elements of this size, mm."""
    part = solid_model.read(solid_model.mesh(program.folder, size))
    write_matrices(program, part)
    reference = logarithms(frequencies(program, from_mesh(part)))
    mesh, files = from_mesh(part), from_matrices(part)
    runners = [
        own(program, "from the mesh, its own elements, validation report", mesh),
        own(program, "from matrices, validation report", files),
        own(program, "from matrices, without the report's modes of the free part", [*files, "--free-modes", "0"]),
    ]
    runners += optional([lambda: in_exudyn(program, part)])
    name = f"reduction of a solid arm of {3 * len(part.points)} coordinates"
    what = f"first {MODES} frequencies with held interfaces, norm of the relative errors"
    return Case(name, what, "1", reference, runners)


def write_matrices(program: Program, part: solid_model.Part) -> None:
    stiffness, mass = solid_model.matrices(part)
    folder = program.folder
    save_npz(folder / "stiffness.npz", stiffness)
    save_npz(folder / "mass.npz", mass)
    nodes = [",".join(map(repr, [k + 1, *point])) for k, point in enumerate((1e-3 * part.points).tolist())]
    (folder / "nodes.csv").write_text("\n".join(["label,x,y,z", *nodes]) + "\n")
    rows = [f"{row + 1},{row // 3 + 1},{row % 3 + 1}" for row in range(3 * len(part.points))]
    (folder / "dofs.csv").write_text("\n".join(["row,node,direction", *rows]) + "\n")
    for name, group in part.groups.items():
        (folder / f"{name}.txt").write_text("\n".join(str(node + 1) for node in group) + "\n")


def from_mesh(part: solid_model.Part) -> list[str]:
    interfaces = [f"--interface={name}=group:{name}" for name in part.groups]
    return ["reduce", str(part.file), "--units", "mm", "--material", MATERIAL, *interfaces, *points(), *common()]


def from_matrices(part: solid_model.Part) -> list[str]:
    interfaces = [f"--interface={name}=nodes:{name}.txt" for name in part.groups]
    files = ["stiffness.npz", "--mass", "mass.npz", "--nodes", "nodes.csv", "--dofs", "dofs.csv"]
    return ["reduce", *files, *interfaces, *common()]


def points() -> list[str]:
    """In the units of the file."""
    return [
        f"--point={name}={','.join(str(number) for number in point)}" for name, point in solid_model.INTERFACES.items()
    ]


def common() -> list[str]:
    return ["--modes", str(MODES), "--no-cache", "--json", "-o", "body.h5"]


def frequencies(program: Program, arguments: list[str]) -> list[float]:
    return json.loads(program.call(*arguments))["frequencies_hz"]


def logarithms(values: list[float] | np.ndarray) -> np.ndarray:
    """Whose differences are relative errors."""
    return np.log(np.atleast_2d(values))


def own(program: Program, settings: str, arguments: list[str]) -> Runner:
    def seconds(step: float | None) -> float:
        before = os.times()
        program.call(*arguments)
        after = os.times()
        return after.children_user + after.children_system - before.children_user - before.children_system

    def outputs(step: float | None) -> np.ndarray:
        return logarithms(frequencies(program, arguments))

    return Runner("mimbre", program.version, settings, (None,), outputs, seconds)


def in_exudyn(program: Program, part: solid_model.Part) -> list[Runner]:
    import solid_in_exudyn

    def reduced() -> np.ndarray:
        files = [program.folder / "stiffness.npz", program.folder / "mass.npz"]
        return solid_in_exudyn.reduce(*files, 1e-3 * part.points, list(part.groups.values()), MODES)[0]

    def seconds(step: float | None) -> float:
        begin = time.process_time()
        reduced()
        return time.process_time() - begin

    said = "from matrices, ComputeHurtyCraigBamptonModes, RBE2, sparse"
    return [Runner("Exudyn", solid_in_exudyn.VERSION, said, (None,), lambda step: logarithms(reduced()), seconds)]

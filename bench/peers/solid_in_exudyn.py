"""The reduction of a solid part in Exudyn, from given matrices, with rigid interfaces (RBE2)."""

import contextlib
import io
import pathlib

import exudyn_solver  # first: it chooses Exudyn's fast build
import numpy as np
from exudyn.FEM import FEMinterface, HCBstaticModeSelection, ObjectFFRFreducedOrderInterface
from scipy.sparse import load_npz

VERSION = exudyn_solver.VERSION


def reduce(
    stiffness: pathlib.Path, mass: pathlib.Path, points: np.ndarray, groups: list[np.ndarray], modes: int
) -> tuple[np.ndarray, ObjectFFRFreducedOrderInterface]:
    """Frequencies of the dynamic modes, Hz, and the body; the frame moves with the first group."""
    part = FEMinterface()
    part.nodes = {"Position": points}
    part.stiffnessMatrix, part.massMatrix = load_npz(stiffness).tocsr(), load_npz(mass).tocsr()
    with contextlib.redirect_stdout(io.StringIO()):
        part.ComputeHurtyCraigBamptonModes(groups, modes, computationMode=HCBstaticModeSelection.RBE2)
        body = ObjectFFRFreducedOrderInterface(part)
    return np.sort(part.GetEigenFrequenciesHz()), body

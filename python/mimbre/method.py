"""The options of a run as arguments. Made by scripts/python-words from the schemas of models and studies."""

from typing import Literal, TypedDict


class Method(TypedDict, total=False):
    """How a model is computed, in place of the model's settings: further arguments of `run`, `simulation`, `static` and
    others (docs/model-file.md, `simulation`)."""

    step: float
    """s; default: 0.01."""
    formulation: Literal["relative", "natural"]
    """Coordinates: of the joints (relative), or points and unit vectors (natural)."""
    inertia: Literal["integrals", "projection", "projection_translations"]
    """Inertia of flexible bodies: shape integrals, or projection of the mesh's mass matrix in every evaluation."""
    formalism: Literal[
        "index3",
        "index1",
        "baumgarte",
        "penalty",
        "index1_augmented",
        "independent",
        "global_modes",
        "transfer_matrices",
    ]
    """How the constraints enter the equations of motion."""
    integrator: Literal["generalized_alpha", "newmark", "hht", "conserve", "rk4", "dopri853", "radau", "auto"]
    """How steps are made."""
    rho: float
    """Spectral radius of generalized_alpha (0 to 1) and hht (0.5 to 1); 1 damps nothing."""
    xi: float
    """Of newmark: 0, or less, which damps."""
    accuracy: float
    """Of dopri853 and radau: error of each part that a step is made in, relative to the size of the mechanism; without
    it a step has one part."""
    tolerance: float
    """Of the iterations, relative; default: 1e-5."""
    max_iterations: int
    """Of a step."""
    substeps: int
    """Parts in which an inaccurate step is made again; 1: never."""
    energy_tolerance: float
    """Error of a step's energy balance, relative to the energy in motion, above which it is made again in substeps;
    default: 1e-4."""
    fixed_cost: bool
    """For real time: a step is made once, and accepted after max_iterations (6)."""

"""Whether a chain of equal modules buckles with a period of two or of three of them.

A module between faces that repeat sees only what all modules do alike. A small motion that is
another one by a phase θ from module to module has the second variation Jᴴ K J, with J that of the
repeated faces times exp(i θ) and ω, t as they are (Bloch's theorem): θ = π is a period of two,
θ = 2π/3 one of three. Its negative eigenvalues are counted by the inertia of its factors, as those
of any state are. A period of one is the module's own business.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure
from softact.system.inertia import negative_eigenvalues

if TYPE_CHECKING:
    import scipy.sparse

    from softact.bodies.seam import Seam
    from softact.measures.snapshot import Snapshot
    from softact.model import Model
    from softact.system.term import State

PERIODS = {2: "two", 3: "three"}
NAME = "module_unstable_waves_of_"


def asked(model: Model) -> bool:
    """Whether a module can be asked: not one of sheets, nor with contact."""
    return not (model.sheets or len(model.contacts))


def unstable_waves(model: Model, state: State, modules: int) -> int:
    """How many independent motions of so many modules' period lower the energy."""
    stiffness, pressures = _folded(model, state, 2 * np.pi / modules)
    return negative_eigenvalues(stiffness) - pressures


def _folded(model: Model, state: State, phase: float) -> tuple[scipy.sparse.csr_matrix, int]:
    """The real symmetric matrix of Jᴴ K J, and how many of its unknowns are pressures."""
    # Imported here: commands that solve nothing know the measures, too.
    import scipy.sparse

    assembler, repeat = model.assembler, model.repeat
    assert repeat is not None
    assembler.clear()
    for term in model.terms:
        term.add_tangent(state, None)
    size = model.unknowns.local
    rows, columns = assembler.entries
    values = np.concatenate([assembler.values, assembler.extra_values])
    raw = scipy.sparse.csr_matrix((values, (rows, columns)), shape=(size, size))
    free = assembler.fixed == 0
    free[model.unknowns.apart_dofs.ravel()] = False
    free[repeat.follows] = False
    kept = np.flatnonzero(free)
    own = scipy.sparse.identity(size, format="csr")
    right = repeat.carried(state.x)
    parts = [np.cos(phase) * right + own, np.sin(phase) * right]
    real, imaginary = (part[:, kept] for part in parts)
    symmetric, skew = _of_motion(raw, real, imaginary)
    for seam in _seams(model):
        # That of a motion without a phase is among the terms.
        own, images = seam.sides(state.x)
        all_alike = [(own + images) @ part for part in (real, imaginary)]
        ahead = np.cos(phase) * images, np.sin(phase) * images
        phased = (
            (own + ahead[0]) @ real - ahead[1] @ imaginary,
            ((own + ahead[0]) @ imaginary + ahead[1] @ real),
        )
        more, less = (_of_motion(seam.matrix, *pair) for pair in (phased, all_alike))
        symmetric, skew = symmetric + more[0] - less[0], skew + more[1] - less[1]
    pressures = int((~np.isin(kept, model.displacement_dofs)).sum())
    if abs(np.sin(phase)) < np.finfo(float).eps * 8:
        return symmetric.tocsr(), pressures
    both = scipy.sparse.bmat([[symmetric, skew], [skew.T, symmetric]], format="csr")
    return both, 2 * pressures


def _of_motion(
    matrix: scipy.sparse.spmatrix, real: scipy.sparse.spmatrix, imaginary: scipy.sparse.spmatrix
) -> tuple[scipy.sparse.spmatrix, scipy.sparse.spmatrix]:
    """Real and imaginary part of Jᴴ M J, with J = real + i imaginary."""
    symmetric = real.T @ matrix @ real + imaginary.T @ matrix @ imaginary
    return symmetric, real.T @ matrix @ imaginary - imaginary.T @ matrix @ real


def _seams(model: Model) -> list[Seam]:
    """Of the layers that bend across the border to the next module."""
    bent = [layer.bending for layer in model.layers if layer.bending is not None]
    return [plate.seam for plate in bent if plate.seam is not None]


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    model = snapshot.model
    if model.repeat is None or not asked(model):
        return {}
    return {
        NAME + word: float(unstable_waves(model, snapshot.state, modules))
        for modules, word in PERIODS.items()
    }


LONGER_WAVES = Measure(
    "module_waves",
    "of a module of a chain: in how many ways the chain buckles with a period longer than a module",
    {
        NAME + word: f"unstable ways with a period of {word} modules; 0: none"
        for word in PERIODS.values()
    },
    _evaluate,
)

"""The membrane energy of a sheet, its weight and its inertia, as terms of the potential energy."""

from __future__ import annotations

import functools
import operator

import numpy as np

from softact.bodies.last_few import LastFew
from softact.materials.plane_stress import Response, SheetLaw
from softact.materials.tension_field import PLACE
from softact.mesh.triangles import MEMBRANE_RULE, Triangles, areas_at
from softact.system.term import Origin, State
from softact.system.triangle_loops import TriangleLoops, linearised_stress

#: Deformation gradient, energy, stress and moduli at a state.
Evaluated = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


class Membrane:
    """Π = t ∫ W(C) dA with C = FᵀF in the sheet's plane and S33 = 0; see ``plane_stress``.

    law: one energy per volume for each layer of the sheet; they share the strain and add up, each
    with its thickness (mm). along: (3,) the first axis of C, put into the sheet.
    """

    from_displacements = False

    def __init__(self, triangles: Triangles, along: np.ndarray, laws: list[tuple[SheetLaw, float]]):
        self.triangles, self.laws = triangles, laws
        points, weights = MEMBRANE_RULE
        frames = triangles.frames(along, points)
        slopes = np.swapaxes(triangles.gradients(frames, points), 2, 3)
        self.weights = areas_at(triangles.places, points) * weights
        made = np.swapaxes(frames, -1, -2) if self.from_displacements else None
        self._loops = TriangleLoops(triangles, slopes, self.weights, made)
        self._kept: LastFew[Evaluated] = LastFew()

    @property
    def thickness(self) -> float:
        """Of all layers together, mm."""
        return sum(t for _, t in self.laws)

    def metric(self, x: np.ndarray) -> np.ndarray:
        """C (k q, 2, 2)."""
        return self._loops.strain(x)[1]

    def response(self, c: np.ndarray) -> Response:
        """Energy, stress and moduli per undeformed area (N/mm), all layers together."""
        parts = [(t, law.evaluate(c)) for law, t in self.laws]
        energy, stress, moduli = (
            functools.reduce(operator.add, (t * part[i] for t, part in parts)) for i in range(3)
        )
        return energy, stress, moduli

    def _evaluate(self, x: np.ndarray) -> Evaluated:
        """Deformation gradient (k, q, 3, 2) and ``response``, kept for the last few states."""

        def find() -> Evaluated:
            f, c = self._loops.strain(x)
            return f, *self.response(c)

        return self._kept(x, b"", find)

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        f, _, stress, _ = self._evaluate(state.x)
        self._loops.add_force(f, stress, out)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        f, _, stress, moduli = self._evaluate(state.x)
        carried = stress if origin is None else self._carried(f, origin)
        self.triangles.table.add(self._loops.tangent(f, moduli, carried))

    def _carried(self, now: np.ndarray, origin: Origin) -> np.ndarray:
        """Stress of the geometric stiffness at deformation gradients, see ``Origin``."""
        kept = [self._evaluate(state) for state in origin.states]
        if not origin.linearised:
            shares = (w * part[2] for w, part in zip(origin.weights, kept, strict=True))
            return functools.reduce(operator.add, shares)
        before, _, stress, moduli = kept[0]
        return linearised_stress(before, now, stress, moduli)

    def energy(self, state: State) -> float:
        """See ``Term``."""
        return float(self._evaluate(state.x)[1] @ self.weights.ravel())

    # --- what measures read -----------------------------------------------------------------

    def cauchy(self, x: np.ndarray) -> np.ndarray:
        """Cauchy stress (k, q, 3, 3) MPa, mean over the layers: F S Fᵀ/J with the law's own
        thickness stretch left at that of constant volume."""
        f, _, stress, _ = self._evaluate(x)
        tensor = stress[:, PLACE].reshape(*f.shape[:2], 2, 2) / self.thickness
        return f @ tensor @ np.swapaxes(f, -1, -2)

    def ply_stresses(self, x: np.ndarray) -> list[np.ndarray]:
        """Second Piola-Kirchhoff stress (k q, 2, 2) MPa of each layer."""
        metric = self.metric(x)
        return [law.evaluate(metric)[1][:, PLACE] for law, _ in self.laws]

    def wrinkling(self, x: np.ndarray) -> np.ndarray | None:
        """0 taut, 1 wrinkled, 2 slack (k, q), of the first layer; None without tension field."""
        states = getattr(self.laws[0][0], "state", None)
        return None if states is None else states(self.metric(x)).reshape(self.weights.shape)


class BondedMembrane(Membrane):
    """A membrane on a solid, which may be so much softer that the membrane's small strains would
    drown in the rounding of the places: F from the displacements.

    Not for sheets by themselves: with it the inflation of a flat disc (Hencky's) does not settle.
    """

    from_displacements = True

"""The membrane energy of a sheet, its weight and its inertia, as terms of the potential energy."""

from __future__ import annotations

import functools
import hashlib
import operator

import numpy as np

from softact.materials.plane_stress import Response, SheetLaw
from softact.materials.tension_field import PLACE, TensionField
from softact.mesh.triangles import MEMBRANE_RULE, Triangles, areas_at
from softact.system.term import Origin, State

KEPT = 4  # states whose stresses are kept, see ``softact.bodies.solid``

#: Deformation gradient, energy, stress and moduli at a state.
Evaluated = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


class Membrane:
    """Π = t ∫ W(C) dA with C = FᵀF in the sheet's plane and S33 = 0; see ``plane_stress``.

    law: one energy per volume for each layer of the sheet; they share the strain and add up, each
    with its thickness (mm). along: (3,) the first axis of C, put into the sheet.
    """

    def __init__(self, triangles: Triangles, along: np.ndarray, laws: list[tuple[SheetLaw, float]]):
        self.triangles, self.laws = triangles, laws
        points, weights = MEMBRANE_RULE
        frames = triangles.frames(along, points)
        self.gradients = triangles.gradients(frames, points)
        k, _, n, _ = self.gradients.shape
        # The same as one matrix (k, n, 2 q) for each triangle.
        self._columns = np.ascontiguousarray(self.gradients.transpose(0, 2, 1, 3)).reshape(k, n, -1)
        self.undeformed = np.swapaxes(frames, -1, -2)
        self.weights = areas_at(triangles.places, points) * weights
        self._kept: dict[bytes, Evaluated] = {}

    @property
    def thickness(self) -> float:
        """Of all layers together, mm."""
        return sum(t for _, t in self.laws)

    def deformation_gradient(self, x: np.ndarray) -> np.ndarray:
        """F (k, q, 3, 2): what the frame's axes become."""
        return self._gradient_of(self.triangles.current(x))

    def _gradient_of(self, nodal: np.ndarray) -> np.ndarray:
        """Derivatives (k, q, 3, 2) along the frames of a field with nodal values (k, n, 3)."""
        k, q = self.weights.shape
        product = np.swapaxes(nodal, 1, 2) @ self._columns
        return np.ascontiguousarray(product.reshape(k, 3, q, 2).transpose(0, 2, 1, 3))

    def metric(self, x: np.ndarray) -> np.ndarray:
        """C (k q, 2, 2)."""
        f = self.deformation_gradient(x).reshape(-1, 3, 2)
        return f.transpose(0, 2, 1) @ f

    def response(self, c: np.ndarray) -> Response:
        """Energy, stress and moduli per undeformed area (N/mm), all layers together."""
        parts = [(t, law.evaluate(c)) for law, t in self.laws]
        energy, stress, moduli = (
            functools.reduce(operator.add, (t * part[i] for t, part in parts)) for i in range(3)
        )
        return energy, stress, moduli

    def _evaluate(self, x: np.ndarray) -> Evaluated:
        """Deformation gradient and ``response``, kept for the last few states."""
        key = hashlib.blake2b(x.data, digest_size=16).digest()
        found = self._kept.pop(key, None)
        if found is None:
            f = self.deformation_gradient(x)
            c = (np.swapaxes(f, -1, -2) @ f).reshape(-1, 2, 2)
            energy, stress, moduli = self.response(c)
            found = f, energy, stress, moduli
        self._kept[key] = found
        while len(self._kept) > KEPT:
            del self._kept[next(iter(self._kept))]
        return found

    def _rates(self, f: np.ndarray) -> np.ndarray:
        """Derivatives (k, q, 3, 3 n) of E11, E22, 2 E12 with respect to nodal displacements."""
        b = self.gradients
        k, q, n, _ = b.shape
        one, two = (b[..., i, None] * f[:, :, None, :, i] for i in (0, 1))
        shear = b[..., 0, None] * f[:, :, None, :, 1] + b[..., 1, None] * f[:, :, None, :, 0]
        return np.stack([one, two, shear], axis=2).reshape(k, q, 3, 3 * n)

    def add_force(self, state: State, out: np.ndarray) -> None:
        f, _, stress, _ = self._evaluate(state.x)
        k, q = self.weights.shape
        tensor = stress[:, PLACE].reshape(k, q, 2, 2) * self.weights[..., None, None]
        first = (f @ tensor).transpose(0, 1, 3, 2).reshape(k, 2 * q, 3)  # first Piola-Kirchhoff
        self.triangles.add_force(self._columns @ first, out)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        f, _, stress, moduli = self._evaluate(state.x)
        k, q = self.weights.shape
        n = self.gradients.shape[2]
        rates = self._rates(f)
        weighted = moduli.reshape(k, q, 3, 3) * self.weights[..., None, None]
        left = (weighted @ rates).reshape(k, 3 * q, 3 * n)
        matrices = rates.reshape(k, 3 * q, 3 * n).transpose(0, 2, 1) @ left
        carried = stress if origin is None else self._carried(state.x, origin)
        tensor = carried.reshape(k, q, 3)[..., PLACE] * self.weights[..., None, None]
        left = (self.gradients @ tensor).transpose(0, 2, 1, 3).reshape(k, n, 2 * q)
        geometric = left @ np.swapaxes(self._columns, 1, 2)
        matrices = matrices.reshape(k, n, 3, n, 3)
        for c in range(3):
            matrices[:, :, c, :, c] += geometric
        self.triangles.table.add(matrices)

    def _carried(self, x: np.ndarray, origin: Origin) -> np.ndarray:
        """Stress of the geometric stiffness, see ``Origin``."""
        kept = [self._evaluate(state) for state in origin.states]
        if not origin.linearised:
            shares = (w * part[2] for w, part in zip(origin.weights, kept, strict=True))
            return functools.reduce(operator.add, shares)
        before, _, stress, moduli = kept[0]
        now = self.deformation_gradient(x)
        e = (np.swapaxes(before, -1, -2) @ (now - before)).reshape(-1, 2, 2)
        rate = np.stack([e[:, 0, 0], e[:, 1, 1], e[:, 0, 1] + e[:, 1, 0]], axis=1)
        return stress + np.einsum("nij,nj->ni", moduli, rate)

    def energy(self, state: State) -> float:
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
        law = self.laws[0][0]
        if not isinstance(law, TensionField):
            return None
        return law.state(self.metric(x)).reshape(self.weights.shape)


class BondedMembrane(Membrane):
    """A membrane on a solid, which may be so much softer that the membrane's small strains would
    drown in the rounding of the places: F from the displacements.

    Not for sheets by themselves: with it the inflation of a flat disc (Hencky's) does not settle.
    """

    def deformation_gradient(self, x: np.ndarray) -> np.ndarray:
        """See ``Membrane.deformation_gradient``."""
        moved = x[self.triangles.dofs]
        return self.undeformed + self._gradient_of(moved)

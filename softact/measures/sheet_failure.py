"""Stresses in the plane of sheets, ply by ply, as the failure of a sheet is judged by them.

A ply has the strain of its sheet and a stress of its own. Its thickness stretch is taken to be that
of constant volume, as in all stresses of sheets. Where a tension field relaxes it, the stress is
that along the wrinkles. A card has one strength: of a woven, the direction of its yarns does not
count.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.mesh.triangles import MEMBRANE_RULE, shape_functions

if TYPE_CHECKING:
    from softact.bodies.sheet import SheetPart
    from softact.materials.base import Material
    from softact.measures.snapshot import Snapshot


@dataclass(frozen=True)
class PlyStress:
    """One ply in a state. name: of its sheet, with its number where there are several. tensors:
    nominal and Cauchy stress (n, 6) MPa and C (n, 6) at the quadrature points. volumes: (n,) of the
    points, mm³."""

    name: str
    material: Material
    part: SheetPart
    tensors: dict[str, np.ndarray]
    volumes: np.ndarray

    def places_of(self, chosen: np.ndarray) -> np.ndarray:
        """Undeformed places (k, 3), mm, of points by their numbers (k,)."""
        places = self.part.triangles.places
        shape = shape_functions(MEMBRANE_RULE[0], places.shape[1])
        triangle, point = np.divmod(chosen, len(shape))
        return np.einsum("kn,knx->kx", shape[point], places[triangle])


def plies(snapshot: Snapshot) -> Iterator[PlyStress]:
    """All plies of all sheets."""
    x = snapshot.state.x
    for name, part in snapshot.model.sheets.items():
        metric, several = part.membrane.metric(x), len(part.materials) > 1
        stretch = _root(metric)
        stresses = part.membrane.ply_stresses(x)
        for number, (ply, material, stress) in enumerate(
            zip(part.sheet.plies, part.materials, stresses, strict=True)
        ):
            tensors = {
                "nominal": _padded((stretch @ stress + stress @ stretch) / 2),
                "cauchy": _padded(stretch @ stress @ stretch),
                "stretch": _padded(metric),
            }
            volumes = ply.thickness * part.membrane.weights.ravel()
            label = f"{name}_{number}" if several else name
            yield PlyStress(label, material, part, tensors, volumes)


def _root(metric: np.ndarray) -> np.ndarray:
    """U (n, 2, 2) of C = U²: (C + √det C I)/√(tr C + 2 √det C), by Cayley and Hamilton."""
    root = np.sqrt(np.maximum(np.linalg.det(metric), 0.0))[:, None, None]
    trace = np.trace(metric, axis1=1, axis2=2)[:, None, None]
    return (metric + root * np.eye(2)) / np.sqrt(trace + 2 * root)


def _padded(tensors: np.ndarray) -> np.ndarray:
    """(n, 6) in the order 11, 22, 33, 12, 13, 23 of tensors (n, 2, 2) in a plane."""
    padded = np.zeros((len(tensors), 6))
    padded[:, 0], padded[:, 1], padded[:, 3] = tensors[:, 0, 0], tensors[:, 1, 1], tensors[:, 0, 1]
    return padded

"""Nodal fields of sheets: stress, stretch, wrinkles."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from softact.materials.tensors import symmetric
from softact.mesh.triangles import MEMBRANE_RULE, average, shape_functions

if TYPE_CHECKING:
    from softact.bodies.sheet import SheetPart
    from softact.model import Model
    from softact.system.term import State


def _at_nodes(model: Model, values_of: Callable[[SheetPart], np.ndarray]) -> np.ndarray:
    """Area-weighted nodal means (nodes, k) of values (k, q, ...) at the quadrature points."""
    count = len(model.nodes.places)
    sums, weights = np.zeros((count, 1)), np.zeros(count)
    for part in model.sheets.values():
        nodes = part.triangles.nodes
        values = values_of(part).reshape(*part.membrane.weights.shape, -1)
        spread = _to_nodes(nodes.shape[1]) @ values
        summed, weight = average(nodes, part.triangles.areas, spread, count)
        sums, weights = sums + summed, weights + weight
    return sums / np.maximum(weights, 1e-300)[:, None]


def _to_nodes(nodes: int) -> np.ndarray:
    """Matrix (n, q): the linear field through the quadrature points, at the nodes."""
    corners = np.eye(3)
    places = (
        corners if nodes == 3 else np.vstack([corners, (corners + np.roll(corners, -1, 0)) / 2])
    )
    return places @ np.linalg.inv(shape_functions(MEMBRANE_RULE[0], 3))


def sheet_stress(model: Model, state: State) -> np.ndarray:
    """Cauchy stress (nodes, 6), MPa."""

    def values(part: SheetPart) -> np.ndarray:
        stress = part.membrane.cauchy(state.x)
        return symmetric(stress).reshape(*stress.shape[:2], 6)

    return _at_nodes(model, values)


def sheet_stretch(model: Model, state: State) -> np.ndarray:
    """Largest principal stretch in the sheets (nodes,)."""

    def values(part: SheetPart) -> np.ndarray:
        return np.linalg.eigvalsh(part.membrane.metric(state.x))[:, 1]

    return np.sqrt(np.maximum(_at_nodes(model, values)[:, 0], 0.0))


def sheet_wrinkles(model: Model, state: State) -> np.ndarray | None:
    """0 taut, 1 wrinkled, 2 slack (nodes,), means; None where no sheet has a tension field."""
    if not any(part.sheet.tension_field for part in model.sheets.values()):
        return None

    def values(part: SheetPart) -> np.ndarray:
        found = part.membrane.wrinkling(state.x)
        return np.zeros(part.membrane.weights.shape) if found is None else found.astype(float)

    return np.clip(_at_nodes(model, values)[:, 0], 0.0, 2.0)

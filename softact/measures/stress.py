"""Largest stresses and where they are."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.materials.tensors import von_mises
from softact.measures.base import Measure, vector_columns

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot

BODY_COLUMN = "max_von_mises_<body>_MPa"


def _of_bodies(snapshot: Snapshot) -> dict[str, float]:
    """The largest von Mises stress of each region and each sheet, of an actuator with both."""
    model = snapshot.model
    if not (model.solids and model.sheets):
        return {}
    in_sheets = von_mises(snapshot.sheet_cauchy)
    parts = [
        (name, snapshot.von_mises, model.cell_nodes[s.cells]) for name, s in model.solids.items()
    ]
    parts += [(name, in_sheets, sheet.triangles.nodes) for name, sheet in model.sheets.items()]
    return {
        BODY_COLUMN.replace("<body>", name): float(stress[np.unique(nodes)].max())
        for name, stress, nodes in parts
    }


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    value, place = snapshot.largest(snapshot.max_principal_stress)
    columns = {"max_principal_stress_MPa": value}
    columns |= vector_columns("max_principal_stress_<xyz>_mm", place)
    columns["max_von_mises_MPa"] = snapshot.largest(snapshot.von_mises)[0]
    return columns | _of_bodies(snapshot)


STRESS = Measure(
    "stress",
    "largest Cauchy stress (nodal means) and its place in the undeformed actuator",
    {"max_principal_stress_MPa": "largest principal Cauchy stress"}
    | {f"max_principal_stress_{c}_mm": f"its undeformed {c} coordinate" for c in "xyz"}
    | {"max_von_mises_MPa": "largest von Mises stress"}
    | {BODY_COLUMN: "the same in each region and sheet, of an actuator that has both"},
    _evaluate,
)

"""Largest stretch, where it is, and how much the material's volume changes."""

import numpy as np

from softact.measures.base import Measure, vector_columns
from softact.tensors import determinant


def _evaluate(snapshot):
    value, place = snapshot.largest(snapshot.max_principal_stretch)
    columns = {"max_principal_stretch": value}
    columns |= vector_columns("max_principal_stretch_<xyz>_mm", place)
    if not snapshot.model.solids:
        return columns
    largest, grown, whole = 0.0, 0.0, 0.0
    for solid in snapshot.model.solids.values():
        change = determinant(solid.deformation_gradient(snapshot.state.x)) - 1
        largest = max(largest, float(np.abs(change).max(initial=0.0)))
        grown += float((change * solid.volumes).sum())
        whole += float(solid.volumes.sum())
    columns["volume_change_max"] = max(snapshot.model.comm.allgather(largest))
    columns["volume_change_mean"] = snapshot.model.sum(grown) / snapshot.model.sum(whole)
    return columns


STRAIN = Measure(
    "strain",
    "largest stretch and its place in the undeformed actuator, volume change of the material",
    {"max_principal_stretch": "largest principal stretch"}
    | {f"max_principal_stretch_{c}_mm": f"its undeformed {c} coordinate" for c in "xyz"}
    | {
        "volume_change_max": "largest |J − 1| at a quadrature point, mostly at a sharp corner",
        "volume_change_mean": "relative change of the material's whole volume",
    },
    _evaluate,
)

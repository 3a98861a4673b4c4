"""Largest stretch, where it is, how much the material's volume changes, and whether elements fold.

At a re-entrant corner the volume of a nearly incompressible material changes without bound as the
mesh is refined, so the largest change at a single point decides nothing: the change that one
percent of the volume exceeds does, and the part of the volume that changes by more than ``BOUND``.

These are looked at in the quadrature points; an element may be folded at a corner beside them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure, vector_columns
from softact.measures.failure import exceeded

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot

#: Bulk by shear modulus from which on a material hardly changes its volume (ν > 0.45).
INCOMPRESSIBLE = 10.0
#: |J − 1| of such a material from which on its volume is far from kept. P2/P1 elements keep it on
#: average and not at each point: of a thin-walled finger on usual meshes, 1 % of the volume changes
#: by more than 13 to 17 % (configs/pneunet_small.yaml with 2 to 4 mm).
BOUND = 0.2
#: Part of the volume in which |J − 1| is larger than the percentile that is told.
SHARE = 0.01
BEYOND_COLUMN = "volume_change_beyond_percent"
PERCENTILE_COLUMN = "volume_change_p99"
JACOBIAN_COLUMN = "jacobian_min"


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    value, place = snapshot.largest(snapshot.max_principal_stretch)
    columns = {"max_principal_stretch": value}
    columns |= vector_columns("max_principal_stretch_<xyz>_mm", place)
    if not snapshot.model.solids:
        return columns
    return columns | _volume_change(snapshot) | _smallest_jacobian(snapshot)


def _smallest_jacobian(snapshot: Snapshot) -> dict[str, float]:
    worst = snapshot.smallest_jacobian
    columns = {JACOBIAN_COLUMN: worst.jacobian}
    return columns | vector_columns(f"{JACOBIAN_COLUMN}_<xyz>_mm", np.array(worst.place))


def _volume_change(snapshot: Snapshot) -> dict[str, float]:
    model, comm = snapshot.model, snapshot.model.comm
    largest, place, grown, whole = 0.0, np.zeros(3), 0.0, 0.0
    changes, volumes, beyond = [np.zeros(0)], [np.zeros(0)], 0.0
    for solid in model.solids.values():
        change = solid.jacobian(snapshot.state.x) - 1
        size, volume = np.abs(change).ravel(), solid.volumes.ravel()
        if size.max(initial=0.0) > largest:
            largest = float(size.max())
            place = snapshot.quadrature_places(solid, np.array([np.argmax(size)]))[0]
        grown += float((change * solid.volumes).sum())
        whole += float(volume.sum())
        if solid.material.bulk_modulus >= INCOMPRESSIBLE * solid.material.shear_modulus:
            changes.append(size)
            volumes.append(volume)
            beyond += float(volume[size > BOUND].sum())
    largest, place = max(comm.allgather((largest, place)), key=lambda pair: pair[0])
    columns = {"volume_change_max": largest}
    columns |= vector_columns("volume_change_max_<xyz>_mm", place)
    columns["volume_change_mean"] = model.sum(grown) / model.sum(whole)
    kept_by = np.concatenate(volumes)
    kept = model.sum(float(kept_by.sum()))
    if kept:
        columns[PERCENTILE_COLUMN] = exceeded(comm, np.concatenate(changes), kept_by, SHARE)
        columns[BEYOND_COLUMN] = 100 * model.sum(beyond) / kept
    return columns


STRAIN = Measure(
    "strain",
    "largest stretch and its place in the undeformed actuator, volume change of the material, "
    "elements that fold",
    {"max_principal_stretch": "largest principal stretch"}
    | {f"max_principal_stretch_{c}_mm": f"its undeformed {c} coordinate" for c in "xyz"}
    | {
        "volume_change_max": "largest |J − 1| at a quadrature point, mostly at a sharp corner, "
        "where it grows with every refinement",
    }
    | {f"volume_change_max_{c}_mm": f"its undeformed {c} coordinate" for c in "xyz"}
    | {
        "volume_change_mean": "relative change of the material's whole volume",
        PERCENTILE_COLUMN: "|J − 1| that 1 % of the volume of the nearly incompressible materials "
        "(bulk modulus above ten times the shear modulus) exceeds",
        BEYOND_COLUMN: "part of that volume in which |J − 1| is above 20 %",
        JACOBIAN_COLUMN: "smallest J anywhere in an element, corners included; one at or below "
        "zero is that of a folded element, and only its sign is exact",
    }
    | {f"{JACOBIAN_COLUMN}_{c}_mm": f"its undeformed {c} coordinate" for c in "xyz"},
    _evaluate,
)

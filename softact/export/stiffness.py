"""Stiffnesses of the rod that the runs do not tell, because nothing pulls on the actuator in them.

They are taken from the initial moduli and the undeformed sections, slice by slice along the axis,
as of a beam whose sections stay plane. Walls that bulge or fold make an actuator softer than that.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from softact.export import masses, states
from softact.materials import Law
from softact.results.folder import Results

if TYPE_CHECKING:
    from softact.export.reduced import Body

FITTED = "fitted to the loads of the runs"
OF_MODULE = "of the module at each pressure"
SAME = "taken from the other plane of bending"
ASSUMED = "assumed: initial moduli and plane sections; no load of the runs tells it"
#: Slices, and how many points of the mesh each should have at least.
MOST_SLICES, POINTS_IN_A_SLICE = 60, 40


def assumed(run: Results, body: Body, data: Mapping) -> dict[str, float]:
    """Stiffnesses by component: N·mm² for twist and bending, N for the stretch.

    data: where the rod lies, as in ``model.json``.
    """
    held = masses.contents(states.spec_of(run), _youngs_modulus)
    places, stiff = masses.points(run, held)  # N·mm
    places = (places - body.base) @ body.axes.T
    start, length = data["start_mm"], data["active_length_mm"]
    count = int(np.clip(len(places) // POINTS_IN_A_SLICE, 1, MOST_SLICES))
    number = np.floor((places[:, 0] - start) / length * count).astype(int)
    inside = (number >= 0) & (number < count)
    arms = places[:, 1:] - [data["offset_y_mm"], data["offset_z_mm"]]
    sums = {
        "stretch": stiff,
        "bending_y": stiff * arms[:, 1] ** 2,
        "bending_z": stiff * arms[:, 0] ** 2,
        "twist": stiff / 3 * (arms**2).sum(axis=1),
    }
    found = {}
    for name, values in sums.items():
        slices = np.bincount(number[inside], values[inside], count) * count / length
        found[name] = float(1.0 / np.mean(1.0 / slices[slices > 0]))
    return found


def _youngs_modulus(law: Law) -> float:
    bulk, shear = law.initial_bulk_modulus, law.shear_modulus
    return 9 * bulk * shear / (3 * bulk + shear)

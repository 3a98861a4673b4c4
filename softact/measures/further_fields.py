"""Fields at the nodes that are written where a spec asks for them: one function each."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot

#: Components of a symmetric tensor, in Voigt's order.
COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")


def _stress(snapshot: Snapshot) -> dict[str, np.ndarray]:
    """Components of the Cauchy stress, MPa."""
    return {f"stress_{c}": snapshot.cauchy[:, i] for i, c in enumerate(COMPONENTS)}


def _contact_pressure(snapshot: Snapshot) -> dict[str, np.ndarray]:
    """Pressure of all contacts, per undeformed area, MPa: at a node the mean over the facets in
    touch around it."""
    model = snapshot.model
    dofs, pressure = model.displacement_dofs, np.zeros(len(model.displacement_dofs))
    for contact in model.contacts:
        local = np.zeros(model.unknowns.local)
        sums = contact.facets.sums_at_nodes(contact.pressures(snapshot.state), len(dofs))
        local[dofs[:, 0]], local[dofs[:, 1]] = sums
        force, area = model.unknowns.sum_shared(local)[dofs[:, :2]].T
        pressure += force / np.maximum(area, 1e-300)
    return {"contact_pressure": pressure}


FURTHER: dict[str, Callable[[Snapshot], dict[str, np.ndarray]]] = {
    "stress": _stress,
    "contact_pressure": _contact_pressure,
}


def further_fields(snapshot: Snapshot, names: Iterable[str]) -> dict[str, np.ndarray]:
    """The fields (nodes,) of those names. Collective."""
    found: dict[str, np.ndarray] = {}
    for name in names:
        found |= FURTHER[name](snapshot)
    return found

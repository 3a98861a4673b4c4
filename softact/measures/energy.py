"""Stored energy and the work of the pressure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from softact.measures.base import Measure, per_cavity
from softact.measures.pressure import PRESSURE
from softact.measures.volume import VOLUME

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def lifted(snapshot: Snapshot) -> float | None:
    """Potential energy of the whole actuator's payloads and carried masses, mJ; None without any.
    Collective."""
    model = snapshot.model
    payloads = [term for (field, _), term in model.load_terms.items() if field == "payload"]
    payloads += [carried.weight() for carried in model.masses]
    if not payloads:
        return None
    energy = model.sum(sum(term.energy(snapshot.state) for term in payloads))
    return snapshot.layout.copies * energy


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    model, previous = snapshot.model, snapshot.previous
    stored = model.strain_energy(snapshot.state)
    columns = {"strain_energy_mJ": snapshot.layout.copies * stored}
    if snapshot.layout.cavities:
        now = PRESSURE.evaluate(snapshot) | VOLUME.evaluate(snapshot)
        names = dict.fromkeys(snapshot.layout.cavities, 0.0)
        pressures = per_cavity("pressure_<cavity>_kPa", names)
        volumes = per_cavity("cavity_volume_<cavity>_mm3", names)
        work = previous.get("pressure_work_mJ", 0.0)
        for p, v in zip(pressures, volumes, strict=True):
            mean = (now[p] + previous.get(p, now[p])) / 2e3
            work += mean * (now[v] - previous.get(v, now[v]))
        columns["pressure_work_mJ"] = work
    softening = [body for body in model.remembering if body.softens]
    if softening:
        lost = model.sum(sum(body.softened_away(snapshot.state) for body in softening))
        columns["softening_loss_mJ"] = snapshot.layout.copies * lost
    if (energy := lifted(snapshot)) is not None:
        columns["payload_energy_mJ"] = energy
    return columns


ENERGY = Measure(
    "energy",
    "stored elastic energy and work of the pressure, of the whole actuator",
    {
        "strain_energy_mJ": "elastic energy of solids and layers; of a material that creeps, what "
        "is left in the long run",
        "pressure_work_mJ": "∫ p dV from the start, by the trapezoidal rule over the increments",
        "payload_energy_mJ": "potential energy of payloads and carried masses, from the undeformed "
        "shape: what it gains under a constant payload is work on it",
        "softening_loss_mJ": "energy that Mullins' softening has taken for good, where a material "
        "softens",
    },
    _evaluate,
)

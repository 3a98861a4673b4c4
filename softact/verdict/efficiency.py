"""What part of the air's work becomes work on the load, as Nguyen and Zhang plot it over payloads.

Air is counted as a cycle would need it: isothermal, taken in at the ambient pressure, with the
exergy p V ln(p/p₀) at the pressure of each state. What a compressor loses before it is not in it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from softact.results.folder import Results
from softact.verdict.in_time import pressures_of, taken, volumes_of

# Pressures below this part of their largest are none.
_NONE = 1e-6


@dataclass(frozen=True)
class Lifting:
    """A state. pressure: the largest of its cavities, kPa. lifted: work on payloads and carried
    masses since the last state without a pressure, exergy: of the air taken in since then, mJ."""

    pressure: float
    lifted: float
    exergy: float

    @property
    def efficiency(self) -> float:
        """Part of the exergy that became work on the load; below zero where the load sank."""
        return self.lifted / self.exergy


def liftings(results: Results) -> list[Lifting]:
    """One for each state under pressure of a run that carries something."""
    pressures, volumes = pressures_of(results), volumes_of(results)
    energy = results.curve.get("payload_energy_mJ")
    if energy is None or not len(pressures) or len(pressures) != len(volumes):
        return []
    largest = pressures.max(axis=0)
    found, start = [], 0
    for row, pressure in enumerate(largest):
        if pressure <= _NONE * largest.max():
            start = row
            continue
        _, exergy = taken(pressures, volumes, start, row)
        if exergy > 0:
            lifted = energy[row] - energy[start]
            found.append(Lifting(float(pressure), float(lifted), float(exergy)))
    return found


def lifting(results: Results) -> Lifting | None:
    """The state of the largest pressure; None where the load is not lifted there.

    Not that of the largest efficiency: at a small pressure p lifting goes with p and the exergy
    with p², so that the efficiency of the first increment is as large as one likes.
    """
    most = max(liftings(results), key=lambda one: one.pressure, default=None)
    return most if most is not None and most.lifted > 0 else None


def figures(results: Results) -> dict[str, float]:
    """What summary.csv says of it: nothing where no load is carried; 0 where it is not lifted."""
    if not liftings(results):
        return {}
    most = lifting(results)
    return {"efficiency_percent": 100 * most.efficiency if most else 0.0}


def lines(results: Results) -> Iterator[str]:
    """What to say of it."""
    if most := lifting(results):
        yield (
            f"the load is lifted with an efficiency of {most.efficiency:.3%} at "
            f"{most.pressure:.4g} kPa: {most.lifted:.4g} mJ by air of {most.exergy:.4g} mJ exergy"
        )

"""How much room the cavities enclose."""

from __future__ import annotations

from typing import TYPE_CHECKING

from softact.measures.base import Measure, per_cavity

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    copies = snapshot.layout.copies
    volumes = {name: copies * volume for name, volume in snapshot.cavity_volumes.items()}
    return per_cavity("cavity_volume_<cavity>_mm3", volumes) if volumes else {}


VOLUME = Measure(
    "volume",
    "volume of the cavities of the whole actuator",
    {"cavity_volume_<cavity>_mm3": "volume that the cavity encloses"},
    _evaluate,
)

"""Air in cavities, what flows, and what was taken from supplies, in normal litres (DIN 1343)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from softact.loads.air_account import account_of, known_cavities
from softact.loads.gas_flow import NORMAL_LITRE
from softact.measures.base import Measure, per_cavity

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot

MINUTE = 60.0  # s


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    memory, copies = snapshot.state.memory, snapshot.layout.copies
    names = [n for n in snapshot.layout.cavities if n in known_cavities(memory)]
    accounts = {name: account_of(memory, name) for name in names}
    if not names:
        return {}
    litres = copies / NORMAL_LITRE
    values = {
        "air_flow_<cavity>_nl_per_min": {n: MINUTE * litres * a.flow for n, a in accounts.items()},
        "air_used_<cavity>_nl": {n: litres * a.used for n, a in accounts.items()},
        "air_exergy_<cavity>_mJ": {n: copies * a.exergy for n, a in accounts.items()},
    }
    row: dict[str, float] = {}
    for title, each in values.items():
        row |= per_cavity(title, each)
    return row


AIR = Measure(
    "air",
    "air of the whole actuator from supplies, in litres at 0 °C and 101.325 kPa",
    {
        "air_flow_<cavity>_nl_per_min": "air that flows into the cavity in the increment",
        "air_used_<cavity>_nl": "air taken from the supply since the start; of a vacuum, air taken "
        "out by it",
        "air_exergy_<cavity>_mJ": "work that this air can do at most: p V ln(p/p₀) of its supply",
    },
    _evaluate,
)

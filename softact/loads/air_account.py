"""What has become of the air of a cavity: how much is in it, and how much was taken from a supply.

It stands in ``State.memory`` under names that begin with "air": the same on all processes.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from softact.system.term import AIR, State

Memory = dict[str, np.ndarray | float]


@dataclass(frozen=True)
class Account:
    """mass: in the cavity, as p V at ambient temperature, mJ; 0 where nothing is known of it. used:
    taken from supplies so far, in the same unit; exergy: of that, mJ. flow: into the cavity, mJ/s.
    All are of the meshed part."""

    mass: float = 0.0
    used: float = 0.0
    exergy: float = 0.0
    flow: float = 0.0

    def after(self, mass: float, brought: float, elapsed: float, ratio: float) -> Account:
        """With air that has come in. ratio: absolute pressure of the supply by that of the ambient;
        a vacuum pump takes out what counts, and air from the ambient does not count."""
        taken = max(brought, 0.0) if ratio > 1 else max(-brought, 0.0) if ratio < 1 else 0.0
        return Account(
            mass,
            self.used + taken,
            self.exergy + taken * abs(float(np.log(ratio))),
            brought / elapsed if elapsed > 0 else 0.0,
        )

    def named(self, cavity: str) -> Memory:
        """As a state remembers it."""
        return {f"{AIR}{cavity}.{f.name}": float(getattr(self, f.name)) for f in fields(self)}


def account_of(memory: Mapping[str, np.ndarray | float], cavity: str) -> Account:
    """That of a cavity; an empty one where there was no air to account for."""
    known = {f.name: memory.get(f"{AIR}{cavity}.{f.name}", 0.0) for f in fields(Account)}
    return Account(**{name: float(value) for name, value in known.items()})


def at_rest(state: State, but: Collection[str]) -> Memory:
    """The memory of a state in which nothing flows, and nothing is known of what is in cavities,
    but in those named."""
    found = dict(state.memory)
    for name in known_cavities(state.memory):
        if name not in but:
            found |= replace(account_of(found, name), mass=0.0, flow=0.0).named(name)
    return found


def known_cavities(memory: Mapping[str, np.ndarray | float]) -> list[str]:
    """Cavities that have an account."""
    end = ".mass"
    names = (n for n in memory if n.startswith(AIR) and n.endswith(end))
    return [name.removeprefix(AIR).removesuffix(end) for name in names]

"""What contacts keep from equilibrium to equilibrium, in ``State.memory`` under their names."""

from __future__ import annotations

import numpy as np

from softact.system.term import CONTACT, State


def remembered(state: State, name: str, what: str) -> np.ndarray | None:
    """What a contact kept of the last equilibrium, None where it kept nothing."""
    kept = state.memory.get(f"{name}.{what}")
    return None if kept is None else np.asarray(kept)


def stiffness_factor(state: State, name: str) -> float:
    """Factor of a contact's penalty, see ``Contacts.stiffen``."""
    return float(state.memory.get(stiffness_key(name), 1.0))


def stiffness_key(name: str) -> str:
    """Under which the factor stands."""
    return f"{CONTACT}{name}.stiffness"


def faced_key(name: str) -> str:
    """Under which stands what points faced, where it decides what they face."""
    return f"{CONTACT}{name}.faced"

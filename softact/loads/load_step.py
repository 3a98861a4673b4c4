"""Loads at the end of a step, as the solver takes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from softact.loads.support import Support
from softact.loads.timing import Timing
from softact.system.term import EVERYTHING, Value


class LoadStep:
    """Loads at the end of a step; they ramp linearly from the last ones. What is not named stays.

    timing: how long the step lasts and how its loads go; None: it has no clock, and what creeps has
    all the time that it wants.

    supports: replace the ones before. max_increment: fraction of the step, None for the solver's.
    loads: by field of the registered loads (``softact.loads``), {what is loaded: value}, or one
    value where it is everything: pressure={"cavity": 0.04}, gravity=(0, 0, -9810). In internal
    units; of the meshed part.
    """

    def __init__(
        self,
        name: str,
        supports: Sequence[Support] | None = None,
        max_increment: float | None = None,
        timing: Timing | None = None,
        **loads: Mapping[str, Any] | Sequence[float] | None,
    ):
        self.name, self.supports, self.max_increment = name, supports, max_increment
        self.timing = timing
        self.loads: dict[str, dict[str, Value]] = {}
        for field, values in loads.items():
            if values is None:
                continue
            named = values if isinstance(values, Mapping) else {EVERYTHING: values}
            self.loads[field] = {key: np.asarray(v, dtype=float) for key, v in named.items()}

    @property
    def at_end(self) -> float:
        """How far loads and supports have gone at the end: 1 but where they go back."""
        return 1.0 if self.timing is None else self.timing.amplitude.at(1.0)

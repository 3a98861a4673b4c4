"""Loads at the end of a step, as the solver takes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from softact.loads.support import Support
from softact.system.term import EVERYTHING, Value


class LoadStep:
    """Loads at the end of a step; they ramp linearly from the last ones. What is not named stays.

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
        **loads: Mapping[str, Any] | Sequence[float] | None,
    ):
        self.name, self.supports, self.max_increment = name, supports, max_increment
        self.loads: dict[str, dict[str, Value]] = {}
        for field, values in loads.items():
            if values is None:
                continue
            named = values if isinstance(values, Mapping) else {EVERYTHING: values}
            self.loads[field] = {key: np.asarray(v, dtype=float) for key, v in named.items()}

"""Gravity on all bodies. Its terms are the weights of the model's bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from softact.fields import STANDARD_GRAVITY
from softact.fields import Gravity as Accelerations
from softact.loads.base import Load
from softact.system.term import EVERYTHING, Value

if TYPE_CHECKING:
    from collections.abc import Mapping

    from softact.model import Model


class Gravity(Load):
    """The acceleration (3,) mm/s² of everything."""

    key = "gravity"
    annotation = Accelerations
    description = "direction times g, such as [0, 0, -1], or three accelerations"
    easy = True

    def ends(self, value: Any, model: Model) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``."""
        return {self.key: {EVERYTHING: np.asarray(value, dtype=float)}}

    def initial(self, model: Model) -> dict[str, dict[str, Value]]:
        """See ``Load.initial``."""
        return {self.key: {EVERYTHING: np.zeros(3)}}

    def said(self, name: str, value: Value, model: Model) -> str:
        """See ``Load.said``."""
        size = float(np.linalg.norm(value)) / STANDARD_GRAVITY
        return f"gravity of {size:.4g} g" if size else ""

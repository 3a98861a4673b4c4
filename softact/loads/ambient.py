"""Absolute pressure of the ambient, from which all pressures count: it falls as a body rises."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import Field

from softact.fields import Fault, Place
from softact.loads.base import Load
from softact.loads.gas_flow import AMBIENT
from softact.mesh.layout import Layout
from softact.system.term import EVERYTHING, Value
from softact.units import Pressure

if TYPE_CHECKING:
    from softact.model import Model


class Ambient(Load):
    """The absolute pressure of the ambient, MPa."""

    key = "ambient"
    annotation = Annotated[Pressure, Field(gt=0)]
    description = (
        "absolute pressure of the ambient at the end of the step, 101.325 kPa where nothing is "
        "said; it acts through the air of cavities that are sealed or filled"
    )

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """See ``Load.faults``."""
        if not any(step.get(key) is not None for key in ("sealed", "supply", "exhaust")):
            yield place, "pressures count from the ambient; it acts on a sealed cavity only"

    def ends(self, value: float, model: Model) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``."""
        return {self.key: {EVERYTHING: np.asarray(value)}}

    def start(self, field: str, before: Value | None, end: Value) -> Value:
        """See ``Load.start``."""
        return np.asarray(AMBIENT) if before is None else before

    def said(self, name: str, value: Value, model: Model) -> str:
        """See ``Load.said``."""
        return f"an ambient of {1e3 * float(value):.4g} kPa"

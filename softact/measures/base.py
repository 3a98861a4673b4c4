"""What a measure is."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


@dataclass(frozen=True)
class Measure:
    """A named group of columns of ``curve.csv``.

    columns: title with its unit -> what it is. Where a title holds ``<cavity>``, there is one
    column for each cavity, without that part when there is only one.
    evaluate: called on all processes with a ``Snapshot``; returns {title: value}.
    """

    name: str
    description: str
    columns: Mapping[str, str]
    evaluate: Callable[[Snapshot], dict[str, float]]


def per_cavity(title: str, values: Mapping[str, float]) -> dict[str, float]:
    """Columns of a title with ``<cavity>``: {'pressure_<cavity>_kPa': ...} for each cavity."""
    if len(values) == 1:
        return {title.replace("_<cavity>", ""): next(iter(values.values()))}
    return {title.replace("<cavity>", name): value for name, value in values.items()}


def vector_columns(title: str, values: np.ndarray) -> dict[str, float]:
    """{'tip_x_mm': ..., ...} from 'tip_<xyz>_mm' and three numbers."""
    return {title.replace("<xyz>", c): float(v) for c, v in zip("xyz", values, strict=True)}


def continued(angle: float, before: float | None, period: float = 360.0) -> float:
    """The angle, plus the whole turns that bring it nearest to the one before (degrees)."""
    if before is None:
        return angle
    return angle + period * np.round((before - angle) / period)

"""Prescribed displacements of surfaces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Support:
    """Prescribed displacements (mm) of a surface: component (0, 1, 2) -> value.

    None holds each point where it is when the support begins.
    """

    surface: str
    values: Mapping[int, float | None]

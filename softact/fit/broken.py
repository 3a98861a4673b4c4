"""What a specimen that broke bore: the strength and the elongation of a card."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.errors import SpecError
from softact.fit.sheet import TestSheet
from softact.fit.trimming import prepare

if TYPE_CHECKING:
    from softact.fit.data import Test

#: Other choices of a sheet with which the last point that is left is not where it broke.
_PARTS = ("loading", "cycle", "whole")
_UNTRIMMED = {"stretch_from": None, "stretch_to": None, "points": None, "smooth": None}


@dataclass(frozen=True)
class Broken:
    """The last point before a specimen broke. stress: nominal, MPa."""

    stretch: float
    stress: float

    @property
    def text(self) -> str:
        """What is told of it."""
        return f"broke at a stretch of {self.stretch:.4g} and {1e3 * self.stress:.4g} kPa (nominal)"


def broken(sheet: TestSheet, test: Test) -> Broken:
    """Where a specimen broke: the last point of its test, without what comes after the break; with
    the zeros of the sheet, but whatever range of it is fitted.

    Raises SpecError where the test is not uniaxial tension, or not the whole of it is there.
    """
    for name in _PARTS:
        if getattr(sheet, name):
            raise SpecError(
                f"{sheet.file}: broke: the last point of the whole test is wanted; leave out {name}"
            )
    whole = prepare(sheet.model_copy(update=_UNTRIMMED), test)
    end = Broken(float(whole.stretch[-1]), float(whole.stress[-1]))
    if test.mode != "uniaxial" or end.stretch <= 1 or end.stress <= 0:
        raise SpecError(
            f"{sheet.file}: broke: strength and elongation come from uniaxial tension; this is "
            f"{test.mode} to a stretch of {end.stretch:.4g} and {1e3 * end.stress:.4g} kPa. A "
            "list of tests (a YAML file in place of FILE) says broke: true of some of them"
        )
    return end


def of_card(tests: Sequence[Test]) -> dict[str, object]:
    """Fields of a card: means over the specimens that broke; none where none did."""
    ends = [test.broken for test in tests if test.broken is not None]
    if not ends:
        return {}
    stresses, stretches = np.array([[end.stress, end.stretch] for end in ends]).T
    count = f"mean of {len(ends)} specimens that broke" if len(ends) > 1 else "one specimen"
    low, high = (f"{1e3 * of:.4g} kPa" for of in (stresses.min(), stresses.max()))
    between = f", {low} to {high}" if len(ends) > 1 else ""
    return {
        "strength": float(f"{stresses.mean():.6g}"),
        "strength_is": "nominal",
        "elongation": float(f"{stretches.mean() - 1:.6g}"),
        "strength_source": f"softact fit, last point before the break, {count}{between}",
    }

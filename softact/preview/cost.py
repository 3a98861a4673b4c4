"""How long a run will take, and how much memory: fits of measured runs.

docs/preview.md has the runs, and how far the fit is off.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from softact.preview.figures import Figures
from softact.spec import Spec


@dataclass(frozen=True)
class _Fit:
    """Of 23 first specs ('softact new'), one process with one thread.

    start: seconds of start, mesh and report. iteration: seconds of an iteration at ``unknowns``,
    which grow with this power, and ``small`` more. plain, fibres, slack, sheets: iterations in an
    increment of the largest size; slack: where layers wrinkle, or lie beside fibres. contact: times
    as many where surfaces touch. gravity: in such a step. off: largest ratio, either way, that the
    page shows. least, each, power: MB.
    """

    start: float = 7.0
    iteration: float = 0.25
    small: float = 0.03
    unknowns: float = 17_600.0
    grows: float = 1.34
    plain: float = 3.0
    fibres: float = 5.0
    slack: float = 20.0
    sheets: float = 60.0
    contact: float = 1.6
    gravity: float = 4.0
    off: float = 2.0
    least: float = 150.0
    each: float = 2e-3
    power: float = 1.15


FIT = _Fit()


@dataclass(frozen=True)
class Cost:
    """seconds: of one core. megabytes: of one process. iterations: of Newton's method."""

    seconds: float
    megabytes: float
    iterations: float

    @property
    def said(self) -> str:
        """In words, as a range."""
        low, high = (_duration(s) for s in (self.seconds / FIT.off, self.seconds * FIT.off))
        memory = _two_digits(self.megabytes / 1000)
        return f"{low} to {high} of one core and about {memory} GB, as far as a fit can say"


def cost(spec: Spec, figures: Figures) -> Cost:
    """The estimate for a spec on its mesh: iterations by what is in the spec, times a power of the
    number of unknowns."""
    per = _in_an_increment(spec, figures)
    per *= FIT.contact if spec.contact or spec.obstacles else 1.0
    iterations = sum(
        FIT.gravity if step.largest_increment == 1.0 else per * _increments(spec, number)
        for number, step in enumerate(spec.steps)
    )
    each = FIT.small + FIT.iteration * (figures.unknowns / FIT.unknowns) ** FIT.grows
    memory = FIT.least + FIT.each * figures.unknowns**FIT.power
    return Cost(FIT.start + iterations * each, memory, iterations)


def _in_an_increment(spec: Spec, figures: Figures) -> float:
    if figures.kind == "triangles":
        return FIT.sheets
    fibres = any(law.anisotropic for law in spec.materials.values())
    slack = any(layer.bending == 0 or layer.surface in figures.curved for layer in spec.layers)
    if slack or (fibres and spec.layers):
        return FIT.slack
    return FIT.fibres if fibres else FIT.plain


def _increments(spec: Spec, number: int) -> int:
    return math.ceil(1 / (spec.steps[number].largest_increment or spec.solver.max_increment) - 1e-9)


def _two_digits(value: float) -> str:
    return f"{float(f'{value:.2g}'):g}"


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{_two_digits(seconds)} s"
    if seconds < 5400:
        return f"{_two_digits(seconds / 60)} min"
    return f"{_two_digits(seconds / 3600)} h"

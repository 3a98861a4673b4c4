"""The plot of a fit: data and laws in every mode, tested or not, and the residuals."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.files.text import replacing
from softact.fit.candidates import as_candidate
from softact.fit.data import Test
from softact.fit.fit import Fit
from softact.fit.modes import MODES
from softact.fit.problem import model_stress
from softact.materials import Law

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = ("#0b62a4", "#d1495b", "#2e8b57", "#8a5fbf", "#c77d0a")
MARKS = "osD^vP"


def write_plot(path: Path, fits: list[Fit], others: dict[str, Law]) -> None:
    """Write a PNG with one panel per mode and one of the residuals of the best fit.

    fits: best first; five are drawn. others: materials to draw beside them, by name.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    best = fits[0]
    panels = drawn_modes(best)
    figure = Figure(figsize=(5.4 * ((len(panels) + 2) // 2), 8.4), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, (len(panels) + 2) // 2).ravel()
    for axis, (mode, direction) in zip(axes, panels, strict=False):
        _draw_mode(axis, mode, direction, fits[:5], others)
    _draw_residuals(axes[len(panels)], best)
    for axis in axes[len(panels) + 1 :]:
        axis.set_visible(False)
    kind = "fit of" if len(fits) == 1 else "best:"
    figure.suptitle(f"{kind} {best.name}, smallest R² {best.r2:.4f}")
    with replacing(path) as temporary:
        figure.savefig(temporary, format="png", dpi=120)


def drawn_modes(fit: Fit) -> list[tuple[str, str | None]]:
    """Modes and directions to draw: those of the tests, then the others as predictions."""
    measured = list(dict.fromkeys((t.mode, t.direction) for t in fit.problem.tests))
    if fit.candidate.law.anisotropic:
        return measured
    return measured + [(mode, None) for mode in MODES if mode not in {m for m, _ in measured}]


def _draw_mode(
    axis: Axes, mode: str, direction: str | None, fits: list[Fit], others: dict[str, Law]
) -> None:
    best = fits[0]
    tests = [t for t in best.problem.tests if (t.mode, t.direction) == (mode, direction)]
    for i, test in enumerate(tests):
        axis.plot(test.stretch, test.stress * 1e3, MARKS[i % len(MARKS)], ms=4, mfc="none",
                  mec="0.35", label=test.name if len(tests) <= 6 else None)  # fmt: skip
    low, high = best.range_of(mode)
    path = path_of(mode, direction, tests, low, high)
    style = "-" if tests else "--"
    for colour, fit in zip(COLOURS, fits, strict=False):
        stress = fit.stress(path) * 1e3
        axis.plot(path.stretch, stress, style, color=colour, lw=1.6, label=fit.name)
        for failed_mode, stretch in fit.failures:
            if failed_mode == mode:
                axis.axvline(stretch, color=colour, lw=0.8, ls=":")
    for i, (name, law) in enumerate(others.items()):
        stress = model_stress(as_candidate(law), np.zeros(0), path) * 1e3
        axis.plot(path.stretch, stress, "-.", color="k", lw=1.2 + 0.4 * i, label=name)
    if not tests and len(fits) + len(others) > 1:
        # Laws that run away where nothing was tested must not hide the others.
        reference = np.nanmax(np.abs(best.stress(path))) * 1e3
        axis.set_ylim(-0.5 * reference * (low < 0.97), 2.0 * reference)
    title = f"{mode}{' ' + direction if direction else ''}"
    axis.set(title=title if tests else f"{title}: prediction, not tested",
             xlabel="stretch", ylabel="nominal stress / kPa")  # fmt: skip
    axis.grid(alpha=0.25)
    axis.legend(fontsize=8, framealpha=0.8)


def path_of(mode: str, direction: str | None, tests: list[Test], low: float, high: float) -> Test:
    """The stretches over which laws are drawn, as a test without stress."""
    if mode == "biaxial":
        return tests[0]
    stretch = np.linspace(low, high, 300)
    return Test("path", mode, stretch, np.zeros_like(stretch), direction)


def _draw_residuals(axis: Axes, fit: Fit) -> None:
    for i, test in enumerate(fit.problem.tests):
        axis.plot(test.stretch, (fit.stress(test) - test.stress) * 1e3, MARKS[i % len(MARKS)],
                  ms=3.5, color=COLOURS[i % len(COLOURS)], mfc="none",
                  label=test.label if len(fit.problem.tests) <= 8 else None)  # fmt: skip
    axis.axhline(0.0, color="0.4", lw=0.8)
    axis.set(title=f"residuals of {fit.name}", xlabel="stretch",
             ylabel="law − data / kPa")  # fmt: skip
    axis.grid(alpha=0.25)
    if len(fit.problem.tests) <= 8:
        axis.legend(fontsize=8, framealpha=0.8)

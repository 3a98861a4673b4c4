"""What ``softact fit`` prints: plain lines."""

import numpy as np

from softact.fit.candidates import as_candidate
from softact.fit.data import Test
from softact.fit.fit import Fit
from softact.fit.problem import model_stress
from softact.fit.reason import reason
from softact.materials import Law


def tell_tests(tests: list[Test]) -> list[str]:
    """Return a line per test and the messages of reading it."""
    lines = []
    for test in tests:
        lines.append(
            f"{test.label}: {len(test.stretch)} points, stretch {np.min(test.stretch):.4g} to "
            f"{np.max(test.stretch):.4g}, stress to {_pressure(np.max(np.abs(test.stress)))}"
        )
        lines += [f"  {message}" for message in test.messages]
    return lines


def tell_fit(fit: Fit) -> list[str]:
    """Return constants with intervals, agreement per test, stability, scatter, remarks."""
    lines = [f"{fit.name}: {fit.candidate.law.formula}"]
    cards = {c.name: c for c in fit.candidate.law.constants()}
    for name, value, half in zip(
        fit.candidate.names, fit.vector, fit.certainty.interval, strict=True
    ):
        unit = f" {cards[name].unit}" if cards[name].unit else ""
        lines.append(f"  {name:9s} = {value:12.6g}{unit}   {_interval(half)}")
    for name, value in fit.candidate.fixed.items():
        lines.append(f"  {name:9s} = {value} (held)")
    for q in fit.qualities:
        lines.append(
            f"  {q.name}: R² {q.r2:.5f}, RMSE {_pressure(q.rmse)}, "
            f"largest error {_pressure(q.largest_error)}"
        )
    chi = "unknown scatter" if fit.chi_square is None else f"{fit.chi_square:.3g}"
    lines.append(
        f"  reduced chi-square {chi}; ε {fit.error:.4f}; "
        f"AICc {fit.information.aicc:.1f}, BIC {fit.information.bic:.1f}"
    )
    lines += stability_lines(fit)
    lines += [f"  attention: {remark}" for remark in fit.remarks()]
    return lines


def _interval(half: float) -> str:
    if np.isnan(half):
        return "at a bound"
    return f"± {half:.2g} (95 %)" if np.isfinite(half) else "not determined"


def stability_lines(fit: Fit) -> list[str]:
    """Return the range of stability in each mode, and the scatter of the specimens."""
    return _tell_stability(fit) + _tell_scatter(fit)


def _tell_stability(fit: Fit) -> list[str]:
    lines = []
    for s in fit.stability:
        parts = []
        if s.below is not None:
            parts.append(f"below {s.below:.3g}")
        if s.above is not None:
            parts.append(f"above {s.above:.3g}")
        said = "unstable " + " and ".join(parts) if parts else "stable from 0.1 to 10"
        lines.append(f"  Drucker, {s.mode}: {said}")
    return lines


def _tell_scatter(fit: Fit) -> list[str]:
    lines = [
        f"  scatter of {s.specimens} specimens ({s.mode}), coefficient of variation: stress "
        f"{100 * s.stress:.1f} %, largest stress {100 * s.strength:.1f} %, "
        f"largest elongation {100 * s.largest_stretch:.1f} %"
        for s in fit.spreads
    ]
    if len(fit.specimens) > 1:
        vectors = np.array([s.vector for s in fit.specimens])
        mean, deviation = np.mean(vectors, axis=0), np.std(vectors, axis=0, ddof=1)
        for name, m, d in zip(fit.candidate.names, mean, deviation, strict=True):
            variation = f"{100 * d / abs(m):.1f} %" if m else "-"
            lines.append(f"  each specimen alone: {name} {m:.4g}, variation {variation}")
    return lines


def tell_ranking(fits: list[Fit]) -> list[str]:
    """Return a table of the fits, best first, and why the first is first."""
    width = max(len(f.name) for f in fits)
    held = "modes" if fits[0].worth.modes else "quarters of the stretch"
    heads = ("smallest R²", "error", "held out", "AICc", "BIC")
    lines = [f"{'law':{width}s}  constants  {'  '.join(f'{h:>10s}' for h in heads)}  remark"]
    for f in fits:
        loose = f"{f.worth.loose} poorly determined" if f.worth.loose else ""
        figures = (
            f"{f.r2:.5f}", percent(f.worth.fitted), percent(f.worth.predicted),
            f"{f.information.aicc:.1f}", f"{f.information.bic:.1f}",
        )  # fmt: skip
        row = "  ".join(
            f"{text:>{max(len(h), 10)}s}" for text, h in zip(figures, heads, strict=True)
        )
        said = "; ".join(filter(None, (remark_of(f), loose)))
        lines.append(f"{f.name:{width}s}  {f.worth.constants:9d}  {row}  {said}".rstrip())
    lines.append(f"(held out: error over {held} that the law was not fitted to, each in turn)")
    return [*lines, reason(fits)]


def percent(part: float | None) -> str:
    """An error as people write it; one that is beyond use has no figure."""
    if part is None:
        return "-"
    return f"{100 * part:.3g} %" if part < 5 else "> 500 %"


def remark_of(fit: Fit) -> str:
    """Why a law is not sound, in a few words; empty where it is."""
    if fit.failures:
        mode, stretch = fit.failures[0]
        return f"unstable in {mode} at {stretch:.3g}"
    return "" if fit.certainty.identifiable else "not determined by these tests"


def tell_comparison(fit: Fit, law: Law, name: str) -> list[str]:
    """Return how another material's stress differs from the fit over each test."""
    lines = []
    other = as_candidate(law)
    for test in fit.problem.tests:
        mine, theirs = fit.stress(test), model_stress(other, np.zeros(0), test)
        large = np.abs(mine) > 0.05 * np.max(np.abs(mine))
        ratio = theirs[large] / mine[large] - 1.0
        error = theirs - test.stress
        total = np.sum((test.stress - np.mean(test.stress)) ** 2)
        worst = int(np.argmax(np.abs(ratio)))
        lines.append(
            f"{name} on {test.label}: R² {1 - np.sum(error**2) / total:.4f}, RMSE "
            f"{_pressure(np.sqrt(np.mean(error**2)))}; its stress differs from the fit by "
            f"{100 * np.mean(ratio):+.1f} % on average, {100 * ratio[worst]:+.1f} % at a stretch "
            f"of {test.stretch[large][worst]:.3g}"
        )
    return lines


def _pressure(value: float) -> str:
    return f"{value * 1e3:.3g} kPa" if abs(value) < 1.0 else f"{value:.4g} MPa"

"""The page of a fit: laws and data in every mode, residuals, constants, ranking, the card."""

from collections.abc import Mapping, Sequence

import numpy as np
from markupsafe import Markup

from softact.fit.candidates import as_candidate
from softact.fit.fit import Fit
from softact.fit.plot import drawn_modes, path_of
from softact.fit.problem import model_stress
from softact.fit.reason import reason
from softact.fit.tell import percent, remark_of, stability_lines
from softact.materials import Law
from softact.report import base
from softact.report.base import Plot, Section

_DRAWN = 5  # laws in a plot; the ranking has them all


def html(name: str, fits: Sequence[Fit], others: Mapping[str, Law], card: str) -> str:
    """The text of the page. fits: best first. others: materials beside them; card: YAML or ""."""
    best = fits[0]
    sections = [
        Section("constants", f"Constants: {best.name}", nav="Constants"),
        Section("curves", "Curves"),
        Section("residuals", "Residuals"),
        *([Section("ranking", "Ranking")] if len(fits) > 1 else []),
        *([Section("card", "Card")] if card else []),
    ]
    return base.page(
        name,
        sections,
        kicker="Fit of a material law",
        kind="fit",
        template="fit/fit_page.html",
        verdict=_verdict(fits),
        formula=best.candidate.law.formula,
        constants=_constants(best),
        agreement=_agreement(best),
        stability=[line.strip() for line in stability_lines(best)],
        curves=base.figures(_curves(fits[:_DRAWN], others)),
        residuals=base.figures([_residuals(best)]),
        ranking=_ranking(fits) if len(fits) > 1 else None,
        card=card,
        download=base.download(f"{name}.yaml", card.encode(), "text/yaml"),
    )


def _verdict(fits: Sequence[Fit]) -> Markup:
    best = fits[0]
    said = f"{best.name}, smallest R² {best.r2:.5f}."
    if len(fits) > 1:
        said += f" {reason(fits)}"
    head = "Fit:" if len(fits) == 1 else "Best of the fits:"
    return base.banner("good" if best.sound else "warn", head, said, best.remarks())


def _constants(fit: Fit) -> Markup:
    cards = {c.name: c for c in fit.candidate.law.constants()}
    rows = [
        [name, f"{value:.6g}", f"{half:.2g}" if np.isfinite(half) else "–", cards[name].unit or ""]
        for name, value, half in zip(
            fit.candidate.names, fit.vector, fit.certainty.interval, strict=True
        )
    ]
    rows += [[name, str(value), "", "held"] for name, value in fit.candidate.fixed.items()]
    return base.table(["Constant", "Value", "± (95 %)", "Unit"], rows, file="constants.csv")


def _agreement(fit: Fit) -> Markup:
    rows: list[list[str | float | None]] = [
        [q.name, float(q.r2), 1e3 * float(q.rmse), 1e3 * float(q.largest_error)]
        for q in fit.qualities
    ]
    return base.table(["Test", "R²", "RMSE (kPa)", "Largest error (kPa)"], rows, file="tests.csv")


def _ranking(fits: Sequence[Fit]) -> dict[str, str]:
    rows: list[list[str | float | None]] = [
        [
            f.name,
            remark_of(f),
            len(f.vector),
            f.worth.loose,
            f"{f.r2:.4f}",
            _unbroken(f.worth.fitted),
            _unbroken(f.worth.predicted),
            _unbroken(f.worth.error),
            round(float(f.information.bic), 1),
        ]
        for f in fits
    ]
    heads = ["Law", "Remark", "Constants", "Poor", "R²", "Error", "Held out", "In all", "BIC"]
    return {
        "reason": reason(fits),
        "table": base.table(heads, rows, file="ranking.csv"),
        "pieces": "modes" if fits[0].worth.modes else "quarters of the stretch",
    }


def _unbroken(part: float | None) -> str:
    return percent(part).replace(" ", "\N{NO-BREAK SPACE}")


def _curves(fits: Sequence[Fit], others: Mapping[str, Law]) -> list[Plot]:
    return [_mode(mode, direction, fits, others) for mode, direction in drawn_modes(fits[0])]


def _mode(mode: str, direction: str | None, fits: Sequence[Fit], others: Mapping[str, Law]) -> Plot:
    best = fits[0]
    tests = [t for t in best.problem.tests if (t.mode, t.direction) == (mode, direction)]
    path = path_of(mode, direction, tests, *best.range_of(mode))
    traces = [
        base.xy(test.name, test.stretch, 1e3 * test.stress, mode="markers", colour="@c8")
        for test in tests
    ]
    dash = {} if tests else {"dash": "dash"}
    for number, fit in enumerate(fits, 1):
        stress = 1e3 * fit.stress(path)
        line = {"width": 2, **dash}
        traces.append(
            base.xy(fit.name, path.stretch, stress, mode="lines", colour=f"@c{number}", line=line)
        )
    for name, law in others.items():
        stress = 1e3 * model_stress(as_candidate(law), np.zeros(0), path)
        line = {"width": 2, "dash": "dashdot"}
        traces.append(base.xy(name, path.stretch, stress, mode="lines", colour="@ink", line=line))
    layout = {}
    if not tests and len(fits) + len(others) > 1:
        # Laws that run away where nothing was tested must not hide the others.
        top = 1e3 * float(np.nanmax(np.abs(best.stress(path))))
        low = best.range_of(mode)[0] < 0.97
        layout = {"yaxis": {"range": [-0.5 * top if low else 0.0, 2.0 * top]}}
    title = f"{mode}{' ' + direction if direction else ''}".capitalize()
    title += "" if tests else ": prediction, not tested"
    return base.lines(title, "Stretch", "Nominal stress (kPa)", traces, layout=layout)


def _residuals(fit: Fit) -> Plot:
    traces = [
        base.xy(test.label, test.stretch, 1e3 * (fit.stress(test) - test.stress), mode="markers")
        for test in fit.problem.tests
    ]
    title = f"Residuals of {fit.name}"
    return base.lines(title, "Stretch", "Law − data (kPa)", traces, wide=True)

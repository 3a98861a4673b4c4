"""The page of a fit: laws and data in every mode, residuals, constants, ranking, the card."""

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

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
        Section("constants", f"Constants: {best.name}", _constants(best), "Constants"),
        Section("curves", "Curves", base.figures(_curves(fits[:_DRAWN], others))),
        Section("residuals", "Residuals", base.figures([_residuals(best)])),
    ]
    if len(fits) > 1:
        sections.append(Section("ranking", "Ranking", _ranking(fits)))
    if card:
        link = base.download(f"{name}.yaml", card.encode(), "text/yaml")
        sections.append(Section("card", "Card", f"<pre>{escape(card)}</pre><p>{link}</p>"))
    kind = "good" if best.sound else "warn"
    head = "Fit:" if len(fits) == 1 else "Best of the fits:"
    said = f"{escape(best.name)}, smallest R² {best.r2:.5f}."
    if len(fits) > 1:
        said += f" {escape(reason(fits))}"
    lead = base.banner(kind, head, said, best.remarks())
    lead += f"<p class='note'>{escape(best.candidate.law.formula)}</p>"
    return base.page(name, sections, kicker="Fit of a material law", kind="fit", lead=lead)


def _constants(fit: Fit) -> str:
    cards = {c.name: c for c in fit.candidate.law.constants()}
    rows = [
        [name, f"{value:.6g}", f"{half:.2g}" if np.isfinite(half) else "–", cards[name].unit or ""]
        for name, value, half in zip(
            fit.candidate.names, fit.vector, fit.certainty.interval, strict=True
        )
    ]
    rows += [[name, str(value), "", "held"] for name, value in fit.candidate.fixed.items()]
    tests = [
        [q.name, float(q.r2), 1e3 * float(q.rmse), 1e3 * float(q.largest_error)]
        for q in fit.qualities
    ]
    listed = "".join(f"<li>{escape(line.strip())}</li>" for line in stability_lines(fit))
    return (
        base.table(["Constant", "Value", "± (95 %)", "Unit"], rows, file="constants.csv")
        + "<h3>Agreement with each test</h3>"
        + base.table(["Test", "R²", "RMSE (kPa)", "Largest error (kPa)"], tests, file="tests.csv")
        + (f"<h3>Range and scatter</h3><ul>{listed}</ul>" if listed else "")
    )


def _ranking(fits: Sequence[Fit]) -> str:
    rows = [
        [
            f.name,
            remark_of(f),
            len(f.vector),
            f.merit.loose,
            f"{f.r2:.4f}",
            _unbroken(f.merit.fitted),
            _unbroken(f.merit.predicted),
            _unbroken(f.merit.error),
            round(float(f.information.bic), 1),
        ]
        for f in fits
    ]
    heads = ["Law", "Remark", "Constants", "Poor", "R²", "Error", "Held out", "In all", "BIC"]
    held = "modes" if fits[0].merit.modes else "quarters of the stretch"
    note = (
        "<p class='note'>Poor: constants whose interval is wider than their value. R²: the "
        "smallest of the tests. Error: root mean square, in parts of that of the stress. Held out: "
        f"the same over {held} that the law was not fitted to, each in turn. In all: both, raised "
        "by what the constants cost, which makes the order.</p>"
    )
    return f"<p>{escape(reason(fits))}</p>" + base.table(heads, rows, file="ranking.csv") + note


def _unbroken(part: float | None) -> str:
    return percent(part).replace(" ", "\N{NO-BREAK SPACE}")


def _curves(fits: Sequence[Fit], others: Mapping[str, Law]) -> list[Plot]:
    return [_mode(mode, direction, fits, others) for mode, direction in drawn_modes(fits[0])]


def _mode(mode, direction, fits: Sequence[Fit], others: Mapping[str, Law]) -> Plot:
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

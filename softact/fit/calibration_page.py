"""The page of a calibration: curves, constants with their confidence, and the way there."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from softact.fit.calibration import Calibration, Trial
from softact.report import base
from softact.report.base import Plot, Section
from softact.report.labels import column


def html(name: str, outcome: Calibration, spec_yaml: str, run: Path) -> str:
    """The text of the page. spec_yaml: the calibrated spec; run: folder of the best run."""
    sections = [
        Section("constants", "Constants"),
        Section("curves", "Measured and computed", nav="Curves"),
        Section("residuals", "Residuals"),
        Section("history", "History"),
        Section("spec", "Calibrated spec", nav="Spec"),
    ]
    measured = outcome.measured
    said = ", ".join(str(column(each)) for each in measured.names)
    return base.page(
        f"{name}: calibration",
        sections,
        kicker="Calibration of a soft actuator",
        kind="calibration",
        template="fit/calibration_page.html",
        verdict=_verdict(outcome),
        data=f"{said} over {column(measured.x)}, from {Path(measured.source).name}",
        constants=_constants(outcome),
        correlation=_correlation(outcome),
        curves=base.figures([_curve(outcome, each) for each in measured.names]),
        agreement=_agreement(outcome),
        residuals=base.figures([_residuals(outcome, each) for each in measured.names]),
        history=base.figures([_misfits(outcome), _way(outcome)]),
        runs=_runs(outcome),
        spec=spec_yaml,
        download=base.download(f"{name}.yaml", spec_yaml.encode(), "text/yaml"),
        folder=run,
    )


def _verdict(outcome: Calibration) -> Markup:
    before, after = (outcome.misfit(trial) for trial in (outcome.first, outcome.best))
    said = f"misfit {before:.2%} before, {after:.2%} after, {outcome.runs} runs."
    sound = not outcome.remarks and np.isfinite(outcome.interval).all()
    return base.banner("good" if sound else "warn", "Calibrated:", said, outcome.remarks)


def interval_text(half: float) -> str:
    """The half width of an interval in words."""
    if np.isnan(half):
        return "at a bound"
    return f"{half:.2g}" if np.isfinite(half) else "not determined"


def _constants(outcome: Calibration) -> Markup:
    heads = ["Constant", "Value", "± (95 %)", "Unit", "Before", "Lower bound", "Upper bound"]
    rows = [
        [knob.path, f"{value:.6g}", interval_text(half), knob.unit,
         *(f"{number:.6g}" for number in (knob.value, knob.low, knob.high))]
        for knob, value, half in zip(
            outcome.knobs, outcome.best.values, outcome.interval, strict=True
        )
    ]  # fmt: skip
    return base.table(heads, rows, file="constants.csv", numbers=True)


def _correlation(outcome: Calibration) -> Markup | None:
    """Of the constants that are determined; None where there are not two."""
    spread = np.sqrt(np.diag(outcome.covariance))
    sure = np.flatnonzero(np.isfinite(spread) & (spread > 0))
    if len(sure) < 2:
        return None
    found = outcome.covariance[np.ix_(sure, sure)] / np.outer(spread[sure], spread[sure])
    names = [outcome.knobs[n].path for n in sure]
    rows = [[name, *map(float, row)] for name, row in zip(names, found, strict=True)]
    return base.table(["", *names], rows, file="correlation.csv")


def _ordered(outcome: Calibration) -> tuple[np.ndarray, np.ndarray]:
    """Order (k,) of the measured points along the abscissa, and that as it is shown."""
    x = outcome.measured.values[outcome.measured.x]
    order = np.argsort(x, kind="stable")
    return order, x[order] * column(outcome.measured.x).factor


def _curve(outcome: Calibration, name: str) -> Plot:
    label, (order, x) = column(name), _ordered(outcome)

    def trace(said: str, values: np.ndarray, **look: Any) -> dict:
        return base.xy(said, x, values[order] * label.factor, **look)

    dashed = {"dash": "dash", "width": 2}
    traces = [
        trace("measured", outcome.measured.values[name], mode="markers", colour="@c8",
              marker={"size": 8}),
        trace("before", outcome.first.curves[name], mode="lines", colour="@c2", line=dashed),
        trace("calibrated", outcome.best.curves[name], mode="lines", colour="@c1"),
    ]  # fmt: skip
    return base.lines(label.name, str(column(outcome.measured.x)), str(label), traces, wide=True)


def _residuals(outcome: Calibration, name: str) -> Plot:
    """Run minus measured."""
    label, (order, x) = column(name), _ordered(outcome)
    traces = [
        base.xy(said, x, (trial.curves[name] - outcome.measured.values[name])[order] * label.factor,
                mode="markers", colour=colour)
        for said, trial, colour in (
            ("before", outcome.first, "@c2"), ("calibrated", outcome.best, "@c1"),
        )
    ]  # fmt: skip
    unit = f" ({label.unit})" if label.unit else ""
    title = f"{label.name}: run minus measured"
    return base.lines(title, str(column(outcome.measured.x)), f"Difference{unit}", traces)


def _agreement(outcome: Calibration) -> Markup:
    before, after = outcome.rmse(outcome.first), outcome.rmse(outcome.best)
    rows: list[Sequence[str | float | None]] = []
    for name in outcome.measured.names:
        label = column(name)
        off = np.abs(outcome.best.curves[name] - outcome.measured.values[name])
        numbers = before[name], after[name], float(off.max())
        rows.append([label.name, label.unit, *(number * label.factor for number in numbers)])
    heads = ["Column", "Unit", "RMSE before", "RMSE after", "Largest difference after"]
    return base.table(heads, rows, file="agreement.csv")


def _misfits(outcome: Calibration) -> Plot:
    numbers = np.arange(1, outcome.runs + 1)
    misfits = 100 * np.array([outcome.misfit(trial) for trial in outcome.trials])
    best = np.minimum.accumulate(misfits)
    traces = [
        base.xy("runs", numbers, misfits, mode="markers", colour="@c1"),
        base.xy("best so far", numbers, best, mode="lines", colour="@c2", line={"shape": "hv"}),
    ]
    ticks = {"yaxis": {"type": "log"}, "xaxis": _whole(outcome.runs)}
    return base.lines("Misfit of each run", "Run", "Misfit (%)", traces, layout=ticks)


def _whole(runs: int) -> dict:
    """Ticks at whole numbers of runs."""
    return {"tick0": 1, "dtick": max(1, runs // 8)}


def _way(outcome: Calibration) -> Plot:
    """Each constant over the runs, by its value before."""
    numbers = np.arange(1, outcome.runs + 1)
    values = np.array([trial.values for trial in outcome.trials])
    traces = [
        base.xy(knob.path, numbers, values[:, n] / knob.size)
        for n, knob in enumerate(outcome.knobs)
    ]
    layout = {"xaxis": _whole(outcome.runs)}
    if len(traces) == 1:
        traces[0]["showlegend"] = True
    return base.lines("Constants of each run", "Run", "By the value before", traces, layout=layout)


def _runs(outcome: Calibration) -> Markup:
    heads = ["Run", "Misfit (%)", *(_head(knob.path, knob.unit) for knob in outcome.knobs)]
    rows = [[str(number), _misfit(outcome, trial), *trial.values]
            for number, trial in enumerate(outcome.trials, 1)]  # fmt: skip
    return base.table(heads, rows, file="runs.csv")


def _head(path: str, unit: str) -> str:
    return f"{path} ({unit})" if unit else path


def _misfit(outcome: Calibration, trial: Trial) -> float | None:
    found = outcome.misfit(trial)
    return 100 * found if np.isfinite(found) else None

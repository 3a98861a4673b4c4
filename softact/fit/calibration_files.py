"""What a calibration tells and leaves behind: spec, curves, numbers, plot, the best run."""

from pathlib import Path

import numpy as np

from softact.files.text import csv_text, json_text, replacing, write_atomic
from softact.fit.calibration import Calibration, CalibrationRequest
from softact.fit.calibration_page import html
from softact.report.labels import column
from softact.results.own_folder import Output
from softact.spec import Spec


def tell(outcome: Calibration) -> list[str]:
    """Return the constants with their intervals, and the errors before and after."""
    lines = [""]
    for knob, value, half in zip(outcome.knobs, outcome.best.values, outcome.interval, strict=True):
        lines.append(
            f"{knob.path} = {knob.text(float(f'{value:.6g}'))}   {_interval(half)}, "
            f"was {knob.text(knob.value)}"
        )
    before, after = outcome.rmse(outcome.first), outcome.rmse(outcome.best)
    for name in outcome.measured.names:
        largest = np.max(np.abs(outcome.measured.values[name]))
        lines.append(
            f"{name}: RMSE {before[name]:.4g} before, {after[name]:.4g} after "
            f"({after[name] / largest:.2%} of the largest), {outcome.runs} runs"
        )
    return [*lines, *(f"attention: {remark}" for remark in outcome.remarks)]


def _interval(half: float) -> str:
    if np.isnan(half):
        return "at a bound"
    return f"± {half:.2g} (95 %)" if np.isfinite(half) else "not determined"


def files(spec: Spec) -> tuple[str, ...]:
    """Names of spec, curves, numbers, plot, page, and the folder of the best run."""
    names = "curves.csv", "calibration.json", "calibration.png", "calibration.html", "run"
    return f"{spec.name}.yaml", *names


def write(request: CalibrationRequest, outcome: Calibration, output: Output) -> list[str]:
    """Write all files; return a line for each."""
    head = [f"# Calibrated by softact to {request.data.name} over {outcome.measured.x}:"]
    head += [f"# {line}" for line in tell(outcome)[1:]]
    spec, curves, numbers, plot, page, run = files(outcome.spec)
    texts = {
        "spec": (spec, "\n".join(head) + "\n" + outcome.spec.to_yaml()),
        "curves": (curves, csv_text(_rows(outcome))),
        "numbers": (numbers, json_text(_numbers(request, outcome))),
    }
    lines = []
    for what, (name, text) in texts.items():
        write_atomic(output.file(name), text)
        lines.append(f"{what + ':':9s}{output.directory / name}")
    _plot(output.file(plot), outcome)
    lines.append(f"plot:    {output.directory / plot}")
    text = html(outcome.spec.name, outcome, texts["spec"][1], output.directory / run)
    write_atomic(output.file(page), text)
    lines.append(f"page:    {output.directory / page}")
    folder = output.results(run, outcome.best.folder)
    return [*lines, f"run:     {folder} (softact report makes its report)"]


def _rows(outcome: Calibration) -> list[dict[str, float]]:
    """Measured, before and after, a row for each measured point."""
    measured = outcome.measured
    rows = []
    for i, x in enumerate(measured.values[measured.x]):
        row = {measured.x: float(x)}
        for name in measured.names:
            row[f"measured_{name}"] = float(measured.values[name][i])
            row[f"before_{name}"] = float(outcome.first.curves[name][i])
            row[f"after_{name}"] = float(outcome.best.curves[name][i])
        rows.append(row)
    return rows


def _numbers(request: CalibrationRequest, outcome: Calibration) -> dict[str, object]:
    return {
        "spec": request.spec.name,
        "data": request.data.name,
        "runs": outcome.runs,
        "constants": {
            knob.path: {
                "value": value,
                "unit": knob.unit,
                "before": knob.value,
                "confidence_95": half,
                "bounds": [knob.low, knob.high],
            }
            for knob, value, half in zip(
                outcome.knobs, outcome.best.values, outcome.interval, strict=True
            )
        },
        "covariance": outcome.covariance.tolist(),
        "rmse_before": outcome.rmse(outcome.first),
        "rmse_after": outcome.rmse(outcome.best),
        "remarks": outcome.remarks,
    }


def _plot(path: Path, outcome: Calibration) -> None:
    """A panel for each measured column: data, the run before and the run after."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    measured = outcome.measured
    order = np.argsort(measured.values[measured.x])
    abscissa = column(measured.x)
    x = measured.values[measured.x][order] * abscissa.factor
    figure = Figure(figsize=(6.4, 4.2 * len(measured.names)), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(measured.names), 1, squeeze=False).ravel()
    for panel, name in zip(panels, measured.names, strict=True):
        label = column(name)
        for trial, style, said in (
            (outcome.first, {"color": "0.55", "ls": "--"}, "before"),
            (outcome.best, {"color": "#0b62a4"}, "calibrated"),
        ):
            panel.plot(x, trial.curves[name][order] * label.factor, label=said, **style)
        panel.plot(x, measured.values[name][order] * label.factor, "o", ms=4, mfc="none",
                   mec="k", label=f"measured ({Path(measured.source).name})")  # fmt: skip
        panel.set(xlabel=str(abscissa), ylabel=str(label))
        panel.grid(alpha=0.25)
        panel.legend()
    with replacing(path) as temporary:
        figure.savefig(temporary, format="png", dpi=120)

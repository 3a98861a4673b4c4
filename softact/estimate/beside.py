"""An estimate beside the run that it is of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from softact.errors import SpecError
from softact.estimate import Estimate, estimate
from softact.report import labels
from softact.report.base import Plot, Section, figures, lines, xy
from softact.report.base.templates import macros
from softact.results.folder import Results
from softact.spec import Spec, loads

#: An estimate that is farther off at half of the pressure is said to be off.
OFF = 0.3


@dataclass(frozen=True)
class Difference:
    """A column of estimate and run at a pressure in kPa."""

    column: str
    pressure: float
    estimated: float
    solved: float

    @property
    def part(self) -> float:
        """Estimate over run, less one."""
        return self.estimated / self.solved - 1 if self.solved else float("nan")

    def text(self) -> str:
        """In words."""
        label = labels.column(self.column)
        one, other = (labels.number(v * label.factor) for v in (self.estimated, self.solved))
        return (
            f"{label.name} at {self.pressure:.4g} kPa: estimate {one} {label.unit}, run {other} "
            f"{label.unit} ({100 * self.part:+.0f} %)"
        )


def of_run(results: Results) -> Estimate:
    """The estimate of a run's spec. Raises SpecError where there is none."""
    return estimate(loads(results.spec_yaml, str(results.directory / "spec.yaml")))


def differences(
    found: Estimate, results: Results, parts: Sequence[float] = (0.5, 1.0)
) -> list[Difference]:
    """Of the columns that both have, at parts of the estimate's last pressure that the run reached.

    Raises SpecError where the run has no such pressure, as of a tube pressed on a bare surface.
    """
    curve, pressure = results.curve, found.pressure
    if pressure not in curve:
        raise SpecError(f"{results.directory}: its curve has no column {pressure} to compare over")
    rising = _rising(curve, pressure)
    last = found.columns[pressure][-1]
    return [
        Difference(
            column, part * last, found.at(column, part * last),
            float(np.interp(part * last, curve[pressure][rising], curve[column][rising])),
        )
        for column in _shared(found, results)
        for part in parts
        if part * last <= curve[pressure][rising].max() + 1e-9
    ]  # fmt: skip


def _shared(found: Estimate, results: Results) -> Iterator[str]:
    for column in list(found.columns)[1:]:
        if column in results.curve and not column.startswith("blocked"):
            yield column


def _rising(curve: Mapping[str, np.ndarray], pressure: str) -> np.ndarray:
    """Rows of the step in which the pressure changes most, up to its largest value."""
    values, steps = curve[pressure], curve["step"]
    spans = {step: np.ptp(values[steps == step]) for step in dict.fromkeys(steps)}
    rows = np.flatnonzero(steps == max(spans, key=spans.__getitem__))
    rows = rows[: int(np.argmax(values[rows])) + 1]
    return rows[np.concatenate([[True], np.diff(values[rows]) > 0])]


def is_of_another(spec: Spec, results: Results) -> list[str]:
    """Parts of a spec in which it differs from that of a run."""
    run = loads(results.spec_yaml, str(results.directory / "spec.yaml"))
    parts = ("geometry", "materials", "layers", "steps")
    return [part for part in parts if getattr(run, part) != getattr(spec, part)]


def verdict(found: Estimate, results: Results) -> list[str]:
    """Plain lines: how far the estimate is off, and why where that is known."""
    apart = differences(found, results)
    said = [difference.text() for difference in apart]
    if any(abs(d.part) > OFF for d in apart if d.pressure < found.columns[found.pressure][-1]):
        said.append(f"at half of the pressure it is off by more than {100 * OFF:g} %")
    return said


def section(results: Results) -> Section:
    """The part of a report that shows the estimate beside the run. Raises SpecError as ``of_run``
    does."""
    found = of_run(results)
    apart = verdict(found, results)
    poor = [f"poor here: {line}" for line in found.reservations]
    told = [*apart, *poor, *found.notes]
    plots = figures(_plots(found, results))
    body = macros("estimate/beside.html").section(found.method, plots, told)
    return Section("estimate", "Beside a beam estimate", body, "Estimate")


def _plots(found: Estimate, results: Results) -> Iterator[Plot]:
    x = found.pressure
    rows = _rising(results.curve, x)
    for column in _shared(found, results):
        label = labels.column(column)
        traces = [
            xy("run", results.curve[x][rows], results.curve[column][rows] * label.factor),
            xy("estimate", found.columns[x], found.columns[column] * label.factor, mode="lines",
               line={"dash": "dash"}),
        ]  # fmt: skip
        yield lines(f"{label.name}: run and estimate", str(labels.column(x)), str(label), traces)

"""Sensitivity indices of the measures (SALib): Sobol's variances or Morris's elementary effects.

Sobol: Saltelli 2010, Comput. Phys. Commun. 181:259; Morris 1991, Technometrics 33:161.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from markupsafe import Markup

from softact.errors import SpecError
from softact.report import base, labels
from softact.report.base import Section
from softact.results.folder import COMPLETE
from softact.sweep.design import MOST_POINTS, Coordinates, sampled
from softact.sweep.spec import Sweep
from softact.sweep.study import Study
from softact.sweep.table import Row

_LEVELS = 4  # of Morris's grid


@dataclass(frozen=True)
class Sample:
    """Points for indices: (n, axes) fractions and their coordinates, in blocks of ``block``
    points that count together or not at all."""

    kind: Literal["sobol", "morris"]
    problem: dict
    fractions: np.ndarray
    points: list[Coordinates]
    block: int


@dataclass(frozen=True)
class Indices:
    """rows: one for each measure and axis. notes: lines on what was left out."""

    kind: str
    rows: list[dict[str, float | str]]
    notes: list[str]


def sample_of(kind: Literal["sobol", "morris"], sweep: Sweep) -> Sample:
    """The points that indices need; ``design.samples`` is the number of blocks.

    Sobol takes axes + 2 points a block, Morris (a trajectory) axes + 1.
    """
    import SALib.sample.morris
    import SALib.sample.sobol

    count, size = sweep.design.samples, len(sweep.axes)
    if size < 2:
        raise SpecError("--sensitivity compares axes, and this sweep has only one")
    points = count * (size + (2 if kind == "sobol" else 1))
    if points > MOST_POINTS:
        raise SpecError(
            f"--sensitivity {kind}: {count} samples of {size} axes are {points} points; a study "
            f"has at most {MOST_POINTS}, so take fewer samples"
        )
    # Sobol: an array, since SALib hands the names to pandas, which takes no list any more.
    titles = [axis.title for axis in sweep.axes]
    names = np.array(titles) if kind == "sobol" else titles
    problem = {"num_vars": size, "names": names, "bounds": [[0.0, 1.0]] * size}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about numbers that are no powers of two
        if kind == "sobol":
            seed = sweep.design.seed
            fractions = SALib.sample.sobol.sample(
                dict(problem), count, calc_second_order=False, seed=seed
            )
            block = size + 2
        else:
            fractions = SALib.sample.morris.sample(
                dict(problem), count, num_levels=_LEVELS, seed=sweep.design.seed
            )
            block = size + 1
    return Sample(kind, problem, fractions, sampled(sweep.axes, fractions), block)


def indices(sample: Sample, study: Study, table: Sequence[Row]) -> Indices:
    """Indices of every measure that varies. Blocks with a point that is not complete are left
    out, and the notes say how many."""
    from softact.sweep.sweep_page import shown_measures

    good = np.array([row["status"] == COMPLETE for row in table])
    whole = np.repeat(good.reshape(-1, sample.block).all(axis=1), sample.block)
    blocks, kept = len(table) // sample.block, int(whole.sum()) // sample.block
    notes = []
    if kept < blocks:
        notes.append(
            f"sensitivity: {blocks - kept} of {blocks} blocks of the sample hold points that are "
            "not complete and are left out"
        )
    if kept < 2:
        return Indices(sample.kind, [], [*notes, "sensitivity: too few complete blocks"])
    rows = []
    for name in shown_measures(list(table), study):
        cells = [row.get(name, np.nan) for row in table]
        values = np.array([c if isinstance(c, float) else np.nan for c in cells])[whole]
        if np.isfinite(values).all() and np.ptp(values) > 0:
            rows += _rows(sample, sample.fractions[whole], name, values)
    return Indices(sample.kind, rows, notes)


def _rows(sample: Sample, fractions: np.ndarray, name: str, values: np.ndarray) -> list[dict]:
    import SALib.analyze.morris
    import SALib.analyze.sobol

    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        if sample.kind == "sobol":
            # The estimator assumes a mean of zero: with another it is biased in small samples.
            found = SALib.analyze.sobol.analyze(
                dict(sample.problem), values - values.mean(), calc_second_order=False, seed=0
            )
            keys = {"S1": "first_order", "S1_conf": "first_order_95",
                    "ST": "total", "ST_conf": "total_95"}  # fmt: skip
        else:
            found = SALib.analyze.morris.analyze(
                dict(sample.problem), fractions, values, num_levels=_LEVELS, seed=0
            )
            keys = {"mu_star": "mean_effect", "mu_star_conf": "mean_effect_95",
                    "mu": "signed_mean_effect", "sigma": "spread"}  # fmt: skip
    return [
        {"measure": name, "axis": str(axis)}
        | {title: float(found[key][number]) for key, title in keys.items()}
        for number, axis in enumerate(sample.problem["names"])
    ]


_MEANING = {
    "sobol": "First order: the part of the measure's variance that the axis makes alone; total: "
    "with what it makes together with others; ± their 95 % confidence.",
    "morris": "Mean effect: by how much the measure changes, on average, when the axis goes from "
    "one end to the other; spread: how much that depends on where the others stand. In the "
    "measure's unit as in sweep.csv.",
}


def section(found: Indices) -> list[Section]:
    """The indices as a section of the page, none where there are none."""
    if not found.rows:
        return []
    names = [name for name in found.rows[0] if name != "measure"]
    rows = [
        (labels.column(str(row["measure"])).name, *(row[name] for name in names))
        for row in found.rows
    ]
    heads = ["measure", *(name.replace("_", " ") for name in names)]
    meaning = base.note(_MEANING[found.kind])
    notes = Markup("").join(base.note(text) for text in found.notes)
    body = meaning + base.table(heads, rows) + notes
    return [Section("sensitivity", f"Sensitivity ({found.kind.capitalize()})", body)]

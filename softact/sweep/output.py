"""The files of a sweep's folder."""

from __future__ import annotations

from collections.abc import Callable

from softact.files.text import csv_text, write_atomic
from softact.results.own_folder import Output
from softact.sweep import confirm, sensitivity, sweep_page, table, tolerance_check
from softact.sweep.compute import Answer
from softact.sweep.design import TOLERANCES
from softact.sweep.points import DesignPoint
from softact.sweep.sensitivity import Sample
from softact.sweep.study import Runner, Study
from softact.sweep.table import Row
from softact.sweep.trends import TrendFound, verdicts

PLAN, INDICES, PAGE = ".plan.json", "sensitivity.csv", "sweep.html"
COMPARED = "tolerances.csv"
FILES = (PLAN, *table.FILES, INDICES, COMPARED, confirm.CONFIRMED, PAGE)


def carry_out(
    study: Study,
    runner: Runner,
    sample: Sample | None,
    output: Output,
    tell: Callable[[DesignPoint, Answer], None],
) -> tuple[list[Row], list[TrendFound], list[str]]:
    """Compute what is missing and write the files, also where that is stopped; returns what
    ``write`` does. tell: called for each point as its run ends."""
    study.plan.remember(output.file(PLAN))
    if study.sweep.design.kind == TOLERANCES:
        study.nominal = tolerance_check.nominal(study)
    try:
        if study.missing():
            study.compute(runner, tell)
        if study.sweep.confirm:
            study.confirm(runner, tell)
    finally:
        written = write(study, sample, output)
    return written


def write(
    study: Study, sample: Sample | None, output: Output
) -> tuple[list[Row], list[TrendFound], list[str]]:
    """Write table, curves, indices and page; returns the rows, what became of the trends, and lines
    on what was left out of the indices and where tolerances are not to first order. sample: of the
    indices, None for none."""
    rows = table.write(study, output)
    seen, sections, notes = verdicts(study, rows), [], []
    if sample is not None:
        indices = sensitivity.indices(sample, study, rows)
        write_atomic(output.file(INDICES), csv_text(indices.rows))
        sections, notes = sensitivity.section(indices), indices.notes
    if study.nominal is not None:
        compared = tolerance_check.compare(study, rows, *study.nominal)
        write_atomic(output.file(COMPARED), csv_text(tolerance_check.rows(compared)))
        sections, notes = [*sections, *tolerance_check.section(compared)], [*notes, *compared.notes]
    if study.confirmed:
        parts = study.compared
        found = confirm.rows(study.confirmed, parts, study.sweep.axes)
        write_atomic(output.file(confirm.CONFIRMED), csv_text(found))
        sections = [*confirm.section(study.confirmed, parts, study.sweep.objectives), *sections]
    csv = (output.directory / table.TABLE).read_bytes()
    write_atomic(output.file(PAGE), sweep_page.html(study, rows, csv, seen, sections))
    return rows, seen, notes

"""The files of a sweep's folder."""

from __future__ import annotations

from softact.files.text import csv_text, write_atomic
from softact.results.own_folder import Output
from softact.sweep import sensitivity, sweep_page, table
from softact.sweep.sensitivity import Sample
from softact.sweep.study import Study
from softact.sweep.table import Row
from softact.sweep.trends import Verdict, verdicts

PLAN, INDICES, PAGE = ".plan.json", "sensitivity.csv", "sweep.html"
FILES = (PLAN, *table.FILES, INDICES, PAGE)


def write(
    study: Study, sample: Sample | None, output: Output
) -> tuple[list[Row], list[Verdict], list[str]]:
    """Write table, curves, indices and page; returns the rows, what became of the trends, and lines
    on what was left out of the indices. sample: of the indices, None for none."""
    rows = table.write(study, output)
    seen, sections, notes = verdicts(study, rows), [], []
    if sample is not None:
        found = sensitivity.indices(sample, study, rows)
        write_atomic(output.file(INDICES), csv_text(found.rows))
        sections, notes = sensitivity.section(found), found.notes
    csv = (output.directory / table.TABLE).read_bytes()
    write_atomic(output.file(PAGE), sweep_page.html(study, rows, csv, seen, sections))
    return rows, seen, notes

"""Force and torque over angle and pressure: a part of a sweep's page, see
``softact.report.force_angle``."""

from __future__ import annotations

from collections.abc import Sequence

from softact.report import base, force_angle
from softact.report.base import Section
from softact.sweep.record import Record


def sections(records: Sequence[Record]) -> list[Section]:
    """The part of a sweep's page; none where the runs do not hold at several angles."""
    by_force: dict[str, list[force_angle.Held]] = {}
    for record in records:
        columns = {name: record.curve(name) for name in record.columns}
        for title, exerted in force_angle.forces(columns).items():
            if (run := force_angle.held(columns, exerted)) is not None:
                by_force.setdefault(title, []).append(run)
    plots = [plot for title, runs in by_force.items() for plot in force_angle.plots(runs, title)]
    if not plots:
        return []
    said = base.note(
        "From all states of all runs. Along a line of one pressure, the force falls to zero at the "
        "angle to which the free actuator bends, where a run passes it. Between the angles of the "
        "runs the map is linear."
    )
    body = base.figures(plots) + said
    return [Section("forceangle", "Force over angle and pressure", body, "Force and angle")]

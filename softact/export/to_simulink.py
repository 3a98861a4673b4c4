"""Lookup tables for Simulink: one over the pressure, one over pressure and a force on the tip.

A script for MATLAB reads them into breakpoints and tables. It was written without MATLAB at hand
and never run.
"""

from __future__ import annotations

import numpy as np

from softact.errors import SpecError
from softact.export.job import Job
from softact.export.to_json import document
from softact.files.text import csv_text

PRESSURES, FORCES = 21, 9
MEASURED = ("bending_angle_deg", "twist_angle_deg", "tip_x_mm", "tip_y_mm", "tip_z_mm",
            "cavity_volume_mm3")  # fmt: skip


def files(job: Job) -> dict[str, str | bytes]:
    """The tables, the script and what they were fitted to. Raises SpecError where some pair of
    pressure and force buckles the model."""
    try:
        under_load = over_load(job)
    except ArithmeticError:
        raise SpecError(
            "--to simulink-csv: under some pressures and forces between those of the runs the "
            "reduced model finds no equilibrium, and the table would have holes; export runs with "
            "smaller payloads"
        ) from None
    columns = ", ".join(f"'{c}'" for c in MEASURED)
    return {
        f"{job.name}_pressure.csv": csv_text(over_pressure(job)),
        f"{job.name}_load.csv": csv_text(under_load),
        f"{job.name}_simulink.m": SCRIPT.format(name=job.name, columns=columns),
        f"{job.name}_simulink.txt": "\n".join(job.about) + "\n",
    }


def over_pressure(job: Job) -> list[dict]:
    """A row for each pressure: angles and stretch without a load, stiffnesses, what holds it."""
    table = document(job)["table"]
    wanted = [n for n in table if not n.startswith(("rest_", "stiffness_"))] + ["rest_volume_mm3"]
    return [
        {name: table[name][row] for name in wanted} for row in range(len(table["pressure_kPa"]))
    ]


def over_load(job: Job) -> list[dict]:
    """A row for each pair of pressure and force on the tip along the model's z, with the weight of
    the runs; as far as the runs went."""
    model, found = job.model, job.model.states
    across = found.force[:, 2]
    low, high = float(min(across.min(), 0.0)), float(max(across.max(), 0.0))
    pressures = np.linspace(found.pressure.min(), found.pressure.max(), PRESSURES)
    forces = np.linspace(low, high, FORCES) if high > low else np.zeros(1)
    grid = np.array([(p, f) for f in forces for p in pressures])
    force = np.column_stack([np.zeros((len(grid), 2)), grid[:, 1]])
    gravity = found.gravity[np.argmax(np.linalg.norm(found.gravity, axis=1))]
    state = model.rod.state(grid[:, 0], force, None, np.tile(gravity, (len(grid), 1)))
    return [
        {"pressure_kPa": p, "tip_force_z_N": f, **{name: state[name][row] for name in MEASURED}}
        for row, (p, f) in enumerate(grid)
    ]


SCRIPT = """\
% Tables of {name} for n-D Lookup Table blocks. Written by softact without MATLAB, never run.
% {name}_simulink.txt says what they were fitted to and how far they are off.
single = readtable('{name}_pressure.csv');
double_ = readtable('{name}_load.csv');
pressure = unique(double_.pressure_kPa);      % breakpoints 1, kPa
force = unique(double_.tip_force_z_N);        % breakpoints 2, N
tables = struct();
for column = {{{columns}}}
    tables.(column{{1}}) = reshape(double_.(column{{1}}), numel(pressure), numel(force));
end
"""

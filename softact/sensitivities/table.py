"""``sensitivities.csv``: a line for each state, measure and parameter."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from softact.results.folder import is_pressure
from softact.sensitivities.parameters import Parameter

if TYPE_CHECKING:
    from softact.sensitivities.following import Slopes

#: Columns of a run's row that say which state it is, and those of its pressures.
STATE = ("step", "increment", "step_fraction")
COLUMNS = ("measure", "value", "parameter", "at", "derivative", "unit", "elasticity")
#: Endings of the columns of measures, and the unit.
UNITS = {
    "mm": "mm", "mm3": "mm^3", "mm2": "mm^2", "deg": "deg", "kPa": "kPa", "MPa": "MPa", "N": "N",
    "Nmm": "N*mm", "mJ": "mJ", "g": "g", "N_per_kg": "N/kg", "J_per_kg": "J/kg", "percent": "%",
}  # fmt: skip


def unit_of(measure: str) -> str:
    """Unit of a column of curve.csv; empty where it has none."""
    return next((unit for end, unit in UNITS.items() if measure.endswith(f"_{end}")), "")


def unit_of_slope(measure: str, parameter: str) -> str:
    """Unit of the derivative of a measure by a parameter of this unit: deg/mm, 1/mm, deg."""
    above = unit_of(measure)
    if not parameter:
        return above
    below = f"({parameter})" if "/" in parameter else parameter
    return f"{above or 1}/{below}"


def pressures(row: Mapping[str, Any]) -> list[str]:
    """Columns of a row that hold the pressures of cavities."""
    return [name for name in row if is_pressure(name)]


class Table:
    """The text of the table, line by line. text: what an interrupted run had written."""

    def __init__(self, parameters: Sequence[Parameter], text: str = ""):
        self._parameters = {parameter.path: parameter for parameter in parameters}
        self._parts = [text] if text else []

    @property
    def text(self) -> str:
        """All lines so far."""
        return "".join(self._parts)

    def add(self, row: Mapping[str, Any], slopes: Slopes) -> None:
        """Add the derivatives at one state, whose row of curve.csv is given."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        loads = pressures(row)
        if not self._parts:
            writer.writerow([*STATE, *loads, *COLUMNS])
        state = [row[name] for name in STATE] + [repr(row[name]) for name in loads]
        for path, of in slopes.of.items():
            parameter = self._parameters[path]
            at = f"{parameter.told:.10g} {parameter.unit}".strip()
            for measure, slope in of.items():
                value = row[measure]
                elasticity = slope * parameter.value / value if value else ""
                writer.writerow([
                    *state, measure, repr(value), path, at, f"{slope * parameter.factor:.9g}",
                    unit_of_slope(measure, parameter.unit),
                    f"{elasticity:.6g}" if value else "",
                ])  # fmt: skip
        self._parts.append(out.getvalue())


def kept(text: str, rows: int) -> str:
    """The lines of a table that belong to the first increments of a run, ``rows`` of them."""
    lines = text.splitlines(keepends=True)
    if not lines:
        return ""
    names = next(csv.reader(lines[:1]))
    if "increment" not in names:
        return ""
    at = names.index("increment")
    return "".join(
        [lines[0]]
        + [
            line
            for line in lines[1:]
            if line.endswith("\n")
            and len(cells := next(csv.reader([line]))) == len(names)
            and cells[at].isdecimal()
            and int(cells[at]) < rows
        ]
    )

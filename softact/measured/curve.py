"""A measured curve of an actuator, and the same curve taken from a run."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import PchipInterpolator

from softact.errors import SpecError
from softact.measured.curve_table import meaning as meaning
from softact.measured.curve_table import read_columns, split_unit
from softact.measures import MEASURES
from softact.measures.base import per_cavity
from softact.units import show

if TYPE_CHECKING:
    from softact.spec import Spec


@dataclass(frozen=True)
class Measured:
    """Columns of a measured table in the units of the run's columns of the same name.

    x: name of the column that the others are drawn over. values: column -> (n,), x included.
    messages: what was left out of the file.
    """

    source: str
    x: str
    values: Mapping[str, np.ndarray]
    messages: tuple[str, ...] = ()

    @property
    def names(self) -> list[str]:
        """The columns to be met."""
        return [name for name in self.values if name != self.x]

    @property
    def count(self) -> int:
        """Number of measured values."""
        return len(self.names) * len(self.values[self.x])


def run_columns(spec: Spec) -> list[str]:
    """Names of the columns that a run of ``spec`` can have."""
    layout = spec.geometry.layout()
    steps = (step.supports or () for step in spec.steps)
    parts = {
        "<support>": dict.fromkeys(
            s.surface for supports in (spec.supports or (), *steps) for s in supports
        ),
        "<region>": layout.regions,
        "<obstacle>": list(spec.obstacles),
        "<contact>": [*spec.obstacles, *(c.name for c in spec.contact or ())],
    }
    names = ["step_fraction"]
    for measure in MEASURES if spec.measures == "all" else spec.measures:
        if measure == "target_line" and spec.target_line is None:
            continue
        for title in MEASURES[measure].columns:
            kind = next((kind for kind in parts if kind in title), None)
            if "<cavity>" in title:
                names += per_cavity(title, dict.fromkeys(layout.cavities, 0.0))
            elif kind == "<region>" and len(layout.regions) == 1:
                names.append(title.replace("_<region>", ""))
            else:
                names += [title.replace(kind, part) for part in parts[kind]] if kind else [title]
    return names


def read_measured(
    path: Path,
    columns: Sequence[str],
    x: str | None = None,
    headings: Sequence[str] | None = None,
    command: str = "softact run SPEC --measured FILE",
) -> Measured:
    """Read a table whose headings name columns of a run, with units of the user's choice.

    columns: what a run has. x: heading of the abscissa; default: the first. headings: in place of
    the file's own, for a file that has none or others. A heading '-' skips its column. command:
    what the user called, for saying how a file is read that cannot be read as it is. Raises
    SpecError with one line per fault.
    """
    found = read_columns(path, columns, headings, command)
    values, names = found.values, list(found.values)
    abscissa = names[0] if x is None else meaning_of_option(x, names)
    measured = Measured(str(path), abscissa, values, found.messages)
    for name in measured.names:
        if not np.any(values[name]):
            raise SpecError(f"{path}: {name} is zero throughout; there is nothing to meet")
    if np.ptp(values[abscissa]) == 0.0:
        raise SpecError(f"{path}: {abscissa} is the same in all rows; a curve is wanted")
    return measured


def meaning_of_option(text: str, names: Sequence[str]) -> str:
    """The measured column that ``--x`` names."""
    stems = {split_unit(name)[0]: name for name in names}
    key = re.sub(r"[\s_]+", "_", text.strip())
    if key in names:
        return key
    if key in stems:
        return stems[key]
    raise SpecError(f"--x: {show(text)} is none of the measured columns: {', '.join(names)}")


def predicted(curve: Mapping[str, np.ndarray], measured: Measured) -> dict[str, np.ndarray] | None:
    """Return the run's columns at the measured abscissae; None where the run did not get there.

    The step in which the abscissa moves most counts; between its increments the curve is a
    monotone cubic (Fritsch and Carlson 1980). Raises SpecError where the abscissa turns back
    within the step, or a column is not there.
    """
    for name in measured.values:
        if name not in curve:
            raise SpecError(f"{measured.source}: this actuator's run has no column '{name}'")
    rows = rising(curve, measured.x)
    x = curve[measured.x][rows]
    direction = math.copysign(1.0, x[-1] - x[0])
    if np.any(direction * np.diff(x) <= 0):
        raise SpecError(
            f"{measured.source}: {measured.x} turns back within a step of the run, so it is no "
            "abscissa; name another with --x"
        )
    wanted = direction * measured.values[measured.x]
    low, high = direction * x[0], direction * x[-1]
    slack = 1e-6 * (high - low)
    if wanted.max() > high + slack:
        return None
    if wanted.min() < low - slack:
        raise SpecError(
            f"{measured.source}: {measured.x} begins at {measured.values[measured.x].min():g}, "
            f"the run's step at {x[0]:g}; leave those rows out"
        )
    inside = np.clip(wanted, low, high)
    return {
        name: PchipInterpolator(direction * x, curve[name][rows])(inside) for name in measured.names
    }


def reached(curve: Mapping[str, np.ndarray], measured: Measured) -> str:
    """What to say of a run that ends before the data do."""
    x = curve[measured.x]
    wanted = measured.values[measured.x]
    return (
        f"{measured.source}: {measured.x} goes from {wanted.min():g} to {wanted.max():g}, the run "
        f"only from {x.min():g} to {x.max():g}; change the spec's last step or leave rows out"
    )


def rising(curve: Mapping[str, np.ndarray], x: str) -> np.ndarray:
    """Return the rows of the step in which x changes most, with the row that it starts from."""
    best, largest = np.arange(len(curve[x])), -1.0
    for step in dict.fromkeys(curve["step"]):
        rows: np.ndarray = np.flatnonzero(curve["step"] == step)
        if rows[0] > 0:
            rows = np.concatenate([[rows[0] - 1], rows])
        change = float(np.ptp(curve[x][rows]))
        if change > largest:
            best, largest = rows, change
    return best

"""What an actuator exerts at an angle: force and torque over the bending angle, at pressures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from softact.report import base, labels
from softact.report.base import Plot
from softact.report.base.plots import numbers
from softact.results.folder import Results, is_pressure, load_name

ANGLE, CELL, TIP, TORQUE = "bending_angle_deg", "blocked_force_N", "tip_force", "blocked_torque_Nmm"
_MOST_LEVELS = 6
_APART_DEG = 1.0  # angles of two runs, or of the states of one, that are not the same
_NOTHING = 1e-3  # of the largest force: no contact yet
_GRID = 41

Columns = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Held:
    """The states of one run in which something is pressed on or held, from the last free one on:
    pressure (kPa), angle (deg) and the size of the force (N) or the torque (N·mm), (n,) each and in
    the order of the pressure.
    free: (m, 2) pressure and angle of those in which nothing is, in their order."""

    pressure: np.ndarray
    angle: np.ndarray
    exerted: np.ndarray
    free: np.ndarray

    def at(self, pressure: float) -> tuple[float, float] | None:
        """Angle and force at a pressure; None where the run has no such state."""
        if not len(self.pressure) or not self.pressure[0] <= pressure <= self.pressure[-1]:
            return None
        angle = np.interp(pressure, self.pressure, self.angle)
        return float(angle), float(np.interp(pressure, self.pressure, self.exerted))


def forces(columns: Columns) -> dict[str, np.ndarray]:
    """Label -> (n,) what a run exerts in its states, NaN where nothing is held: the force on a load
    cell or, where the tip is held, the size of its force, and its torque about the bending axis."""
    found = {}
    if CELL in columns and np.nanmax(columns[CELL], initial=0.0) > 0:
        cell = columns[CELL]
        found["Force on the load cell (N)"] = np.where(cell > _NOTHING * cell.max(), cell, np.nan)
    tip = [columns[name] for name in (f"{TIP}_{c}_N" for c in "xyz") if name in columns]
    if len(tip) == 3 and np.isfinite(tip[0]).any():
        found["Force of the held tip (N)"] = np.linalg.norm(tip, axis=0)
    if TORQUE in columns and np.isfinite(columns[TORQUE]).any():
        found["Torque of the held tip (N·mm)"] = columns[TORQUE]
    return found


def held(columns: Columns, exerted: np.ndarray) -> Held | None:
    """The states of a run that bear on a force; None without pressure or angle."""
    name = _pressure(columns)
    if name is None or ANGLE not in columns:
        return None
    pressure, angle = columns[name], columns[ANGLE]
    there = np.isfinite(exerted) & np.isfinite(angle)
    order = np.flatnonzero(there)[np.argsort(pressure[there], kind="stable")]
    rest = np.flatnonzero(~there & np.isfinite(angle))
    # Free states count up to where the hold begins: later the tip may have been let go elsewhere.
    rest = rest[rest < order.min()] if len(order) else rest
    rest = rest[np.argsort(pressure[rest], kind="stable")]
    free = np.column_stack([pressure[rest], angle[rest]])
    begins = len(order) > 0 and len(free) > 0 and free[-1, 0] < pressure[order[0]]
    if begins:  # from nothing
        return Held(
            np.append(free[-1, 0], pressure[order]), np.append(free[-1, 1], angle[order]),
            np.append(0.0, exerted[order]), free,
        )  # fmt: skip
    return Held(pressure[order], angle[order], exerted[order], free)


def _pressure(columns: Columns) -> str | None:
    """The column of the pressure that changes most."""
    names = [n for n in columns if is_pressure(n)]
    return max(names, key=lambda n: np.ptp(columns[n]), default=None)


def levels(runs: Sequence[Held]) -> list[float]:
    """Pressures at which curves are drawn: those at which runs end, or even parts where these are
    many."""
    ends = sorted({float(f"{run.pressure[-1]:.6g}") for run in runs if len(run.pressure)})
    if len(ends) > _MOST_LEVELS or len(ends) == 1:
        low = min(float(run.pressure[0]) for run in runs if len(run.pressure))
        even = np.linspace(low, ends[-1], _MOST_LEVELS)[1:]
        ends = [float(f"{level:.3g}") for level in even]
    return ends


def characteristic(runs: Sequence[Held], pressure: float) -> np.ndarray:
    """(n, 2) angle and force at a pressure, by angle: of each run that holds, and zero at the angle
    at which it would be free, where a run passes it so."""
    found = [point for run in runs if (point := run.at(pressure))]
    for run in runs:
        if len(run.free) > 1 and run.free[0, 0] <= pressure <= run.free[-1, 0]:
            found.append((float(np.interp(pressure, run.free[:, 0], run.free[:, 1])), 0.0))
    points = np.array(sorted(found)).reshape(-1, 2)
    if not len(points):
        return points
    # Runs that hold at the same angle say the same.
    size = max(np.ptp(points[:, 0]), _APART_DEG)
    new = np.concatenate([[True], np.diff(points[:, 0]) > 0.01 * size])
    return points[new]


def plots(runs: Sequence[Held], y: str) -> list[Plot]:
    """Curves over the angle at constant pressures, and the map of both; none where all runs hold at
    one angle. y: title of the force."""
    runs = [run for run in runs if len(run.pressure)]
    if not runs:
        return []
    at = {level: characteristic(runs, level) for level in levels(runs)}
    at = {level: points for level, points in at.items() if len(points) > 1}
    if not at or max(np.ptp(points[:, 0]) for points in at.values()) < _APART_DEG:
        return []
    name, _, unit = y.rpartition(" (")
    x = str(labels.column(ANGLE))
    traces = [base.xy(f"{labels.number(level)} kPa", *points.T) for level, points in at.items()]
    curves = base.lines(f"{name} over the angle, at pressures", x, y, traces)
    return [curves, *_map(runs, name, unit.rstrip(")"))]


def _map(runs: Sequence[Held], name: str, unit: str) -> list[Plot]:
    """Force as a colour over angle and pressure, linear between the runs."""
    pressures = np.linspace(min(float(r.pressure[0]) for r in runs),
                            max(float(r.pressure[-1]) for r in runs), _GRID)  # fmt: skip
    lines = [characteristic(runs, pressure) for pressure in pressures]
    ends = np.vstack([points for points in lines if len(points)])
    angles = np.linspace(ends[:, 0].min(), ends[:, 0].max(), _GRID)
    z = [np.interp(angles, points[:, 0], points[:, 1], left=np.nan, right=np.nan) if len(points) > 1
         else np.full(_GRID, np.nan) for points in lines]  # fmt: skip
    if np.isfinite(z).sum() < _GRID:
        return []
    trace = {
        "type": "contour", "x": numbers(angles), "y": numbers(pressures),
        "z": [numbers(row) for row in z], "colorscale": "Viridis", "connectgaps": False,
        "contours": {"coloring": "heatmap", "showlabels": True, "labelfont": {"color": "#ffffff"}},
        "colorbar": {"title": {"text": unit}, "thickness": 10, "outlinewidth": 0},
        "hovertemplate": "%{x:.4~g}°, %{y:.4~g} kPa: %{z:.4~g} " + unit + "<extra></extra>",
    }  # fmt: skip
    grid = np.array(np.meshgrid(angles, pressures)).reshape(2, -1)
    x, y, head = str(labels.column(ANGLE)), "Pressure (kPa)", f"{name} ({unit})"
    table = {x: numbers(grid[0]), y: numbers(grid[1]), head: numbers(z)}
    return [Plot(f"{name} over angle and pressure", [trace], x, y, table=table)]


def of_run(results: Results) -> list[Plot]:
    """Of a run whose angle changes while it presses: its force over the angle, coloured by the
    pressure."""
    columns = {n: v for n, v in results.curve.items() if v.dtype == float}
    found = []
    for y, exerted in forces(columns).items():
        run = held(columns, exerted)
        if load_name(results) is None or run is None or len(run.angle) < 2:
            continue
        if np.ptp(run.angle) < _APART_DEG:
            continue
        marker = {
            "size": 7, "color": numbers(run.pressure), "colorscale": "Viridis", "showscale": True,
            "colorbar": {"title": {"text": "kPa"}, "thickness": 10, "outlinewidth": 0},
        }  # fmt: skip
        texts = [f"{labels.number(p)} kPa" for p in run.pressure]
        trace = base.xy("states", run.angle, run.exerted, marker=marker, text=texts,
                        hovertemplate="%{text}: %{x:.4~g}°, %{y:.4~g}<extra></extra>")  # fmt: skip
        name = y.rpartition(" (")[0]
        x = str(labels.column(ANGLE))
        table = {x: trace["x"], y: trace["y"], "Pressure (kPa)": numbers(run.pressure)}
        found.append(base.lines(f"{name} over the angle", x, y, [trace], table=table))
    return found

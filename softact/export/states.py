"""What a reduced model is fitted to: the states of one or more runs, their loads, their masses.

From curve.csv: pressures, bending angle (and its axis where the layout has none), twist, the tip's
place, the volume of the cavities, the force and moment of a held tip, the reaction of the clamp.
From fields.h5: the undeformed mesh only, for masses and for where the cavities begin and end. From
spec.yaml: densities, weight and the force on the tip, which ramp as the steps say.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from softact.errors import SpecError
from softact.export.masses import point_masses
from softact.mesh.layout import Layout
from softact.results.folder import Results, load_name
from softact.spec import Spec, loads

#: A reaction that differs by more than this part (and N) from weight and tip's load tells of
#: another load: an obstacle, a pressure on an outer face.
FOREIGN, LEAST_FORCE = 0.02, 1e-4
OTHER_LOAD = "under another load than weight and a force on the tip"
UNLOADING = "past the largest pressure so far"
#: Where the tip turns out of the plane of bending by more, the model twists (degrees).
TWISTED = 0.5


@dataclass(frozen=True)
class States:
    """Accepted states of all runs in the model's directions, see ``rod.Rod``.

    run: (s,) number of the run. pressure: (s,) kPa in the driven cavity. turned: (s, 3) radians:
    twist, bending about y and z. tip: (s, 3) mm from the clamp's centre. volume: (s,) mm³. force,
    moment: (s, 3) on the tip, N and N·mm. gravity: (s, 3) mm/s². held: (s,) whether force and
    moment are those of a support of the tip: as dead loads they might not leave it where it is.
    left_out: reason -> number.
    """

    run: np.ndarray
    pressure: np.ndarray
    turned: np.ndarray
    tip: np.ndarray
    volume: np.ndarray
    force: np.ndarray
    moment: np.ndarray
    gravity: np.ndarray
    held: np.ndarray
    left_out: Counter

    def __len__(self) -> int:
        return len(self.run)

    def part(self, chosen: np.ndarray) -> States:
        """The states of a mask."""
        return States(*(getattr(self, name)[chosen] for name in COLUMNS), Counter())


COLUMNS = tuple(entry.name for entry in fields(States) if entry.name != "left_out")


def frame(layout: Layout) -> np.ndarray:
    """Rows: the model's x (the layout's axis), y and z as seen in the actuator's coordinates.

    y is the layout's bending axis; of half an actuator without one, the normal of its plane.
    """
    axis = np.array(layout.axis, float)
    choices = [layout.bending_axis] if layout.bending_axis else []
    choices += [np.eye(3)[plane] for plane in layout.symmetry.values()]
    choices += [(0.0, 1.0, 0.0), (1.0, 0.0, 0.0)]
    across = next(c for c in np.array(choices, float) if abs(c @ axis) < 0.9)
    across = across - axis * (axis @ across)
    across /= np.linalg.norm(across)
    return np.stack([axis, across, np.cross(axis, across)])


def driven_walls(run: Results) -> list[str]:
    """Walls of the cavities whose pressure changes."""
    found = []
    for name, walls in run.layout.cavities.items():
        values = run.curve.get(f"pressure_{name}_kPa", run.curve.get("pressure_kPa"))
        if values is not None and np.ptp(values) > 0:
            found += walls
    return found


def spec_of(results: Results) -> Spec:
    """The resolved spec of a run. Raises SpecError with the folder's name."""
    try:
        return loads(results.spec_yaml, str(results.directory / "spec.yaml"))
    except SpecError as error:
        raise SpecError(*error.lines) from None


def check(runs: Sequence[Results]) -> None:
    """Raise SpecError unless the runs are of one actuator that has a clamp and a tip."""
    for run in runs:
        if run.layout is None or not run.increments:
            raise SpecError(f"{run.directory}: has no states; only a run that got on is exported")
        if not (run.layout.clamp and run.layout.tip):
            raise SpecError(
                f"{run.directory}: {run.spec['geometry'].get('type')} has no clamp or no tip, so "
                "it has no angle and no reduced model"
            )
        missing = [n for n in ("bending_angle_deg", "tip_x_mm", "twist_angle_deg")
                   if n not in run.curve]  # fmt: skip
        if missing:
            raise SpecError(
                f"{run.directory / 'curve.csv'}: lacks {', '.join(missing)}; solve the spec with "
                "measures: all"
            )
        if load_name(run) is None:
            raise SpecError(f"{run.directory}: no pressure changes in it; a reduced model needs it")
    first = runs[0]
    for run in runs[1:]:
        for part in ("geometry", "materials", "layers", "sheets"):
            if run.spec.get(part) != first.spec.get(part):
                raise SpecError(
                    f"{run.directory}: its {part} differs from that of {first.directory}; one "
                    "reduced model is of one actuator under several loads"
                )
        if load_name(run) != load_name(first):
            raise SpecError(
                f"{run.directory}: drives {load_name(run)}, {first.directory} drives "
                f"{load_name(first)}; export them one by one"
            )


def gather(runs: Sequence[Results], base: np.ndarray) -> States:
    """The states of runs that ``check`` has passed. base: (3,) the clamp's centre, mm.

    Left out, and counted: states past the largest pressure so far (unloading, the way beyond a
    pressure limit), states under loads that the model does not know, and those between equilibria.
    Raises SpecError where no state is left.
    """
    parts, left_out = [], Counter()
    for number, run in enumerate(runs):
        parts.append(_states(run, number, base, left_out))
    joined = [np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS]
    if not len(joined[0]):
        why = "; ".join(f"{count} {reason}" for reason, count in left_out.items())
        raise SpecError(f"{runs[0].directory}: no state can be used: {why}")
    return States(*joined, left_out)


def _states(run: Results, number: int, base: np.ndarray, left_out: Counter) -> States:
    curve, spec, axes = run.curve, spec_of(run), frame(run.layout)
    pressure = curve[load_name(run)]
    ramps = _Ramps(spec, curve)
    tip = ramps.force_on(run.layout.tip)
    support, moment = _support(curve, "tip_force", "N"), _support(curve, "tip_moment", "Nmm")
    force, held = tip + support, np.any(np.hstack([support, moment]) != 0.0, axis=1)
    turned = np.column_stack([np.radians(curve["twist_angle_deg"]), _bending(run, axes)])
    place = np.column_stack([curve[f"tip_{c}_mm"] for c in "xyz"]) - base
    kept = _kept(run, pressure, force, ramps.gravity, spec, left_out)
    count = int(kept.sum())
    return States(
        np.full(count, number), pressure[kept], turned[kept], (place @ axes.T)[kept],
        _volume(run, pressure)[kept], (force @ axes.T)[kept], (moment @ axes.T)[kept],
        (ramps.gravity @ axes.T)[kept], held[kept], Counter(),
    )  # fmt: skip


def _support(curve, stem: str, unit: str) -> np.ndarray:
    """(rows, 3) what a support of the tip exerts on it; zero where the tip is free."""
    columns = [curve.get(f"{stem}_{c}_{unit}") for c in "xyz"]
    rows = len(next(iter(curve.values())))
    if columns[0] is None:
        return np.zeros((rows, 3))
    return -np.nan_to_num(np.column_stack(columns))


def _bending(run: Results, axes: np.ndarray) -> np.ndarray:
    """(rows, 2) radians of bending about the model's y and z."""
    angle = np.radians(run.curve["bending_angle_deg"])
    names = [f"bending_axis_{c}" for c in "xyz"]
    if names[0] not in run.curve:
        return np.column_stack([angle, np.zeros_like(angle)])
    about = np.column_stack([run.curve[name] for name in names]) @ axes.T
    return angle[:, None] * about[:, 1:]


def _volume(run: Results, pressure: np.ndarray) -> np.ndarray:
    """(rows,) mm³ whose product with the driving pressure is the work of all cavities.

    Where several cavities are driven, in a fixed ratio. Raises SpecError where the ratio changes.
    """
    stem = "cavity_volume"
    if f"{stem}_mm3" in run.curve:
        return run.curve[f"{stem}_mm3"]
    total = np.zeros(len(pressure))
    for name in run.layout.cavities:
        own, volume = run.curve.get(f"pressure_{name}_kPa"), run.curve.get(f"{stem}_{name}_mm3")
        if own is None or volume is None:
            continue
        ratio = float(own @ pressure / (pressure @ pressure))
        if np.abs(own - ratio * pressure).max() > 1e-3 * np.abs(pressure).max():
            raise SpecError(
                f"{run.directory}: the pressure in {name} is no fixed part of {load_name(run)}; "
                "a reduced model follows one pressure: export a run in which it is"
            )
        total += ratio * volume
    return total


def _kept(run, pressure, force, gravity, spec, left_out) -> np.ndarray:
    sign = 1.0 if pressure[np.argmax(np.abs(pressure))] >= 0 else -1.0
    rising = sign * pressure >= np.maximum.accumulate(sign * pressure) - 1e-9
    left_out[UNLOADING] += int((~rising).sum())
    kept = rising & np.isfinite(run.curve["bending_angle_deg"])
    reactions = [run.curve.get(f"reaction_{c}_N") for c in "xyz"]
    if reactions[0] is not None:
        weight = point_masses(run, spec)[1].sum() * gravity
        foreign = np.column_stack(reactions) + weight + force
        allowed = FOREIGN * np.linalg.norm(np.abs(weight) + np.abs(force), axis=1) + LEAST_FORCE
        other = np.linalg.norm(foreign, axis=1) > allowed
        left_out["under another load than weight and a force on the tip"] += int(
            (kept & other).sum()
        )
        kept &= ~other
    return kept


class _Ramps:
    """Loads of the rows of a curve, which ramp linearly from step to step."""

    def __init__(self, spec: Spec, curve):
        self._spec, self._steps = spec, [str(step) for step in curve["step"]]
        self._fractions = curve["step_fraction"]

    def _ramp(self, value) -> np.ndarray:
        """(rows, 3) of a load; value: its end value in a step, None where the step leaves it."""
        before, spans = np.zeros(3), {}
        for step in self._spec.steps:
            after = value(step)
            after = before if after is None else np.asarray(after, float)
            spans[step.name], before = (before, after), after
        pairs = [spans[name] for name in self._steps]
        parts = zip(pairs, self._fractions, strict=True)
        return np.array([(1 - part) * start + part * end for (start, end), part in parts])

    @property
    def gravity(self) -> np.ndarray:
        """(rows, 3) mm/s²."""
        return self._ramp(lambda step: step.gravity)

    def force_on(self, tip: str) -> np.ndarray:
        """(rows, 3) N of the payload on a surface."""

        def value(step):
            load = step.payload
            if load is None or (load.surface or tip) != tip:
                return None
            return load.force

        return self._ramp(value)

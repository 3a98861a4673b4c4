"""What a reduced model is fitted to: the states of one or more runs, their loads, their masses.

From curve.csv: pressures, bending angle (and its axis where the layout has none), twist, the tip's
place, the volume of the cavities, the force and moment of a held tip, the reaction of the clamp.
From fields.h5: the undeformed mesh only, for masses and for where the cavities begin and end. From
spec.yaml: densities, weight and the force on the tip, which ramp as the steps say.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
from pydantic import BaseModel

from softact.bodies.carried_mass import carried_at
from softact.errors import SpecError
from softact.export.masses import point_masses
from softact.loads.several import entries
from softact.mesh.layout import Layout
from softact.results.folder import Results, load_name
from softact.spec import Spec, Step, loads
from softact.verdict.reached import moving_rows

#: A reaction that differs by more than this part (and N) from weight and tip's load tells of
#: another load: an obstacle, a pressure on an outer face.
FOREIGN, LEAST_FORCE = 0.02, 1e-4
OTHER_LOAD = "under another load than weight and a force on the tip"
UNLOADING = "past the largest pressure so far"
MOVING = "of a motion from one equilibrium to another"
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
        return States(**{name: getattr(self, name)[chosen] for name in COLUMNS}, left_out=Counter())


#: Columns of curve.csv without which there is no model.
NEEDED = ("step", "step_fraction", "bending_angle_deg", "twist_angle_deg", "tip_x_mm", "tip_y_mm",
          "tip_z_mm", "reaction_x_N", "reaction_y_N", "reaction_z_N")  # fmt: skip
#: Loads of a step that a model knows; a volume that is injected has a pressure too.
KNOWN = ("pressure", "inject", "gravity", "payload")

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
    found: list[str] = []
    for name, walls in run.layout.cavities.items():
        values = run.curve.get(f"pressure_{name}_kPa", run.curve.get("pressure_kPa"))
        if values is not None and np.ptp(values) > 0:
            found += walls
    return found


def spec_of(results: Results) -> Spec:
    """The resolved spec of a run. Raises SpecError with the folder's name."""
    return loads(results.spec_yaml, str(results.directory / "spec.yaml"))


def check(runs: Sequence[Results]) -> None:
    """Raise SpecError unless the runs are of one actuator that has a clamp and a tip."""
    for run in runs:
        if not run.has_mesh or not run.increments:
            raise SpecError(f"{run.directory}: has no states; only a run that got on is exported")
        if not run.spec_yaml:
            raise SpecError(f"{run.directory}: has no spec.yaml, which tells weights and loads")
        if not run.layout.regions:
            raise SpecError(
                f"{run.directory}: {run.spec['geometry']['type']} is made of sheets alone, whose "
                "stiffness comes from the pressure; there is no reduced model of it"
            )
        if not (run.layout.clamp and run.layout.tip):
            raise SpecError(
                f"{run.directory}: {run.spec['geometry']['type']} has no clamp or no tip, so "
                "it has no angle and no reduced model"
            )
        if load_name(run) is None:
            raise SpecError(f"{run.directory}: no pressure changes in it; a reduced model needs it")
        missing = [name for name in NEEDED if name not in run.curve]
        missing += [] if _volumes(run) else ["cavity_volume_mm3"]
        if missing:
            raise SpecError(
                f"{run.directory / 'curve.csv'}: lacks {', '.join(missing)}; solve the spec with "
                "measures: all"
            )
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


def _volumes(run: Results) -> list[str]:
    """Columns of the volumes of the cavities that are driven."""
    names = ("cavity_volume_mm3", *(f"cavity_volume_{c}_mm3" for c in run.layout.cavities))
    return [name for name in names if name in run.curve]


def gather(runs: Sequence[Results], base: np.ndarray) -> States:
    """The states of runs that ``check`` has passed. base: (3,) the clamp's centre, mm.

    Left out, and counted: states past the largest pressure so far (unloading, the way beyond a
    pressure limit), states under loads that the model does not know, and those between equilibria.
    Raises SpecError where no state is left.
    """
    parts: list[States] = []
    left_out: Counter = Counter()
    for number, run in enumerate(runs):
        parts.append(_states(run, number, base, left_out))
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS}
    if not len(joined["run"]):
        why = "; ".join(f"{count} {reason}" for reason, count in left_out.items())
        raise SpecError(f"{runs[0].directory}: no state can be used: {why}")
    return States(**joined, left_out=left_out)


def _states(run: Results, number: int, base: np.ndarray, left_out: Counter) -> States:
    curve, spec, axes = run.curve, spec_of(run), frame(run.layout)
    pressure = curve[str(load_name(run))]
    ramps = _Ramps(spec, curve)
    tip = ramps.force_on(run.layout.tip)
    support, moment = _support(curve, "tip_force", "N"), _support(curve, "tip_moment", "Nmm")
    force, held = tip + support, np.any(np.hstack([support, moment]) != 0.0, axis=1)
    turned = np.column_stack([np.radians(curve["twist_angle_deg"]), _bending(run, axes)])
    place = np.column_stack([curve[f"tip_{c}_mm"] for c in "xyz"]) - base
    kept = _kept(run, pressure, force, ramps, left_out)
    count = int(kept.sum())
    return States(
        np.full(count, number), pressure[kept], turned[kept], (place @ axes.T)[kept],
        _volume(run, pressure)[kept], (force @ axes.T)[kept], (moment @ axes.T)[kept],
        (ramps.gravity @ axes.T)[kept], held[kept], Counter(),
    )  # fmt: skip


def _support(curve: Mapping[str, np.ndarray], stem: str, unit: str) -> np.ndarray:
    """(rows, 3) what a support of the tip exerts on it; zero where the tip is free."""
    names = [f"{stem}_{c}_{unit}" for c in "xyz"]
    if names[0] not in curve:
        return np.zeros((len(curve["step"]), 3))
    return -np.nan_to_num(np.column_stack([curve[name] for name in names]))


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


def _kept(
    run: Results, pressure: np.ndarray, force: np.ndarray, ramps: _Ramps, left_out: Counter
) -> np.ndarray:
    """(rows,) the states that the model is fitted to; the others are counted in ``left_out``."""
    sign = 1.0 if pressure[np.argmax(np.abs(pressure))] >= 0 else -1.0
    rising = sign * pressure >= np.maximum.accumulate(sign * pressure) - 1e-9
    left_out[UNLOADING] += int((~rising).sum())
    still = ~moving_rows(run) & np.isfinite(run.curve["bending_angle_deg"])
    left_out[MOVING] += int((rising & ~still).sum())
    kept = rising & still
    weight = point_masses(run, ramps.spec)[1].sum() * ramps.gravity
    reactions = np.column_stack([run.curve[f"reaction_{c}_N"] for c in "xyz"])
    allowed = FOREIGN * np.linalg.norm(np.abs(weight) + np.abs(force), axis=1) + LEAST_FORCE
    other = np.linalg.norm(reactions + weight + force, axis=1) > allowed
    other |= ramps.others
    left_out[OTHER_LOAD] += int((kept & other).sum())
    return kept & ~other


class _Ramps:
    """Loads of the rows of a curve, which ramp linearly from step to step."""

    def __init__(self, spec: Spec, curve: Mapping[str, np.ndarray]):
        self.spec, self._steps = spec, [str(step) for step in curve["step"]]
        self._fractions = curve["step_fraction"]

    @property
    def others(self) -> np.ndarray:
        """(rows,) whether a load is on that the model does not know: in the step that brings it,
        and from there on. A pure moment, such as a torque, does not show in the reactions."""
        on, begun = {}, False
        for step in self.spec.steps:
            begun |= any(key not in KNOWN and _acts(value) for key, value in step.loads.items())
            on[step.name] = begun
        return np.array([on[name] for name in self._steps])

    def _ramp(self, value: Callable[[Step], Sequence[float] | None]) -> np.ndarray:
        """(rows, 3) of a load; value: its end value in a step, None where the step leaves it."""
        before, spans = np.zeros(3), {}
        for step in self.spec.steps:
            new = value(step)
            after = before if new is None else np.asarray(new, float)
            spans[step.name], before = (before, after), after
        pairs = [spans[name] for name in self._steps]
        parts = zip(pairs, self._fractions, strict=True)
        return np.array([(1 - part) * start + part * end for (start, end), part in parts])

    @property
    def gravity(self) -> np.ndarray:
        """(rows, 3) mm/s²."""
        return self._ramp(lambda step: step.gravity)

    def force_on(self, tip: str) -> np.ndarray:
        """(rows, 3) N of the payload and of carried masses on a surface."""

        def value(step: Step) -> Sequence[float] | None:
            forces = [p.force for p in entries(step.payload) if (p.surface or tip) == tip]
            return np.sum(forces, axis=0) if forces else None

        return self._ramp(value) + carried_at(self.spec.masses, tip, tip) * self.gravity


def _acts(value: object) -> bool:
    """Whether a load of a step is more than zeros."""
    if isinstance(value, BaseModel):
        return _acts(value.model_dump())
    if isinstance(value, Mapping):
        return any(map(_acts, value.values()))
    if isinstance(value, list | tuple):
        return any(map(_acts, value))
    return isinstance(value, float | int) and value != 0

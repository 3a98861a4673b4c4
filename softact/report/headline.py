"""What stands at the head of a data sheet: what the actuator does, and how far it gets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softact.nearest import nearest
from softact.report import curves, labels
from softact.report.curves import noise
from softact.results.folder import COMPLETE, Results, load, load_name, load_text
from softact.verdict.reached import Reached, reached

# Motions are compared by these sizes: degrees, and a part of the actuator's length.
TURN, CHANGE = 30.0, 0.1
# Below these parts of them, and below this part of the most telling one, nothing has moved.
STILL, BESIDE = 0.01, 0.1
# A force below this part of the stored energy over the length is what the solver leaves.
WEAK = 1e-4
# Degrees of bending beyond which the tip's way along the axis is that of bending.
BENT = 20.0

BENDING, TWIST, ELONGATION = "bending_angle_deg", "twist_angle_deg", "elongation_mm"
FORCE, TORQUE, PULL = "blocked_force_N", "blocked_torque_Nmm", "pull_N"
AXIAL_TORQUE = "blocked_axial_torque_Nmm"
BY_MASS = ("mass_g", "specific_force_N_per_kg", "specific_work_J_per_kg")
#: Columns that have another name where they are below zero.
_OPPOSITES = {ELONGATION: ("Elongation", "Contraction"), PULL: ("Pull", "Push")}
_SHORT = {BENDING: "bending", TWIST: "twist"}


@dataclass(frozen=True)
class Figure:
    """A figure of the head. value: in the column's unit. note: where or when; "" otherwise."""

    column: str
    label: labels.Label
    value: float
    note: str = ""

    @property
    def text(self) -> str:
        """Such as "contraction 12.3 mm"."""
        shown = f"{labels.number(self.value * self.label.factor)} {self.label.unit}"
        return f"{self.label.name.lower()} {shown.strip()}".replace(" °", "°")


def told(results: Results) -> list[str]:
    """Columns that say what the actuator does, the most telling first: those that the spec names
    as its ``tiles``, else what holds it back, then what moves, then what it lifts."""
    return chosen(results) or held(results) + moving(results) + _lifted(results)


def chosen(results: Results) -> list[str]:
    """The tiles of the spec that the run has."""
    return [name for name in _wanted(results) if _is_number(results, name)]


def missing(results: Results) -> list[str]:
    """A line for each tile of the spec that the run has not."""
    return [
        f"tiles: the run has no column '{name}'; {nearest(name, curves.measures(results))}"
        for name in _wanted(results)
        if not _is_number(results, name)
    ]


def _wanted(results: Results) -> list[str]:
    wanted = results.spec.get("tiles")
    return [str(name) for name in wanted] if isinstance(wanted, list) else []


def _is_number(results: Results, name: str) -> bool:
    return name in results.curve and results.curve[name].dtype == float


def held(results: Results) -> list[str]:
    """What the actuator exerts: on a load cell, then on what holds its tip, the largest first and
    none that is small beside it; torques count by the force that they are over the length."""
    sizes: dict[str, float] = {}
    if TORQUE in results.curve:
        length = results.layout.length or 1.0
        sizes = {name: _largest(results, name) / length for name in (TORQUE, AXIAL_TORQUE)}
        sizes[PULL] = _largest(results, PULL)
    most = max(sizes.values(), default=0.0)
    floor = max(BESIDE * most, _weak(results))
    found = [n for n in sizes if sizes[n] > floor and _largest(results, n) > noise(results, n)]
    on_cell = [FORCE] if _largest(results, FORCE) > noise(results, FORCE) else []
    return on_cell + sorted(found, key=lambda name: -sizes[name])


def _lifted(results: Results) -> list[str]:
    """The pull of an actuator that grows longer or shorter and is free to."""
    stretches = TORQUE not in results.curve and moving(results)[:1] == [ELONGATION]
    floor = max(noise(results, PULL), _weak(results))
    return [PULL] if stretches and _largest(results, PULL) > floor else []


def _weak(results: Results) -> float:
    """A force that is nothing beside those within the actuator, N."""
    length = results.layout.length
    return WEAK * _largest(results, "strain_energy_mJ") / length if length else 0.0


def moving(results: Results) -> list[str]:
    """Motions, the largest first, and none that hardly move; the bending of an actuator that is
    made to bend comes first."""
    sizes = {name: _largest(results, name) / TURN for name in (BENDING, TWIST)}
    length = results.layout.length
    if length and _largest(results, BENDING) < BENT:
        sizes[ELONGATION] = _largest(results, ELONGATION) / (CHANGE * length)
    most = max(sizes.values())
    moved = [name for name in sizes if sizes[name] > max(STILL, BESIDE * most)]
    bends = results.layout.bending_axis is not None
    return sorted(moved, key=lambda name: (not (bends and name == BENDING), -sizes[name]))


def _largest(results: Results, name: str) -> float:
    values = results.curve.get(name)
    if values is None or values.dtype != float:
        return 0.0
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def by_mass(results: Results, row: int) -> list[Figure]:
    """The mass, and what the actuator does for it in a state."""
    found = [figure(results, name, row) for name in BY_MASS if _is_number(results, name)]
    return [each for each in found if np.isfinite(each.value)]


def figure(results: Results, name: str, row: int, note: str = "") -> Figure:
    """The figure of a column in a state; an elongation below zero is a contraction, a pull a
    push."""
    label, value = labels.column(name), float(results.curve[name][row])
    if name in _OPPOSITES:
        label = labels.Label(_OPPOSITES[name][value < 0], label.unit, label.factor)
        value = abs(value)
    length = results.layout.length
    if name == ELONGATION and length:
        part = f"{100 * value / length:.3g} % of the length"
        note = f"{part}, {note}" if note else part
    return Figure(name, label, value, note)


def short(results: Results, name: str, value: float) -> str:
    """A motion on a picture: "155° bending", "12.3 mm contraction"."""
    label = labels.column(name)
    words = _SHORT.get(name, label.name.lower())
    if name in _OPPOSITES:
        words, value = _OPPOSITES[name][value < 0].lower(), abs(value)
    value *= label.factor
    shown = f"{round(value)}°" if label.unit == "°" else f"{labels.number(value, 3)} {label.unit}"
    return f"{shown} {words}"


def state_text(results: Results, row: int) -> str:
    """What the actuator does in a state, in a few words; "" where nothing moves."""
    there = [name for name in told(results) if np.isfinite(results.curve[name][row])]
    return figure(results, there[0], row).text if there else ""


def figures(results: Results) -> list[Figure]:
    """What the actuator does: in the last state or, where its path has a limit, at the largest load
    of a stable state and where it has moved most."""
    far = reached(results)
    if far.main is None:
        return []
    name = load_name(results)
    moved = [each for each in told(results) if each != name]
    if not _ends_at_limit(results, far):
        found = [figure(results, name, far.main)] if name else []
        return found + [figure(results, each, far.main) for each in moved]
    at = load_text(results, far.main)
    found = []
    if name:
        label = labels.column(name)
        label = labels.Label(f"Largest stable {label.name.lower()}", label.unit, label.factor)
        found.append(Figure(name, label, float(load(results)[far.main])))
    for each in moved:
        found.append(figure(results, each, far.main, f"at {at}, stable"))
        values = np.abs(np.nan_to_num(results.curve[each]))
        most = int(np.argmax(values))
        if values[most] > values[far.main] * (1 + 1e-3):
            further = figure(results, each, most)
            name = f"Largest {further.label.name.lower()} reached"
            label = labels.Label(name, further.label.unit, further.label.factor)
            stable = "" if far.stable[most] else ", not stable"
            found.append(
                Figure(each, label, further.value, f"at {load_text(results, most)}{stable}")
            )
        else:
            found[-1] = figure(results, each, far.main, f"at {at}, the largest reached")
    return found


def _ends_at_limit(results: Results, far: Reached) -> bool:
    """Whether the last state does not stand for the run."""
    return far.limit and (results.status != COMPLETE or far.main != len(far.stable) - 1)


def title(results: Results) -> str:
    """Of which state the figures are."""
    far = reached(results)
    if far.main is None:
        return ""
    what = "largest stable load" if _ends_at_limit(results, far) else "last state"
    return f"At the {what}, {load_text(results, far.main)}"

"""What stands at the head of a data sheet: what the actuator does, and how far it gets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softact.report import labels
from softact.report.curves import noise
from softact.results.folder import COMPLETE, Results, load, load_name, load_text
from softact.verdict.reached import Reached, reached

# Motions are compared by these sizes: degrees, and a part of the actuator's length.
TURN, CHANGE = 30.0, 0.1
# Below these parts of them, and below this part of the most telling one, nothing has moved.
STILL, BESIDE = 0.01, 0.1
# Degrees of bending beyond which the tip's way along the axis is that of bending.
BENT = 20.0

BENDING, TWIST, ELONGATION = "bending_angle_deg", "twist_angle_deg", "elongation_mm"
#: What an actuator exerts that something holds back; told before any motion.
HELD = ("blocked_force_N", "blocked_torque_Nmm")
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


def motions(results: Results) -> list[str]:
    """Columns that say what the actuator does, the most telling first, and none that hardly move.

    What holds it back tells first, then the bending of an actuator that is made to bend.
    """
    sizes = {name: _largest(results, name) / TURN for name in (BENDING, TWIST)}
    length = results.layout.length
    if length and _largest(results, BENDING) < BENT:
        sizes[ELONGATION] = _largest(results, ELONGATION) / (CHANGE * length)
    most = max(sizes.values())
    moved = [name for name in sizes if sizes[name] > max(STILL, BESIDE * most)]
    held = [name for name in HELD if _largest(results, name) > noise(results, name)]
    bends = results.layout.bending_axis is not None
    return held + sorted(moved, key=lambda name: (not (bends and name == BENDING), -sizes[name]))


def _largest(results: Results, name: str) -> float:
    values = results.curve.get(name)
    if values is None or values.dtype != float:
        return 0.0
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def figure(results: Results, name: str, row: int, note: str = "") -> Figure:
    """The figure of a column in a state; an elongation below zero is a contraction."""
    label, value = labels.column(name), float(results.curve[name][row])
    if name == ELONGATION:
        label = labels.Label("Contraction" if value < 0 else "Elongation", label.unit)
        value = abs(value)
        length = results.layout.length
        if length:
            part = f"{100 * value / length:.3g} % of the length"
            note = f"{part}, {note}" if note else part
    return Figure(name, label, value, note)


def short(results: Results, name: str, value: float) -> str:
    """A motion on a picture: "155° bending", "12.3 mm contraction"."""
    label = labels.column(name)
    words = _SHORT.get(name, label.name.lower())
    if name == ELONGATION:
        words, value = ("contraction" if value < 0 else "elongation"), abs(value)
    shown = f"{round(value)}°" if label.unit == "°" else f"{labels.number(value, 3)} {label.unit}"
    return f"{shown} {words}"


def state_text(results: Results, row: int) -> str:
    """What the actuator does in a state, in a few words; "" where nothing moves."""
    there = [name for name in motions(results) if np.isfinite(results.curve[name][row])]
    return figure(results, there[0], row).text if there else ""


def figures(results: Results) -> list[Figure]:
    """What the actuator does: in the last state or, where its path has a limit, at the largest load
    of a stable state and where it has moved most."""
    far = reached(results)
    if far.main is None:
        return []
    name, moved = load_name(results), motions(results)
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

"""From where to look at an actuator so that its bending shows, and which colours span what."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from softact.results.folder import Results, load, rest_state
from softact.verdict.reached import reached

#: A little off the bending plane's normal, so that the depth shows (degrees).
_TURN_DEG, _RISE_DEG = 22.0, 20.0

#: The colour scale of stresses, from low to high: Turbo (Mikhailov 2019) from 7 to 92 % of its
#: length. Without its dark ends, shading cannot be taken for stress.
STRESS_COLOURS = (
    "#4143a7", "#4456c7", "#4669e0", "#477bf2", "#458cfd", "#3ba0fd", "#2fb2f4", "#23c3e4",
    "#1ad2d2", "#18dec0", "#1fe9af", "#2ff19b", "#46f884", "#61fc6c", "#7dff56", "#96fe44",
    "#a9fb39", "#bcf534", "#cdec34", "#dde037", "#ebd339", "#f5c53a", "#fbb637", "#fea431",
    "#fe9029", "#fa7b1f", "#f46617", "#ec530f", "#e2430a", "#d63506", "#c82803", "#b71d02",
)  # fmt: skip


@dataclass(frozen=True)
class View:
    """Directions of a parallel projection, unit vectors: to the right, up, and to the eye."""

    right: np.ndarray
    up: np.ndarray
    eye: np.ndarray

    def project(self, points: np.ndarray) -> np.ndarray:
        """(n, 2) mm in the picture's plane: right and up."""
        return points @ np.column_stack([self.right, self.up])


def bending_view(results: Results) -> View:
    """Look nearly along the normal of the bending plane, the actuator's axis to the right.

    The normal is the layout's bending axis, else that of the plane in which the tip moved, else
    a symmetry plane's. Up is +z, or the axis itself where the actuator stands upright.
    """
    axis = _unit(np.array(results.layout.axis, float))
    normal = _normal(results, axis)
    vertical = np.array([0.0, 0.0, 1.0])
    up = vertical - normal * (vertical @ normal)
    if np.linalg.norm(up) < 0.3:
        up = np.cross(normal, axis)
    up = _unit(up)
    # Of the two sides, the one from which the axis runs to the right.
    eye = normal if np.cross(up, normal) @ axis >= 0 else -normal
    right = np.cross(up, eye)
    turn, rise = math.radians(_TURN_DEG), math.radians(_RISE_DEG)
    level = math.cos(turn) * eye + math.sin(turn) * right
    toward = math.cos(rise) * level + math.sin(rise) * up
    right = _unit(np.cross(up, toward))
    return View(right, np.cross(toward, right), toward)


def _normal(results: Results, axis: np.ndarray) -> np.ndarray:
    layout = results.layout
    if layout.bending_axis is not None:
        return _unit(np.array(layout.bending_axis, float))
    tip = results.surfaces.get(layout.tip)
    if tip is not None and results.increments:
        moved = results.field(-1, "displacement")[np.unique(tip)].mean(axis=0)
        for index in layout.symmetry.values():
            moved[index] = 0.0
        across = np.cross(axis, moved)
        if np.linalg.norm(across) > 1e-3 * np.ptp(results.points, axis=0).max():
            return _unit(across)
    for index in layout.symmetry.values():
        if abs(axis[index]) < 0.5:
            return np.eye(3)[index]
    return _unit(np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))]))


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def states(results: Results, count: int) -> list[int]:
    """Numbers of at most ``count`` states: the one that stands for the run (``reached``), the ends
    of the steps before it, and states at even parts of the load of the step that changes it most.
    """
    main = reached(results).main
    last = len(results.increments) - 1
    last = last if main is None else min(main, last)
    rest = max(rest_state(results), 0)
    if last <= rest:
        return [last]
    steps = results.curve.get("step")
    ends = [n for n in range(rest + 1, last) if steps is not None and steps[n] != steps[n + 1]]
    ends = ends[len(ends) - count + 1 :] if len(ends) >= count else ends
    found = {*ends, last}
    return sorted(found | _between(results, [rest, *ends, last], count - len(found)))


def _between(results: Results, ends: list[int], count: int) -> set[int]:
    """So many states within the step whose load changes most, at even parts of it."""
    loads = load(results)
    begin, end = max(pairwise(ends), key=lambda pair: abs(loads[pair[1]] - loads[pair[0]]))
    inside = np.arange(begin + 1, end)
    if not len(inside):
        return set()
    aims = loads[begin] + (loads[end] - loads[begin]) * np.arange(1, count + 1) / (count + 1)
    return {int(inside[np.argmin(np.abs(loads[inside] - aim))]) for aim in aims}


def colour_range(results: Results, name: str, nodes: np.ndarray) -> tuple[float, float, float]:
    """(low, high, largest) of a field on ``nodes`` over all states.

    high leaves out the half percent of the nodes with the largest values, since a corner's peak
    would hide all the rest, and is rounded up to two digits; low is 0 for stresses and 1 for
    stretches unless the field goes below.
    """
    low = 1.0 if name.endswith("stretch") else 0.0
    high = largest = low
    for number in range(len(results.increments)):
        values = results.scalar(number, name)[nodes]
        values = values[np.isfinite(values)]
        if len(values):
            high = max(high, float(np.percentile(values, 99.5)))
            largest = max(largest, float(values.max()))
            low = min(low, float(np.percentile(values, 0.5)))
    if high <= low:
        return low, low + 1.0, largest
    digit = 10.0 ** (math.floor(math.log10(high - low)) - 1)
    low = math.floor(low / digit + 1e-6) * digit
    return low, math.ceil(high / digit - 1e-6) * digit, largest

"""Sections in a row: what the actuator does as the pressure grows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from softact.estimate.sections import Section


@dataclass(frozen=True)
class Beam:
    """A clamped beam of sections.

    sections: of which each is all of its kind. length: overall, mm. axis_height: z of the tip's
    centre over the sections' origin. stiff: length (mm) at clamp and tip that does not give.
    """

    sections: Sequence[Section]
    length: float
    axis_height: float = 0.0
    clamp: float = 0.0
    tip: float = 0.0


@dataclass(frozen=True)
class Curve:
    """Of a beam without weight, over parts (n,) of the full pressures.

    angle: (n, 2) radians about y and about −z. elongation: (n,) mm of the line through the tip's
    centre. stiffness: (n, 2) N·mm² tangent flexural stiffness for both, as of a uniform beam of the
    length that gives. stretch: (n,) largest of the walls along the axis. reached: part of the full
    pressures up to which there are values.
    """

    parts: np.ndarray
    angle: np.ndarray
    elongation: np.ndarray
    stiffness: np.ndarray
    stretch: np.ndarray
    reached: float


def follow(beam: Beam, pressures: Mapping[str, float], parts: np.ndarray) -> Curve:
    """Solve each kind of section as the pressures (MPa) grow from nothing by ``parts``.

    It ends where the walls of a section can carry no more: a limit of the pressure.
    """
    strains = [np.zeros(3) for _ in beam.sections]
    angles, elongations, stiffness, stretches = [], [], [], []
    for part in parts:
        found = []
        for section, start in zip(beam.sections, strains, strict=True):
            load = section.pressed({name: part * p for name, p in pressures.items()})
            found.append(section.solve(load, start))
        solved = [strain for strain in found if strain is not None]
        if len(solved) < len(found):
            break
        strains = solved
        lengths = [section.length for section in beam.sections]
        turned = np.array(lengths) @ np.array(strains)
        angles.append(turned[1:])
        elongations.append(turned[0] + turned[1] * beam.axis_height)
        stiffness.append(_stiffness(beam, strains))
        pairs = zip(beam.sections, strains, strict=True)
        stretches.append(max(section.largest_stretch(strain) for section, strain in pairs))
    count = len(angles)
    reached = float(parts[count - 1]) if count else 0.0
    columns = np.array(angles), np.array(elongations), np.array(stiffness), np.array(stretches)
    return Curve(parts[:count], *columns, reached)


def _stiffness(beam: Beam, strains: Sequence[np.ndarray]) -> np.ndarray:
    """(2,) N·mm²: moment at the tip over what it adds to the angle, times the length that gives."""
    give, total = np.zeros((3, 3)), 0.0
    for section, strain in zip(beam.sections, strains, strict=True):
        give += section.length * np.linalg.pinv(section.tangent(strain), rcond=1e-10)
        total += section.length
    return total / np.maximum(np.diag(give)[1:], 1e-30)


def blocked(beam: Beam, pressures: Mapping[str, float]) -> tuple[float, np.ndarray]:
    """Force (N) along the axis that alone, and moments (2,) N·mm that alone, take back what full
    pressures do to the undeformed beam; linear in the pressure."""
    give, free = np.zeros((3, 3)), np.zeros(3)
    for section in beam.sections:
        own = section.length * np.linalg.pinv(section.tangent(np.zeros(3)), rcond=1e-10)
        give, free = give + own, free + own @ section.pressed(pressures)
    return float(free[0] / give[0, 0]), np.linalg.pinv(give[1:, 1:], rcond=1e-10) @ free[1:]

"""Size and mass of an actuator, from the stored mesh and spec."""

import numpy as np

from softact.report.surface import mirrored
from softact.results.folder import Results
from softact.units import DENSITY, LENGTH


def extent(results: Results) -> np.ndarray | None:
    """(3,) mm: outer dimensions along x, y, z of the whole undeformed actuator."""
    if not results.has_mesh:
        return None
    planes = tuple(results.layout.symmetry.values())
    whole, _ = mirrored(results.points, np.zeros((0, 3), int), planes)
    return np.ptp(whole, axis=0)


def profile(results: Results) -> float | None:
    """mm: height of the undeformed actuator across its axis, in the plane in which it bends."""
    size = extent(results)
    if size is None:
        return None
    across = np.array([0.0, 0.0, 1.0])
    if results.layout.bending_axis is not None:
        across = np.cross(results.layout.bending_axis, results.layout.axis)
    return float(np.abs(across) @ size)


def whole_bending(results: Results) -> np.ndarray | None:
    """(rows,) degrees, the bending of the whole length: that of the curve, and where it is counted
    between two markers, which lie as far from one end as from the other, as if the rest were bent
    as what lies between them."""
    angle, layout = results.curve.get("bending_angle_deg"), results.layout
    if angle is None or not layout.base:
        return angle
    at = results.curve["tip_x_mm"][0]
    return angle * layout.length / (2 * at - layout.length)


def mass(results: Results) -> float | None:
    """kg of the whole actuator without its layers; None where a density is not known."""
    if len(results.cells) == 0:
        return None
    parts = []
    if results.layout.regions:
        parts.append(_solid_mass(results))
    if results.layout.sheets:
        parts.append(_sheet_mass(results))
    known = [part for part in parts if part is not None]
    return sum(known) if len(known) == len(parts) else None


def _solid_mass(results: Results) -> float | None:
    """kg of the whole actuator's solids; None where a region's density is not known."""
    corners = results.points[results.cells[:, :4]]
    edges = corners[:, 1:] - corners[:, :1]
    volumes = np.abs(np.linalg.det(edges)) / 6
    whole = 2 ** len(results.layout.symmetry)
    total = 0.0
    for number, name in enumerate(results.region_names):
        density = _density(results, name)
        if density is None:
            return None
        total += whole * density * volumes[results.region == number].sum()
    return 1e3 * float(total)  # of tonnes


def _sheet_mass(results: Results) -> float | None:
    """kg of the whole actuator of sheets; None where a density is not known."""
    total = 0.0
    try:
        sheets = results.spec["sheets"]
        for name in results.layout.sheets:
            a, b, c = np.moveaxis(results.points[results.surfaces[name][:, :3]], 1, 0)
            area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2
            for ply in sheets[name]["plies"]:
                density = DENSITY.parse(ply["material"]["density"])
                thickness = LENGTH.parse(ply["thickness"])
                total += density * thickness * area
    except (KeyError, TypeError, ValueError):
        return None
    return 1e3 * total * 2 ** len(results.layout.symmetry)


def _density(results: Results, region: str) -> float | None:
    """tonne/mm³ of a region's material, as the resolved spec has it."""
    try:
        material = results.spec["materials"][region]
        return DENSITY.parse(material["density"])
    except (KeyError, TypeError, ValueError):
        return None

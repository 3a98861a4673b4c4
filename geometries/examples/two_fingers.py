"""Two fingers that hang side by side along x, each with a chamber beside its middle: under pressure
they close on what is between them. Half of both, y >= 0."""

from __future__ import annotations

from types import ModuleType

LENGTH, WIDTH, HEIGHT = 50.0, 16.0, 12.0  # mm, of a finger
ROOM = 25.0  # between both
END, SIDE, INSIDE, OUTSIDE = 5.0, 2.5, 5.5, 2.0  # walls of the chamber, INSIDE faces the other


def build(gmsh: ModuleType) -> None:
    """Add both fingers; see ``geometries/from_script.py``."""
    occ = gmsh.model.occ
    fingers: list[int] = []
    for side in (1, -1):
        low = min(side * ROOM / 2, side * (ROOM / 2 + HEIGHT))
        finger = occ.addBox(0, 0, low, LENGTH, WIDTH / 2, HEIGHT)
        low += INSIDE if side > 0 else OUTSIDE
        room = (LENGTH - 2 * END, WIDTH / 2 - SIDE, HEIGHT - INSIDE - OUTSIDE)
        chamber = occ.addBox(END, 0, low, *room)
        cut, _ = occ.cut([(3, finger)], [(3, chamber)])
        fingers += [tag for _, tag in cut]
    occ.synchronize()
    named: dict[str, list[int]] = {}
    solids = [(3, tag) for tag in fingers]
    for _, face in gmsh.model.getBoundary(solids, oriented=False):
        named.setdefault(_name(gmsh, face), []).append(face)
    for name, faces in named.items():
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, faces), name)
    gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, fingers), "body")


def _name(gmsh: ModuleType, face: int) -> str:
    """Which surface a flat face is of."""
    low, high = (gmsh.model.getBoundingBox(2, face)[k : k + 3] for k in (0, 3))
    flat = [abs(a - b) < 1e-3 for a, b in zip(low, high, strict=True)]
    if flat[1] and abs(low[1]) < 1e-3:
        return "symmetry"
    if flat[0] and abs(low[0]) < 1e-3:
        return "clamp"
    if flat[0] and abs(low[0] - LENGTH) < 1e-3:
        return "tip"
    height = abs(low[2] + high[2]) / 2 - ROOM / 2
    inside = low[0] > END - 1e-3 and high[0] < LENGTH - END + 1e-3
    return "cavity" if inside and 1e-3 < height < HEIGHT - 1e-3 else "outer"

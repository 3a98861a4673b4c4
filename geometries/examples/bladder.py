"""A part of one's own: a bladder of silicone with two rooms on a stiffer strip, so that it bends.

``configs/own_script.yaml`` runs ``build`` as a script. ``configs/own_step.yaml`` reads the STEP
file that this file writes when it runs by itself, without a name for anything:
``python geometries/examples/bladder.py configs/parts/bladder.step``.
"""

import math
import sys
from types import ModuleType

LENGTH, WIDTH, HEIGHT, STRIP = 60.0, 16.0, 12.0, 1.5  # mm
WALL, BETWEEN = 2.0, 4.0


def add_solids(gmsh: ModuleType) -> tuple[int, int]:
    """Add bladder and strip, which share the face between them; returns their tags."""
    occ = gmsh.model.occ
    block = occ.addBox(0, -WIDTH / 2, 0, LENGTH, WIDTH, HEIGHT)
    room = (LENGTH - 2 * WALL - BETWEEN) / 2
    for start in (WALL, WALL + room + BETWEEN):
        radius = WIDTH / 2 - WALL
        tube = occ.addCylinder(start, 0, WALL, room, 0, 0, radius, angle=math.pi)
        occ.rotate([(3, tube)], start, 0, WALL, 1, 0, 0, -math.pi / 2)
        ((_, block),), _ = occ.cut([(3, block)], [(3, tube)])
    strip = occ.addBox(0, -WIDTH / 2, -STRIP, LENGTH, WIDTH, STRIP)
    occ.fragment([(3, block)], [(3, strip)])
    occ.synchronize()
    lower, upper = sorted(
        (tag for _, tag in gmsh.model.getEntities(3)),
        key=lambda tag: occ.getCenterOfMass(3, tag)[2],
    )
    return upper, lower


def build(gmsh: ModuleType) -> None:
    """The solids, with names for what a spec needs."""
    bladder, strip = add_solids(gmsh)
    groups: dict[str, list[int]] = {"clamp": [], "tip": [], "near": [], "far": []}
    for _, face in gmsh.model.getBoundary([(3, bladder), (3, strip)], oriented=False):
        x0, _, _, x1, _, _ = gmsh.model.getBoundingBox(2, face)
        if x1 < 1e-3 or x0 > LENGTH - 1e-3:
            groups["clamp" if x1 < 1e-3 else "tip"].append(face)
        elif x0 > 1e-3 and x1 < LENGTH - 1e-3:
            groups["near" if x1 < LENGTH / 2 else "far"].append(face)
    for name, solid in (("bladder", bladder), ("strip", strip)):
        gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, [solid]), name)
    for name, faces in groups.items():
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, faces), name)


def main(path: str) -> None:
    """Write the solids as a STEP file."""
    import gmsh

    gmsh.initialize(readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    add_solids(gmsh)
    gmsh.write(path)
    gmsh.finalize()


if __name__ == "__main__":
    main(sys.argv[1])

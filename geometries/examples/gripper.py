"""A gripper: several copies of one finger around an axis, from the mesh of any geometry.

``softact mesh finger.yaml -o finger.msh``, then
``python geometries/examples/gripper.py finger.msh gripper.msh --fingers 3 --radius 15`` writes the
mesh and prints the parts of a spec that go with it. The finger has to be a whole one, not a half.
The gripper's axis is x; each finger lies with its lower side, z = 0, to the axis and at the radius
from it, so that what curls down closes. Regions keep their names; surfaces get the finger's number:
``clamp_1``, ``cavity_2``.
"""

import argparse
import math
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import yaml

TETRAHEDRON, TRIANGLE = 4, 2  # gmsh's numbers of first-order elements
Groups = dict[tuple[int, str], np.ndarray]


def read(gmsh: ModuleType, file: Path) -> tuple[np.ndarray, Groups]:
    """Points (n, 3) mm and, for each (dimension, name), the corners of its elements as rows of
    them."""
    gmsh.open(str(file))
    tags, points, _ = gmsh.model.mesh.getNodes()
    row = np.zeros(int(tags.max()) + 1, int)
    row[tags.astype(int)] = np.arange(len(tags))
    groups = {}
    for dimension, number in gmsh.model.getPhysicalGroups():
        kind = {2: TRIANGLE, 3: TETRAHEDRON}.get(dimension)
        if kind is None:
            continue
        found = [
            gmsh.model.mesh.getElementsByType(kind, entity)[1]
            for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, number)
        ]
        corners = row[np.concatenate(found).astype(int)].reshape(-1, dimension + 1)
        groups[dimension, gmsh.model.getPhysicalName(dimension, number)] = corners
    return points.reshape(-1, 3), groups


def turned(points: np.ndarray, angle: float, radius: float) -> np.ndarray:
    """Points of a finger at the radius, turned about x by an angle (radians)."""
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    return (points + np.array([0.0, 0.0, radius])) @ turn.T


def copies(
    points: np.ndarray, groups: Groups, fingers: int, radius: float
) -> Iterator[tuple[np.ndarray, Groups]]:
    """Of each finger its points and its groups; surfaces with its number."""
    for n in range(fingers):
        named = {
            (dimension, name if dimension == 3 else f"{name}_{n + 1}"): corners
            for (dimension, name), corners in groups.items()
        }
        yield turned(points, 2 * math.pi * n / fingers, radius), named


def write(
    gmsh: ModuleType, points: np.ndarray, groups: Groups, fingers: int, radius: float
) -> None:
    """Make the current gmsh model the gripper's mesh, with its groups."""
    gmsh.clear()
    gmsh.model.add("gripper")
    members: dict[tuple[int, str], list[int]] = {}
    first = 0
    for places, named in copies(points, groups, fingers, radius):
        body = gmsh.model.addDiscreteEntity(3)
        tags = np.arange(first + 1, first + len(places) + 1)
        gmsh.model.mesh.addNodes(3, body, tags, places.ravel())
        for (dimension, name), corners in named.items():
            entity = gmsh.model.addDiscreteEntity(dimension)
            kind = TETRAHEDRON if dimension == 3 else TRIANGLE
            gmsh.model.mesh.addElementsByType(entity, kind, [], tags[corners].ravel())
            members.setdefault((dimension, name), []).append(entity)
        first += len(places)
    for (dimension, name), entities in members.items():
        group = gmsh.model.addPhysicalGroup(dimension, entities)
        gmsh.model.setPhysicalName(dimension, group, name)


def parts(file: Path, groups: Groups, fingers: int) -> dict:
    """The geometry and the supports of a spec for the file; a cavity is a surface whose name
    begins so."""
    numbers = range(1, fingers + 1)
    surfaces = [name for dimension, name in groups if dimension == 2]
    cavities = [name for name in surfaces if name.startswith("cavity")]
    others = [name for name in surfaces if name not in (*cavities, "clamp", "tip")]
    every = [f"{name}_{n}" for n in numbers for name in ("clamp", "tip", *others)]
    return {
        "geometry": {
            "type": "from_mesh",
            "file": str(file),
            "regions": [name for dimension, name in groups if dimension == 3],
            "clamp": "clamp_1",
            "tip": "tip_1",
            "surfaces": [name for name in every if name not in ("clamp_1", "tip_1")],
            "cavities": {f"{name}_{n}": [f"{name}_{n}"] for n in numbers for name in cavities},
        },
        "supports": [{"surface": f"clamp_{n}", "fix": ["x", "y", "z"]} for n in numbers],
    }


def make(finger: Path, gripper: Path, fingers: int, radius: float) -> dict:
    """Write the gripper's mesh, and return what ``parts`` does."""
    import gmsh

    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        points, groups = read(gmsh, finger)
        if (2, "symmetry") in groups:
            raise SystemExit(f"{finger}: half a finger; write symmetry: false in its geometry")
        write(gmsh, points, groups, fingers, radius)
        # meshio reads no entities without a boundary in the newer version.
        gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
        gmsh.write(str(gripper))
    finally:
        gmsh.finalize()
    return parts(gripper, groups, fingers)


def main() -> None:
    """Write a mesh and print a spec's parts."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("finger", type=Path)
    parser.add_argument("gripper", type=Path)
    parser.add_argument("--fingers", type=int, default=3)
    parser.add_argument("--radius", type=float, default=15.0, help="mm from the axis to z = 0")
    given = parser.parse_args()
    if given.fingers < 2 or given.radius <= 0:
        parser.error("two fingers at least, at a radius above 0")
    found = make(given.finger, given.gripper, given.fingers, given.radius)
    print(yaml.safe_dump(found, sort_keys=False, default_flow_style=None, width=110), end="")


if __name__ == "__main__":
    main()

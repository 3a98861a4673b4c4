"""The process in which gmsh runs: reads a job from stdin, writes one file, says faults on stdout.

Started by ``softact.geometry.base`` only. A fault is a line that starts with ``softact-fault:``,
what the user should know of a mesh that is fit one that starts with ``softact-remark:``.
"""

import importlib
import importlib.util
import json
import math
import os
import signal
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import gmsh
import numpy as np

from softact.child_processes import end_with
from softact.errors import MeshError
from softact.files.streams import make_safe
from softact.geometry.base import Geometry
from softact.geometry.curved import are_curved, curving
from softact.geometry.gmsh_groups import TETRAHEDRA, TRIANGLES
from softact.geometry.motion import moved
from softact.geometry.saying import FAULT, tell
from softact.geometry.walls import one_element_thick, remark
from softact.mesh import leaks
from softact.mesh.boundary import face_keys
from softact.mesh.components import FACES
from softact.mesh.curves import GMSH_EDGES, Curves, of_quadratic, volumes
from softact.mesh.file_mesh import missing
from softact.mesh.quality import quality
from softact.mesh.triangles import VOLUME_RULE, areas_at, shape_functions, tangents
from softact.units import one_line

# Nodes of straight and of quadratic elements, by the number of their corners.
NODES = ({3: 3, 4: 4}, {3: 6, 4: 10})
# Mean ratio (1 regular, 0 flat) under which a tetrahedron would spoil the solution.
WORST_QUALITY = 0.01
REMARKABLE = 0.01  # relative error of a volume that the user is told of


@dataclass(frozen=True)
class Parts:
    """A mesh by names: points (n, 3) mm, tetrahedra (m, 4), triangles (k, 3) turned outward from
    the region that they belong to. Triangles inside the solid are in no cell's outside. curves:
    edges that are not straight."""

    points: np.ndarray
    regions: dict[str, np.ndarray]
    surfaces: dict[str, np.ndarray]
    curves: Curves

    @property
    def cells(self) -> np.ndarray:
        """All tetrahedra (m, 4)."""
        return np.vstack(list(self.regions.values()))


def preload() -> None:
    """Load softact's geometries, in a fork server: a job names one of them, and each process would
    load it anew, which takes longer than most meshes. They stand above this room."""
    importlib.import_module("softact.geometries")


def main() -> int:
    make_safe("utf-8")  # as softact.geometry.base reads it, with names in any letters
    job = json.load(sys.stdin)
    end_with(job["parent"])
    # A gmsh that hangs is stopped by its parent, or here.
    signal.alarm(math.ceil(job["timeout"]) + 5)
    geometry = load(job)
    pairs = [
        (load({**job, "parameters": low}), load({**job, "parameters": high}), width)
        for low, high, width in job.get("pairs", ())
    ]
    gmsh.initialize(readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 1)
    # Threads would make the mesh differ from run to run.
    gmsh.option.setNumber("General.NumThreads", 1)
    gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
    gmsh.model.add("softact")
    try:
        if pairs:
            moved(gmsh, geometry, pairs, job["curved"]).store(job["path"])
            faults = []
        else:
            with curving(job.get("curved", False)):
                faults = write(geometry, Path(job["path"]), job.get("part", "solid"))
    except MeshError as error:
        faults = error.lines
    except MemoryError:
        faults = ["gmsh ran out of memory; a larger mesh_size needs less"]
    except Exception as error:
        faults = [f"{type(error).__name__}: {' '.join(str(error).split())}"]
    for fault in faults:
        print(FAULT + one_line(fault))
    sys.stdout.flush()
    gmsh.finalize()
    return 1 if faults else 0


def load(job: dict) -> Geometry:
    """The geometry object of a job. Its parameters were validated by the caller."""
    module = sys.modules.get(job["module"]) if job["module"] != "__main__" else None
    try:
        module = module or importlib.import_module(job["module"].replace("__main__", ""))
    except (ImportError, ValueError):
        # A script of the user's, or one that runs by itself; what lies beside it comes last.
        sys.path.append(os.path.dirname(job["file"]))
        spec = importlib.util.spec_from_file_location("geometry_script", job["file"])
        if spec is None or spec.loader is None:
            raise ImportError(f"{job['file']} is no Python file") from None
        module = importlib.util.module_from_spec(spec)
        sys.modules["geometry_script"] = module
        spec.loader.exec_module(module)
    return getattr(module, job["class"]).model_construct(**job["parameters"])


def write(geometry: Geometry, path: Path, part: str) -> list[str]:
    """Writes the file that the suffix of ``path`` asks for; returns what is wrong with the mesh.

    part: "look" and "faces" are about the file that a geometry is made of.
    """
    if part == "look":
        geometry.look(gmsh)
        meshed = any(map(len, gmsh.model.mesh.getElements(3)[1]))
        return faults_of(geometry)[1] if meshed else []
    if part == "faces":
        geometry.draw(gmsh, path)
        return []
    if path.suffix == ".step":
        write_step(geometry, path, part)
        return []
    geometry.mesh(gmsh)
    parts, faults = faults_of(geometry)
    if faults:
        return faults
    if part == "core":
        write_core(geometry, parts, path)
        return []
    for said in remarks(geometry, parts):
        tell(said)
    writers = {".msh": write_msh, ".vtu": write_vtu, ".stl": write_stl}
    writers[path.suffix](geometry, parts, path)
    return []


def faults_of(geometry: Geometry) -> tuple[Parts, list[str]]:
    """The named groups of the current gmsh model, and what is wrong with them. Raises MeshError
    where one is missing."""
    parts = read_parts(geometry)
    return parts, check(geometry, parts)


def read_parts(geometry: Geometry) -> Parts:
    """The named groups of the current gmsh model. Raises MeshError where one is missing."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    number = np.zeros(int(tags.max(initial=0)) + 1, dtype=np.int64)
    number[tags] = np.arange(len(tags))
    points, curved = coordinates.reshape(-1, 3), Curves()
    named = {}
    quadratic = len(gmsh.model.mesh.getElementsByType(TETRAHEDRA[1])[0]) > 0
    for dimension, group in gmsh.model.getPhysicalGroups():
        kinds, corners = {2: (TRIANGLES, 3), 3: (TETRAHEDRA, 4)}.get(dimension, ((0, 0), 0))
        if corners:
            pieces = [
                gmsh.model.mesh.getElementsByType(kinds[quadratic], entity)[1]
                for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, group)
            ]
            nodes = NODES[quadratic][corners]
            elements = number[np.concatenate(pieces).astype(np.int64)].reshape(-1, nodes)
            named[dimension, gmsh.model.getPhysicalName(dimension, group)] = elements
    if quadratic:
        every = np.vstack([part for (dimension, _), part in named.items() if dimension == 3])
        curved = of_quadratic(points, every, GMSH_EDGES)
        named = {key: part[:, : key[0] + 1] for key, part in named.items()}
    layout = geometry.layout()
    wanted = [(3, name) for name in layout.regions] + [(2, name) for name in layout.surfaces]
    faults = [
        missing("volume" if d == 3 else "surface", name, [n for kind, n in named if kind == d])
        for d, name in wanted
        if not len(named.get((d, name), ()))
    ]
    if faults:
        raise MeshError(*faults)
    regions = {name: named[3, name] for name in layout.regions}
    surfaces = {name: named[2, name] for name in layout.surfaces}
    return Parts(points, regions, surfaces, curved)


def outward(triangles: np.ndarray, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles turned outward from a cell that they are a face of, and of how many cells."""
    faces = cells[:, FACES].reshape(-1, 3)
    count = int(cells.max()) + 1
    keys, wanted = face_keys(faces, count), face_keys(triangles, count)
    first = np.argsort(keys, kind="stable")
    ordered = keys[first]
    start = np.searchsorted(ordered, wanted)
    members = np.searchsorted(ordered, wanted, side="right") - start
    return faces[first[np.minimum(start, len(first) - 1)]], members


def check(geometry: Geometry, parts: Parts) -> list[str]:
    """What makes a mesh unfit: flat cells, stray triangles, leaking cavities, wrong volumes."""
    points, cells, layout = parts.points, parts.cells, geometry.layout()
    flat = int(np.sum(quality(points, cells) < WORST_QUALITY))
    if flat:
        return [
            f"{flat} of {len(cells)} tetrahedra are flat or inside out; "
            "a smaller mesh_size or thicker walls make better ones"
        ]
    stray = {name: outward(tris, cells)[1] for name, tris in parts.surfaces.items()}
    faults = [
        f"{int(np.sum(count == 0))} triangles of '{name}' are not faces of the tetrahedra"
        for name, count in stray.items()
        if not count.all()
    ]
    if faults:
        return faults
    closing = list(layout.symmetry.values())
    for cavity, walls in layout.cavities.items():
        triangles = np.vstack([parts.surfaces[wall] for wall in walls])
        edges = leaks.open_edges(points, triangles, closing)
        edges = edges[~leaks.within_repeats(layout, parts.surfaces, edges)]
        if len(edges):
            why = leaks.reason(points, parts.regions, triangles, edges)
            faults.append(leaks.line(cavity, points, edges) + why)
    if faults:
        return faults
    found = measure(geometry, parts)
    faults = [
        f"the walls of the cavity '{cavity}' enclose the solid itself and no room in it; name the "
        "faces inside"
        for cavity in layout.cavities
        if found[cavity] <= 0
    ]
    for name, wanted in geometry.volumes().items():
        if abs(found[name] - wanted) > geometry.volume_tolerance(name) * wanted:
            faults.append(
                f"the mesh gives {found[name]:.6g} for the measure of '{name}', "
                f"the closed form {wanted:.6g}"
            )
    return faults


def remarks(geometry: Geometry, parts: Parts) -> list[str]:
    """What the user should know of a mesh that is fit."""
    return [*_far_off(geometry, parts), *_thin(geometry, parts)]


def _far_off(geometry: Geometry, parts: Parts) -> Iterator[str]:
    """The volume that the mesh misses most, and the others, where that is by more than
    REMARKABLE."""
    found, layout = measure(geometry, parts), geometry.layout()
    wanted = geometry.volumes()
    solid = [name for name in (*layout.regions, *layout.cavities) if name in wanted]
    off = {name: found[name] / wanted[name] - 1 for name in solid}
    far = sorted((name for name in off if abs(off[name]) > REMARKABLE), key=lambda n: -abs(off[n]))
    if far:
        worst, others = far[0], ", ".join(f"'{name}' {off[name]:+.1%}" for name in far[1:])
        yield (
            f"the mesh gives '{worst}' {found[worst]:.4g} mm^3, {off[worst]:+.1%} of the closed "
            f"form {wanted[worst]:.4g} mm^3{f' ({others})' if others else ''}; a smaller mesh_size "
            "comes nearer"
            + ("" if are_curved() else ", and so do curved walls (solver: {curved: true})")
        )


def _thin(geometry: Geometry, parts: Parts) -> list[str]:
    known, layout = geometry.walls(), geometry.layout()
    if known == ():
        return []
    cavities = {
        name: np.vstack([parts.surfaces[wall] for wall in of])
        for name, of in layout.cavities.items()
    }
    aside = {*layout.symmetry, layout.clamp, layout.tip} & set(parts.surfaces)
    left_out = [parts.surfaces[name] for name in aside]
    said = remark(known, one_element_thick(parts.points, parts.cells, cavities, left_out))
    return [said] if said else []


def measure(geometry: Geometry, parts: Parts) -> dict[str, float]:
    """Volumes of regions and cavities (mm^3) and areas of surfaces (mm^2) of the mesh. A name
    that a cavity shares with a surface means the cavity."""
    points, cells, curves = parts.points, parts.cells, parts.curves
    rule, weights = VOLUME_RULE
    found = {
        name: float((areas_at(curves.triangles(triangles, points), rule) @ weights).sum())
        for name, triangles in parts.surfaces.items()
    }
    for name, tets in parts.regions.items():
        found[name] = float(volumes(curves.nodes(tets, points)).sum())
    for name, walls in geometry.layout().cavities.items():
        triangles, _ = outward(np.vstack([parts.surfaces[wall] for wall in walls]), cells)
        nodes = curves.triangles(triangles, points)
        place = shape_functions(rule, nodes.shape[1]) @ nodes
        area = np.cross(*np.moveaxis(tangents(nodes, rule), -1, 0)) / 2
        # Flux of (x, 0, 0), (0, y, 0) and (0, 0, z). Planes that close a cavity take no flux if
        # they are symmetry planes; an open end takes the flux along the axis, so that is left out.
        flux = -np.einsum("kqc,kqc,q->c", place, area, weights)
        found[name] = float(flux.max())
    return found


def write_msh(geometry: Geometry, parts: Parts, path: Path) -> None:
    gmsh.write(str(path))


def write_vtu(geometry: Geometry, parts: Parts, path: Path) -> None:
    """The mesh for ParaView: cell data ``region`` (its number, -1 on triangles), and for each
    surface 1 on its triangles."""
    import meshio

    triangles = np.unique(np.sort(np.vstack(list(parts.surfaces.values())), axis=1), axis=0)
    cells = parts.cells
    numbers = [np.full(len(tets), i) for i, tets in enumerate(parts.regions.values())]
    data = {"region": [np.concatenate(numbers), np.full(len(triangles), -1)]}
    for name, members in parts.surfaces.items():
        known = {tuple(t) for t in np.sort(members, axis=1).tolist()}
        inside = np.array([tuple(t) in known for t in triangles.tolist()], dtype=int)
        data[name] = [np.zeros(len(cells), dtype=int), inside]
    blocks = [("tetra", cells), ("triangle", triangles)]
    meshio.Mesh(parts.points, blocks, cell_data=data).write(path)


def write_stl(geometry: Geometry, parts: Parts, path: Path) -> None:
    """The closed skin of the whole solid, outside and cavities, mirrored at symmetry planes."""
    faces = parts.cells[:, FACES].reshape(-1, 3)
    _, count = outward(faces, parts.cells)
    write_skin(geometry, parts.points[faces[count == 1]], path)


def write_core(geometry: Geometry, parts: Parts, path: Path) -> None:
    """The closed skins of the cavities' air: their walls, turned out of the air."""
    walls = [wall for names in geometry.layout().cavities.values() for wall in names]
    triangles, _ = outward(np.vstack([parts.surfaces[wall] for wall in walls]), parts.cells)
    write_skin(geometry, parts.points[triangles[:, ::-1]], path)


def write_skin(geometry: Geometry, skin: np.ndarray, path: Path) -> None:
    """Triangles (k, 3, 3), and their mirror images, but for those in symmetry planes."""
    import meshio

    for axis in geometry.layout().symmetry.values():
        skin = skin[~(np.abs(skin[:, :, axis]) < 1e-9).all(axis=1)]
        mirrored = skin[:, ::-1].copy()
        mirrored[:, :, axis] *= -1
        skin = np.concatenate([skin, mirrored])
    corners = skin.reshape(-1, 3)
    triangles = np.arange(len(corners)).reshape(-1, 3)
    meshio.Mesh(corners, [("triangle", triangles)]).write(path, binary=True)


def write_step(geometry: Geometry, path: Path, part: str) -> None:
    """The whole solid for CAD, or the air of its cavities, mirrored at symmetry planes, without the
    surfaces inside it."""
    geometry.build(gmsh)
    occ = gmsh.model.occ
    for axis in geometry.layout().symmetry.values():
        parts = occ.getEntities(3)
        mirrored = occ.copy(parts)
        plane = [0.0, 0.0, 0.0, 0.0]
        plane[axis] = 1.0
        occ.mirror(mirrored, *plane)
        for solid, image in zip(parts, mirrored, strict=True):
            occ.fuse([solid], [image])
    if part == "core":
        keep_air()
    occ.synchronize()
    gmsh.write(str(path))


def keep_air() -> None:
    """Replaces the OCC solids by the air that they enclose."""
    occ = gmsh.model.occ
    solids = occ.getEntities(3)
    boxes = np.array([occ.getBoundingBox(*solid) for solid in solids])
    lower, upper = boxes[:, :3].min(axis=0), boxes[:, 3:].max(axis=0)
    margin = 0.1 * np.linalg.norm(upper - lower)
    around = occ.addBox(*(lower - margin), *(upper - lower + 2 * margin))
    air, _ = occ.cut([(3, around)], solids)
    outside = [tag for tag in air if occ.getBoundingBox(*tag)[0] < lower[0] - margin / 2]
    occ.remove(outside, recursive=True)


if __name__ == "__main__":
    sys.exit(main())

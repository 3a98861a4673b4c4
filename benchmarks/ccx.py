"""CalculiX on softact's mesh: writes its input, runs it, reads what it found.

Formats after the manual 'CalculiX CrunchiX User's Manual version 2.20' (G. Dhondt): *HYPERELASTIC,
*DLOAD, *STATIC, *NODE PRINT, 'Ten-node tetrahedral element (C3D10)'.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from softact.errors import SoftactError, SpecError
from softact.mesh.msh_file import Tetrahedra

# Corners of the edges whose middles are nodes 5 to 10 of a C3D10.
EDGES = np.array([[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]])
# CalculiX's faces P1 to P4 are 1-2-3, 1-4-2, 2-4-3, 3-4-1; here by the corner opposite to each.
FACE_OPPOSITE_TO = np.array([3, 4, 2, 1])
# Nodes of each face by the opposite corner: corners so turned that the normal leaves the element.
FACE_CORNERS = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
# A compressibility D that is zero is replaced by a default; this one leaves the term out.
NO_TERM = 1e30
# Stresses go in as Pa, forces are then µN: CalculiX sets a residual below 1e-6 to zero, which in N
# is a ten-thousandth of the forces of a soft finger (calcresidual.c).
PASCAL = 1e6


@dataclass(frozen=True)
class QuadraticMesh:
    """C3D10 tetrahedra with straight edges over softact's mesh; numbers start at 0.

    points: (n, 3) mm, corners first. cells: (m, 10) in CalculiX's order, positively turned.
    surfaces: name -> (k, 2) cell and opposite corner of each face (one cell per face).
    """

    points: np.ndarray
    cells: np.ndarray
    surfaces: dict[str, np.ndarray]
    element: ClassVar[str] = "C3D10"

    def faces(self, surface: str) -> np.ndarray:
        """Nodes (k, 6) of the faces: corners with the normal out of the cell, then middles of the
        edges 01, 12, 20."""
        cell, opposite = self.surfaces[surface].T
        return self.cells[cell[:, None], FACE_NODES[opposite]]

    def nodes(self, surface: str) -> np.ndarray:
        """Numbers of all nodes on a surface, each once."""
        return np.unique(self.faces(surface))

    def loaded_faces(self, surface: str) -> np.ndarray:
        """Element (from 1) and CalculiX's number of each face of a surface, (k, 2)."""
        cell, opposite = self.surfaces[surface].T
        return np.column_stack([cell + 1, FACE_OPPOSITE_TO[opposite]])

    @staticmethod
    def face_quadrature():
        """Weight, shape functions (6,) and their derivatives at the points of a rule on a face."""
        s, weights = gauss(4)
        for u, wu in zip(s, weights, strict=True):
            for v, wv in zip(s, weights, strict=True):
                # The square is collapsed onto the triangle; 1 - u is the Jacobian of that.
                yield wu * wv * (1 - u), *_triangle(u, v * (1 - u))


def _face_nodes() -> np.ndarray:
    middle = {frozenset(edge): 4 + i for i, edge in enumerate(EDGES.tolist())}
    return np.array(
        [[*c, *(middle[frozenset((c[i], c[(i + 1) % 3]))] for i in range(3))] for c in FACE_CORNERS]
    )


FACE_NODES = _face_nodes()


def quadratic(tets: Tetrahedra) -> QuadraticMesh:
    """Put nodes on the middles of all edges."""
    count = len(tets.points)
    corners = tets.cells.copy()
    a, b, c, d = (tets.points[corners[:, i]] for i in range(4))
    negative = np.einsum("ki,ki->k", np.cross(b - a, c - a), d - a) < 0
    corners[negative] = corners[negative][:, [0, 2, 1, 3]]
    ends, number = np.unique(
        np.sort(corners[:, EDGES], axis=2).reshape(-1, 2), axis=0, return_inverse=True
    )
    points = np.vstack([tets.points, tets.points[ends].mean(axis=1)])
    cells = np.hstack([corners, count + number.reshape(-1, 6)])
    keys = _keys(corners[:, FACE_CORNERS], count).ravel()
    order = np.argsort(keys, kind="stable")
    surfaces = {}
    for name, triangles in tets.surfaces.items():
        place = order[np.searchsorted(keys, _keys(triangles, count), sorter=order)]
        surfaces[name] = np.column_stack([place // 4, place % 4])
    return QuadraticMesh(points, cells, surfaces)


def _keys(triangles: np.ndarray, count: int) -> np.ndarray:
    corners = np.sort(triangles, axis=-1).astype(np.int64)
    return (corners[..., 0] * count + corners[..., 1]) * count + corners[..., 2]


def surface_mean(mesh, field: np.ndarray, surface: str) -> np.ndarray:
    """Mean of a nodal field (n, k) over the undeformed area of a surface: (k,)."""
    faces = mesh.faces(surface)
    x, values = mesh.points[faces], field[faces]
    total, area = 0.0, 0.0
    for weight, shape, by_first, by_second in mesh.face_quadrature():
        da = weight * np.linalg.norm(np.cross(by_first @ x, by_second @ x), axis=1)
        total = total + da @ (shape @ values)
        area += da.sum()
    return total / area


def cavity_volume(mesh, displacement: np.ndarray, surfaces) -> float:
    """Volume (mm³) enclosed by the surfaces and symmetry planes through the origin.

    displacement: (n, 3) mm. V = -1/3 ∫ x·n da, n out of the solid; the rule integrates it exactly
    for quadratic triangles.
    """
    faces = np.vstack([mesh.faces(name) for name in surfaces])
    x = (mesh.points + displacement)[faces]
    volume = 0.0
    for weight, shape, by_first, by_second in mesh.face_quadrature():
        normal = np.cross(by_first @ x, by_second @ x)
        volume -= weight * np.einsum("ki,ki->", shape @ x, normal) / 3
    return float(volume)


def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights on (0, 1)."""
    s, weights = np.polynomial.legendre.leggauss(count)
    return (s + 1) / 2, weights / 2


def _triangle(r: float, s: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shape functions of the six-node triangle and their derivatives by r and s."""
    t = 1 - r - s
    values = [t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t]
    by_r = [1 - 4 * t, 4 * r - 1, 0, 4 * (t - r), 4 * s, -4 * s]
    by_s = [1 - 4 * t, 0, 4 * s - 1, -4 * r, 4 * r, 4 * (t - s)]
    return np.array(values), np.array(by_r), np.array(by_s)


def write_input(path: Path, mesh, spec, tolerance: float | None = None) -> None:
    """Write the problem of a spec as CalculiX input.

    mesh: a ``QuadraticMesh`` or ``benchmarks.hexahedra.HexahedralMesh``.
    tolerance: relative residual and correction at which an increment has converged; None: the
    defaults of CalculiX (0.5 % and 1 %). Raises SpecError for what is not translated.
    """
    law, step = _translatable(spec)
    layout = spec.geometry.layout()
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{i}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(mesh.points, 1)]
    lines.append(f"*ELEMENT, TYPE={mesh.element}, ELSET=BODY")
    for i, cell in enumerate(mesh.cells + 1, 1):
        words = list(map(str, (i, *cell)))  # a line holds 16 numbers
        lines += [", ".join(words[:12]) + ("," if words[12:] else "")]
        if words[12:]:
            lines.append(", ".join(words[12:]))
    for name in mesh.surfaces:
        lines += [f"*NSET, NSET={name.upper()}", *(f"{n}," for n in mesh.nodes(name) + 1)]
    # U = Σ (J - 1)^2i / Di, so that D1 = 2/K is softact's K/2 (J - 1)^2.
    constants = [PASCAL * c for c in (law.c10, law.c20, law.c30)]
    constants += [2 / (PASCAL * law.bulk_modulus), NO_TERM, NO_TERM]
    lines += [
        "*MATERIAL, NAME=RUBBER",
        "*HYPERELASTIC, YEOH",
        ", ".join(f"{c:.12g}" for c in constants),
        "*SOLID SECTION, ELSET=BODY, MATERIAL=RUBBER",
        "*BOUNDARY",
    ]
    lines += [f"{name.upper()}, {c + 1}, {c + 1}" for name, c in layout.symmetry.items()]
    for support in spec.supports:
        lines += [f"{support.surface.upper()}, {c + 1}, {c + 1}" for c in support.values]
    lines.append("*STEP, NLGEOM, INC=100000")
    if tolerance is not None:
        lines += ["*CONTROLS, PARAMETERS=FIELD", f"{tolerance:g}, {tolerance:g}, , , {tolerance:g}"]
    s = spec.solver
    lines += ["*STATIC", f"{s.initial_increment:g}, 1.0, 1e-6, {s.max_increment:g}"]
    # Under NLGEOM the faces are those of the deformed body: the pressure follows them.
    lines.append("*DLOAD")
    for cavity, walls in layout.cavities.items():
        pressure = f"{PASCAL * step.pressure[cavity]:.12g}"
        for element, face in np.vstack([mesh.loaded_faces(name) for name in walls]):
            lines.append(f"{element}, P{face}, {pressure}")
    lines += ["*NODE FILE", "U", "*EL FILE", "S", "*NODE PRINT, NSET=ALL", "U", "*END STEP", ""]
    path.write_text("\n".join(lines))


def _translatable(spec):
    """The law and the step of a spec, if CalculiX can be told all that it says."""
    law = next(iter(spec.materials.values()))
    faults = {
        "layers": bool(spec.layers),
        "materials": len(spec.materials) != 1 or law.law != "yeoh",
        "steps": len(spec.steps) != 1 or not spec.steps[0].pressure or bool(spec.steps[0].gravity),
        "supports": any(any(support.values.values()) for support in spec.supports),
    }
    wrong = [name for name, fault in faults.items() if fault]
    if wrong:
        raise SpecError(
            f"{spec.name}: {', '.join(wrong)}: only one Yeoh body under one step of pressure, held "
            "at zero displacement, is translated for CalculiX"
        )
    return law, spec.steps[0]


@dataclass(frozen=True)
class Solution:
    """What CalculiX found.

    times: (i,) fractions of the load; displacement: (i, n, 3) mm, one for each. wall_time: seconds
    of the whole command, solve_time: from the first increment on. increments: accepted ones;
    iterations: all, also of increments that were cut.
    """

    times: np.ndarray
    displacement: np.ndarray
    wall_time: float
    solve_time: float
    increments: int
    iterations: int


def executable() -> str | None:
    """Path of ccx, None where it is not installed."""
    return shutil.which("ccx")


def run(path: Path, nodes: int, threads: int, limit: float | None = None) -> Solution:
    """Solve an input file in its own folder with so many threads.

    Raises SoftactError where ccx is missing or does not reach the full load, within ``limit``
    seconds where that is given.
    """
    ccx = executable()
    if ccx is None:
        raise SoftactError("ccx is not installed; on Debian 12: apt-get install calculix-ccx")
    # One variable sets the threads of all parts that have no variable of their own.
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("CCX_", "NUMBER_OF_"))}
    environment |= {"OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": str(threads)}
    started = time.perf_counter()
    first = None
    log = path.with_suffix(".log")
    with log.open("w") as out:
        process = subprocess.Popen(
            ["stdbuf", "-oL", ccx, "-i", path.stem],
            cwd=path.parent,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=environment,
        )
        alarm = threading.Timer(limit, process.kill) if limit else None
        if alarm:
            alarm.start()
        for line in process.stdout:
            out.write(line)
            if first is None and line.startswith(" increment 1 "):
                first = time.perf_counter()
        code = process.wait()
        if alarm:
            alarm.cancel()
    ended = time.perf_counter()
    times, displacement = read_displacement(path.with_suffix(".dat"), nodes)
    if code or not len(times) or abs(times[-1] - 1) > 1e-9:
        reached = times[-1] if len(times) else 0.0
        raise SoftactError(f"ccx reached {reached:.2%} of the load, exit code {code}; see {log}")
    return Solution(
        times,
        displacement,
        ended - started,
        ended - (first or started),
        len(_rows(path.with_suffix(".sta"))),
        len(_rows(path.with_suffix(".cvg"))),
    )


def _rows(path: Path) -> list[list[str]]:
    """The lines of a table that begin with a number."""
    lines = (line.split() for line in path.read_text().splitlines())
    return [line for line in lines if line and line[0].isdigit()]


def read_displacement(path: Path, nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """Times (i,) and displacements (i, nodes, 3) in mm from a .dat file with *NODE PRINT, U."""
    times, found = [], []
    if not path.exists():
        return np.array([]), np.empty((0, nodes, 3))
    for line in path.read_text().splitlines():
        words = line.split()
        if line.lstrip().startswith("displacements"):
            times.append(float(words[-1]))
            found.append(np.full((nodes, 3), np.nan))
        elif len(words) == 4 and found:
            found[-1][int(words[0]) - 1] = [float(word) for word in words[1:]]
    return np.array(times), np.array(found).reshape(-1, nodes, 3)

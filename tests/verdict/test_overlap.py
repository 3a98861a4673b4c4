"""Bodies that pass through themselves: how far and where is known by hand."""

from pathlib import Path

import numpy as np
import pytest

from softact.mesh.layout import Layout
from softact.results.folder import read
from softact.results.writer import ResultsWriter
from softact.verdict.overlap import first_overlap, overlap
from tests import bent_beam

EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))


def box(size, corner, count):
    """Points and quadratic tets of a block, Kuhn's six to a cell."""
    axes = [np.linspace(c, c + s, n + 1) for c, s, n in zip(corner, size, count, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    grid = np.arange(len(points)).reshape([n + 1 for n in count])
    tets = []
    for cell in np.ndindex(*count):
        for order in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
            way = [np.array(cell)]
            for axis in order:
                way.append(way[-1] + np.eye(3, dtype=int)[axis])
            tet = [grid[tuple(place)] for place in way]
            if np.linalg.det(points[tet[1:]] - points[tet[0]]) < 0:
                tet[2:] = tet[:1:-1]
            tets.append(tet)
    return bent_beam._quadratic(points, np.array(tets))


def write(folder: Path, parts, moves, symmetry=None):
    """A result folder of bodies (points, cells) and, for each state, a shift of each body."""
    points, cells, first = [], [], 0
    for some, tets in parts:
        points.append(some)
        cells.append(tets + first)
        first += len(some)
    all_cells = np.vstack(cells)
    surfaces = {}
    for number, tets in enumerate(cells):
        faces = bent_beam._surfaces(np.vstack(points), tets)
        surfaces[f"face_{number}"] = np.vstack([faces["clamp"], faces["cavity_wall"]])
        if symmetry is not None:
            surfaces.setdefault("plane", faces["symmetry"])
    layout = Layout(
        regions=("body",), surfaces=tuple(surfaces), cavities={}, clamp="", tip="",
        symmetry={} if symmetry is None else {"plane": symmetry},
    )  # fmt: skip
    writer = ResultsWriter(folder, "name: boxes\n", {})
    writer.mesh(np.vstack(points), all_cells, np.zeros(len(all_cells)), ["body"], surfaces, layout)
    for number, state in enumerate(moves):
        shift = [
            np.tile(move, (len(some), 1)) for move, (some, _) in zip(state, parts, strict=True)
        ]
        writer.increment({"step": "push", "step_fraction": number / 4.0},
                         {"displacement": np.vstack(shift).astype(float)})  # fmt: skip
    writer.finish("complete")
    return read(folder)


SMALL, LARGE = (10.0, 10.0, 10.0), (20.0, 20.0, 20.0)


@pytest.fixture(scope="module")
def pushed(tmp_path_factory):
    """A small cube 1 mm in front of a large one that is pushed towards it by 0.5, 1, 2 and 4 mm."""
    parts = [box(LARGE, (0, 0, 0), (6, 6, 6)), box(SMALL, (21.0, 5.0, 5.0), (3, 3, 3))]
    moves = [((0, 0, 0), (-way, 0, 0)) for way in (0.0, 0.5, 0.999, 2.0, 4.0)]
    return write(tmp_path_factory.mktemp("overlap") / "boxes", parts, moves)


def test_nothing_overlaps_before_they_touch(pushed):
    assert [overlap(pushed, number) for number in (0, 1, 2)] == [None] * 3


def test_depth_share_and_place_of_a_cube_in_a_cube(pushed):
    found = overlap(pushed, 4)
    assert found.depth == pytest.approx(3.0, rel=1e-6)  # 4 mm less the gap
    # Its end face, 3 mm of its four sides, and as much of the other's face: of 6·10² + 6·20² mm².
    share = (100 + 4 * 10 * 3 + 100) / (600 + 2400)
    assert found.share == pytest.approx(share, rel=0.1)
    x, y, z = found.place
    assert x == pytest.approx(21.0) and 5 <= y <= 15 and 5 <= z <= 15
    assert found.seen[0] == pytest.approx(17.0)
    assert found.other == pytest.approx([17.0, y, z])
    assert not found.at_least


def test_the_first_state_with_an_overlap_is_found(pushed):
    number, found = first_overlap(pushed, 4)
    assert number == 3
    assert found.depth == pytest.approx(3.0, rel=1e-6)
    assert first_overlap(pushed, 2) is None


def test_a_half_that_crosses_its_symmetry_plane_meets_its_image(tmp_path):
    """A body that stands off the plane by 1 mm and moves through it by 3 mm: its face is 6 mm deep
    in its image, 4 mm from the image's other face, which is the nearest."""
    whole = [box(LARGE, (0, 0, 0), (2, 2, 2)), box(SMALL, (30.0, 1.0, 5.0), (2, 2, 2))]
    results = write(tmp_path / "r", whole, [((0, 0, 0), (0, -way, 0)) for way in (0, 1, 4)], 1)
    assert overlap(results, 0) is None
    assert overlap(results, 1) is None  # they touch
    found = overlap(results, 2)
    assert found.depth == pytest.approx(4.0, rel=1e-6)
    assert found.place[0] > 25 and found.other[0] > 25


@pytest.mark.parametrize("angle, expected", [(200.0, False), (340.0, False)])
def test_a_bent_beam_does_not_overlap_before_a_full_turn(tmp_path, angle, expected):
    bent_beam.write(tmp_path / "r", angle, 1, size={"nx": 24, "ny": 4, "nz": 7})
    assert (overlap(read(tmp_path / "r"), 1) is not None) is expected


def test_a_beam_bent_past_a_full_turn_passes_through_its_clamp(tmp_path):
    """At 400° its last 40° stand where its first are: the ends lie inside, 40/360 of a turn."""
    bent_beam.write(tmp_path / "r", 400.0, 1, size={"nx": 24, "ny": 4, "nz": 7})
    found = overlap(read(tmp_path / "r"), 1)
    assert found is not None
    assert {"clamp", "tip"} <= set(found.surfaces)
    assert min(found.place[0], bent_beam.LENGTH - found.place[0]) < bent_beam.LENGTH / 9
    far = abs(found.place[0] - found.other[0])
    assert far == pytest.approx(bent_beam.LENGTH * 360 / 400, rel=0.02)


def sheet(count, size, origin, across):
    """Flat quadratic triangles of a square: points and (k, 6) nodes."""
    n = 2 * count
    grid = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    t = np.linspace(0, size, n + 1)
    u, v = np.meshgrid(t, t, indexing="ij")
    one, other = np.array(across, float)
    points = np.array(origin, float) + u.reshape(-1, 1) * one + v.reshape(-1, 1) * other
    nodes = []
    for i, j in np.ndindex(count, count):
        a, b, c, d = (grid[2 * (i + p), 2 * (j + q)] for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)))
        middle = grid[2 * i + 1, 2 * j + 1]
        below, right = grid[2 * i + 1, 2 * j], grid[2 * i + 2, 2 * j + 1]
        above, left = grid[2 * i + 1, 2 * j + 2], grid[2 * i, 2 * j + 1]
        nodes += [(a, b, c, below, right, middle), (a, c, d, middle, above, left)]
    return points, np.array(nodes)


def test_two_sheets_that_cross(tmp_path):
    """A level sheet, and an upright one that hangs 1 mm above it and is let down by 4 mm: it sticks
    out by 3 mm, of which its rows of nodes (2.5 mm apart) show at least half a spacing."""
    level, triangles = sheet(4, 20.0, (0, 0, 0), ((1, 0, 0), (0, 1, 0)))
    upright, more = sheet(4, 20.0, (0.3, 10.7, 1.0), ((0.95, 0.05, 0), (0, 0, 1)))
    layout = Layout(regions=(), surfaces=("floor", "wall"), cavities={}, clamp="", tip="",
                    sheets=("floor", "wall"))  # fmt: skip
    points = np.vstack([level, upright])
    parts = {"floor": triangles, "wall": more + len(level)}
    writer = ResultsWriter(tmp_path / "r", "name: sheets\n", {})
    cells = np.vstack([*parts.values()])
    writer.mesh(points, cells, np.zeros(len(cells)), list(parts), parts, layout)
    for way in (0.0, 0.9, 4.0):
        moved = np.zeros_like(points)
        moved[len(level) :, 2] = -way
        writer.increment({"step": "s", "step_fraction": 1.0}, {"displacement": moved})
    writer.finish("complete")
    results = read(tmp_path / "r")
    assert overlap(results, 0) is None and overlap(results, 1) is None
    found = overlap(results, 2)
    assert set(found.surfaces) == {"floor", "wall"} and found.at_least
    assert 0.4 <= found.depth <= 3.0 + 1e-9
    assert found.seen[2] == pytest.approx(0.0, abs=1e-9)

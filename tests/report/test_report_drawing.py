"""What the report draws: the skin, the 3-D view, colours, pictures to scale, obstacles."""

import base64
import gzip
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from softact.mesh.layout import Layout
from softact.report import frames, obstacles, pictures, surface, view, viewer
from softact.results.folder import read
from softact.results.writer import ResultsWriter
from tests import bent_beam

LENGTH, HALF, HEIGHT = bent_beam.LENGTH, bent_beam.HALF_WIDTH, bent_beam.HEIGHT
WALL = bent_beam.WALL
ANGLE, INCREMENTS = bent_beam.ANGLE, bent_beam.INCREMENTS


def area(points, triangles):
    a, b, c = (points[triangles[:, n]] for n in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def volume(points, triangles):
    a, b, c = (points[triangles[:, n]] for n in range(3))
    return (a * np.cross(b, c)).sum() / 6


def test_skin_of_the_block(reported_beam):
    results = read(reported_beam)
    skin = surface.skin(results)
    points = results.points[skin.nodes]
    channel = (LENGTH - 2 * WALL) * (HALF - WALL) * (HEIGHT - 2 * WALL)
    both = np.vstack([skin.outer, skin.inner])
    assert volume(points, both) == pytest.approx(LENGTH * HALF * HEIGHT - channel)
    outside = 2 * LENGTH * HALF + LENGTH * HEIGHT + 2 * HALF * HEIGHT
    assert area(points, skin.outer) == pytest.approx(outside)
    # Creases of the half block: two sides along x and z, four along y; none in the cut.
    ends = points[skin.edges]
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum()
    each = 2 * LENGTH + 2 * HEIGHT + 4 * HALF
    assert length == pytest.approx(2 * each)  # once for each of the two faces that meet


def test_mirrored_whole(reported_beam):
    results = read(reported_beam)
    skin = surface.skin(results)
    points, triangles = surface.mirrored(results.points[skin.nodes], skin.outer, skin.mirrors)
    assert volume(points, triangles) == pytest.approx(LENGTH * 2 * HALF * HEIGHT)


def test_many_triangles_are_drawn_by_their_corners(reported_beam):
    results = read(reported_beam)
    full, coarse = surface.skin(results), surface.skin(results, most=100)
    assert len(full.outer) == 4 * len(coarse.outer)
    assert area(results.points[coarse.nodes], coarse.outer) == pytest.approx(
        area(results.points[full.nodes], full.outer)
    )


def unpacked(packed):
    """What shape.js does with the data: triangles, tets, places, shades and peaks."""
    raw = gzip.decompress(base64.b64decode(packed["data"]))
    n, states = packed["vertices"], len(packed["states"])
    faces, size, at = packed["outer"] + packed["inner"], 3 * n * len(packed["states"]), 0

    def take(kind, count):
        nonlocal at
        part = np.frombuffer(raw, kind, count, at)
        at += part.nbytes
        return part

    triangles = np.cumsum(take("<u4", 3 * faces).reshape(3, -1), axis=1, dtype=np.uint32).T
    tets = np.cumsum(take("<u4", 4 * packed["tets"]).reshape(4, -1), axis=1, dtype=np.uint32).T
    peaks = dict(zip(take("<u4", packed["peaks"]), take("<f4", packed["peaks"]), strict=True))
    signed = take("u1", size).astype(np.uint16) | (take("u1", size).astype(np.uint16) << 8)
    change = ((signed >> 1) ^ (0 - (signed & 1)).astype(np.uint16)).reshape(states, 3, n)
    steps = np.cumsum(np.cumsum(change, axis=2, dtype=np.uint16), axis=0, dtype=np.uint16)
    places = np.array(packed["low"])[:, None] + packed["scale"] * steps
    shades = take("u1", len(packed["fields"]) * states * n).reshape(-1, states, n)
    assert at + 3 * n == len(raw)
    shades = np.cumsum(shades, axis=1, dtype=np.uint8)
    return triangles, tets, places.transpose(0, 2, 1), shades, peaks


def test_the_3d_view_holds_the_deformed_surface(reported_beam):
    results = read(reported_beam)
    packed = viewer.pack(results)
    triangles, tets, places, shades, _ = unpacked(packed)
    # The tets of the corners fill the half block, to the chords of what is curved.
    corners = places[0][tets]
    sizes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    channel = (LENGTH - 2 * WALL) * (HALF - WALL) * (HEIGHT - 2 * WALL)
    rounded = packed["scale"] / WALL
    assert sizes.sum() == pytest.approx(LENGTH * HALF * HEIGHT - channel, rel=rounded)
    assert len(places) == INCREMENTS + 1
    skin = surface.skin(results)
    k = np.radians(ANGLE) / LENGTH
    # Of the last state: area of base and roof by their arcs, r k = l, of the sides by the rings
    # (r2^2 - r1^2) a / 2, of the ends by H' = r2 - r1.
    roof = np.sqrt(1 + 2 * k * HEIGHT)
    depth = (roof - 1) / k
    exact = LENGTH * HALF * (1 + roof) + HEIGHT * LENGTH + 2 * HALF * depth
    outer = triangles[: packed["outer"]]
    assert len(outer) == len(skin.outer)
    assert area(places[-1], outer) == pytest.approx(exact, rel=2e-4)
    assert area(places[0], outer) == pytest.approx(
        2 * LENGTH * HALF + LENGTH * HEIGHT + 2 * HALF * HEIGHT, rel=2e-4
    )
    stress = packed["fields"][0]
    seen = stress["low"] + (stress["high"] - stress["low"]) * shades[0, -1] / 255.0
    on_roof = places[0][:, 2] > HEIGHT - 1e-3
    expected = bent_beam.state(np.array([[0, 0, HEIGHT]]), ANGLE)["von_mises"][0]
    assert seen[on_roof] == pytest.approx(min(expected, stress["high"]), abs=stress["high"] / 250)


def test_the_view_knows_the_values_above_its_colours(tmp_path):
    points, cells, surfaces = bent_beam.mesh()
    writer = ResultsWriter(tmp_path / "r", "", {})
    writer.mesh(points, cells, np.zeros(len(cells)), ["body"], surfaces, bent_beam.LAYOUT)
    stress = np.linspace(0, 0.123, len(points))
    corner = np.linalg.norm(points - [LENGTH, HALF, HEIGHT], axis=1).argmin()
    stress[corner] = 7.0
    fields = {"displacement": np.zeros_like(points), "von_mises": stress}
    writer.increment({"step": "s", "step_fraction": 1.0}, fields)
    packed = viewer.pack(read(tmp_path / "r"))
    _, _, places, shades, peaks = unpacked(packed)
    assert packed["fields"][0]["high"] < 0.2
    (value,) = set(peaks.values())
    assert value == 7.0
    for place in peaks:  # one vertex for each face that meets there
        assert places[-1][place] == pytest.approx(points[corner], abs=0.01)
        assert shades[0, -1, place] == 255


def test_the_view_outlines_what_is_held(tmp_path):
    points, cells, surfaces = bent_beam.mesh(nx=30)
    spec = bent_beam.SPEC + "supports:\n- {surface: clamp, fix: [x, y, z]}\n"
    spec += "- {surface: symmetry, fix: [y]}\n"
    writer = ResultsWriter(tmp_path / "r", spec, {})
    writer.mesh(points, cells, np.zeros(len(cells)), ["body"], surfaces, bent_beam.LAYOUT)
    fields = bent_beam.state(points, 30.0)
    writer.increment(bent_beam.row(points, fields, 1.0, 30.0), fields)
    packed = viewer.pack(read(tmp_path / "r"))
    (held,) = packed["held"]  # the symmetry plane is a cut, and nothing holds it
    assert held["name"] == "clamped face"
    ends = unpacked(packed)[2][0][np.array(held["pairs"]).reshape(-1, 2)]
    assert ends[..., 0] == pytest.approx(0.0, abs=0.02)
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum()
    assert length == pytest.approx(2 * HALF + HEIGHT, abs=0.1)  # without the side in the cut


def test_the_view_has_a_state_at_rest(tmp_path):
    points, cells, surfaces = bent_beam.mesh(nx=2, ny=2, nz=7)
    writer = ResultsWriter(tmp_path / "r", "", {})
    writer.mesh(points, cells, np.zeros(len(cells)), ["body"], surfaces, bent_beam.LAYOUT)
    fields = bent_beam.state(points, 30.0)
    writer.increment(bent_beam.row(points, fields, 1.0, 30.0), fields)
    packed = viewer.pack(read(tmp_path / "r"))
    places = unpacked(packed)[2]
    assert packed["states"][0] == "undeformed" and len(places) == 2
    assert places[0][:, 0].max() == pytest.approx(LENGTH, abs=0.01)


def test_the_colour_range_leaves_out_a_lonely_peak(tmp_path):
    points, cells, surfaces = bent_beam.mesh()
    writer = ResultsWriter(tmp_path / "r", "", {})
    writer.mesh(points, cells, np.zeros(len(cells)), ["body"], surfaces, bent_beam.LAYOUT)
    stress = np.linspace(0, 0.123, len(points))
    stress[0] = 7.0
    fields = {"displacement": np.zeros_like(points), "von_mises": stress}
    writer.increment({"step": "s", "step_fraction": 1.0}, fields)
    everywhere = np.arange(len(points))
    low, high, largest = view.colour_range(read(tmp_path / "r"), "von_mises", everywhere)
    assert (low, high, largest) == pytest.approx((0.0, 0.13, 7.0))


@pytest.mark.parametrize(
    "layout, seen",
    [
        ({}, (1, 0)),  # nothing known but the axis: it runs to the right
        ({"bending_axis": (0, 1, 0)}, (1, 0)),
        ({"bending_axis": (0, -1, 0)}, (1, 0)),
        ({"axis": (0, 0, 1), "bending_axis": (0, 1, 0)}, (0, 1)),  # upright: it runs up
        ({"axis": (0, 1, 0), "symmetry": {"symmetry": 0}}, (1, 0)),
    ],
)
def test_the_bending_plane_is_seen(reported_beam, layout, seen):
    """The axis is drawn nearly at full length, to the right or up; the frame is orthonormal."""
    plain = Layout(regions=("body",), surfaces=(), cavities={}, **layout)
    looked = view.bending_view(replace(read(reported_beam), layout=plain, surfaces={}))
    frame = np.array([looked.right, looked.up, looked.eye])
    assert frame @ frame.T == pytest.approx(np.eye(3))
    assert np.linalg.det(frame) == pytest.approx(1)
    axis = np.array(plain.axis, float)
    drawn = looked.project(axis[None])[0]
    assert drawn @ np.array(seen) > 0.9


def test_pictures_are_drawn_to_scale(reported_beam):
    """Extent of the opaque pixels against that of the projected block."""
    results = read(reported_beam)
    scene = frames.make_scene(results)
    group = scene.group([8], ghost=False, pixels=600)
    with frames.renderer() as renderer:
        renderer.draw(scene.job(group))
        ((image,),) = renderer.drawn()
    opaque = (image < 250).any(axis=-1)
    columns, rows = np.flatnonzero(opaque.any(axis=0)), np.flatnonzero(opaque.any(axis=1))
    low, high = group.low, group.high
    pixel = (high[0] - low[0]) / image.shape[1]
    margin = 0.04 / 1.08 * (high - low).max()  # at most: the frame's margin on either side
    drawn = np.array([np.ptp(columns) + 1, np.ptp(rows) + 1]) * pixel
    exact = scene.view.project(
        np.vstack([
            (results.points + results.field(8, "displacement")) * (1, sign, 1) for sign in (1, -1)
        ])
    )  # fmt: skip
    assert drawn == pytest.approx(np.ptp(exact, axis=0), abs=3 * pixel)
    assert columns[0] * pixel == pytest.approx(margin, rel=0.1)


def test_picture_files_show_colours_on_white(reported_beam):
    for name, width in (("states.png", 1200), ("shape.png", 700), ("curve.png", 1200)):
        with Image.open(reported_beam / name) as image:
            assert image.width >= width
            pixels = np.asarray(image.convert("RGB"), float)
        white = (pixels > 250).all(axis=2).mean()
        coloured = (np.ptp(pixels, axis=2) > 60).mean()
        assert 0.3 < white < 0.99
        assert coloured > (0.002 if name == "curve.png" else 0.05)


def test_obstacles_are_drawn(tmp_path):
    """An obstacle stands beside each state where its columns say, and is left out when removed."""
    directory = tmp_path / "beam"
    bent_beam.write(directory, 90.0, 2)
    text = (directory / "spec.yaml").read_text()
    block = "{type: block, center: [60 mm, 0 mm, -9 mm], size: [10 mm, 30 mm, 4 mm]}"
    (directory / "spec.yaml").write_text(f"{text}obstacles:\n  cell: {block}\n")
    table = (directory / "curve.csv").read_text().splitlines()
    columns = ["obstacle_cell_x_mm,obstacle_cell_y_mm,obstacle_cell_z_mm,contact_gap_cell_mm"]
    columns += ["0,0,-3,0.5"] * (len(table) - 2) + [",,,"]
    rows = [f"{row},{more}" for row, more in zip(table, columns, strict=True)]
    (directory / "curve.csv").write_text("\n".join(rows) + "\n")
    (body,) = obstacles.bodies(read(directory), np.zeros(3), np.full(3, 100.0))
    np.testing.assert_allclose(np.ptp(body.points, axis=0), [10, 30, 4])
    np.testing.assert_allclose(body.at(0)[:, 2].min(), -9 - 2 - 3)
    last = len(table) - 2
    assert body.seen(0) and not body.seen(last)
    np.testing.assert_allclose(body.at(-1)[:, 2].min(), -9 - 2)
    # Between two states, as in a film: linear, and there as in the later one.
    np.testing.assert_allclose(body.at(last - 0.25)[:, 2].min(), -9 - 2 - 0.25 * 3)
    assert body.seen(last - 1) and not body.seen(last - 0.25)
    scene = frames.make_scene(read(directory))
    points, _ = scene.bodies([0.5, last - 0.25], np.array([[0.0] * 3, [100.0] * 3]))
    np.testing.assert_allclose(points[0], body.points - [0, 0, 3])
    assert not points[1].any()
    (drawn,) = viewer.pack(read(directory))["bodies"]
    assert drawn["there"][-1] is False and drawn["shift"][-2][2] == -3


def test_pictures_stand_on_any_ground():
    """What white gave to the mean of a pixel is taken away, and what the ground gives added."""
    colour, cover = np.meshgrid(np.arange(256), np.arange(256), indexing="ij")
    panels = np.stack([colour, 255 - colour, colour // 2, cover], axis=-1).astype(np.uint8)
    assert (pictures._on(panels, pictures.LIGHT) == panels[..., :3]).all()
    paper = 255 * frames.colours([pictures.DARK.paper])[0]
    through = 1 - cover[..., None] / 255
    wanted = np.clip(panels[..., :3] - 255 * through + paper * through, 0, 255)
    assert np.abs(pictures._on(panels, pictures.DARK) - wanted).max() <= 0.5 + 1e-9

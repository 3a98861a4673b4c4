"""Hot spots: places, not neighbours; where they are, and their pictures."""

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from softact.report import hot_spots, pictures, surface
from softact.report.frames import colours
from softact.report.place import Places
from softact.report.view import STRESS_COLOURS
from softact.results.folder import read
from softact.results.writer import ResultsWriter
from tests import bent_beam

LENGTH, HALF, HEIGHT, WALL = (
    bent_beam.LENGTH, bent_beam.HALF_WIDTH, bent_beam.HEIGHT, bent_beam.WALL
)  # fmt: skip


def chain(values):
    """Peaks of values along a line of nodes."""
    edges = np.column_stack([np.arange(len(values) - 1), np.arange(1, len(values))])
    return hot_spots.peaks(np.array(values, float), edges)


def test_a_peak_needs_a_valley():
    assert chain([1, 5, 10, 9, 9.5, 8, 4, 7.5, 3]) == [2, 7]  # 9.5 falls by 5 % only
    assert chain([10, 8.6, 9.9]) == [0]  # 13 %
    assert chain([10, 8.4, 9.9]) == [0, 2]  # 15 % of 9.9 is 8.415
    assert chain([10, 1, 4.9]) == [0]  # less than half of the highest
    assert chain([3, 3, 3]) in ([0], [1], [2])  # a plateau is one place
    assert chain([0, 0]) == []


def folder(path, bumps, size=3.0):
    """A block at rest with a stretch of 1 + height exp(-(r/size)^2) around each (place, height)."""
    points, cells, surfaces = bent_beam.mesh()
    writer = ResultsWriter(path, "name: bumps\n", {})
    writer.mesh(points, cells, np.zeros(len(cells)), ["body"], surfaces, bent_beam.LAYOUT)
    stretch = np.ones(len(points))
    for place, height in bumps:
        far = np.linalg.norm(points - place, axis=1)
        stretch += height * np.exp(-((far / size) ** 2))
    fields = {
        "displacement": np.zeros_like(points),
        "max_principal_stretch": stretch,
        "max_principal_stress": 0.3 * (stretch - 1),
    }
    row = {"step": "s", "step_fraction": 1.0, "pressure_kPa": 10.0}
    writer.increment(row, fields)
    writer.finish("complete")
    return read(path)


ROOF, SIDE = (30.0, 0.0, HEIGHT), (90.0, HALF, 8.0)
EDGE = (60.0, HALF - WALL, WALL)  # of the channel


def test_places_and_what_is_like_them(tmp_path):
    alike = [((x, 0.0, HEIGHT), 0.5) for x in (50.0, 70.0)]  # along the axis behind the highest
    results = folder(tmp_path / "r", [(ROOF, 0.55), (SIDE, 0.4), (EDGE, 0.3), *alike])
    roof, side, edge = hot_spots.spots(results)
    assert roof.before == pytest.approx(ROOF, abs=0.01)
    assert roof.values["max_principal_stretch"] == pytest.approx(1.55, abs=1e-3)
    assert roof.values["max_principal_stress"] == pytest.approx(0.165, abs=1e-3)
    assert roof.alike == 3 and roof.reach == pytest.approx((30.0, 70.0), abs=0.01)
    assert side.before == pytest.approx(SIDE, abs=0.01) and side.alike == 1
    assert edge.before == pytest.approx(EDGE, abs=0.01)
    assert edge.words == "wall of the cavity"
    assert [spot.sharp for spot in (roof, side, edge)] == [False, False, True]


def test_re_entrant_edges(tmp_path):
    """Those of the channel, none of the block's outer ones; the cut is closed and has none."""
    results = folder(tmp_path / "r", [])
    points, sharp = results.points, hot_spots._sharp(results)
    inside = (np.abs(points - [LENGTH / 2, 0, HEIGHT / 2]) - [LENGTH / 2 - WALL, HALF - WALL,
              HEIGHT / 2 - WALL])  # fmt: skip
    wall = np.abs(inside) < 1e-6
    within = (inside < 1e-6).all(axis=1)
    expected = within & (wall.sum(axis=1) >= 2)
    assert (sharp == expected).all() and expected.sum() > 100


def test_words(tmp_path):
    results = folder(tmp_path / "r", [])
    words = Places(results).words

    def at(*place):
        return words(int(np.linalg.norm(results.points - place, axis=1).argmin()))

    assert at(60, 4, 0) == "strain limiting layer"
    assert at(0, 4, 6) == "clamped face"
    assert at(0, 4, 0) == "edge of the clamped face and the strain limiting layer"
    assert at(60, 7, 7) == "inside the wall"


def test_pictures_show_the_place_in_the_middle(tmp_path):
    """In the middle stands the colour of the highest value, also on the wall of the channel, which
    is seen from within: what stands before it is cut away."""
    results = folder(tmp_path / "r", [(ROOF, 0.5), ((60.0, 3.0, WALL), 0.4)], size=5.0)
    found = hot_spots.spots(results)
    with pictures.drawing(results, lambda: surface.skin(results), found) as finish:
        drawn = finish()
    assert not drawn.fault and len(drawn.spots) == len(found) == 2
    red = 255 * colours(STRESS_COLOURS)[-1]
    for picture in drawn.spots:
        image = np.asarray(Image.open(BytesIO(picture)).convert("RGBA"), float)
        high, wide, _ = image.shape
        middle = image[high // 2 - 2 : high // 2 + 2, wide // 2 - 2 : wide // 2 + 2].mean((0, 1))
        assert middle[3] > 250
        hue = middle[:3] / middle[:3].sum()
        assert np.abs(hue - red / red.sum()).max() < 0.12  # lit, so darker or lighter
    for name in ("shape.png", "states.png"):
        light = np.asarray(Image.open(tmp_path / "r" / name).convert("RGB"))
        dark = np.asarray(Image.open(BytesIO(drawn.both[name][1])).convert("RGB"))
        assert light.shape == dark.shape
        assert light[-1, 0].tolist() == [255, 255, 255]
        # WebP rounds.
        assert np.abs(dark[-1, 0].astype(int) - [0x12, 0x18, 0x1D]).max() <= 1

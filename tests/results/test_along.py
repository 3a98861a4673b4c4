"""Curvature, twist and stretch along the axis, against motions with closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from softact.mesh.layout import Layout
from softact.results import along
from softact.results.folder import read
from softact.results.writer import ResultsWriter
from softact.system.rotation import rotation_about
from tests import bent_beam

LENGTH = bent_beam.LENGTH


def write(folder, move, layout=bent_beam.LAYOUT, states=1):
    """A result folder of the half block of ``bent_beam`` after the map ``move``: its resolved
    points (n, 3) to their places (n, 3)."""
    points, cells, surfaces = bent_beam.mesh()
    writer = ResultsWriter(folder, "name: r\n", {})
    writer.mesh(points, cells, np.zeros(len(cells)), ["body"], surfaces, layout)
    for n in range(states + 1):
        row = {"pressure_kPa": 10.0 * n, "bending_angle_deg": 0.0}
        moved = move(points) - points
        writer.increment(row, {"displacement": moved * (n == states)})
    writer.finish("complete")
    return read(folder)


def test_a_block_bent_to_an_arc_has_one_curvature(tmp_path):
    """Rivlin's flexure by 200 degrees: k = 200 degrees over 120 mm everywhere, about +y. The first
    and last slice have an end wall on one side, which counts to first order only. Without the
    layout's word it is about the direction that is seen."""
    bent_beam.write(tmp_path / "r", bent_beam.ANGLE, 4)
    results = read(tmp_path / "r")
    found = along.along(results)
    assert len(found.places) == 23
    for state in range(5):
        wanted = np.radians(bent_beam.ANGLE) * state / 4 / LENGTH
        np.testing.assert_allclose(found.curvature[state, 1:-1], wanted, rtol=1e-6, atol=1e-12)
        np.testing.assert_allclose(found.curvature[state], wanted, rtol=0.03, atol=1e-12)
    np.testing.assert_allclose([found.across, found.twist], 0, atol=1e-12)
    assert found.turns_deg[0] == pytest.approx(
        bent_beam.ANGLE * np.ptp(found.places) / LENGTH, rel=3e-3
    )
    free = replace(results, layout=replace(results.layout, bending_axis=None))
    np.testing.assert_allclose(along.along(free).curvature, found.curvature, atol=1e-12)


def rod(points, curvature, twist, stretch, parts=4000):
    """Places of points whose sections stay rigid while their axis has these strains.

    curvature, twist (rad/mm) and stretch: functions of the place on the undeformed axis; the rod is
    integrated by the midpoint rule.
    """
    step = LENGTH / parts
    frame, centre, frames, centres = np.eye(3), np.zeros(3), [np.eye(3)], [np.zeros(3)]
    for s in (np.arange(parts) + 0.5) * step:
        vector = np.array([twist(s), curvature(s), 0.0]) * step
        size = np.linalg.norm(vector)
        turn, half = np.eye(3), np.eye(3)
        if size:
            turn, half = (rotation_about(vector, np.degrees(size * part)) for part in (1, 0.5))
        centre = centre + stretch(s) * step * (frame @ half)[:, 0]
        frame = frame @ turn
        frames.append(frame)
        centres.append(centre)
    at = np.rint(points[:, 0] / step).astype(int)
    flat = points * [0.0, 1.0, 1.0]
    return np.array(centres)[at] + np.einsum("nij,nj->ni", np.array(frames)[at], flat)


WHOLE = replace(bent_beam.LAYOUT, symmetry={})


def test_a_rod_is_found_as_it_was_made(tmp_path):
    """Curvature that grows with the length, a twist, and a stretch that differs: each is found at
    its place. The half block stands for a whole, which is not symmetric."""
    strains = {
        "curvature": lambda s: 0.02 * s / LENGTH,
        "twist": lambda s: 0.005 + 0 * s,
        "stretch": lambda s: 1 + 0.3 * s / LENGTH,
    }
    results = write(tmp_path / "r", lambda points: rod(points, **strains), WHOLE)
    found = along.along(results)
    vectors = np.column_stack([found.curvature[1], found.across[1]])
    wanted = strains["curvature"](found.places)
    np.testing.assert_allclose(vectors[1:-1, 0], wanted[1:-1], atol=0.005 * 0.02)
    np.testing.assert_allclose(vectors[:, 0], wanted, atol=0.02 * 0.02)
    np.testing.assert_allclose(vectors[:, 1], 0, atol=0.02 * 0.02)
    np.testing.assert_allclose(found.twist[1], 0.005, rtol=0.04)
    # The centre lies beside the rod's axis, so its line is longer or shorter by the curvature.
    y, z = 4.0, 7.0
    found_at = found.stretch[1] - strains["stretch"](found.places)
    assert np.abs(found_at).max() < 0.02 * (y + z)
    rows = along.rows(results, found)
    assert list(rows[0]) == ["state", "pressure_kPa", *along.COLUMNS]
    assert rows[-1]["pressure_kPa"] == 10.0 and len(rows) == 2 * 23
    assert rows[-1]["curvature_per_m"] == pytest.approx(1e3 * wanted[-1], rel=0.02)
    assert rows[-1]["twist_deg_per_m"] == pytest.approx(np.degrees(5.0), rel=0.04)


def test_a_stretched_block_has_that_stretch_and_no_curvature(tmp_path):
    results = write(tmp_path / "r", lambda points: points * [1.3, 0.9, 0.9])
    found = along.along(results)
    np.testing.assert_allclose(found.stretch, [[1.0] * 23, [1.3] * 23], rtol=1e-5)
    np.testing.assert_allclose([found.curvature, found.twist], 0, atol=1e-12)
    assert max(found.turns_deg) < 1e-9


def test_more_slices_come_nearer(tmp_path, monkeypatch):
    """Half of the slices: four times the error of a curvature that is no straight line."""
    curvature = lambda s: 0.02 * np.sin(np.pi * s / LENGTH)  # noqa: E731
    made = lambda points: rod(points, curvature, lambda s: 0.0, lambda s: 1.0)  # noqa: E731
    results, errors = write(tmp_path / "r", made, WHOLE), []
    for count in (6, 12):
        monkeypatch.setattr(along, "MOST_SLICES", count)
        found = along.along(results)
        middle = np.argmin(np.abs(found.places - LENGTH / 2))
        errors.append(abs(found.curvature[1][middle] - curvature(found.places[middle])))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.2)


def test_where_there_is_no_axis_there_is_nothing(tmp_path):
    no_tip = Layout(regions=("body",), surfaces=(), cavities={}, tip="", length=LENGTH)
    assert along.along(write(tmp_path / "r", lambda points: points, no_tip)) is None
    short = replace(WHOLE, length=5.0)
    assert along.along(write(tmp_path / "s", lambda points: points, short)) is None

"""The workspace of the tip: sizes by hand, what is none, and its part of a sweep's page."""

from itertools import product

import numpy as np
import pytest

from softact.sweep import compute as computing
from softact.sweep import sweep_page, table, workspace
from softact.sweep.cache import Cache
from softact.sweep.spec import Sweep, read
from softact.sweep.study import locally, open_study
from tests.browsing import DESK, PHONE, assert_quiet_and_fits
from tests.report.test_headline import write
from tests.sweep.folders import CUBE


def rows(*points, status="complete"):
    """Rows of a sweep from pairs of a tip and pressures: name -> kPa."""
    return [
        {"point": n, "status": status, **dict(zip(workspace.TIP, map(float, tip), strict=True)),
         **{f"pressure_{name}_kPa": float(value) for name, value in pressures.items()}}
        for n, (tip, pressures) in enumerate(points)
    ]  # fmt: skip


def flat(left=(0, 10, 20), right=(0, 5)):
    return rows(*(((2 * p, 1, 3 * q), {"left": p, "right": q}) for p, q in product(left, right)))


def test_a_flat_workspace_is_an_area():
    """x from 0 to 40 mm, z from 0 to 15 mm, filled to its corners: 600 mm²."""
    found = workspace.workspace(flat())
    np.testing.assert_allclose(found.spans, [40, 0, 15])
    assert found.hull() == pytest.approx((600, 2))
    (section,) = workspace.sections(flat())
    text = str(section.body)
    assert "Reach along x" in text and "Reach along y" not in text
    assert ">600" in text and "mm²" in text


def test_a_workspace_in_space_is_a_volume():
    """The corners of a box of 2 by 3 by 4 mm, turned; and pictures along the third coordinate."""
    turn = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    corners = [((turn @ (2 * p, 3 * q, 4 * r)), {"a": p, "b": q, "c": r})
               for p, q, r in product((0, 1), repeat=3)]  # fmt: skip
    found = workspace.workspace(rows(*corners))
    assert found.hull() == pytest.approx((24, 3))
    assert len(workspace._plots(found)) == 3 + 2


def test_pressures_that_go_together_are_no_workspace():
    """One pressure, two that are alike, and two of which one falls as the other grows."""
    one = [((p, 0, p * p), {"left": p}) for p in range(5)]
    alike = [((p, 0, p * p), {"left": p, "right": 2 * p}) for p in range(5)]
    against = [((p, 0, p * p), {"left": p, "right": 40 - p}) for p in range(5)]
    for some in (one, alike, against):
        assert workspace.sections(rows(*some)) == []


def test_what_has_no_tip_or_was_not_solved_is_left_out():
    without = [{k: v for k, v in row.items() if k != "tip_y_mm"} for row in flat()]
    assert workspace.sections(without) == []
    failed = flat() + rows(((900, 0, 900), {"left": 90, "right": 90}), status="failed")
    np.testing.assert_allclose(workspace.workspace(failed).spans, [40, 0, 15])
    early = flat() + rows(((50, 0, 5), {"left": 21, "right": 2}), status="no_equilibrium")
    assert workspace.workspace(early).spans[0] == 50
    still = rows(*(((1, 1, 1), {"left": p, "right": q}) for p, q in product((0, 1), repeat=2)))
    assert workspace.sections(still) == []


def test_a_tip_that_moves_on_a_line_has_no_hull():
    line = [((p + q, 0, p + q), {"left": p, "right": q}) for p, q in product((0, 1, 2), repeat=2)]
    assert workspace.workspace(rows(*line)).hull() == (0.0, 1)
    assert "hull" not in str(workspace.sections(rows(*line))[0].body).split("The hull")[0].lower()


SWEEP = f"""{CUBE}
axes:
  - {{path: geometry.length, values: [4 mm, 6 mm, 8 mm]}}
  - {{path: geometry.width, values: [4 mm, 5 mm]}}
"""


def instead_of_run(spec, directory, status="complete", **options):
    """Pressures of as many kPa as the block has millimetres, and a tip in proportion."""
    left, right = spec.geometry.length, spec.geometry.width
    last = {"pressure_left_kPa": left, "pressure_right_kPa": right, "tip_x_mm": 5 * left,
            "tip_y_mm": 0.0, "tip_z_mm": 7 * right, "bending_angle_deg": left}  # fmt: skip
    write(directory, [dict.fromkeys(last, 0.0), last], status)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    top = tmp_path_factory.mktemp("workspace")
    (top / "sweep.yaml").write_text(SWEEP)
    sweep, base = read(top / "sweep.yaml", Sweep)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(computing, "run", instead_of_run)
        study = open_study(sweep, base, Cache(top / "runs"))
        study.compute(locally(1), lambda point, answer: None)
    (top / "sweep.html").write_text(sweep_page.html(study, table.rows(study), b"x\n1\n", [], []))
    return top / "sweep.html"


@pytest.mark.parametrize("width", [PHONE, DESK])
def test_the_cloud_on_the_page(browser, page, width):
    """20 by 7 mm: 140 mm². Each point has the colour of its pressure, and stands in the CSV."""
    browser.open(page, width)
    assert_quiet_and_fits(browser)
    cards = browser.run("return [...document.querySelectorAll('#workspace .card')].map("
                        "c => c.textContent)")  # fmt: skip
    assert cards[-1].startswith("Convex hull140")
    x, z, colours = browser.run(
        "const t = document.querySelectorAll('#workspace .js-plotly-plot')[1].data[0];"
        "return [t.x, t.y, t.marker.color];"
    )
    assert sorted(x) == [20, 20, 30, 30, 40, 40] and set(z) == {28, 35}
    assert colours == [value / 7 for value in z]
    heads, *lines = browser.csv("Tip z over x, colour: pressure left")
    assert heads[:3] == ["point", "status", "Pressure left (kPa)"] and len(lines) == 6

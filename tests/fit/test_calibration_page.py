"""The page of a calibration: what it shows is what was found, on a phone and on a desk."""

import numpy as np
import pytest

from softact.fit.calibration import Calibration, Trial
from softact.fit.calibration_page import html
from softact.fit.knobs import Knob
from softact.measured.curve import Measured
from softact.spec import loads
from tests.browsing import DESK, PHONE, assert_quiet_and_fits

X = np.array([30.0, 10.0, 20.0])  # not in order, as a test may be written down
SPEC = """
name: finger
geometry: {type: pneunet, chambers: 2, mesh_size: 6 mm}
materials: {body: {law: yeoh, c10: 0.11 MPa, c20: 0.02 MPa}}
steps: [{name: inflate, pressure: 30 kPa}]
"""
C10, C20 = "materials.body.c10", "materials.body.c20"


def angle(c10, c20):
    return X / c10 - X**2 * c20


def outcome(folder, covariance=((4e-6, -1e-6), (-1e-6, 1e-6)), remarks=()):
    """Four runs, the third of which ended early; the second is the best."""
    knobs = [Knob(C10, 0.11, "MPa", 0.011, 1.1), Knob(C20, 0.02, "MPa", 0.002, 0.2)]
    measured = Measured("angle.csv", "pressure_kPa",
                        {"pressure_kPa": X, "bending_angle_deg": angle(0.15, 0.03)})  # fmt: skip
    trials = [
        Trial(values, {"bending_angle_deg": angle(*values)}, folder)
        for values in ((0.11, 0.02), (0.149, 0.03), (0.1, 0.02))
    ]
    trials.insert(2, Trial((0.02, 0.02), None, folder))
    covariance = np.array(covariance)
    with np.errstate(invalid="ignore"):
        interval = 2 * np.sqrt(np.diag(covariance))
    found = (loads(SPEC), knobs, measured, trials[0], trials[1], interval, covariance, trials)
    return Calibration(*found, remarks=list(remarks))


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calibration")
    path = folder / "calibration.html"
    path.write_text(html("finger", outcome(folder), SPEC, folder / "run"), encoding="utf-8")
    return path


def data(browser, title):
    """Traces of the plot of that title: name -> (x, y)."""
    found = browser.run(
        "const f = [...document.querySelectorAll('figure.chart')].find("
        "f => f.querySelector('b').textContent === arguments[0]);"
        "return f.querySelector('.js-plotly-plot').data.map(t => [t.name, t.x, t.y]);", title,
    )  # fmt: skip
    return {name: (np.array(x, float), np.array(y, float)) for name, x, y in found}


@pytest.mark.parametrize("width", [PHONE, DESK])
def test_quiet_and_fits(browser, page, width):
    assert_quiet_and_fits(browser.open(page, width), plots=4)


def test_the_curves_are_those_of_the_runs(browser, page):
    """Measured, before and calibrated, along the pressure; and what is left of them."""
    browser.open(page, DESK)
    shown, order = data(browser, "Bending angle"), np.argsort(X)
    for name, values in (("measured", (0.15, 0.03)), ("before", (0.11, 0.02)),
                         ("calibrated", (0.149, 0.03))):  # fmt: skip
        np.testing.assert_allclose(shown[name][0], X[order])
        np.testing.assert_allclose(shown[name][1], angle(*values)[order], rtol=1e-6)
    left = data(browser, "Bending angle: run minus measured")["calibrated"][1]
    np.testing.assert_allclose(left, (X / 0.149 - X / 0.15)[order], rtol=1e-4)


def test_the_history_has_every_run(browser, page):
    """The misfit by hand; none of the run that ended early; the best so far never rises."""
    browser.open(page, DESK)
    shown = data(browser, "Misfit of each run")
    truth = angle(0.15, 0.03)
    wanted = [
        100 * np.sqrt(np.mean((angle(*values) - truth) ** 2)) / truth.max()
        for values in ((0.11, 0.02), (0.149, 0.03), (0.1, 0.02))
    ]
    np.testing.assert_allclose(shown["runs"][1][[0, 1, 3]], wanted, rtol=1e-6)
    assert np.isnan(shown["runs"][1][2])
    np.testing.assert_allclose(shown["best so far"][1], [wanted[0], *[wanted[1]] * 3], rtol=1e-6)
    way = data(browser, "Constants of each run")
    np.testing.assert_allclose(way[C10][1], np.array([0.11, 0.149, 0.02, 0.1]) / 0.11, rtol=1e-6)


def test_the_constants_stand_with_their_confidence(browser, page):
    browser.open(page, DESK)
    cells = "return [...document.querySelectorAll('#constants table')].map(t => "
    cells += "[...t.querySelectorAll('tbody tr')].map(r => [...r.cells].map(c => c.textContent)))"
    constants, correlation = browser.run(cells)
    assert constants[0] == [C10, "0.149", "0.004", "MPa", "0.11", "0.011", "1.1"]
    assert constants[1][:3] == [C20, "0.03", "0.002"]
    assert correlation[0][1:] == ["1", "−0.5"]  # −1e-6 over the root of 4e-6 times 1e-6


@pytest.mark.parametrize(
    ("covariance", "word"), [(np.full((2, 2), np.inf), "not determined"),
                             (np.full((2, 2), np.nan), "at a bound")],
)  # fmt: skip
def test_what_is_not_known_is_said(tmp_path, covariance, word):
    """In the table, with an amber head; and there is no correlation of it."""
    text = html("finger", outcome(tmp_path, covariance, ["a remark"]), SPEC, tmp_path / "run")
    assert text.count(word) == 2 and "Correlation" not in text
    assert "a remark" in text and "banner warn" in text

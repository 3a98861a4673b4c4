"""report.html in headless Chromium: no error, and the slider moves the shape."""

import time
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from softact.report import pictures, write_report
from tests import bent_beam
from tests.browsing import DESK, PHONE, assert_quiet_and_fits

ANGLE, INCREMENTS = 180.0, 6
PLACES = "const t = document.getElementById('shape').data[0]; return [t.x, t.y, t.z].map("
PLACES += "a => Array.from(a));"


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    directory = tmp_path_factory.mktemp("browser") / "beam"
    bent_beam.write(directory, ANGLE, INCREMENTS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pictures, "drawing", bent_beam.undrawn)
        return write_report(directory)


@pytest.fixture(scope="module", params=[PHONE, DESK])
def page(request, report, browser):
    """The report, opened at the width of a phone and of a desk."""
    return browser.open(report, request.param)


def slide(browser, state):
    """Move the slider as a reader does, and wait for the drawing."""
    browser.run(
        "const s = document.getElementById('load'); s.value = arguments[0];"
        "window.drawn = false;"
        "document.getElementById('shape').once('plotly_afterplot', () => window.drawn = true);"
        "s.dispatchEvent(new Event('input'));",
        state,
    )
    browser.wait("return window.drawn")


def picture(browser):
    """(height, width, 3) what the 3-D view shows."""
    shape = browser.driver.find_element("id", "shape")
    browser.run("arguments[0].scrollIntoView()", shape)
    time.sleep(0.3)
    return np.asarray(Image.open(BytesIO(shape.screenshot_as_png)).convert("RGB"), float)


def test_quiet_and_fits(page):
    assert_quiet_and_fits(page)
    level = page.run("return document.getElementById('curvature_per_m').data.at(-1).y")
    np.testing.assert_allclose(level[1:-1], 1e3 * np.radians(ANGLE) / bent_beam.LENGTH, rtol=1e-4)
    for section, plots in (("curves", 4), ("convergence", 2)):
        drawn = page.run(f"return document.querySelectorAll('#{section} .js-plotly-plot').length")
        assert drawn >= plots


@pytest.mark.parametrize("state", [0, INCREMENTS // 2, INCREMENTS])
def test_the_slider_moves_the_shape(page, state):
    """Vertices of the bent block: its base is an arc of length L, its roof one of radius r."""
    slide(page, INCREMENTS - state)
    before = np.array(page.run(PLACES))
    slide(page, state)
    x, y, z = after = np.array(page.run(PLACES))
    angle = np.radians(ANGLE) * state / INCREMENTS
    width, height, length = bent_beam.HALF_WIDTH, bent_beam.HEIGHT, bent_beam.LENGTH
    if angle:  # at 90 degrees and more, the roof's circle reaches its own radius
        radius = length / angle
        roof = np.sqrt(radius**2 + 2 * height * radius)
        reach, top = roof, roof - radius
    else:
        reach, top = length, height
    assert x.max() == pytest.approx(reach, abs=0.1)
    assert z.max() == pytest.approx(top, abs=0.01)
    assert (y.min(), y.max()) == pytest.approx((-width, width), abs=0.01)
    if state != INCREMENTS - state:
        assert np.abs(after - before).max() > length / 2
    said = page.driver.find_element("id", "caption").text
    assert f"{bent_beam.PRESSURE * state / INCREMENTS:g} kPa" in said
    assert f"{np.degrees(angle):g}°" in said


def test_the_slider_answers_the_keyboard(page):
    from selenium.webdriver.common.keys import Keys

    slide(page, INCREMENTS)
    page.driver.find_element("id", "load").send_keys(Keys.ARROW_LEFT)
    said = f"{bent_beam.PRESSURE * (INCREMENTS - 1) / INCREMENTS:.4g} kPa"
    page.wait(f"return document.getElementById('caption').textContent.includes('{said}')")


def test_the_view_really_shows_the_shape(page):
    slide(page, 0)
    straight = picture(page)
    slide(page, INCREMENTS)
    bent = picture(page)
    for seen in (straight, bent):
        assert (np.ptp(seen, axis=2) > 60).mean() > 0.01  # coloured by stress, not blank
    assert (np.abs(straight - bent).max(axis=2) > 60).mean() > 0.01


def test_the_camera_stays_when_the_load_changes(page):
    page.driver.execute_async_script(
        "const done = arguments[0];"
        "Plotly.relayout('shape', {'scene.camera.eye': {x: 0.1, y: -2, z: 0.7}}).then(() => done())"
    )
    slide(page, 2)
    eye = page.run("return document.getElementById('shape')._fullLayout.scene.camera.eye")
    assert eye == {"x": 0.1, "y": -2, "z": 0.7}


def test_cut_open_shows_the_half_with_its_cavity(page):
    before = page.run(PLACES)
    faces = "return document.getElementById('shape').data[0].i.length"
    closed = page.run(faces)
    box = page.driver.find_element("id", "cut")
    page.run("arguments[0].click()", box)
    page.wait(f"{faces} !== {closed}")
    x, y, _ = np.array(page.run(PLACES))
    assert 2 * len(x) == len(before[0])
    assert y.min() == pytest.approx(0, abs=0.01)
    page.run("arguments[0].click()", box)
    page.wait(f"{faces} === {closed}")


def test_the_field_can_be_chosen(page):
    top = "return document.getElementById('shape').data[0].cmax"
    before = page.run(top)
    page.run(
        "const f = document.getElementById('field'); f.value = 2;"
        "f.dispatchEvent(new Event('change'));"
    )
    page.wait(f"{top} !== {before}")
    assert page.run(top) > 1  # a stretch
    title = "return document.getElementById('shape')._fullData[0].colorbar.title.text"
    assert "stretch" in page.run(title)


def test_play_runs_through_the_states_and_can_be_stopped(page):
    slide(page, INCREMENTS)
    play = page.driver.find_element("id", "play")
    state = "return Number(document.getElementById('load').value)"
    page.run("arguments[0].click()", play)  # from the last state on: from the first
    page.wait(f"{state} < {INCREMENTS}")
    page.run("arguments[0].click()", play)
    page.wait("return document.getElementById('play').textContent === '\u25b6'")
    stopped = page.run(state)
    assert stopped < INCREMENTS
    page.driver.execute_async_script("setTimeout(arguments[0], 500)")
    assert page.run(state) == stopped
    page.run("arguments[0].click()", play)
    page.wait(f"{state} === {INCREMENTS}")
    page.wait("return document.getElementById('play').textContent === '\u25b6'")
    said = page.driver.find_element("id", "caption").text
    assert f"{bent_beam.PRESSURE:g} kPa" in said and f"{ANGLE:g}°" in said
    z = page.run(PLACES)[2]
    length = bent_beam.LENGTH
    roof = length / np.pi + 2 * bent_beam.HEIGHT
    assert max(z) == pytest.approx(np.sqrt(roof * length / np.pi) - length / np.pi, abs=0.01)

"""report.html in headless Chromium: no error, and the slider moves the shape."""

import shutil
import time
from contextlib import nullcontext
from io import BytesIO

import bent_beam
import numpy as np
import pytest
from PIL import Image

from softact.report import pictures, write_report

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(
    not (CHROMIUM and DRIVER), reason="needs chromium and chromium-driver (apt)"
)
selenium = pytest.importorskip("selenium", reason="needs selenium (pip install softact[dev])")

FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--enable-unsafe-swiftshader", "--hide-scrollbars",
)  # fmt: skip
ANGLE, INCREMENTS = 180.0, 6
PLACES = "const t = document.getElementById('shape').data[0]; return [t.x, t.y, t.z].map("
PLACES += "a => Array.from(a));"


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    directory = tmp_path_factory.mktemp("browser") / "beam"
    bent_beam.write(directory, ANGLE, INCREMENTS)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pictures, "drawing", lambda results, parts: nullcontext(lambda: "left out"))
        return write_report(directory)


@pytest.fixture(scope="module", params=[390, 1400])
def page(request, report, tmp_path_factory):
    """The report, opened at the width of a phone and of a desk."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    try:
        size = {"width": request.param, "height": 850, "deviceScaleFactor": 1}
        driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride", {**size, "mobile": request.param < 600}
        )
        driver.set_script_timeout(60)
        driver.get(report.as_uri())
        wait_for(driver, "return document.body.dataset.ready !== undefined", 60)
        yield driver
    finally:
        driver.quit()


def wait_for(driver, script, seconds=20):
    """Wait until ``script`` returns something true; returns it."""
    end = time.monotonic() + seconds
    while not (value := driver.execute_script(script)):
        assert time.monotonic() < end, f"not within {seconds} s: {script}"
        time.sleep(0.05)
    return value


def slide(driver, state):
    """Move the slider as a reader does, and wait for the drawing."""
    driver.execute_script(
        "const s = document.getElementById('load'); s.value = arguments[0];"
        "window.drawn = false;"
        "document.getElementById('shape').once('plotly_afterplot', () => window.drawn = true);"
        "s.dispatchEvent(new Event('input'));",
        state,
    )
    wait_for(driver, "return window.drawn")


def picture(driver):
    """(height, width, 3) what the 3-D view shows."""
    shape = driver.find_element("id", "shape")
    driver.execute_script("arguments[0].scrollIntoView()", shape)
    time.sleep(0.3)
    return np.asarray(Image.open(BytesIO(shape.screenshot_as_png)).convert("RGB"), float)


def test_drawn_without_console_errors(page):
    assert page.execute_script("return document.body.dataset.ready") == "yes"
    assert len(page.find_elements("css selector", "#curves .js-plotly-plot")) >= 4
    assert len(page.find_elements("css selector", "#convergence .js-plotly-plot")) == 2
    log = page.get_log("browser")
    assert [entry for entry in log if entry["level"] in ("SEVERE", "ERROR")] == []


def test_nothing_is_fetched(page):
    asked = page.execute_script(
        "return performance.getEntriesByType('resource').map(e => e.name)"
        ".filter(n => !n.startsWith('data:') && !n.startsWith('blob:'))"
    )
    assert asked == []


def test_nothing_sticks_out(page):
    width, content = page.execute_script(
        "return [window.innerWidth, document.documentElement.scrollWidth]"
    )
    assert content <= width


@pytest.mark.parametrize("state", [0, INCREMENTS // 2, INCREMENTS])
def test_the_slider_moves_the_shape(page, state):
    """Vertices of the bent block: its base is an arc of length L, its roof one of radius r."""
    slide(page, INCREMENTS - state)
    before = np.array(page.execute_script(PLACES))
    slide(page, state)
    x, y, z = after = np.array(page.execute_script(PLACES))
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
    said = page.find_element("id", "caption").text
    assert f"{bent_beam.PRESSURE * state / INCREMENTS:g} kPa" in said
    assert f"{np.degrees(angle):g}°" in said


def test_the_slider_answers_the_keyboard(page):
    from selenium.webdriver.common.keys import Keys

    slide(page, INCREMENTS)
    page.find_element("id", "load").send_keys(Keys.ARROW_LEFT)
    said = f"{bent_beam.PRESSURE * (INCREMENTS - 1) / INCREMENTS:.4g} kPa"
    wait_for(page, f"return document.getElementById('caption').textContent.includes('{said}')")


def test_the_view_really_shows_the_shape(page):
    slide(page, 0)
    straight = picture(page)
    slide(page, INCREMENTS)
    bent = picture(page)
    for seen in (straight, bent):
        assert (np.ptp(seen, axis=2) > 60).mean() > 0.01  # coloured by stress, not blank
    assert (np.abs(straight - bent).max(axis=2) > 60).mean() > 0.01


def test_the_camera_stays_when_the_load_changes(page):
    page.execute_async_script(
        "const done = arguments[0];"
        "Plotly.relayout('shape', {'scene.camera.eye': {x: 0.1, y: -2, z: 0.7}}).then(() => done())"
    )
    slide(page, 2)
    eye = page.execute_script(
        "return document.getElementById('shape')._fullLayout.scene.camera.eye"
    )
    assert eye == {"x": 0.1, "y": -2, "z": 0.7}


def test_cut_open_shows_the_half_with_its_cavity(page):
    before = page.execute_script(PLACES)
    faces = "return document.getElementById('shape').data[0].i.length"
    closed = page.execute_script(faces)
    box = page.find_element("id", "cut")
    page.execute_script("arguments[0].click()", box)
    wait_for(page, f"{faces} !== {closed}")
    x, y, _ = np.array(page.execute_script(PLACES))
    assert 2 * len(x) == len(before[0])
    assert y.min() == pytest.approx(0, abs=0.01)
    page.execute_script("arguments[0].click()", box)
    wait_for(page, f"{faces} === {closed}")


def test_the_field_can_be_chosen(page):
    top = "return document.getElementById('shape').data[0].cmax"
    before = page.execute_script(top)
    page.execute_script(
        "const f = document.getElementById('field'); f.value = 2;"
        "f.dispatchEvent(new Event('change'));"
    )
    wait_for(page, f"{top} !== {before}")
    assert page.execute_script(top) > 1  # a stretch
    title = "return document.getElementById('shape')._fullData[0].colorbar.title.text"
    assert "stretch" in page.execute_script(title)

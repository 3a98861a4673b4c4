"""report.html in headless Chromium: no error, and the slider moves the shape."""

import time
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from softact.mesh.boundary import among, exterior
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


PLAY_AND_STOP = """
const [play, last, done] = arguments, load = document.getElementById("load");
const look = () => {
  if (Number(load.value) > 0 && Number(load.value) < last) { play.click(); done(); }
  else setTimeout(look, 5);
};
play.click();
look();
"""


def test_play_runs_through_the_states_and_can_be_stopped(page):
    slide(page, INCREMENTS)
    play = page.driver.find_element("id", "play")
    state = "return Number(document.getElementById('load').value)"
    # From the last state on: from the first. Stopped by the page itself, however busy the machine.
    page.driver.execute_async_script(PLAY_AND_STOP, play, INCREMENTS)
    page.wait("return document.getElementById('play').textContent === '\u25b6'")
    stopped = page.run(state)
    assert 0 < stopped < INCREMENTS
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


TOLD = "return [...document.querySelectorAll('#picked tr')].map(r => "
TOLD += "[...r.cells].map(c => c.textContent.replaceAll('\u2212', '-')));"


def choose(browser, control, value):
    """Set a control as a reader does, and wait until the surface is drawn anew."""
    browser.run(
        "const c = document.getElementById(arguments[0]), value = arguments[1];"
        "window.drawn = false;"
        "document.getElementById('shape').once('plotly_afterplot', () => window.drawn = true);"
        "if (c.type === 'checkbox') c.checked = value; else c.value = value;"
        "c.dispatchEvent(new Event(c.type === 'range' ? 'input' : 'change'));",
        control,
        value,
    )
    browser.wait("return window.drawn")
    time.sleep(0.2)  # the other traces follow


def surface(browser):
    """Points (n, 3) and triangles (m, 3) of what is drawn."""
    arrays = browser.run(
        "const t = document.getElementById('shape').data[0];"
        "return ['x', 'y', 'z', 'i', 'j', 'k'].map(a => Array.from(t[a]));"
    )
    return np.array(arrays[:3]).T, np.array(arrays[3:], int).T


@pytest.mark.parametrize("state", [0, INCREMENTS])
def test_a_section_closes_what_it_leaves(page, state):
    """The half block up to X = c is closed by the face of the cut, with the volume that the
    material there has in any state: flexure keeps volumes."""
    slide(page, state)
    choose(page, "cut", True)
    choose(page, "sectionaxis", "0")
    choose(page, "sectionat", 30)
    points, triangles = surface(page)
    at = bent_beam.LENGTH * 30.5 / 100
    assert page.driver.find_element("id", "sectionsaid").text == f"x = {at:.1f} mm"
    height, half, wall = bent_beam.HEIGHT, bent_beam.HALF_WIDTH, bent_beam.WALL
    solid = at * half * height - (at - wall) * (half - wall) * (height - 2 * wall)
    a, b, c = (points[triangles[:, n]] for n in range(3))
    assert (a * np.cross(b, c)).sum() / 6 == pytest.approx(solid, rel=2e-3)
    if state == 0:
        used = points[np.unique(triangles)]
        assert used[:, 0].max() == pytest.approx(at, abs=0.02)
    choose(page, "sectionother", True)
    points, triangles = surface(page)
    a, b, c = (points[triangles[:, n]] for n in range(3))
    channel = (bent_beam.LENGTH - 2 * wall) * (half - wall) * (height - 2 * wall)
    rest = bent_beam.LENGTH * half * height - channel - solid
    assert (a * np.cross(b, c)).sum() / 6 == pytest.approx(rest, rel=2e-3)
    choose(page, "sectionother", False)
    choose(page, "sectionaxis", "")
    choose(page, "cut", False)


def test_a_click_tells_place_and_values(page):
    """The middle of the side Y = -W/2, seen straight on; then where it goes to."""
    slide(page, 0)
    page.run("document.getElementById('fit').click()")
    page.driver.execute_async_script(
        "const done = arguments[0];"
        "Plotly.relayout('shape', {'scene.camera': {eye: {x: 0, y: -2, z: 0},"
        " up: {x: 0, y: 0, z: 1}, center: {x: 0, y: 0, z: 0},"
        " projection: {type: 'orthographic'}}}).then(() => done())"
    )
    time.sleep(0.5)
    left, top, wide, high = page.run(
        "document.getElementById('shape').scrollIntoView();"
        "const r = document.querySelector('#shape .gl-container canvas').getBoundingClientRect();"
        "return [r.left, r.top, r.width, r.height];"
    )
    page.click(left + wide / 2, top + high / 2)
    page.wait("return !document.getElementById('picked').hidden")
    told = dict(page.run(TOLD))

    def place(text):
        return [float(part) for part in text.split(" mm")[0].split(",")]

    length, height = bent_beam.LENGTH, bent_beam.HEIGHT
    middle = place(told["Undeformed at x, y, z"])
    wanted = [length / 2, -bent_beam.HALF_WIDTH, height / 2]
    assert middle == pytest.approx(wanted, abs=1.0)  # a pixel is 0.3 mm on a phone
    slide(page, INCREMENTS)
    told = dict(page.run(TOLD))
    exact = bent_beam.state(np.array([middle]), ANGLE)
    now = place(told["Now at x, y, z"])
    assert now == pytest.approx((middle + exact["displacement"][0]).tolist(), abs=0.2)
    stretch = float(told["Largest principal stretch"])
    assert stretch == pytest.approx(exact["max_principal_stretch"][0], abs=0.02)
    page.run("document.getElementById('unpick').click()")
    page.wait("return document.getElementById('picked').hidden")


def test_the_mesh_is_drawn_when_asked(page):
    slide(page, 0)
    lines = "const t = document.getElementById('shape').data[2]; return [t.visible, t.x, t.y, t.z]"
    assert page.run(lines)[0] is False
    choose(page, "mesh", True)
    visible, *axes = page.run(lines)
    ends = np.array(axes, float).T.reshape(-1, 3, 3)[:, :2]  # two ends and a gap
    assert visible
    assert len(ends) == 2 * 2 * edges_outside()  # two pieces of each edge, and the mirrored half
    size = bent_beam.LENGTH
    assert ends[..., 0].max() == pytest.approx(size, abs=0.01 * size)
    choose(page, "mesh", False)


def edges_outside():
    """Number of edges of the faces that are neither in the channel nor in the symmetry plane."""
    _, cells, surfaces = bent_beam.mesh()
    faces = exterior(cells)[:, :3]
    hidden = among(faces, [surfaces["cavity_wall"], surfaces["symmetry"]])
    sides = faces[~hidden][:, ((0, 1), (1, 2), (2, 0))].reshape(-1, 2)
    return len(np.unique(np.sort(sides, axis=1), axis=0))


def test_fit_fits_the_axes_to_the_state(page):
    slide(page, INCREMENTS)
    page.run("document.getElementById('fit').click()")
    range_ = "return document.getElementById('shape').layout.scene.xaxis.range"
    page.wait(f"{range_}[1] < {0.8 * bent_beam.LENGTH}")
    bent = page.run(range_)
    slide(page, 0)  # sticks out, so the axes take in all states
    page.wait(f"{range_}[1] >= {bent_beam.LENGTH}")
    assert page.run(range_)[1] > bent[1]

"""Pages of many runs and of a fit in headless Chromium: choices, clicks, CSV, dark, phone, desk.

The runs are made up, by the closed form of tests/bent_beam.py.
"""

import numpy as np
import pytest

from softact.fit.modes import nominal_stress
from softact.fit.run import Request
from softact.fit.run import run as fit
from softact.fit.sheet import make_sheet
from softact.materials import LAWS
from softact.optimise import optimise_page
from softact.optimise.spec import Optimisation
from softact.optimise.study import Trials
from softact.results.own_folder import Output
from softact.sweep import compute as computing
from softact.sweep import sweep_page, table
from softact.sweep.cache import Cache
from softact.sweep.spec import Sweep, read
from softact.sweep.study import locally, open_study
from tests.browsing import DESK, FITS_PAPER, PHONE, assert_quiet_and_fits
from tests.sweep.folders import CUBE, instead_of_run

LENGTHS, SIDES = [4.0, 6.0, 8.0], [4.0, 5.0]
SWEEP = f"""{CUBE}
axes:
  - {{path: geometry.length, values: [{", ".join(f"{length:g} mm" for length in LENGTHS)}]}}
  - {{name: side, path: [geometry.width, geometry.height], values: [4 mm, 5 mm]}}
"""
OPTIMISE = f"""{CUBE}
parameters:
  - {{path: geometry.length, from: 4 mm, to: 20 mm}}
objectives: [{{measure: bending_angle_deg, goal: maximise}}]
constraints: [{{measure: tip_x_mm, above: -1000}}]
trials: 6
reference: {{geometry.length: 5 mm}}
"""
LAW = LAWS["yeoh"].of(c10=0.11, c20=-0.004, c30=0.003)
STRETCH = np.linspace(1.0, 2.5, 12)
SHAPE = "return Array.from(document.getElementById('oneshape').data[0].x)"


def a_sweep(top):
    (top / "sweep.yaml").write_text(SWEEP)
    sweep, base = read(top / "sweep.yaml", Sweep)
    study = open_study(sweep, base, Cache(top / "runs"))
    study.compute(locally(1), lambda point, answer: None)
    (top / "sweep.html").write_text(sweep_page.html(study, table.rows(study), b"x\n1\n", [], []))
    return top / "sweep.html"


def an_optimisation(top):
    (top / "opt.yaml").write_text(OPTIMISE)
    wanted, base = read(top / "opt.yaml", Optimisation)
    trials = Trials(wanted, base, Cache(top / "runs"), top)
    trials.run(1, lambda trial, answer: None)
    return optimise_page.write(trials, Output(top, "optimize"))


def a_fit(top):
    sheets = []
    for mode in ("uniaxial", "planar"):
        stress = 1e3 * nominal_stress(LAW, LAW, mode, STRETCH)
        rows = [f"{s:.8f};{p:.8f}" for s, p in zip(STRETCH, stress, strict=True)]
        (top / f"{mode}.csv").write_text("\n".join(["stretch;nominal stress (kPa)", *rows]))
        sheets.append(make_sheet({"file": top / f"{mode}.csv", "mode": mode}, mode))
    wanted = Request(sheets, "yeoh", top / "fit", "mine", compare=("ecoflex-00-30",))
    fit(wanted, lambda line: None)
    return top / "fit" / "mine.html"


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Name -> file of a sweep's, an optimisation's and a fit's page."""
    top = tmp_path_factory.mktemp("studies")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(computing, "run", instead_of_run)
        patch.setattr(optimise_page, "write_report", lambda directory: None)
        return {"sweep": a_sweep(top), "optimisation": an_optimisation(top), "fit": a_fit(top)}


PLOTS = {"sweep": 5, "optimisation": 2, "fit": 4}


@pytest.mark.parametrize("width", [PHONE, DESK])
@pytest.mark.parametrize("name", PLOTS)
def test_quiet_fits_and_follows_the_readers_colours(browser, files, name, width):
    browser.open(files[name], width)
    assert_quiet_and_fits(browser, PLOTS[name])
    texts = "#front .xtitle" if name == "sweep" else "figure.chart .xtitle"
    assert browser.luminance(texts, "fill") < 0.2
    browser.colours("dark")
    browser.wait("return themed('@paper') === '#12181d'")
    colour = "return getComputedStyle(document.querySelector(arguments[0])).fill"
    ink = browser.run("return themed('@ink')")
    rgb = f"rgb({', '.join(str(int(ink[k : k + 2], 16)) for k in (1, 3, 5))})"
    browser.wait(f"{colour.replace('arguments[0]', repr(texts))} === '{rgb}'")
    assert browser.luminance("body") < 0.15
    if name == "sweep":
        drawn = "#curves .scatterlayer .trace path.js-line"
        browser.wait(f"return document.querySelectorAll('{drawn}').length >= 6")
        assert browser.luminance(drawn, "stroke") > 0.35  # the darkest comes first
    assert_quiet_and_fits(browser, PLOTS[name])


def rows_of(browser, title):
    """Heads of a plot's CSV, and its numbers."""
    heads, *rows = browser.csv(title)
    return heads, np.array([[float(cell) for cell in row] for row in rows])


def test_every_plot_of_a_sweep_gives_its_data(browser, files):
    browser.open(files["sweep"], DESK, anew=True)
    angles = sorted(10.0 * length for length in LENGTHS for _ in SIDES)
    titles = browser.run(
        "return [...document.querySelectorAll('figure.chart b')].map(b => b.textContent)"
    )
    front, curves, length, side, parallel = titles
    heads, *rows = browser.csv(front)
    angle = heads.index("Bending angle (°)")
    assert sorted(float(row[angle]) for row in rows) == pytest.approx(angles)
    assert {row[heads.index("status")] for row in rows} == {"complete"}
    heads, values = rows_of(browser, curves)
    assert heads == ["point", "geometry.length (mm)", "side (mm)", *heads[-2:]]
    last = [values[values[:, 0] == point][-1] for point in range(6)]
    assert [row[4] for row in last] == pytest.approx([10.0 * row[1] for row in last])
    heads, *rows = browser.csv(length)
    means = {float(x): float(y) for curve, x, y in rows if curve == "mean"}
    assert (length, means) == ("geometry.length (mm)", pytest.approx({4: 40, 6: 60, 8: 80}))
    heads, *rows = browser.csv(side)
    assert [float(y) for curve, _, y in rows if curve == "mean"] == pytest.approx([60, 60])
    heads, values = rows_of(browser, parallel)
    assert heads[:4] == ["point", "geometry.length (mm)", "side (mm)", "Bending angle (°)"]
    assert values[:, 3] == pytest.approx(10.0 * values[:, 1])


def test_choices_of_a_sweep_are_drawn(browser, files):
    browser.open(files["sweep"], DESK, anew=True)
    choose = (
        "const s = document.getElementById(arguments[0]); s.selectedIndex = arguments[1];"
        "s.dispatchEvent(new Event('change'));"
    )
    label = "return document.getElementById(arguments[0]).options[1].text"
    for select, box, axis in (
        ("first", "front", "xaxis"), ("second", "front", "yaxis"), ("curve", "curves", "yaxis"),
        ("effect", "effects", "yaxis"),
    ):  # fmt: skip
        browser.run(choose, select, 1)
        wanted = browser.run(label, select)
        titles = browser.run(
            "return [...document.querySelectorAll(`#${arguments[0]}.plot, #${arguments[0]} .plot`)]"
            ".map(p => p.layout[arguments[1]].title.text)", box, axis,
        )  # fmt: skip
        assert titles and set(titles) == {wanted}
    for select in ("first", "second"):
        browser.run(choose, select, 0)
    front = "return document.getElementById('front').data[2].x"
    assert browser.run(front) == pytest.approx([80, 60, 40])  # more of it and less of it
    browser.run(choose, "firstgoal", 1)
    assert browser.run(front) == pytest.approx([40])  # less of it twice
    joined = "return document.querySelectorAll('#front .scatterlayer .js-line').length"
    assert browser.run(joined) == 0  # between two points nothing was computed
    assert browser.errors() == []


@pytest.mark.parametrize("width", [PHONE, DESK])
def test_a_click_on_a_trial_shows_its_design(browser, files, width):
    browser.open(files["optimisation"], width, anew=True)
    number = "return Number(document.getElementById('onepoint').dataset.point)"
    ready = "return document.getElementById('oneshape')?.dataset.ready === 'yes'"
    trials = browser.run(
        "return Object.assign(...[...document.querySelectorAll('#history .plot')[0].data]"
        ".filter(t => t.customdata).map(t => Object.fromEntries("
        "t.customdata.map((n, k) => [n, t.y[k]]))))"
    )
    browser.wait(ready)
    assert browser.run(number) == int(max(trials, key=trials.get))  # the best, before any click
    best = np.ptp(browser.run(SHAPE))
    browser.click_point("front", trace=3, point=0)  # the reference
    browser.wait(f"{number} === 0")
    browser.wait(ready)
    assert np.ptp(browser.run(SHAPE)) != pytest.approx(best)
    said = browser.run("return document.getElementById('onepoint').textContent")
    assert "Trial 0" in said and "geometry.length5 mm" in said and "bending_angle_deg50" in said
    assert_quiet_and_fits(browser, 2)


def test_plots_of_an_optimisation_and_of_a_fit_give_their_data(browser, files):
    browser.open(files["optimisation"], DESK)
    heads, *rows = browser.csv("maximise bending_angle_deg")
    assert heads == ["curve", "Trial", "Bending angle (°)"]
    assert ["holds all constraints", "0", "50"] in rows
    assert any(row[2] == "50" for row in browser.csv("bending_angle_deg and tip_x_mm"))
    browser.open(files["fit"], DESK)
    for mode in ("uniaxial", "planar"):
        heads, *rows = browser.csv(mode.capitalize())
        assert heads == ["curve", "Stretch", "Nominal stress (kPa)"]
        found = np.array([row[1:] for row in rows if row[0] == mode], float)
        expected = 1e3 * nominal_stress(LAW, LAW, mode, STRETCH)
        assert found == pytest.approx(np.column_stack([STRETCH, expected]), abs=1e-3)
    assert {row[0] for row in browser.csv("Uniaxial")[1:]} == {"uniaxial", "yeoh", "ecoflex-00-30"}
    heads, *rows = browser.csv("Residuals of yeoh")
    assert np.abs(np.array([row[-1] for row in rows], float)).max() < 1e-2


def test_load_and_colour_of_the_curves_can_be_chosen(browser, files):
    browser.open(files["sweep"], DESK, anew=True)
    curves = "const b = document.getElementById('curves');"
    choose = (
        "const s = document.getElementById(arguments[0]); s.selectedIndex = arguments[1];"
        "s.dispatchEvent(new Event('change')); return s.options[s.selectedIndex].text"
    )
    colours = f"{curves} return b.data.map(t => t.line.color)"
    by_length = browser.run(colours)
    assert len(set(by_length)) == len(LENGTHS)
    assert browser.run(choose, "colour", 1) == "side (mm)"
    assert len(set(browser.run(colours))) == len(SIDES)
    assert "side (mm)" in browser.run("return document.getElementById('curvenote').textContent")
    wanted = browser.run(choose, "load", 2)
    assert browser.run(f"{curves} return b.layout.xaxis.title.text") == wanted
    heads, *_ = browser.csv(f"{browser.run(f'{curves} return b.layout.yaxis.title.text')}"
                            f" over {wanted}")  # fmt: skip
    assert heads[-2] == wanted
    assert browser.errors() == []


def test_a_range_of_parallel_coordinates_can_be_dragged(browser, files):
    """Pressing and drawing along an axis keeps the runs of that range."""
    browser.open(files["sweep"], DESK, anew=True)
    x, top, bottom = browser.run(
        "const p = document.getElementById('parallel'); p.scrollIntoView({block: 'center'});"
        "const r = p.querySelector('.axis-brush .background').getBoundingClientRect();"
        "return [r.left + r.width / 2, r.top, r.bottom]"
    )

    def at(part):
        return {"x": x, "y": bottom - part * (bottom - top)}

    browser.tell("Input.dispatchMouseEvent", {"type": "mouseMoved", **at(0.3)})
    left = {"button": "left", "buttons": 1, "clickCount": 1}
    browser.tell("Input.dispatchMouseEvent", {"type": "mousePressed", **at(0.3), **left})
    for part in (0.4, 0.5, 0.6, 0.7):
        browser.tell("Input.dispatchMouseEvent", {"type": "mouseMoved", **at(part), **left})
    browser.tell("Input.dispatchMouseEvent", {"type": "mouseReleased", **at(0.7), **left})
    kept = "return document.getElementById('parallel').data[0].dimensions[0].constraintrange"
    low, high = browser.wait(kept)
    assert LENGTHS[0] < low < LENGTHS[1] < high < LENGTHS[2]
    assert browser.errors() == []


def test_a_sweep_on_paper_is_white_and_fits(browser, files):
    browser.open(files["sweep"], DESK, anew=True)
    browser.colours("dark", media="print")
    browser.run("window.dispatchEvent(new Event('beforeprint'))")
    browser.wait("return themed('@paper') === '#ffffff'")
    browser.wait(FITS_PAPER)
    assert browser.luminance("#front .xtitle", "fill") < 0.2
    browser.run("window.dispatchEvent(new Event('afterprint'))")
    browser.colours("light")
    assert browser.errors() == []

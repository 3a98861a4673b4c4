"""Every kind of page in headless Chromium: quiet console, phone and desk, dark, paper, CSV."""

import json
import time

import numpy as np
import pytest

from softact import spec as specs
from softact.converge import output
from softact.converge.carry import carry_into
from softact.converge.study import Convergence, Level, refined
from softact.report import pictures, write_report
from softact.report.base import Plot, Section, bars, figures, lines, page, table, xy
from softact.report.compare import write_comparison
from softact.report.targets import section
from softact.results.folder import read
from softact.results.own_folder import Output
from softact.sweep.record import from_results
from tests import bent_beam
from tests.browsing import DESK, FITS_PAPER, PHONE, assert_quiet_and_fits

SIZE = {"nx": 6, "ny": 2, "nz": 7}
MEASURES = ("bending_angle_deg", "max_principal_stress_MPa", "tip_x_mm", "tip_z_mm")
PLOT = "#angle .main-svg"
PRESSURE, ANGLE = [0.0, 12.5, 50.0], [0.0, 1 / 3, 120.25]


def a_page():
    """A page with one plot of each kind."""
    several = [xy("one", PRESSURE, ANGLE), xy("two, 'with' \"marks\"", [1, 2], [3, float("nan")])]
    effects = ["wall", "roof <b>", "=1+1", "-3 mm"]
    both = {"wall (mm)": [1, 2], "angle (°)": [90, 40]}
    axes = [{"label": name, "values": values} for name, values in both.items()]
    parallel = {"type": "parcoords", "line": {"color": "@c2"}, "dimensions": axes}
    plots = [
        lines("Angle", "Pressure (kPa)", "Angle (°)", several[:1], id="angle"),
        lines("Two curves", "Pressure (kPa)", "Angle (°)", several, wide=True),
        bars("Effects", "Effect (°)", "Parameter", effects, [3.0, -1.5, 0, 1]),
        Plot("All runs", [parallel], table=both, wide=True, scroll=True, id="all"),
    ]  # fmt: skip
    wide = table(["name", *(f"a long heading {n}" for n in range(12))], [["x", *[1.5] * 12]] * 3)
    sections = [Section("plots", "Plots", figures(plots)), Section("table", "Table", wide)]
    script = """
whenReady((data) => byId("angle").on("plotly_click", (event) => {
  document.body.dataset.clicked = data.names[event.points[0].pointIndex];
}));
"""
    names = ["first", "second", "third"]
    return page("A page", sections, kicker="Test", data={"names": names}, script=script)


def a_study(top):
    """Bent beams of 90°, 87.5° and 86.25° on meshes of 4, 2 and 1 mm: first order, limit 85°."""
    text = "geometry: {type: block, mesh_size: 4 mm}\nmaterials: {body: ecoflex-00-30}\n"
    spec = specs.loads(f"{text}steps: [{{name: hang, gravity: [0, 0, -1]}}]")
    study = Convergence(MEASURES, 0.05)
    for number, angle in enumerate((90.0, 87.5, 86.25)):
        fine, folder = refined(spec, 2.0, number), top / f"level{number}"
        bent_beam.write(folder, angle, 4, size=SIZE, spec_hash=fine.hash)
        found = from_results(f"{number:032d}", read(folder), 1.5)
        study.levels.append(Level(fine, found, 4.0 / 2**number))
    return study


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Name -> file: a page of the base, a comparison, a report with requirements and error bars,
    and a convergence study."""
    top = tmp_path_factory.mktemp("pages")
    (top / "page.html").write_text(a_page())
    study, folder = a_study(top), top / "level0"
    bent_beam.write(top / "b", 120.0, 4, size=SIZE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pictures, "drawing", bent_beam.undrawn)
        carry_into(study, folder)
        report = write_report(folder, [lambda results: section(results, ["glove"])])
    return {
        "base": top / "page.html",
        "comparison": write_comparison([folder, top / "b"], top / "out"),
        "report": report,
        "convergence": output.write(study, "beam", Output(top, "converge")),
    }


@pytest.mark.parametrize(
    "name, width",
    [("comparison", PHONE), ("base", PHONE), ("report", PHONE), ("convergence", PHONE),
     ("comparison", DESK), ("report", DESK),
     ("convergence", DESK), ("base", DESK)],
)  # fmt: skip
def test_pages_are_quiet_and_fit(browser, files, name, width):
    browser.open(files[name], width)
    assert_quiet_and_fits(browser, plots=4)


def test_the_data_of_a_plot_are_one_click_away(browser, files):
    browser.open(files["base"], DESK)
    rows = browser.csv("Angle")
    assert rows[0] == ["Pressure (kPa)", "Angle (°)"]
    assert np.array(rows[1:], float) == pytest.approx(np.column_stack([PRESSURE, ANGLE]), rel=1e-6)
    rows = browser.csv("Two curves")
    assert rows[0] == ["curve", "Pressure (kPa)", "Angle (°)"]
    assert rows[-1] == ["two, 'with' \"marks\"", "2", ""]
    rows = browser.csv("Effects")
    assert rows[1:] == [["wall", "3"], ["roof <b>", "-1.5"], ["'=1+1", "0"], ["-3 mm", "1"]]
    assert browser.csv("All runs")[2] == ["2", "40"]


def test_a_click_on_a_point_reaches_the_page(browser, files):
    browser.open(files["base"], DESK)
    browser.click_point("angle", trace=0, point=1)
    browser.wait("return document.body.dataset.clicked === 'second'")


def test_dark_light_and_paper(browser, files):
    browser.open(files["base"], DESK)
    browser.colours("dark")
    browser.wait("return themed('@paper') === '#12181d'")
    time.sleep(0.3)
    assert browser.luminance("body") < 0.15
    assert browser.luminance(PLOT) < 0.15 and browser.luminance("#angle .xtitle", "fill") > 0.7
    browser.colours("light")
    browser.wait("return themed('@paper') === '#ffffff'")
    time.sleep(0.3)
    assert browser.luminance(PLOT) > 0.95 and browser.luminance("#angle .xtitle", "fill") < 0.2
    browser.colours("dark", media="print")
    browser.run("window.dispatchEvent(new Event('beforeprint'))")
    assert browser.luminance(PLOT) > 0.95  # paper is white for those who like it dark
    browser.wait(FITS_PAPER)
    browser.colours("dark")
    browser.run("window.dispatchEvent(new Event('afterprint'))")
    browser.wait("return themed('@paper') === '#12181d'")
    time.sleep(0.3)
    assert browser.luminance(PLOT) < 0.15


@pytest.mark.parametrize("name", ["comparison", "report", "convergence"])
def test_every_page_follows_the_readers_colours(browser, files, name):
    browser.open(files[name], DESK)
    browser.colours("dark")
    browser.wait("return themed('@paper') === '#12181d'")
    ink = browser.run("return themed('@ink')")
    rgb = f"rgb({', '.join(str(int(ink[k : k + 2], 16)) for k in (1, 3, 5))})"
    titles = "[...document.querySelectorAll('figure.chart .xtitle')]"
    browser.wait(f"return {titles}.every(t => getComputedStyle(t).fill === '{rgb}')")
    assert browser.luminance("body") < 0.15
    assert_quiet_and_fits(browser, plots=4)


def test_curves_of_one_abscissa_are_columns(browser, files):
    browser.open(files["report"], DESK)
    rows = browser.csv("Stress")
    assert rows[0][0] == "Pressure (kPa)" and len(rows[0]) == 3
    assert rows[0][1] == "Largest von Mises stress: Stress (MPa)"
    assert [float(row[0]) for row in rows[1:]] == [0, 12.5, 25, 37.5, 50]


def test_error_bars_of_a_convergence_study(browser, files):
    """1.25 times the distances of 5°, 2.5° and 1.25° to the limit, in the plot and in its CSV."""
    browser.open(files["convergence"], DESK)
    rows = browser.csv("Bending angle")
    assert rows[0] == [
        "Mean cell size (mm)", "Bending angle (°)", "Error bar of Bending angle (°)",
        "limit (Richardson)",
    ]  # fmt: skip
    expected = [[4, 90, 6.25, 85], [2, 87.5, 3.125, 85], [1, 86.25, 1.5625, 85]]
    assert np.array(rows[1:], float) == pytest.approx(np.array(expected), rel=1e-6)
    drawn = browser.run(
        "return [...document.querySelectorAll('figure.chart')].map("
        "f => f.querySelectorAll('.errorbar path').length)"
    )
    assert drawn == [3, 3, 3, 3]


def test_names_from_users_are_no_markup():
    text = page("</title><b>x", [Section("a", "<i>", "")], kicker="<u>")
    assert "<b>x" not in text and "<i>" not in text and "<u>" not in text
    plot = figures([lines("</script><b>", "x", "y", [xy("</script>", [1], [2])])])
    assert "<b></script>" not in plot and json.loads(
        plot.split("application/json'>")[1].split("</script>")[0]
    )["title"].startswith("</script>")

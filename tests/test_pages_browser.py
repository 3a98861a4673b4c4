"""Every kind of page in headless Chromium: quiet console, phone and desk, dark, paper, CSV."""

import csv
import json
import shutil
import time
from contextlib import nullcontext
from pathlib import Path

import bent_beam
import numpy as np
import pytest

from softact import spec as specs
from softact.converge import output
from softact.converge.carry import carry_into
from softact.converge.study import Convergence, Level, mesh_sizes, refined
from softact.report import pictures, write_report
from softact.report.base import Plot, Section, bars, figures, lines, page, table, xy
from softact.report.compare import write_comparison
from softact.report.targets import section
from softact.results import read
from softact.sweep.record import from_results

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
SIZE = {"nx": 6, "ny": 2, "nz": 7}
MEASURES = ("bending_angle_deg", "max_principal_stress_MPa", "tip_x_mm", "tip_z_mm")
PLOT = "#angle .main-svg"
PRESSURE, ANGLE = [0.0, 12.5, 50.0], [0.0, 1 / 3, 120.25]


def a_page():
    """A page with one plot of each kind."""
    several = [xy("one", PRESSURE, ANGLE), xy("two, 'with' \"marks\"", [1, 2], [3, float("nan")])]
    both = {"wall (mm)": [1, 2], "angle (°)": [90, 40]}
    axes = [{"label": name, "values": values} for name, values in both.items()]
    parallel = {"type": "parcoords", "line": {"color": "@c2"}, "dimensions": axes}
    plots = [
        lines("Angle", "Pressure (kPa)", "Angle (°)", several[:1], id="angle"),
        lines("Two curves", "Pressure (kPa)", "Angle (°)", several, wide=True),
        bars("Effects", "Effect (°)", "Parameter", ["wall", "roof <b>"], [3.0, -1.5]),
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
        fine, folder = refined(spec, 2.0**number), top / f"level{number}"
        bent_beam.write(folder, angle, 4, size=SIZE, spec_hash=fine.hash)
        found = from_results(f"{number:032d}", read(folder), 1.5)
        study.levels.append(Level(mesh_sizes(fine), fine, found, 4.0 / 2**number))
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
        patch.setattr(pictures, "drawing", lambda results, parts: nullcontext(lambda: "left out"))
        carry_into(study, folder)
        report = write_report(folder, [lambda results: section(results, ["glove"])])
    return {
        "base": top / "page.html",
        "comparison": write_comparison([folder, top / "b"], top / "out"),
        "report": report,
        "convergence": output.write(study, "beam", top),
    }


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    driver.shown = None
    driver.downloads = tmp_path_factory.mktemp("downloads")
    driver.execute_cdp_cmd(
        "Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(driver.downloads)}
    )
    try:
        yield driver
    finally:
        driver.quit()


def open_page(driver, file, width):
    """Open a page that is not open already, in light colours."""
    if driver.shown == (file, width):
        return
    driver.shown = file, width
    size = {"width": width, "height": 850, "deviceScaleFactor": 1, "mobile": width < 600}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    scheme = {"name": "prefers-color-scheme", "value": "light"}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": [scheme]})
    driver.get(file.as_uri())
    wait_for(driver, "return document.body.dataset.ready === 'yes'", 60)


def wait_for(driver, script, seconds=20):
    end = time.monotonic() + seconds
    while not (value := driver.execute_script(script)):
        assert time.monotonic() < end, f"not within {seconds} s: {script}"
        time.sleep(0.05)
    return value


def saved(driver, link, name):
    """Click a link as a reader does; the rows of the CSV that is saved."""
    target = Path(driver.downloads) / name
    target.unlink(missing_ok=True)
    driver.execute_script("arguments[0].click()", link)
    end = time.monotonic() + 20
    while not target.is_file():
        assert time.monotonic() < end, f"{name} was not saved"
        time.sleep(0.05)
    with open(target, newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


def csv_of(driver, title):
    script = (
        "return [...document.querySelectorAll('figure.chart')].find("
        "f => f.querySelector('b').textContent === arguments[0]).querySelector('.csv')"
    )
    return driver.execute_script(script, title)


@pytest.mark.parametrize(
    "name, width",
    [("comparison", 390), ("base", 390), ("report", 390), ("convergence", 390),
     ("convergence", 1400), ("base", 1400)],
)  # fmt: skip
def test_pages_are_quiet_and_fit(browser, files, name, width):
    open_page(browser, files[name], width)
    plots, drawn, inner, content = browser.execute_script(
        "return [document.querySelectorAll('figure.chart').length,"
        "document.querySelectorAll('figure.chart .js-plotly-plot').length,"
        "window.innerWidth, document.documentElement.scrollWidth]"
    )
    assert drawn == plots >= 4
    assert content <= inner
    log = browser.get_log("browser")
    assert [entry for entry in log if entry["level"] in ("SEVERE", "ERROR")] == []
    asked = browser.execute_script(
        "return performance.getEntriesByType('resource').map(e => e.name)"
        ".filter(n => !n.startsWith('data:') && !n.startsWith('blob:'))"
    )
    assert asked == []


def test_the_data_of_a_plot_are_one_click_away(browser, files):
    open_page(browser, files["base"], 1400)
    rows = saved(browser, csv_of(browser, "Angle"), "angle.csv")
    assert rows[0] == ["Pressure (kPa)", "Angle (°)"]
    assert np.array(rows[1:], float) == pytest.approx(np.column_stack([PRESSURE, ANGLE]), rel=1e-6)
    rows = saved(browser, csv_of(browser, "Two curves"), "two_curves.csv")
    assert rows[0] == ["curve", "Pressure (kPa)", "Angle (°)"]
    assert rows[-1] == ["two, 'with' \"marks\"", "2", ""]
    rows = saved(browser, csv_of(browser, "Effects"), "effects.csv")
    assert rows[1:] == [["wall", "3"], ["roof <b>", "-1.5"]]
    assert saved(browser, csv_of(browser, "All runs"), "all_runs.csv")[2] == ["2", "40"]


def test_a_click_on_a_point_reaches_the_page(browser, files):
    from selenium.webdriver import ActionChains

    open_page(browser, files["base"], 1400)
    places = browser.execute_script(
        "const box = byId('angle'); box.scrollIntoView({block: 'center'});"
        "const l = box._fullLayout, b = box.getBoundingClientRect();"
        "return [b.x + l._size.l + l.xaxis.d2p(12.5), b.y + l._size.t + l.yaxis.d2p(1 / 3)];"
    )
    actions = ActionChains(browser)
    actions.w3c_actions.pointer_action.move_to_location(*map(round, places))
    actions.w3c_actions.pointer_action.click()
    actions.perform()
    wait_for(browser, "return document.body.dataset.clicked === 'second'")


def luminance(driver, selector, style="background-color"):
    """Of a colour as drawn: 0 is black, 1 is white."""
    script = "return getComputedStyle(document.querySelector(arguments[0])).getPropertyValue("
    colour = driver.execute_script(f"{script}arguments[1])", selector, style)
    rgb = [float(n) for n in colour[colour.index("(") + 1 : -1].split(",")[:3]]
    return float(np.dot(rgb, [0.2126, 0.7152, 0.0722]) / 255)


def test_dark_light_and_paper(browser, files):
    open_page(browser, files["base"], 1400)
    scheme = [{"name": "prefers-color-scheme", "value": "dark"}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": scheme})
    wait_for(browser, "return themed('@paper') === '#12181d'")
    time.sleep(0.3)
    assert luminance(browser, "body") < 0.15
    assert luminance(browser, PLOT) < 0.15 and luminance(browser, "#angle .xtitle", "fill") > 0.7
    scheme[0]["value"] = "light"
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": scheme})
    wait_for(browser, "return themed('@paper') === '#ffffff'")
    time.sleep(0.3)
    assert luminance(browser, PLOT) > 0.95 and luminance(browser, "#angle .xtitle", "fill") < 0.2
    scheme[0]["value"] = "dark"
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print", "features": scheme})
    browser.execute_script("window.dispatchEvent(new Event('beforeprint'))")
    assert luminance(browser, PLOT) > 0.95  # paper is white for those who like it dark
    widths = browser.execute_script(
        "return [...document.querySelectorAll('.main-svg')].map("
        "svg => svg.getBoundingClientRect().width)"
    )
    assert max(widths) <= 660  # of the 700 or so that A4 has between its margins
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": scheme})
    browser.execute_script("window.dispatchEvent(new Event('afterprint'))")
    wait_for(browser, "return themed('@paper') === '#12181d'")
    time.sleep(0.3)
    assert luminance(browser, PLOT) < 0.15


def test_curves_of_one_abscissa_are_columns(browser, files):
    open_page(browser, files["report"], 1400)
    rows = saved(browser, csv_of(browser, "Largest stress"), "largest_stress.csv")
    assert rows[0][0] == "Pressure (kPa)" and len(rows[0]) == 3
    assert rows[0][1] == "Largest von Mises stress: Largest stress (MPa)"
    assert [float(row[0]) for row in rows[1:]] == [0, 12.5, 25, 37.5, 50]


def test_error_bars_of_a_convergence_study(browser, files):
    """1.25 times the distances of 5°, 2.5° and 1.25° to the limit, in the plot and in its CSV."""
    open_page(browser, files["convergence"], 1400)
    rows = saved(browser, csv_of(browser, "Bending angle"), "bending_angle.csv")
    assert rows[0] == [
        "Mean cell size (mm)", "Bending angle (°)", "Error bar of Bending angle (°)",
        "limit (Richardson)",
    ]  # fmt: skip
    expected = [[4, 90, 6.25, 85], [2, 87.5, 3.125, 85], [1, 86.25, 1.5625, 85]]
    assert np.array(rows[1:], float) == pytest.approx(np.array(expected), rel=1e-6)
    drawn = browser.execute_script(
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

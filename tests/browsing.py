"""Headless Chromium for the tests of the pages: sizes, colours, clicks, waiting, what it says.

``browser`` of tests/conftest.py is one ``Browser`` for all tests of a session.
"""

import csv
import importlib.util
import shutil
import time
from pathlib import Path

import numpy as np
import pytest

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--enable-unsafe-swiftshader", "--hide-scrollbars",
)  # fmt: skip
PHONE, DESK = 390, 1400
# Every plot fits the 700 pixels or so that A4 has between its margins.
FITS_PAPER = """
const plots = [...document.querySelectorAll('.main-svg')];
return plots.length && plots.every(plot => plot.getBoundingClientRect().width <= 660);
"""
HEIGHT = 850
READY_S = 180  # on a busy machine; 1 or 2 s on an idle one
PAPER = {"light": "#ffffff", "dark": "#12181d"}  # --paper of softact/report/base/base.css


def start(folder: Path) -> "Browser":
    """A browser with its profile and its downloads in ``folder``; skips where there is none."""
    if not (CHROMIUM and DRIVER):
        pytest.skip("needs chromium and chromium-driver (apt)")
    if importlib.util.find_spec("selenium") is None:
        pytest.skip("needs selenium (pip install softact[dev])")
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for flag in (*FLAGS, f"--user-data-dir={folder / 'profile'}"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    options.page_load_strategy = "none"  # pages tell by themselves when they are ready
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    driver.set_script_timeout(READY_S)
    downloads = folder / "downloads"
    downloads.mkdir()
    driver.execute_cdp_cmd(
        "Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(downloads)}
    )
    return Browser(driver, downloads)


class Browser:
    """A driver of selenium and the page that it shows."""

    def __init__(self, driver, downloads: Path):
        self.driver, self.downloads = driver, downloads
        self.run, self.tell = driver.execute_script, driver.execute_cdp_cmd
        self.shown: tuple | None = None
        self._said: list[dict] = []

    def quit(self) -> None:
        self.driver.quit()

    def open(self, file: Path, width: int, anew: bool = False) -> "Browser":
        """Show a page in light colours; ``anew`` also where it is shown already."""
        self.colours("light")
        if self.shown == (file, width) and not anew:
            self.wait(f"return themed('@paper') === '{PAPER['light']}'")
            return self
        self.shown = None
        size = {"width": width, "height": HEIGHT, "deviceScaleFactor": 1, "mobile": width < 600}
        self.tell("Emulation.setDeviceMetricsOverride", size)
        self.driver.get("about:blank")
        self.wait("return location.href === 'about:blank'", READY_S)
        self.driver.get_log("browser")
        self._said = []
        self.driver.get(file.as_uri())
        self.wait("return document.body?.dataset.ready !== undefined", READY_S)
        ready = self.run("return document.body.dataset.ready")
        assert ready == "yes", f"{ready}: {self.errors()}"
        self.shown = file, width
        return self

    def colours(self, scheme: str, media: str = "") -> None:
        """What the reader's system asks for. scheme: "light" or "dark"; media: "print" or ""."""
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self.tell("Emulation.setEmulatedMedia", {"media": media, "features": features})

    def wait(self, script: str, seconds: float = 20):
        """Wait until ``script`` returns something true; returns it."""
        end = time.monotonic() + seconds
        while not (value := self.run(script)):
            assert time.monotonic() < end, f"not within {seconds} s: {script}"
            time.sleep(0.05)
        return value

    # ---- what is wrong with a page ----

    def errors(self) -> list[str]:
        """What the console has said since the page was opened, if it is an error."""
        self._said += self.driver.get_log("browser")
        return [e["message"] for e in self._said if e["level"] in ("SEVERE", "ERROR")]

    def fetched(self) -> list[str]:
        """Addresses that the page has asked for."""
        return self.run(
            "return performance.getEntriesByType('resource').map(e => e.name)"
            ".filter(n => !n.startsWith('data:') && !n.startsWith('blob:'))"
        )

    def overhang(self) -> float:
        """Pixels by which the page is wider than the window: 0 where nothing sticks out."""
        return self.run("return document.documentElement.scrollWidth - window.innerWidth")

    def drawn(self) -> tuple[int, int]:
        """Numbers of figures, and of those with a plot that has an area."""
        return tuple(
            self.run(
                "const all = [...document.querySelectorAll('figure.chart')];"
                "return [all.length, all.filter(f => { const s = f.querySelector("
                "'.js-plotly-plot .main-svg'); return s && s.clientWidth * s.clientHeight > 0; }"
                ").length]"
            )
        )

    def cut(self) -> list[str]:
        """Texts of plots that stand more than 1 px outside of the plot's drawing: which plot, the
        text, and by how much on each side."""
        return self.run(
            "return [...document.querySelectorAll('.js-plotly-plot')].flatMap(box => {"
            " const b = box.getBoundingClientRect();"
            " return [...box.querySelectorAll('svg.main-svg text')].filter(t => {"
            "  const r = t.getBoundingClientRect();"
            "  return r.width * r.height > 0 && (r.left < b.left - 1 || r.right > b.right + 1"
            "   || r.top < b.top - 1 || r.bottom > b.bottom + 1); }).map(t => {"
            "  const r = t.getBoundingClientRect(), sides = [b.left - r.left, r.right - b.right,"
            "   b.top - r.top, r.bottom - b.bottom].map(Math.round);"
            "  return `${box.ariaLabel}: '${t.textContent}' by ${sides}`; }); })"
        )

    def luminance(self, selector: str, style: str = "background-color") -> float:
        """Of a colour as drawn: 0 is black, 1 is white."""
        colour = self.run(
            "return getComputedStyle(document.querySelector(arguments[0]))"
            ".getPropertyValue(arguments[1])",
            selector,
            style,
        )
        rgb = [float(n) for n in colour[colour.index("(") + 1 : -1].split(",")[:3]]
        return float(np.dot(rgb, [0.2126, 0.7152, 0.0722]) / 255)

    # ---- what a reader does ----

    def click(self, x: float, y: float) -> None:
        """Press and release the mouse at a place of the window, px."""
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            more = {} if kind == "mouseMoved" else {"button": "left", "clickCount": 1}
            self.tell("Input.dispatchMouseEvent", {"type": kind, "x": x, "y": y, **more})
            time.sleep(0.1)

    def click_point(self, plot: str, trace: int, point: int) -> None:
        """Click on a point of a plot's trace, both by their numbers."""
        self.click(
            *self.run(
                "const box = document.getElementById(arguments[0]);"
                "box.scrollIntoView({block: 'center'});"
                "const l = box._fullLayout, t = box.data[arguments[1]];"
                "const r = box.getBoundingClientRect(), n = arguments[2];"
                "return [r.left + l.xaxis._offset + l.xaxis.d2p(t.x[n]),"
                " r.top + l.yaxis._offset + l.yaxis.d2p(t.y[n])];",
                plot,
                trace,
                point,
            )
        )

    def csv(self, title: str) -> list[list[str]]:
        """Click on the link beside a plot's title; the rows of the file that is saved."""
        link, name = self.run(
            "const f = [...document.querySelectorAll('figure.chart')].find("
            "f => f.querySelector('b').textContent === arguments[0]);"
            "return [f.querySelector('.csv'),"
            " f.plot.file];",
            title,
        )
        target = self.downloads / name
        target.unlink(missing_ok=True)
        self.run("arguments[0].click()", link)
        end = time.monotonic() + 20
        while not (target.is_file() and target.read_bytes().endswith(b"\n")):  # to its last line
            assert time.monotonic() < end, f"{name} was not saved"
            time.sleep(0.05)
        with open(target, newline="", encoding="utf-8") as file:
            return list(csv.reader(file))


def assert_quiet_and_fits(browser: Browser, plots: int = 0) -> None:
    """No error, nothing fetched, nothing wider than the window, ``plots`` figures at least and all
    of them drawn, with all of their texts in sight."""
    figures, drawn = browser.drawn()
    assert drawn == figures >= plots
    assert browser.overhang() <= 0
    assert browser.cut() == []
    assert browser.fetched() == []
    assert browser.errors() == []

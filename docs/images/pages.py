"""Pictures of pages for the documentation, in headless Chromium.

    .venv/bin/python docs/images/pages.py PAGE PICTURE [--phone] [--dark] [--height 1100] [--at ID]
        [--click ID,TRACE,POINT] [--do SCRIPT] [--scale 0.75]

PAGE: an HTML file of softact; PICTURE: the PNG. --at: the section to begin at.
"""

import argparse
import base64
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
from tests import browsing

DESK = 900


def picture(browser: browsing.Browser, wanted: argparse.Namespace) -> bytes:
    """PNG of what the options ask for."""
    width = browsing.PHONE if wanted.phone else DESK
    browser.open(wanted.page.resolve(), width)
    if wanted.dark:
        browser.colours("dark")
        browser.wait(f"return themed('@paper') === '{browsing.PAPER['dark']}'")
    if wanted.click:
        plot, trace, point = wanted.click.split(",")
        browser.click_point(plot, int(trace), int(point))
        browser.wait("return document.getElementById('oneshape')?.dataset.ready === 'yes'")
    if wanted.do:
        browser.run(wanted.do)
        time.sleep(3.0)  # until it is drawn
    browser.tell("Input.dispatchMouseEvent", {"type": "mouseMoved", "x": 1, "y": 1})
    time.sleep(1.0)  # until what was hovered over is gone
    top, end = browser.run(
        "const s = document.getElementById(arguments[0]);"
        "return [s ? s.getBoundingClientRect().top + window.scrollY : 0,"
        " document.documentElement.scrollHeight];",
        wanted.at,
    )
    height = min(wanted.height, end - top)
    clip = {"x": 0, "y": top, "width": width, "height": height, "scale": wanted.scale}
    shot = browser.tell("Page.captureScreenshot", {"captureBeyondViewport": True, "clip": clip})
    return base64.b64decode(shot["data"])


def main() -> None:
    """Take one picture."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("page", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--phone", action="store_true", help="390 px wide")
    parser.add_argument("--dark", action="store_true")
    parser.add_argument("--height", type=float, default=1100)
    parser.add_argument("--at", default="", metavar="ID")
    parser.add_argument("--click", metavar="ID,TRACE,POINT")
    parser.add_argument("--do", metavar="SCRIPT", help="JavaScript, to set controls")
    parser.add_argument("--scale", type=float, default=0.75)
    wanted = parser.parse_args()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        browser = browsing.start(Path(folder))
        try:
            wanted.picture.write_bytes(picture(browser, wanted))
        finally:
            browser.quit()


if __name__ == "__main__":
    main()

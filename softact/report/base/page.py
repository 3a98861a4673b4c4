"""A whole page: head, contents, sections, the data and the scripts they need."""

import base64
import gzip
import hashlib
import os
import zlib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

from softact.files.text import write_atomic
from softact.report.base.plots import script_json


@dataclass(frozen=True)
class Section:
    """A part of a page under a heading. body: HTML. nav: its name in the contents, if another."""

    id: str
    title: str
    body: str
    nav: str = ""


def page(
    title: str,
    sections: Sequence[Section],
    *,
    kicker: str,
    kind: str = "",
    lead: str = "",
    data=None,
    style: str = "",
    script: str = "",
) -> str:
    """The text of an HTML file.

    kicker: what sort of page it is, above the title. kind: the same in the browser's title.
    lead: HTML above the contents. data: for ``script``, anything that JSON can hold. style,
    script: CSS and JavaScript of this page. Plotly comes along where there is a plot or a script.
    """
    here = files("softact.report.base")
    bodies = "\n".join(
        f"<section id='{s.id}'>\n<h2>{escape(s.title)}</h2>\n{s.body}\n</section>" for s in sections
    )
    nav = "".join(f"<a href='#{s.id}'>{escape(s.nav or s.title)}</a> " for s in sections)
    drawn = "class='chart" in bodies + lead or "Plotly" in script
    parts = {
        "title": escape(title),
        "heading": escape(f"{title}: {kind}" if kind else title),
        "kicker": escape(kicker),
        "style": (here / "base.css").read_text(encoding="utf-8") + style,
        "lead": lead,
        "nav": nav,
        "sections": bodies,
        "data": script_json(data),
        "plotly": plotly() if drawn else "",
        "script": (here / "base.js").read_text(encoding="utf-8") + script,
    }
    return Template((here / "base.html").read_text(encoding="utf-8")).substitute(parts)


@cache
def plotly() -> str:
    """plotly.js as base64 of gzip: 2 MB instead of 5. Kept in the user's cache once it is made."""
    source = files("plotly") / "package_data" / "plotly.min.js"
    script = source.read_bytes()
    name = f"plotly-{hashlib.blake2b(script, digest_size=8).hexdigest()}.gz"
    with suppress(OSError, EOFError, zlib.error, RuntimeError):
        packed = _kept(name).read_bytes()
        if gzip.decompress(packed) == script:
            return base64.b64encode(packed).decode()
    packed = gzip.compress(script, 6, mtime=0)
    with suppress(OSError, RuntimeError):  # no home, or one that cannot be written
        _kept(name).parent.mkdir(parents=True, exist_ok=True)
        write_atomic(_kept(name), packed)
    return base64.b64encode(packed).decode()


def _kept(name: str) -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "softact" / name

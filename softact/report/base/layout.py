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
from importlib.resources import files
from pathlib import Path
from typing import Any

from markupsafe import Markup

from softact.files.text import write_atomic
from softact.report.base.templates import render


@dataclass(frozen=True)
class Section:
    """A part of a page under a heading. body: ``Markup``, or a text that is escaped; None: the
    block of the page's template that is called like the id. nav: its name in the contents, if
    another."""

    id: str
    title: str
    body: str | None = None
    nav: str = ""


def page(
    title: str,
    sections: Sequence[Section],
    *,
    kicker: str,
    kind: str = "",
    data: Any = None,
    lead: str = "",
    style: str = "",
    script: str = "",
    template: str = "report/base/layout.html",
    **shown: Any,
) -> str:
    """The text of an HTML file.

    kicker: what sort of page it is, above the title. kind: the same in the browser's title. data:
    for ``script``, anything that JSON can hold. lead: ``Markup`` above the contents. style, script:
    CSS and JavaScript of this page. template: one that extends the layout, of which ``shown`` are
    the variables; it may have style, script and lead of its own. Plotly comes along where there is
    a plot or a script that draws one.
    """
    return render(
        template,
        title=title,
        sections=sections,
        kicker=kicker,
        kind=kind,
        data=data,
        lead=lead,
        style=Markup(style),
        script=Markup(script),
        plotly=plotly,
        **shown,
    )


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

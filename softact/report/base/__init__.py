"""What every HTML page of softact is made of: one file, no network, light and dark, print, phone.

A page is a list of sections; a section's body is HTML, put together from the pieces here::

    from softact.report.base import Section, bars, figures, lines, page, table, xy

    angle = lines("Bending angle", "Pressure (kPa)", "Bending angle (°)", [xy("run 1", p, a)])
    sections = [
        Section("curves", "Curves", figures([angle])),
        Section("runs", "Runs", table(["wall (mm)", "angle (°)"], rows, file="runs.csv")),
    ]
    write_atomic(path, page("A sweep", sections, kicker="Sweep"))

- ``lines``, ``bars`` and ``Plot`` (any plotly traces and layout) become figures with their data as
  CSV beside them. Names of axes carry their unit. A plot that the page's script draws stands in
  a ``frame``; ``describe(box, plot)`` says what its CSV holds.
- Colours are tokens, so that they fit light, dark and paper: ``"@c1"`` to ``"@c8"`` (told apart by
  colour-blind readers), ``"@ink"``, ``"@soft"``, ``"@line"``, ``"@paper"``, ``"@good"``,
  ``"@warn"``, ``"@bad"``; the same as ``var(--c1)`` ... in CSS.
- Own JavaScript goes into ``script``: ``whenReady(async (data) => {...})`` is called with ``data``
  once all figures stand; ``byId(plot_id)`` is the element to listen at
  (``.on("plotly_click", ...)``); ``themed(x)`` replaces colour tokens; ``onTheme(f)`` calls ``f``
  when light turns to dark. ``document.body.dataset.ready`` is then "yes" (or "failed").
- A section's body is ``Markup``, as all pieces are; a plain text is escaped, and so is whatever
  goes into a piece. HTML of one's own stands in a template (``templates.render``).
"""

from softact.report.base.layout import Section, page, plotly
from softact.report.base.parts import (
    banner,
    card,
    download,
    image,
    note,
    parts,
    picture,
    table,
    two_images,
)
from softact.report.base.plots import Plot, bars, figures, frame, lines, xy

__all__ = [
    "Plot",
    "Section",
    "banner",
    "bars",
    "card",
    "download",
    "figures",
    "frame",
    "image",
    "lines",
    "note",
    "page",
    "parts",
    "picture",
    "plotly",
    "table",
    "two_images",
    "xy",
]

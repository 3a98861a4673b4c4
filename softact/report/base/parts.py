"""Pieces of HTML that stand on many pages."""

import base64
from collections.abc import Iterable, Sequence
from io import BytesIO
from typing import Any

import numpy as np
from markupsafe import Markup

from softact.files.text import csv_text
from softact.report.base.templates import macros


def parts() -> Any:
    """The macros of parts.html."""
    return macros("report/base/parts.html")


def banner(kind: str, head: str, text: str, items: Iterable[str | tuple[str, str]] = ()) -> Markup:
    """A coloured note. kind: "good", "warn" or "bad". items: texts, or pairs of a title and a
    text."""
    return parts().banner(kind, head, text, list(items))


def note(text: str) -> Markup:
    """A paragraph in small print."""
    return parts().note(text)


def card(name: str, value: str, unit: str = "", note: str = "", error: str = "") -> Markup:
    """A large number with its name; cards go into ``<div class='cards'>``. error: such as
    "± 0.5", in the same unit."""
    return parts().card(name, value, unit, note, error)


def image(png: bytes, alt: str) -> Markup:
    """A picture that stands in the page itself."""
    return parts().image(_packed(png), alt)


def two_images(light: bytes, dark: bytes, alt: str) -> Markup:
    """A picture on a light ground and on a dark one, as WebP; paper is light."""
    return parts().two_images(_packed(light), _packed(dark), alt)


def picture(webp: bytes, alt: str) -> Markup:
    """A WebP with a ground that lets through the page's."""
    return parts().picture(_packed(webp), alt)


def webp(picture: np.ndarray) -> bytes:
    """A picture (height, width, 3 or 4) uint8 as WebP: a tenth of a PNG's size."""
    from PIL import Image

    out = BytesIO()
    # Method 4 makes it 5 % smaller, in twice the time.
    Image.fromarray(picture).save(out, format="WEBP", quality=88, method=2)
    return out.getvalue()


def download(name: str, data: bytes, kind: str = "text/csv", text: str = "") -> Markup:
    """A link that saves ``data``, which stand in the page, as a file."""
    return parts().download(name, _packed(data), kind, text or f"Download {name}")


def _packed(data: bytes) -> Markup:
    return Markup(base64.b64encode(data).decode())


def table(
    heads: Sequence[str],
    rows: Iterable[Sequence[str | float | None]],
    *,
    file: str = "",
    marks: Sequence[str] = (),
    numbers: bool = False,
) -> Markup:
    """A table that scrolls sideways where it is too wide; the first column stays in sight.

    Numbers are shown with four digits. file: name of a CSV of all digits, for which a link is put
    below. marks: for each row "good", "warn", "bad" or "", the colour of its second cell. numbers:
    texts after the second column are numbers too, and stand to the right.
    """
    rows = [list(row) for row in rows]
    right = [
        n > 0 and (any(not isinstance(row[n], str) for row in rows) or (numbers and n > 1))
        for n in range(len(heads))
    ]
    link: str = ""
    if file:
        text = csv_text([dict(zip(heads, row, strict=True)) for row in rows])
        link = download(file, text.encode())
    cells = [[_cell(value) for value in row] for row in rows]
    return parts().table(heads, cells, right, [*marks, *[""] * len(rows)], link)


def _cell(value: str | float | None) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return value
    from softact.report.labels import number

    return number(float(value))

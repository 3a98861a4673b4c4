"""Pieces of HTML that stand on many pages."""

import base64
from collections.abc import Iterable, Sequence
from html import escape

from softact.files.text import csv_text


def banner(kind: str, head: str, text: str, items: Iterable[str | tuple[str, str]] = ()) -> str:
    """A coloured note. kind: "good", "warn" or "bad"; text is HTML, head and items are not. items:
    texts, or pairs of a title and a text."""
    listed = "".join(f"<li>{_item(item)}</li>" for item in items)
    more = f"<ul>{listed}</ul>" if listed else ""
    return (
        f"<div class='banner {kind}' role='status'><strong>{escape(head)}</strong> {text}{more}"
        "</div>"
    )


def _item(item: str | tuple[str, str]) -> str:
    if isinstance(item, str):
        return escape(item)
    head, text = item
    return f"<strong>{escape(head)}</strong> {escape(text)}"


def card(name: str, value: str, unit: str = "", note: str = "", error: str = "") -> str:
    """A large number with its name; cards go into ``<div class='cards'>``. error: such as
    "± 0.5", in the same unit."""
    tail = f" <span class='unit'>{escape(unit)}</span>" if unit else ""
    tail = "°" if unit == "°" else tail
    below = f"<div class='error'>{escape(error)}{tail}</div>" if error else ""
    below += f"<div class='note'>{escape(note)}</div>" if note else ""
    return (
        f"<div class='card'><div class='name'>{escape(name)}</div>"
        f"<div class='value'>{escape(value)}{tail}</div>{below}</div>"
    )


def image(png: bytes, alt: str) -> str:
    """A picture that stands in the page itself."""
    data = base64.b64encode(png).decode()
    return f"<img src='data:image/png;base64,{data}' alt='{escape(alt, quote=True)}'>"


def download(name: str, data: bytes, kind: str = "text/csv", text: str = "") -> str:
    """A link that saves ``data``, which stand in the page, as a file."""
    packed = base64.b64encode(data).decode()
    said = escape(text or f"Download {name}")
    name = escape(name, quote=True)
    return f"<a download='{name}' href='data:{kind};base64,{packed}'>{said}</a>"


def table(
    heads: Sequence[str],
    rows: Iterable[Sequence[str | float | None]],
    *,
    file: str = "",
    marks: Sequence[str] = (),
    numbers: bool = False,
) -> str:
    """A table that scrolls sideways where it is too wide; the first column stays in sight.

    Texts are escaped; numbers are shown with four digits. file: name of a CSV of all digits, for
    which a link is put below. marks: for each row "good", "warn", "bad" or "", the colour of its
    second cell. numbers: texts after the second column are numbers too, and stand to the right.
    """
    rows = [list(row) for row in rows]
    right = [
        any(not isinstance(row[n], str) for row in rows) or (numbers and n > 1)
        for n in range(len(heads))
    ]
    marked = [" class='number'" if number and n else "" for n, number in enumerate(right)]
    head = "".join(
        f"<th scope='col'{mark}>{escape(text)}</th>"
        for mark, text in zip(marked, heads, strict=True)
    )
    kinds = [*marks, *[""] * len(rows)]
    body = "".join(_row(row, kind, marked) for row, kind in zip(rows, kinds, strict=False))
    below = ""
    if file:
        text = csv_text([dict(zip(heads, row, strict=True)) for row in rows])
        below = f"<p class='note'>{download(file, text.encode())}</p>"
    return (
        f"<div class='scroll'><table class='list'><thead><tr>{head}</tr></thead>"
        f"<tbody>{body}</tbody></table></div>{below}"
    )


def _row(row: Sequence, kind: str, marked: Sequence[str]) -> str:
    first, *rest = [_cell(value) for value in row]
    cells = "".join(f"<td{mark}>{text}</td>" for mark, text in zip(marked[1:], rest, strict=True))
    mark = f" class='{kind}'" if kind else ""
    return f"<tr{mark}><th scope='row'>{first}</th>{cells}</tr>"


def _cell(value) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return escape(value)
    from softact.report.labels import number

    return number(float(value))

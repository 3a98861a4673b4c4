"""Which measure a column of ``curve.csv`` belongs to, from its name."""

import re
from dataclasses import dataclass
from functools import cache

from softact.measures import MEASURES


@dataclass(frozen=True)
class Title:
    """A group of columns. measure: its name; title: with ``<cavity>`` or the like where there is a
    column for each; meaning: what it is."""

    measure: str
    title: str
    meaning: str


@cache
def titles() -> tuple[Title, ...]:
    """All columns, those without the name of a part first, then the longest."""
    found = [
        Title(measure.name, title, meaning)
        for measure in MEASURES.values()
        for title, meaning in measure.columns.items()
    ]
    return tuple(sorted(found, key=lambda entry: ("<" in entry.title, -len(entry.title))))


@cache
def _pattern(title: str) -> re.Pattern:
    parts = re.split(r"(_<\w+>)", title)
    return re.compile("".join("(_.+)?" if p.startswith("_<") else re.escape(p) for p in parts))


def title_of(column: str) -> Title | None:
    """The group that a column belongs to; None where no measure has it."""
    return next((each for each in titles() if _pattern(each.title).fullmatch(column)), None)

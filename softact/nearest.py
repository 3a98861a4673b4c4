"""What is told of a word that is not known here: the one that was meant, or all that there are."""

import re
from collections.abc import Iterable
from difflib import SequenceMatcher

MOST_SHOWN = 24
ALIKE = 0.8  # ratio of difflib above which a word is misspelt: 'duration', 'traction' have 0.75
AKIN = 0.6  # and at least, where a single slip of the fingers lies between two words


def nearest(word: object, known: Iterable[object]) -> str:
    """Return the end of an error line: the word that is really near, else all that are known."""
    names = [str(entry) for entry in known]
    if meant := likely(word, names):
        return meant
    shown = [*names[:MOST_SHOWN], "..."] if len(names) > MOST_SHOWN else names
    return f"known: {', '.join(shown)}" if names else "none is known here"


def likely(word: object, known: Iterable[object]) -> str:
    """Return the question whether a word that is really near was meant, "" where none is."""
    meant = _near(str(word), [str(entry) for entry in known])
    return f"did you mean {' or '.join(repr(name) for name in meant)}?" if meant else ""


def _near(word: str, names: list[str]) -> list[str]:
    """The word that was misspelt, else up to three that begin with what was written or have it as
    a part, as outer_wall has wall."""
    alike = [(_likeness(word.lower(), name.lower()), name) for name in names]
    if best := max((ratio for ratio, _ in alike), default=0.0):
        return [next(name for ratio, name in alike if ratio == best)]
    if len(word) < 3:
        return []
    return [n for n in names if n.startswith(word) or word in re.split(r"[_.\-]", n)][:3]


def _likeness(word: str, name: str) -> float:
    """Ratio of difflib for two words of which one is a misspelling of the other, else 0."""
    letters = SequenceMatcher(None, word, name)
    # The quick ratios are upper bounds, and most words are told apart by them.
    if letters.real_quick_ratio() < AKIN or letters.quick_ratio() < AKIN:
        return 0.0
    ratio = letters.ratio()
    return ratio if ratio > ALIKE or (ratio >= AKIN and _one_slip(word, name)) else 0.0


def _one_slip(a: str, b: str) -> bool:
    """Whether one letter is left out, added or another, or two neighbours are swapped."""
    pairs = zip(a, b, strict=False)
    start = next((i for i, (x, y) in enumerate(pairs) if x != y), min(len(a), len(b)))
    rest, other = a[start:], b[start:]
    swapped = rest[:2] == other[1::-1] and rest[2:] == other[2:]
    return swapped or rest[1:] == other[1:] or rest[1:] == other or rest == other[1:]

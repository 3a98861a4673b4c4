"""The kinds of YAML files that people write for softact, and how one is told from another."""

from dataclasses import dataclass

from softact.errors import SpecError
from softact.spec.document import Document


@dataclass(frozen=True)
class Kind:
    """A kind of file. called: in a sentence. keys: at the top of such files, and of no other or few
    others. use: what is done with one; ``{}`` is its name."""

    called: str
    keys: frozenset[str]
    use: str


def _kind(called: str, use: str, keys: str) -> Kind:
    return Kind(called, frozenset(keys.split()), use)


KINDS = {
    "spec": _kind(
        "a spec",
        "to solve it: softact run {}",
        "geometry materials layers sheets supports obstacles contact steps assumptions measures "
        "safety_factor solver",
    ),
    "sweep": _kind("a sweep", "to compute it: softact sweep {}", "base set axes design trends"),
    "optimise": _kind(
        "an optimisation",
        "to compute it: softact optimize {}",
        "base set parameters objectives constraints trials seed reference",
    ),
    "case": _kind("a reference case", "to check it: softact check {}", "spec values history"),
    "card": _kind(
        "a material card",
        "a spec names it as a material, such as 'materials: {{body: {}}}'",
        "law density stretch_range strength test notes",
    ),
    "tests": _kind("a list of test data", "to fit a law to it: softact fit {}", "tests"),
    "figures": _kind(
        "a file of published figures",
        "docs/validation_table.py reads it and says what is wrong in it",
        "sources",
    ),
    "targets": _kind(
        "a file of published requirements",
        "those that softact knows: softact report DIR --targets NAME",
        "targets sources",
    ),
}


def kind_of(document: Document, wanted: str = "spec") -> str:
    """Return the kind that most of the keys of a file belong to, ``wanted`` where that is open.

    What has a key of the wanted kind that the other kind lacks is a file of that kind with faults.
    """
    keys = set(document.data)
    shared = {name: len(keys & kind.keys) for name, kind in KINDS.items()}
    most = max(shared, key=lambda name: (shared[name], name == wanted))
    mixed = keys & KINDS[wanted].keys - KINDS[most].keys
    return wanted if mixed or not shared[most] else most


def expect(document: Document, wanted: str) -> None:
    """Raise SpecError where a file is of another kind than is wanted, with what it is and what is
    done with it."""
    found = kind_of(document, wanted)
    if found != wanted:
        raise SpecError(
            f"{document.name}: this is {KINDS[found].called}, where {KINDS[wanted].called} is "
            f"wanted; {KINDS[found].use.format(document.name)}"
        )

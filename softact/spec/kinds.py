"""The kinds of YAML files that people write for softact, and how one is told from another."""

import os
from dataclasses import dataclass
from pathlib import Path

from softact.errors import SpecError
from softact.files import document
from softact.files.document import Document
from softact.units import one_line


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
        "geometry materials layers sheets supports obstacles contact steps probes assumptions "
        "measures safety_factor solver constraints masses points lines fields tolerances module "
        "tiles target_line",
    ),
    "sweep": _kind(
        "a sweep",
        "to compute it: softact sweep {}",
        "base set axes design trends objectives model blocked confirm",
    ),
    "optimise": _kind(
        "an optimisation",
        "to compute it: softact optimize {}",
        "base set parameters objectives constraints trials seed reference method starts "
        "model blocked confirm",
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


def kind_of(source: Document, wanted: str = "spec") -> str:
    """Return the kind that most of the keys of a file belong to, ``wanted`` where that is open.

    What has a key of the wanted kind that the other kind lacks is a file of that kind with faults.
    """
    keys = set(source.data)
    shared = {name: len(keys & kind.keys) for name, kind in KINDS.items()}
    most = max(shared, key=lambda name: (shared[name], name == wanted))
    mixed = keys & KINDS[wanted].keys - KINDS[most].keys
    return wanted if mixed or not shared[most] else most


def expect(source: Document, wanted: str) -> None:
    """Raise SpecError where a file is of another kind than is wanted, with what it is and what is
    done with it."""
    found = kind_of(source, wanted)
    if found != wanted:
        raise SpecError(_other(source.name, found, KINDS[wanted].called))


def read_as(path: Path, wanted: str) -> Document:
    """Read a YAML file of a kind. Raises SpecError where it cannot be read or is of another."""
    source = read_any(path, wanted)
    expect(source, wanted)
    return source


def read_any(path: Path, wanted: str = "spec") -> Document:
    """Read a YAML file. Raises SpecError where it cannot be read; ``wanted``: what is said then."""
    stored = path / "spec.yaml"
    if os.path.isfile(stored) and os.path.isfile(path / "run.json"):
        raise SpecError(
            f"{one_line(str(path))}: this is a result folder, where {KINDS[wanted].called} is "
            f"wanted; the spec of its run is {one_line(str(stored))}"
        )
    return document.read(path)


def expect_results(path: Path) -> None:
    """Raise SpecError where a file of one of the kinds is named in place of a result folder."""
    if path.suffix.lower() in (".yaml", ".yml") and os.path.isfile(path):
        found = document.read(path)
        raise SpecError(_other(found.name, kind_of(found), "a result folder"))


def _other(name: str, found: str, wanted: str) -> str:
    kind = KINDS[found]
    return f"{name}: this is {kind.called}, where {wanted} is wanted; {kind.use.format(name)}"

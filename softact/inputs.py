"""Every YAML file that a user writes, checked as what it is, and its JSON schema.

A kind is imported where it is asked for: a spec need not wait for the libraries of a fit.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Union

from pydantic import BaseModel, Field, RootModel

from softact.errors import SpecError
from softact.files.document import Document
from softact.materials import LAWS, Law
from softact.spec import Spec, json_schema, opened, spec_at
from softact.spec.card_files import read_card
from softact.spec.faults import validated
from softact.spec.kinds import KINDS, kind_of, read_any

_MOST_TRIED = 200  # points of a sweep that are looked at for one that is right


@dataclass(frozen=True)
class Checked:
    """A file without faults. called: what it is, in words. source, spec: of a spec, else None."""

    called: str
    source: Document | None = None
    spec: Spec | None = None


def validate(path: Path, overrides: Sequence[str] = ()) -> Checked:
    """Check a file as what it is, without meshing or solving.

    overrides: as of ``--set``, for a spec only. Raises SpecError with one line per fault.
    """
    kind = kind_of(read_any(path))
    if kind == "spec":
        source = opened(path, overrides)
        spec = spec_at(source)
        _check_tolerances(source, spec)
        return Checked(KINDS[kind].called, source, spec)
    if overrides:
        raise SpecError(f"{path}: this is {KINDS[kind].called}; --set replaces values of a spec")
    if kind not in _CHECKS:
        raise SpecError(f"{path}: this is {KINDS[kind].called}; {KINDS[kind].use}")
    _CHECKS[kind](path)
    return Checked(KINDS[kind].called)


def _check_tolerances(source: Document, spec: Spec) -> None:
    """Raise SpecError where a tolerance is of no number, or in no unit of it."""
    if not spec.tolerances:
        return
    from softact.tolerances.causes import causes

    try:
        causes(spec)
    except SpecError as error:
        where = source.where(("tolerances",))
        raise SpecError(*(f"{where}: {line}" for line in error.lines)) from None


def _sweep(path: Path) -> None:
    from softact.sweep.points import first_right
    from softact.sweep.spec import Sweep, read

    study, base = read(path, Sweep)
    points = study.design.points(study.axes)
    first_right(study.spec_at, base, study.axes, points[:: -(-len(points) // _MOST_TRIED)])


def _optimisation(path: Path) -> None:
    from softact.optimise.spec import Optimisation
    from softact.sweep.spec import read

    read(path, Optimisation)


def _case(path: Path) -> None:
    from softact.check.cases import read

    read(path)


def _tests(path: Path) -> None:
    from softact.fit.data import read_tests
    from softact.fit.sheet import sheets_from_argument

    faults = []
    for sheet in sheets_from_argument(str(path), {}):
        try:
            read_tests(sheet)
        except SpecError as error:
            faults += error.lines
    if faults:
        raise SpecError(*faults)


def _targets(path: Path) -> None:
    from softact.report.targets_file import TargetsFile

    validated(read_any(path), TargetsFile)


_CHECKS: dict[str, Callable[[Path], Any]] = {
    "sweep": _sweep,
    "optimise": _optimisation,
    "case": _case,
    "card": read_card,
    "tests": _tests,
    "targets": _targets,
}


if TYPE_CHECKING:
    AnyLaw = Law
else:
    AnyLaw = Union[tuple(LAWS.values())]  # noqa: UP007 (there is no other way to join a tuple)


class Card(RootModel[Annotated[AnyLaw, Field(discriminator="law")]]):
    """A material card: a law, its constants, and where they are from."""


def schema(kind: str) -> dict[str, Any]:
    """Return the JSON schema of a spec, sweep, optimise, case, card or tests file."""
    from softact.check.cases import CaseFile
    from softact.fit.sheet import TestList
    from softact.optimise.spec import Optimisation
    from softact.sweep.spec import Sweep

    models: dict[str, type[BaseModel]]
    models = {"sweep": Sweep, "optimise": Optimisation, "case": CaseFile, "tests": TestList}
    holds_spec = {"sweep": "base", "optimise": "base", "case": "spec"}
    if kind == "spec":
        return json_schema()
    return json_schema(Card if kind == "card" else models[kind], holds_spec.get(kind))

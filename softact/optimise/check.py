"""What makes an optimisation senseless, told before its first run."""

from __future__ import annotations

from pathlib import Path

from softact.columns import column_fault
from softact.errors import SpecError
from softact.optimise.spec import Optimisation
from softact.spec import Spec, document
from softact.sweep.design import Design
from softact.sweep.points import changes_of, spec_at
from softact.units import show

_TRIED = Design(kind="latin_hypercube", samples=64)


def check(file: Path, wanted: Optimisation, base: document.Document) -> None:
    """Raise SpecError where the reference, or else no design at all, has a right spec, and where an
    objective or a constraint is no column of the runs."""
    spec, source = _first_right(wanted, base), document.read(file)
    faults = []
    for key in ("objectives", "constraints"):
        for number, part in enumerate(getattr(wanted, key)):
            if fault := column_fault(part.measure, spec):
                where = source.where((key, number, "measure"))
                at = f"{where}: {key}.{number}.measure: {show(part.measure)}"
                faults.append(f"{at}: {fault}")
    if faults:
        raise SpecError(*faults)


def _first_right(wanted: Optimisation, base: document.Document) -> Spec:
    """The reference's spec, or the first right one of some designs."""
    if wanted.reference:
        return spec_at(base, changes_of(wanted.parameters, wanted.reference))
    faults: list[str] = []
    for coordinates in _TRIED.points(wanted.parameters):
        try:
            return spec_at(base, changes_of(wanted.parameters, coordinates))
        except SpecError as error:
            faults = faults or error.lines
    raise SpecError(
        *faults,
        f"{base.name}: none of {_TRIED.samples} designs between the parameters' ends has a right "
        "spec; mend the base, narrow the ranges, or give a reference that can be built",
    )

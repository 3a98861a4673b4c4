"""What makes an optimisation senseless, told before its first run."""

from __future__ import annotations

from pathlib import Path

from softact.errors import SpecError
from softact.files import document
from softact.optimise.spec import Optimisation
from softact.sweep.measure_names import measure_fault
from softact.sweep.points import first_right
from softact.units import show


def check(file: Path, wanted: Optimisation, base: document.Document) -> None:
    """Raise SpecError where an objective or a constraint is no column of the runs."""
    spec, source = (
        first_right(wanted.spec_at, base, wanted.parameters, wanted.tried()),
        document.read(file),
    )
    faults = []
    for key in ("objectives", "constraints"):
        for number, part in enumerate(getattr(wanted, key)):
            if fault := measure_fault(part.measure, spec, wanted.kinds):
                where = source.where((key, number, "measure"))
                at = f"{where}: {key}.{number}.measure: {show(part.measure)}"
                faults.append(f"{at}: {fault}")
    if faults:
        raise SpecError(*faults)

"""The runs of a module, and the table of what they say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softact.errors import NoEquilibriumError
from softact.modules.module_spec import ModuleSpecs
from softact.results import chain
from softact.results.folder import Results, is_pressure, read
from softact.run.start import run

BEFORE = ("step", "increment", "step_fraction")

Row = dict[str, float | str]


@dataclass(frozen=True)
class Study:
    """free: results; blocked: those of the ``straight`` and ``clamped`` runs. modules: of the whole
    actuator, 0 where that is not known."""

    free: Results
    blocked: dict[str, Results]
    modules: float

    def rows(self) -> list[Row]:
        """A row for each state of the free module: loads, how it stands, its cross-section, what a
        blocked one exerts, and the angle of so many of them."""
        curve = self.free.curve
        loads = [n for n in curve if is_pressure(n)]
        own = [name for name in curve if name.startswith("module_")]
        air = [name for name in curve if name.startswith("cavity_volume")]
        table = {name: curve[name] for name in (*BEFORE, *loads, *own)}
        table |= {f"module_{name}": curve[name] for name in air}
        table |= chain.exerted(curve, {kind: run.curve for kind, run in self.blocked.items()})
        if self.modules:
            table |= chain.angles(curve, self.modules)
        return [
            {name: _cell(values[k]) for name, values in table.items()}
            for k in range(len(curve["step"]))
        ]


def _cell(value: float | str) -> float | str:
    if isinstance(value, str):
        return value
    return "" if np.isnan(value) else float(value)


def study(specs: ModuleSpecs, folder: Path, modules: float, tell: Callable[[str], None]) -> Study:
    """Solve a module's runs into folders of their names in ``folder``.

    modules: of the whole actuator, 0 where that is not known. Raises NoEquilibriumError where
    a run found no state at all, and what ``softact.run.start.run`` raises.
    """
    found = {}
    for name, spec in specs.runs.items():
        outcome = run(spec, folder / name, report=False)
        if outcome.message:
            tell(f"{name} module: {outcome.message}")
        found[name] = read(folder / name)
        if not len(found[name].curve.get("step", ())):
            raise NoEquilibriumError(f"the {name} module has no equilibrium at all")
    return Study(found.pop("free"), found, modules)

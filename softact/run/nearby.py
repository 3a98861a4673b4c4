"""The run of an actuator like this one, from whose last state this one's is guessed.

Its mesh has the same cells, so that its unknowns are these; its twins (``softact.sensitivities``)
say how they change with the numbers of the spec, so that the guess goes along with them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.errors import SoftactError
from softact.measures.snapshot import gather_mesh
from softact.results.folder import COMPLETE, read
from softact.sensitivities.parameters import chosen
from softact.solve.checkpoint import Ended, ended
from softact.spec import loads

if TYPE_CHECKING:
    from softact.model import Model
    from softact.results.folder import Results
    from softact.spec import Spec

#: Columns that are counted on from row to row, so that those of the neighbour say how many turns.
COUNTED = ("_deg", "bending_axis_x", "bending_axis_y", "bending_axis_z")


@dataclass(frozen=True)
class Nearby:
    """Guesses (local,) of the last state, the best first, and what is counted on from it."""

    guesses: Sequence[np.ndarray]
    row: Mapping[str, float]


def nearby(model: Model, spec: Spec, directory: Path) -> Nearby | str:
    """What the run in a folder says of the last state of ``spec``; or why it says nothing."""
    if model.remembering:
        return "a material remembers where it has been"
    if model.comm.size > 1:
        return "several processes share the mesh"
    try:
        there = read(directory)
        if reason := _other(there, model):
            return reason
        last = ended(model, directory, there.points)
    except (SoftactError, OSError) as error:
        return str(error)
    if isinstance(last, str):
        return last
    guesses = [*_predicted(last, spec, there), last.x]
    row = {name: values[-1] for name, values in there.curve.items() if name.endswith(COUNTED)}
    return Nearby(guesses, row)


def _other(there: Results, model: Model) -> str:
    """Why a run is of no use; empty: nothing."""
    if there.status != COMPLETE:
        return "that run did not end"
    if any(control != "load" for control in there.curve["control"]):
        return "that actuator has passed a limit"
    if any(v[-1] > 0.0 for name, v in there.curve.items() if name.startswith("contact_area_")):
        return "that actuator touches itself"
    whole = gather_mesh(model)
    assert whole is not None  # of one process
    if not np.array_equal(whole[1], there.cells):
        return "its mesh has other cells"
    return ""


def _predicted(last: Ended, spec: Spec, there: Results) -> list[np.ndarray]:
    """The last unknowns, moved along with the parameters to first order; none where the run has no
    derivatives."""
    before, paths = loads(there.spec_yaml, str(there.directory)), list(last.twins)
    if not paths:
        return []
    moved = last.x.copy()
    for old, new in zip(chosen(before, paths), chosen(spec, paths), strict=True):
        moved += (last.twins[old.path] - last.x) * ((new.value - old.value) / old.step)
    return [moved]

"""The parameters of a run: which of those that were asked for its mesh can follow."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from softact.errors import SpecError
from softact.geometry.motion import Moved
from softact.sensitivities.mesh_motion import mesh_motion
from softact.sensitivities.parameters import Parameter, chosen

if TYPE_CHECKING:
    from softact.spec import Spec


class Chosen:
    """The parameters at dotted paths, or the usual ones where none are named (None: no others), and
    those that have tolerances.

    Raises SpecError where one is none, or where there is none.
    """

    def __init__(
        self, spec: Spec, paths: Sequence[str] | None, tolerances: Sequence[Parameter] = ()
    ):
        self._spec = spec
        asked = [] if paths is None else chosen(spec, paths)
        #: Path -> how a line about it begins, of those that may not be left out.
        self._wanted = {p.path: f"-p {p.path}" for p in (asked if paths else ())}
        self._wanted |= {p.path: f"tolerances: {p.path}" for p in tolerances}
        self.parameters = list({p.path: p for p in (*asked, *tolerances)}.values())
        if not self.parameters:
            raise SpecError("the spec has no number by which its measures can be differentiated")

    def job(self, folder: Path) -> tuple[dict[str, Any], list[str]]:
        """What the solver has to know, and what the user should: the means by which the mesh is
        moved, and what is left out since it cannot be.

        folder: for the file that says how the mesh moves. Raises SpecError where a parameter that
        was named is left out, MeshError where there is no mesh.
        """
        of_geometry = [p for p in self.parameters if p.of_geometry]
        if not of_geometry:
            return {"paths": [p.path for p in self.parameters], "motion": None}, []
        file = folder / "motion.npz"
        moved = mesh_motion(self._spec.geometry, of_geometry, file, self._spec.solver.curved)
        pairs = list(zip(of_geometry, moved.velocities, strict=True))
        refused = {p.path: why for p, why in pairs if isinstance(why, str)}
        if faults := [f"{self._wanted[p]}: {refused[p]}" for p in refused if p in self._wanted]:
            raise SpecError(*faults)
        kept = [v for _, v in pairs if not isinstance(v, str)]
        Moved(moved.points, moved.edges, kept, moved.means).store(file)
        paths = [p.path for p in self.parameters if p.path not in refused]
        notes = [
            f"sensitivities: left out: {', '.join(p for p in refused if refused[p] == why)}: {why}"
            for why in dict.fromkeys(refused.values())
        ]
        return {"paths": paths, "motion": str(file)}, notes

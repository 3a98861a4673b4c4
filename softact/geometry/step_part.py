"""A STEP file in gmsh: its solids, joined where they touch, and its faces, by their names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np

from softact.errors import MeshError
from softact.geometry.part_size import Drawn
from softact.geometry.step_faces import (
    NEAR,
    Face,
    Selection,
    around_rooms,
    automatic,
    faces_of,
    linked,
)
from softact.geometry.step_joining import join
from softact.geometry.step_names import UNITS, StepFile
from softact.geometry.step_solids import Solid, named
from softact.mesh.components import place
from softact.mesh.file_mesh import listed, similar
from softact.units import show

MOST_FACES = 60  # in a list of all
STEP = (".step", ".stp")
LISTS = "'softact validate' lists the faces"


@dataclass(frozen=True)
class StepPart:
    """file: its name. solids: in gmsh's order; names: of each, made up where the file gives none.
    drawn: its size. faces: of all solids, those between joined ones once. slack: mm by which their
    boxes may be too large."""

    file: str
    solids: tuple[Solid, ...]
    names: tuple[str, ...]
    drawn: Drawn
    faces: tuple[Face, ...]
    slack: float = 0.0

    @classmethod
    def read(
        cls,
        gmsh: ModuleType,
        path: Path,
        unit: str | None,
        separate: bool,
        mesh_size: float | None,
        heal: float | None = None,
    ) -> StepPart:
        """Put the solids of a file into gmsh's current model, in mm.

        unit: of length, where the file says it wrong or not at all. separate: whether solids that
        touch are left apart. mesh_size: mm, None where it is not meshed. heal: edges
        and faces narrower than this (mm) are removed. Raises MeshError where
        there is no solid, where part and mesh size do not fit, or where solids cannot be joined.
        """
        file = StepFile(path.read_text(encoding="utf-8", errors="replace"))
        others = [
            n for n in map(file.name, file.kinds("DOCUMENT_FILE")) if n.lower().endswith(STEP)
        ]
        if others:
            raise MeshError(
                f"{path.name} refers to other files ({listed(others)}); export the whole assembly "
                "into one"
            )
        said = file.units()
        if unit and len(said) > 1:
            raise MeshError(f"{path.name} has several units ({', '.join(said)}); leave unit: out")
        in_file = said[0] if said else "mm"  # as OCC takes it
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        gmsh.option.setNumber("Geometry.OCCScaling", _size(unit or in_file) / _size(in_file))
        try:
            gmsh.model.occ.importShapes(str(path.absolute()), True, "step")
        except Exception as error:
            reason = " ".join(str(error).split())
            raise MeshError(f"{path.name} cannot be read as a STEP file: {reason}") from None
        gmsh.model.occ.synchronize()
        if heal is not None:
            _heal(gmsh, path.name, heal)
        if not gmsh.model.getEntities(3):
            raise MeshError(
                f"{path.name} holds no solid: its surfaces do not close one (not watertight)"
            )
        drawn = Drawn.of_model(gmsh, unit or in_file, not unit and bool(said))
        if mesh_size is not None:
            drawn.refuse(mesh_size)
        scale = _size(unit or in_file) if len(said) < 2 else None
        solids = named(gmsh, file.bodies(), scale)
        names = tuple(s.name or f"solid_{i}" for i, s in enumerate(solids, start=1))
        pieces: dict[int, list[int]] = {}
        if len(solids) > 1 and not separate:
            solids, pieces = join(gmsh, solids, names)
        faces = tuple(faces_of(gmsh, solids, pieces))
        return cls(path.name, tuple(solids), names, drawn, faces, 2 * (heal or 0.0))

    def regions(self, wanted: Sequence[str]) -> dict[str, list[int]]:
        """Region -> gmsh's tags of its solids. Raises MeshError where one is missing or left."""
        if len(self.solids) == 1 == len(wanted):
            return {wanted[0]: [self.solids[0].tag]}
        found: dict[str, list[int]] = {name: [] for name in wanted}
        faults = []
        for number, (solid, name) in enumerate(zip(self.solids, self.names, strict=True), start=1):
            fitting = [region for region in found if region in (name, f"solid_{number}")]
            if not fitting:
                also = f" (or solid_{number})" if solid.name else ""
                faults.append(f"the solid {show(name)}{also} is in no region; name all solids")
            elif len(fitting) > 1:
                faults.append(f"{' and '.join(map(show, fitting))} are one solid; name it once")
            for region in fitting:
                found[region].append(solid.tag)
        known = f"there are {listed(list(dict.fromkeys(self.names)))}"
        lost = [name for name, tags in found.items() if not tags]
        faults += [f"no solid has the name {show(name)}; {known}" for name in lost]
        if faults:
            raise MeshError(*(f"{self.file}: {fault}" for fault in faults))
        return found

    def surfaces(
        self,
        wanted: Sequence[str],
        walls: Sequence[str],
        select: Mapping[str, Selection],
        ends: tuple[str, str],
        axis: str,
    ) -> tuple[dict[str, list[Face]], list[str]]:
        """Surface -> its faces, and those that have their names by themselves.

        walls: those of the wanted ones that wall a cavity. ends, axis: names of clamp and tip, and
        which way the part points. Raises MeshError where one has no face.
        """
        by_name: dict[str, list[Face]] = {}
        for face in self.faces:
            for name in face.names:
                by_name.setdefault(name, []).append(face)
        by_itself = {} if by_name else automatic(self.faces, *ends, axis, self.slack)
        near = NEAR * float(np.linalg.norm(self.drawn.extents)) + 1e-6 + self.slack
        chosen = self._chosen(select, by_itself | by_name, near)
        found = by_itself | by_name | chosen
        found |= {n: around_rooms(found[n], self.faces) for n in walls if n in found}
        faults = [
            f"{self.file}: {self._no_face(name, name in select, by_name, by_itself)}"
            for name in wanted
            if not found.get(name)
        ]
        if faults:
            raise MeshError(*faults)
        alone = [name for name in wanted if name in by_itself and name not in chosen]
        return {name: found[name] for name in wanted}, alone

    def _chosen(
        self, select: Mapping[str, Selection], named: Mapping[str, list[Face]], near: float
    ) -> dict[str, list[Face]]:
        """The faces of each selection; those beside the faces of another come after it."""
        chosen: dict[str, list[Face]] = {}
        waiting = dict(select)
        while waiting:
            ready = [
                name
                for name, selection in waiting.items()
                if not (isinstance(selection.beside, str) and selection.beside in waiting)
            ]
            for name in ready or list(waiting):  # those in a circle choose nothing
                selection = waiting.pop(name)
                others = self._beside(selection, {**named, **chosen})
                chosen[name] = [f for f in self.faces if selection.holds(f, near, others)]
        return chosen

    def _beside(self, selection: Selection, named: Mapping[str, list[Face]]) -> list[Face]:
        beside = selection.beside
        if isinstance(beside, str):
            return named.get(beside, [])
        return [face for face in self.faces if face.numbers & set(beside or ())]

    def slivers(self, below: float) -> Iterator[str]:
        """A line for each face narrower than so many mm."""
        for face in self.faces:
            if face.width < below:
                numbers = " and ".join(map(str, sorted(face.numbers)))
                yield (
                    f"face {numbers} is a sliver {face.width:.2g} mm wide near "
                    f"{place(face.centre)}: it makes tiny elements; heal: {_above(face.width)} mm "
                    "removes it"
                )

    def _no_face(self, name: str, selected: bool, by_name: Mapping, by_itself: Mapping) -> str:
        if selected:
            return f"select.{name} chooses no face; {LISTS}"
        choose = f"choose it by number or place, select: {{{name}: [1, 2]}} ({LISTS})"
        if not by_name:
            there = listed(sorted(by_itself)) or "none"
            return (
                f"no face has a name, and {show(name)} is not among those that are found without "
                f"({there}); name it in the CAD program and export with names, or {choose}"
            )
        return (
            f"no face has the name {show(name)}; there are {listed(sorted(by_name))}"
            f"{similar(name, by_name)}; or {choose}"
        )

    def parts(self) -> list[list[str]]:
        """The names of the solids of each part that hangs together."""
        touching = [face.solids for face in self.faces]
        number: dict[int, int] = {}
        for solids, label in zip(touching, linked(touching), strict=True):
            number |= dict.fromkeys(solids, label)
        labels = [number[solid.tag] for solid in self.solids]
        return [
            [name for name, own in zip(self.names, labels, strict=True) if own == label]
            for label in dict.fromkeys(labels)
        ]

    def overview(self) -> Iterator[str]:
        """Lines about the whole: size, unit, solids, and over what area they are joined."""
        source = f"the file says {self.drawn.unit}" if self.drawn.said else f"in {self.drawn.unit}"
        count = len({number for face in self.faces for number in face.numbers})
        solids = f"{len(self.solids)} solid{'s' * (len(self.solids) > 1)}"
        yield f"{self.file}: {solids} with {count} faces, {self.drawn.sides} ({source})"
        area = sum(face.area for face in self.faces if len(face.solids) == 2)
        if area:
            yield f"solids that touch are joined, over {area:.4g} mm^2"

    def apart(self) -> Iterator[str]:
        """A line about the parts that the solids make, where there are several."""
        parts = self.parts()
        if len(parts) > 1:
            apart = "; ".join(listed(part) for part in parts)
            yield f"{len(parts)} parts, which are not joined: {apart}"

    def owners(self) -> dict[int, str]:
        """The name of each solid, by gmsh's tag; "" where there is one only."""
        owners = {s.tag: name for s, name in zip(self.solids, self.names, strict=True)}
        return owners if len(owners) > 1 else dict.fromkeys(owners, "")

    def list_of_faces(self) -> Iterator[str]:
        """A line for each face."""
        owners = self.owners()
        for face in self.faces[:MOST_FACES]:
            yield face.line(" and ".join(owners[solid] for solid in face.solids))
        if len(self.faces) > MOST_FACES:
            yield f"and {len(self.faces) - MOST_FACES} more faces"


def numbers_of(faces: Sequence[Face]) -> str:
    """The numbers of faces as text: 'faces 1, 3 to 6'."""
    numbers = sorted({number for face in faces for number in face.numbers})
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    texts = [", ".join(map(str, run)) if len(run) < 3 else f"{run[0]} to {run[-1]}" for run in runs]
    return f"face{'s' * (len(numbers) > 1)} {', '.join(texts)}"


def _heal(gmsh: ModuleType, name: str, narrow: float) -> None:
    """Let OCC remove small edges and faces, and close gaps, of all solids. Raises MeshError."""
    try:
        gmsh.model.occ.healShapes([], narrow, True, True, True, True, True)
        gmsh.model.occ.synchronize()
    except Exception as error:
        reason = " ".join(str(error).split())
        raise MeshError(f"{name}: OCC cannot heal it with {narrow:g} mm: {reason}") from None


def _above(width: float) -> str:
    """A round length a little above a width."""
    return f"{float(f'{2 * width:.1g}'):g}"


def _size(unit: str) -> float:
    """mm of a unit as ``StepFile.units`` writes it."""
    return UNITS[unit] if unit in UNITS else float(unit.split()[0])

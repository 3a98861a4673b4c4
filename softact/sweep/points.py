"""The points of a design as specs, each with the key under which its run is kept."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from softact.errors import SpecError
from softact.files import document
from softact.files.text import digest, write_atomic
from softact.geometry.imported import Imported
from softact.spec import Spec, spec_at
from softact.sweep.axes import Axis
from softact.sweep.design import Coordinates
from softact.sweep.version import run_key, version

#: Makes the spec of a point of a base and of what is changed in it.
Make = Callable[[document.Document, Iterable[tuple[str, Any]]], Spec]


@dataclass(frozen=True)
class DesignPoint:
    """One point: its coordinates, and the key of its run or why there can be none.

    key: None where the spec of the point is wrong; then ``faults`` says why.
    """

    coordinates: Coordinates
    changes: tuple[tuple[str, Any], ...]
    key: str | None
    faults: tuple[str, ...] = ()

    def text(self) -> str:
        """The coordinates in a few words."""
        return ", ".join(f"{name} {value}" for name, value in self.coordinates.items()) or "base"

    def options(self) -> list[str]:
        """The options of ``softact run`` that give this point from the base."""
        return [f"--set {path}='{value}'" for path, value in self.changes]


def changes_of(axes: Sequence[Axis], coordinates: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    """(path, value) of each path that differs from the base."""
    titles = {axis.title: axis for axis in axes}
    return tuple(pair for title, v in coordinates.items() for pair in titles[title].changes(v))


def first_right(
    make: Make, base: document.Document, axes: Sequence[Axis], designs: Iterable[Coordinates]
) -> Spec:
    """The first right spec of some designs. make: ``StudyFile.spec_at``.

    Raises SpecError with the faults of the first where there is none."""
    faults: list[str] = []
    for coordinates in designs:
        try:
            return make(base, changes_of(axes, coordinates))
        except SpecError as error:
            faults = faults or error.lines
    raise SpecError(*faults)


class Plan:
    """Keys of points, remembered in a file: to make 10,000 specs takes a minute, to read their
    keys a moment. What is remembered counts for one base spec, one content of the files that it
    names, and one version of softact. The key of a geometry that a script makes is never
    remembered: nobody knows what the script reads.

    path: the file, None where nothing is remembered. make, blocked: ``StudyFile.spec_at`` and
    ``StudyFile.kinds``, by default those of whole actuators.
    """

    def __init__(
        self,
        base: document.Document,
        path: Path | None = None,
        make: Make = spec_at,
        blocked: Sequence[str] | None = None,
    ):
        self.base, self._make, self._blocked = base, make, blocked
        self.folders = (base.folder, Path())
        known = [base.data, self._contents(base.data), blocked]
        text = json.dumps(known, sort_keys=True, default=str)
        self.fingerprint = hashlib.sha256((text + version()).encode()).hexdigest()
        self.known: dict[str, Any] = {}
        try:
            stored = json.loads(path.read_text(encoding="utf-8")) if path else {}
            if stored.get("fingerprint") == self.fingerprint:
                self.known = stored["points"]
        except (OSError, ValueError, AttributeError, KeyError):
            pass  # nothing is remembered, or a file that is damaged: the keys are made anew

    def points(self, axes: Sequence[Axis], design: Sequence[Coordinates]) -> list[DesignPoint]:
        """The points of a design. Raises SpecError where no point at all has a right spec."""
        points = [self._point(axes, coordinates) for coordinates in design]
        if all(point.key is None for point in points):
            raise SpecError(*points[0].faults)
        return points

    def remember(self, path: Path) -> None:
        """Write the file, for the next call."""
        data = {"fingerprint": self.fingerprint, "points": self.known}
        write_atomic(path, json.dumps(data))

    def _point(self, axes: Sequence[Axis], coordinates: Coordinates) -> DesignPoint:
        changes = changes_of(axes, coordinates)
        name = json.dumps([changes, self._contents(changes)], sort_keys=True, default=str)
        found = self.known.get(name)
        if found is None:
            found, lasting = self._key(changes)
            if lasting:
                self.known[name] = found
        if isinstance(found, str):
            return DesignPoint(coordinates, changes, found)
        return DesignPoint(coordinates, changes, None, tuple(found))

    def _key(self, changes: Sequence[tuple[str, Any]]) -> tuple[str | list[str], bool]:
        """The key of a point, or the faults of its spec, and whether it may be remembered."""
        try:
            spec = self._make(self.base, changes)
        except SpecError as error:
            return error.lines, True
        geometry = spec.geometry
        key = run_key(spec, blocked=self._blocked)
        return key, not isinstance(geometry, Imported) or geometry.self_contained

    def _contents(self, value: Any) -> list[tuple[str, str]]:
        """Every text in plain data that is the name of a file, and the digest of the file."""
        if isinstance(value, str):
            paths = [folder / value for folder in self.folders]
            return [(value, digest(path)) for path in paths if _is_file(path)]
        if isinstance(value, dict):
            value = list(value.values())
        if isinstance(value, list | tuple):
            return [pair for item in value for pair in self._contents(item)]
        return []


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a text that is too long for a name, or holds a null
        return False

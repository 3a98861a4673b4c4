"""The points of a design as specs, each with the key under which its run is kept."""

from __future__ import annotations

import copy
import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from softact.errors import SpecError
from softact.spec import Spec, document, overrides
from softact.spec.faults import fault_lines
from softact.sweep.axes import Axis
from softact.sweep.design import Coordinates
from softact.sweep.version import run_key, version


@dataclass(frozen=True)
class Point:
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


def changes_of(axes: Sequence[Axis], coordinates: Coordinates) -> tuple[tuple[str, Any], ...]:
    """(path, value) of each path that differs from the base."""
    titles = {axis.title: axis for axis in axes}
    return tuple((path, v) for title, v in coordinates.items() for path in titles[title].path)


def spec_at(base: document.Document, changes: Sequence[tuple[str, Any]]) -> Spec:
    """The spec of a point. Raises SpecError."""
    here = document.Document(
        base.name, copy.deepcopy(base.data), dict(base.lines), dict(base.overridden)
    )
    for path, value in changes:
        overrides.assign(here, path, copy.deepcopy(value), f"{path}={value}")
    try:
        return Spec.model_validate(here.data)
    except ValidationError as error:
        raise SpecError(*fault_lines(error, here, Spec)) from None


class Plan:
    """Keys of points, remembered in a file: to make 10,000 specs takes a minute, to read their
    keys a moment. What is remembered counts for one base spec and one version of softact only.

    path: the file, None to remember nothing.
    """

    def __init__(self, base: document.Document, path: Path | None = None):
        self.base, self.path = base, path
        text = json.dumps(base.data, sort_keys=True, default=str) + version()
        self.fingerprint = hashlib.sha256(text.encode()).hexdigest()
        self.known: dict[str, Any] = {}
        try:
            stored = json.loads(path.read_text(encoding="utf-8")) if path else {}
            if stored.get("fingerprint") == self.fingerprint:
                self.known = stored["points"]
        except (OSError, ValueError, AttributeError, KeyError):
            pass  # nothing is remembered, or a file that is damaged: the keys are made anew

    def points(self, axes: Sequence[Axis], design: Sequence[Coordinates]) -> list[Point]:
        """The points of a design. Raises SpecError where no point at all has a right spec."""
        points = list(self._points(axes, design))
        if all(point.key is None for point in points):
            raise SpecError(*points[0].faults)
        if self.path is not None:
            from softact.files import write_atomic

            data = {"fingerprint": self.fingerprint, "points": self.known}
            write_atomic(self.path, json.dumps(data))
        return points

    def _points(self, axes, design) -> Iterator[Point]:
        for coordinates in design:
            changes = changes_of(axes, coordinates)
            name = json.dumps(changes, default=str)
            if name not in self.known:
                try:
                    self.known[name] = run_key(spec_at(self.base, changes))
                except SpecError as error:
                    self.known[name] = error.lines
            found = self.known[name]
            if isinstance(found, str):
                yield Point(coordinates, changes, found)
            else:
                yield Point(coordinates, changes, None, tuple(found))

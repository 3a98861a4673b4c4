"""What is drawn of an actuator: its skin in chosen states, handed to ``render.py``."""

import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from softact.child_processes import environment
from softact.forkserver import command
from softact.report import labels
from softact.report.obstacles import bodies
from softact.report.surface import Skin, drawn, mirrored, skin
from softact.report.view import STRESS_COLOURS, View, bending_view, colour_range
from softact.results.folder import Results

_TIME_LIMIT_S = 600.0
_RENDERING = str(Path(__file__).with_name("render.py"))
# Neither a display nor the MPI job that we may be part of is the business of who draws.
_NOT_ITS_BUSINESS = ("OMPI_", "PMIX_", "PMI_", "PRTE_", "DISPLAY", "WAYLAND_DISPLAY")


class DrawingError(Exception):
    """The process that draws failed; the text says how."""


@dataclass(frozen=True)
class Group:
    """States drawn in one frame. numbers: of the states, -1 is undeformed and a fraction is linear
    between two; ghost: whether the
    undeformed outline is drawn too; low, high: corners of the frame, mm in the picture; size:
    width and height in pixels.
    """

    numbers: Sequence[float]
    ghost: bool
    low: np.ndarray
    high: np.ndarray
    size: tuple[int, int]


@dataclass(frozen=True)
class Scene:
    """All that is the same in every picture of a result. limits: of the field's colours."""

    results: Results
    skin: Skin
    view: View
    field: str
    limits: tuple[float, float]

    def points(self, number: float) -> np.ndarray:
        """(v, 3) mm: vertices of the meshed part in state ``number``; -1 is undeformed."""
        moved = np.zeros_like(self.results.points)
        if number >= 0:
            moved = _between(number, lambda n: self.results.field(n, "displacement"))
        return drawn(self.results, moved)[self.skin.nodes]

    def values(self, number: float) -> np.ndarray:
        """(v,) of the field in state ``number``."""
        if number < 0:
            return np.full(len(self.skin.nodes), self.limits[0])
        return _between(number, lambda n: self.results.scalar(n, self.field))[self.skin.nodes]

    def group(self, numbers: Sequence[float], ghost: bool, pixels: float) -> Group:
        """A frame about all these states whose longer side has ``pixels``, even numbers."""
        used = np.unique(self.skin.outer)
        projected = []
        for number in [*numbers, -1] if ghost else numbers:
            whole, _ = mirrored(self.points(number)[used], np.zeros((0, 3), int), self.skin.mirrors)
            projected.append(self.view.project(whole))
        flat = np.vstack(projected)
        margin = 0.04 * np.ptp(flat, axis=0).max()
        low, high = flat.min(axis=0) - margin, flat.max(axis=0) + margin
        mm = (high - low).max() / pixels  # of a pixel
        width, height = size = 2 * np.ceil((high - low) / mm / 2).astype(int)
        middle = (low + high) / 2
        low, high = middle - size * mm / 2, middle + size * mm / 2
        return Group(numbers, ghost, low, high, (int(width), int(height)))

    def bodies(self, numbers: Sequence[float], whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points (states, m, 3) and triangles (b, 3) of the obstacles; those that are not there
        have shrunk to a point."""
        points, triangles, count = [np.zeros((len(numbers), 0, 3))], [np.zeros((0, 3), int)], 0
        for body in bodies(self.results, whole.min(axis=0), whole.max(axis=0)):
            places = [body.at(n) if body.seen(n) else 0 * body.points for n in numbers]
            points.append(np.array(places))
            triangles.append(body.triangles + count)
            count += len(body.points)
        return np.concatenate(points, axis=1), np.concatenate(triangles)

    def job(self, group: Group) -> dict[str, np.ndarray]:
        """Arrays for ``render.py``."""
        points, values = [], []
        for number in group.numbers:
            whole, triangles = mirrored(self.points(number), self.skin.outer, self.skin.mirrors)
            points.append(whole)
            values.append(np.tile(self.values(number), len(whole) // len(self.skin.nodes)))
        ghost, edges = mirrored(self.points(-1), self.skin.edges, self.skin.mirrors)
        beside, body_triangles = self.bodies(group.numbers, np.concatenate(points))
        return {
            "bodies": beside, "body_triangles": body_triangles,
            "points": np.array(points), "values": np.array(values), "triangles": triangles,
            "edges": edges, "ghost": ghost if group.ghost else np.zeros((0, 3)),
            "limits": np.array(self.limits), "colours": colours(STRESS_COLOURS),
            "right": self.view.right, "up": self.view.up, "eye": self.view.eye,
            "low": group.low, "high": group.high, "size": np.array(group.size),
        }  # fmt: skip


def _between(number: float, state: Callable[[int], np.ndarray]) -> np.ndarray:
    low = int(number)
    part = number - low
    return state(low) if part == 0 else (1 - part) * state(low) + part * state(low + 1)


def make_scene(results: Results, parts: Skin | None = None) -> Scene:
    """The scene of a result that has states. parts: its ``skin``, where that is known."""
    parts = parts or skin(results)
    names = results.field_names(-1)
    field = next((name for name in labels.FIELDS if name in names), "displacement")
    low, high, _ = colour_range(results, field, parts.nodes[np.unique(parts.outer)])
    return Scene(results, parts, bending_view(results), field, (low, high))


def colours(names: Sequence[str]) -> np.ndarray:
    """(n, 3) in 0..1 of colours such as "#4143a7"."""
    return np.array([[int(c[n : n + 2], 16) / 255 for n in (1, 3, 5)] for c in names])


class Renderer:
    """A process that draws; it is given groups of states one by one.

    scratch: folder of its jobs and pictures. Starts the process, which loads its libraries while
    the first job is made.
    """

    def __init__(self, scratch: Path):
        self._scratch = scratch
        self._errors = scratch / "stderr"
        self._pictures: list[Path] = []
        variables = environment(without=_NOT_ITS_BUSINESS)
        with self._errors.open("wb") as stderr:
            self.process = subprocess.Popen(
                command([_RENDERING, str(scratch)], variables),
                stdin=subprocess.PIPE,  # ends with us, and tells the process so
                env=variables,
                stderr=stderr,
                stdout=subprocess.DEVNULL,
            )

    def draw(self, job: Mapping[str, np.ndarray]) -> None:
        """Begin to draw the arrays of a job, see ``render.py``."""
        file = self._scratch / f"{len(self._pictures)}.npz"
        # Not told through a pipe: PETSc makes writing into one that is closed the end of all.
        arrays: dict[str, Any] = {**job}  # stubs of numpy 2 want a bool among them
        np.savez(file.with_suffix(".new.npz"), **arrays)
        file.with_suffix(".new.npz").rename(file)
        self._pictures.append(file.with_suffix(".npy"))

    def drawn(self) -> Iterator[np.ndarray]:
        """For each group (states, height, width, 3) uint8 on white, as soon as it is there.

        Raises DrawingError with one line where the process failed.
        """
        return (picture[..., :3] for picture in self.covering())

    def covering(self) -> Iterator[np.ndarray]:
        """As ``drawn``, with how much of each pixel is covered as a fourth channel."""
        (self._scratch / "end").touch()
        until = time.monotonic() + _TIME_LIMIT_S
        for picture in self._pictures:
            while not picture.exists():
                ended = self.process.poll()
                if ended is not None and not picture.exists():
                    raise DrawingError(self._said(ended))
                if time.monotonic() > until:
                    raise DrawingError(
                        f"drawing took longer than {_TIME_LIMIT_S:g} s and was given up"
                    )
                time.sleep(0.005)
            yield np.load(picture)

    def _said(self, code: int) -> str:
        words = self._errors.read_text(encoding="utf-8", errors="replace").splitlines()
        said = [line for line in words if line.strip()]
        return f"drawing ended with code {code}: {said[-1] if said else 'no message'}"


@contextmanager
def renderer() -> Iterator[Renderer]:
    """A ``Renderer`` that ends with the block."""
    with tempfile.TemporaryDirectory(prefix="softact-draw-") as scratch:
        started = Renderer(Path(scratch))
        try:
            yield started
        finally:
            started.process.kill()
            started.process.communicate()  # closes what it is told by, and waits

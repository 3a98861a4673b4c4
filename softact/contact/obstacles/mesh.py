"""A body out of an STL file."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from softact.contact.closed_surface import ClosedSurface, closed
from softact.contact.obstacles.base import Filled, SpecObstacle, rotation_of
from softact.contact.obstacles.block import Turns
from softact.errors import SpecError
from softact.fields import Point, fault_at
from softact.files.stl import read_stl
from softact.files.text import NAMES_A_FILE, digest
from softact.units import Dimensionless, Length

ROUNDING = 0.01  # radius of the edges by the smallest extent


class MeshObstacle(SpecObstacle):
    """A body out of an STL file, which closes it."""

    kind: ClassVar[str] = "mesh"

    type: Literal["mesh"]
    file: Annotated[str, NAMES_A_FILE] = Field(
        description="STL file (text or binary), seen from the file that names it"
    )
    scale: Dimensionless = Field(1.0, gt=0, description="mm of the file's unit: 1000 for m")
    center: Point | None = Field(
        None, description="where the middle of its volume is put; default: where the file has it"
    )
    rotation: Turns = Field(
        (0.0, 0.0, 0.0),
        description="turned about x, then about y, then about z through that middle",
    )
    rounding: Length | None = Field(
        None,
        gt=0,
        description="radius of its edges, so that what presses on it has a normal; default: 1 % of "
        "its smallest extent",
    )

    def shape(self) -> Solid:
        """See ``SpecObstacle``. Raises SpecError where the file does not hold one."""
        path = Path(self.file)
        return _solid(path, digest(path), self.scale, self.center, self.rotation, self.rounding)

    @model_validator(mode="after")
    def _is_closed(self) -> Self:
        try:
            self.shape()
        except SpecError as error:
            place = "rounding" if str(error).startswith("rounding") else "file"
            raise fault_at((place,), str(error).removeprefix("rounding: ")) from None
        except OSError as error:
            raise fault_at(("file",), f"there is no file '{self.file}': {error.strerror}") from None
        return self


@functools.lru_cache(maxsize=16)
def _solid(
    path: Path,
    content: str,
    scale: float,
    center: tuple[float, float, float] | None,
    rotation: tuple[float, float, float],
    rounding: float | None,
) -> Solid:
    """The shape of a file with this content."""
    read = closed(scale * read_stl(path), str(path))
    middle = read.centre
    there = middle if center is None else np.asarray(center)
    points = (read.points - middle) @ rotation_of(rotation).T + there
    surface = ClosedSurface(points, read.triangles)
    if rounding is None:
        rounding = ROUNDING * float(np.ptp(points, axis=0).min())
    x, y, z = (float(c) for c in there)
    return Solid(surface, surface.inside(rounding), rounding, (x, y, z))


@dataclass(frozen=True, eq=False)
class Solid:
    """A closed surface with rounded edges: what is ``rounding`` mm or less from ``inner``."""

    outer: ClosedSurface
    inner: ClosedSurface
    rounding: float
    center: tuple[float, float, float]

    @property
    def filled(self) -> Filled:
        """See ``Shape``: its corners touch other obstacles."""
        return Filled(self.outer.gyration, self.outer.points)

    @property
    def room(self) -> float:
        """See ``Shape``."""
        return self.inner.room + self.rounding

    def gap(self, x: np.ndarray) -> np.ndarray:
        """See ``Shape``."""
        return self.distance(x)[0]

    def distance(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See ``Shape``: that from the surface inside, whose normals have no jumps outside of it
        but where it is hollow, less the rounding."""
        g, n, h = self.inner.distance(x)
        return g - self.rounding, n, h

    def surface(self, extent: float, about: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The triangles of the file."""
        return self.outer.points, self.outer.triangles

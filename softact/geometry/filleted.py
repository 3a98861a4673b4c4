"""What geometries share whose edges may be rounded: then gmsh meshes what OCC builds."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from types import ModuleType
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from softact.geometry.chains import Chain
from softact.geometry.fillets import around, chord_error, fill_rounded
from softact.geometry.subdivide import cut_mesh
from softact.units import Length

if TYPE_CHECKING:
    from softact.geometry.boxes import Boxes
    from softact.geometry.prisms import Prisms

FilletSize = Annotated[
    Length | None,
    Field(
        description="longest edge around the fillets; by default two elements to a quarter of each"
    ),
]


class Filleted(Chain):
    """A geometry with a field ``fillet_mesh_size: FilletSize`` and radii, 0 mm where edges are
    sharp."""

    if TYPE_CHECKING:
        fillet_mesh_size: float | None

    @property
    @abstractmethod
    def fillets(self) -> Mapping[str, float]:
        """Radii (mm) by the names of their fields."""

    @abstractmethod
    def solid(self) -> Boxes | Prisms:
        """The solid as it is painted."""

    @property
    def filleted(self) -> bool:
        """Whether any edge is rounded."""
        return any(self.fillets.values())

    def chord_error(self, radius: float) -> float:
        """Area (mm²) between a quarter of a rounding and the straight edges of the mesh along
        it."""
        least = min(filter(None, self.fillets.values()))
        return chord_error(radius, around(least, self.fillet_mesh_size))

    def no_chain(self) -> Iterator[tuple[str, str]]:
        """Why there is no module: the faces of a mesh of gmsh's do not repeat."""
        yield from super().no_chain()
        for name, radius in self.fillets.items():
            if radius:
                yield name, "a module of its own has sharp edges; leave it out"

    def entities(self, gmsh: ModuleType) -> None:
        """See ``Geometry.entities``."""
        self.solid().divide(gmsh)

    def mesh(self, gmsh: ModuleType) -> None:
        """See ``Geometry.mesh``; for what has fillets."""
        self.entities(gmsh)
        radius = min(filter(None, self.fillets.values()))
        fill_rounded(gmsh, radius, self.mesh_size, self.fillet_mesh_size, self.least_steps)
        cut_mesh(gmsh, self.least_steps)

"""A solid box with named faces: the specimen for material tests and beams.

Run by itself it writes a mesh: ``python geometries/block.py --length "100 mm" -o block.msh``.
"""

from types import ModuleType
from typing import ClassVar, Literal

from pydantic import Field

from softact.geometry.base import Layout, ThroughWall, main
from softact.geometry.boxes import Box, Boxes, Counts, Plane
from softact.geometry.chains import Chain, OneModule
from softact.geometry.walls import Wall
from softact.units import Length


class Block(Chain):
    """A solid box with one corner in the origin; x_min is the clamp, x_max the tip."""

    meets_itself: ClassVar[bool] = False

    type: Literal["block"] = "block"
    length: Length = Field(10.0, description="extent along x")
    width: Length = Field(10.0, description="extent along y")
    height: Length = Field(10.0, description="extent along z")
    mesh_size: Length = Field(5.0, description="longest edge along the axes")
    through_wall: ThroughWall = None
    module_alone: OneModule = None

    @property
    def ends(self) -> tuple[str, str]:
        return "x_min", "x_max"

    @property
    def pitches(self) -> float:
        """The whole block is a module: any slice of it is one."""
        return 1.0

    def layout(self) -> Layout:
        names = tuple(f"{axis}_{end}" for axis in "xyz" for end in ("min", "max"))
        return Layout(
            regions=("body",),
            surfaces=names,
            cavities={},
            clamp="x_min",
            tip="x_max",
            length=self.length,
            repeats=self.repeats,
        )

    def walls(self) -> tuple[Wall, ...]:
        """None that bends."""
        return ()

    def volumes(self) -> dict[str, float]:
        a, b, c = self.length, self.width, self.height
        faces = {"x": b * c, "y": a * c, "z": a * b}
        areas = {f"{axis}_{end}": area for axis, area in faces.items() for end in ("min", "max")}
        return {"body": a * b * c, **areas}

    def solid(self) -> Boxes:
        """The box with its six named planes."""
        extent = (self.length, self.width, self.height)
        planes = [
            Plane(f"{'xyz'[axis]}_{end}", axis, at)
            for axis in range(3)
            for end, at in (("min", 0.0), ("max", extent[axis]))
        ]
        return Boxes((Box("body", (0.0, 0.0, 0.0), extent),), ("body",), planes=tuple(planes))

    def _counts(self, solid: Boxes) -> Counts:
        (along,), *across = solid.counts(self.mesh_size, self.mesh_size, self.least_steps)
        # From face to face the split of the cells fits for an even number of steps only.
        return ((along + along % 2,) if self.alone else (along,)), *across

    def cells(self) -> int:
        solid = self.solid()
        return solid.cells(self._counts(solid))

    def build(self, gmsh: ModuleType) -> None:
        self.solid().build(gmsh)

    def mesh(self, gmsh: ModuleType) -> None:
        solid = self.solid()
        solid.grid(self._counts(solid)).add_to(gmsh)


if __name__ == "__main__":
    main(Block)

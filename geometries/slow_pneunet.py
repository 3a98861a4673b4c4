"""A slow PneuNet: a row of chambers in one block, joined by a tunnel.

Moseley et al. (2016), Adv. Eng. Mater. 18:978. The bending kind is open below and closed by a film;
the linear kind has the same wall below as above. Run by itself it writes a mesh:
``python geometries/slow_pneunet.py --chambers 5 -o block.msh``.
"""

from collections.abc import Iterator
from types import ModuleType
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from softact.geometry.base import Layout, ThroughWall, main
from softact.geometry.boxes import Box, Boxes, Counts, Plane
from softact.geometry.chains import OneModule
from softact.geometry.filleted import Filleted, FilletSize
from softact.geometry.fillets import Rounded, beside, too_large
from softact.geometry.steps import steps
from softact.geometry.walls import Wall
from softact.units import Length

SHORT = 4  # chambers of a finger whose middle ones know nothing of the ends

FILM, FLOOR = 0.5, 7.0  # mm, where nothing is given


class SlowPneunet(Filleted):
    """A slow PneuNet: a block with a row of chambers, joined by a tunnel.

    Along x: clamp wall, chambers with walls between them, tip wall. Across y: outer wall, chamber,
    outer wall. Along z from below, bending kind: film, chamber, roof; the tunnel runs along the
    floor, and the film alone closes chambers and tunnel below. Linear kind: floor, chamber, roof;
    the tunnel runs at half height. The film is a region of its own, meshed one element thick.
    """

    type: Literal["slow_pneunet"] = "slow_pneunet"
    kind: Literal["bending", "linear"] = Field("bending", description="what the pressure does")
    chambers: Annotated[int, Field(ge=1, le=200)] = Field(5, description="number of chambers")
    chamber_height: Length = Field(8.0, description="height of the air space of a chamber")
    chamber_width: Length = Field(8.0, description="width of the air space of a chamber (y)")
    chamber_length: Length = Field(2.0, description="length of the air space of a chamber (x)")
    inner_wall: Length = Field(7.0, description="walls between chambers")
    outer_wall: Length = Field(7.0, description="side walls (across y)")
    roof: Length = Field(7.0, description="wall above the chambers")
    floor: Length | None = Field(
        None, description="wall below the chambers, linear kind only; by default 7 mm"
    )
    clamp_wall: Length = Field(7.0, description="wall between the clamp and the first chamber")
    tip_wall: Length = Field(7.0, description="wall between the last chamber and the tip")
    tunnel_width: Length = Field(2.0, description="width of the tunnel that joins the chambers")
    tunnel_height: Length = Field(2.0, description="height of the tunnel")
    film_thickness: Length | None = Field(
        None, description="film below, bending kind only; by default 0.5 mm"
    )
    film_width: Length | None = Field(
        None, description="width of the film, bending kind only; by default that of the block"
    )
    fillet: Length = Field(
        0.0,
        description="radius of the edges of chambers and tunnel, but for those at the film; "
        "0 mm: sharp",
    )
    symmetry: bool = Field(True, description="model the half y >= 0 only")
    mesh_size: Length = Field(2.0, description="longest edge along the axes")
    cavity_mesh_size: Length | None = Field(
        None, description="the same between the walls of the chambers; by default mesh_size"
    )
    fillet_mesh_size: FilletSize = None
    through_wall: ThroughWall = None
    module_alone: OneModule = None

    counted: ClassVar[tuple[str, str] | None] = ("chambers", "chamber")

    @property
    def fillets(self) -> dict[str, float]:
        return {"fillet": self.fillet}

    def short(self) -> dict[str, Any]:
        return {"chambers": SHORT}

    def faults(self) -> Iterator[tuple[str, str]]:
        yield from super().faults()
        if self.tunnel_height > self.chamber_height:
            yield (
                "tunnel_height",
                f"{self.tunnel_height:g} mm is taller than the chamber "
                f"({self.chamber_height:g} mm): the roof would be thinned or vanish",
            )
        if self.tunnel_width > self.chamber_width:
            yield (
                "tunnel_width",
                f"{self.tunnel_width:g} mm is wider than the chamber ({self.chamber_width:g} mm): "
                "the outer walls would be thinned or vanish",
            )
        yield from self._fillet_faults()
        other = ("floor",) if self.bends else ("film_thickness", "film_width")
        for name in other:
            if getattr(self, name) is not None:
                yield name, f"the {self.kind} kind has none; leave it out"
        if self.bends and self.film_width is not None:
            if self.film_width < self.chamber_width:
                yield (
                    "film_width",
                    f"{self.film_width:g} mm is narrower than the chamber "
                    f"({self.chamber_width:g} mm): the film would not close it",
                )
            elif self.film_width > self.width:
                yield (
                    "film_width",
                    f"{self.film_width:g} mm is wider than the block ({self.width:g} mm)",
                )

    def _fillet_faults(self) -> Iterator[tuple[str, str]]:
        # At the film edges are sharp: a height holds one rounding there, not two.
        chamber = {
            "a chamber_length": self.chamber_length,
            "a chamber_width": self.chamber_width,
            "a chamber_height": self.chamber_height,
        }
        tunnel = {"tunnel_width": self.tunnel_width, "tunnel_height": self.tunnel_height}
        rooms = {name: size for name, size in chamber.items() if name != "a chamber_height"}
        heights = {"a chamber_height": self.chamber_height}
        if self.chambers > 1:
            yield from beside(self.fillet, tunnel, chamber, 1 if self.bends else 2)
            rooms["a tunnel_width"] = self.tunnel_width
            heights["a tunnel_height"] = self.tunnel_height
        yield from too_large("fillet", self.fillet, rooms)
        yield from too_large("fillet", self.fillet, heights, 1 if self.bends else 2)

    @property
    def bends(self) -> bool:
        """Whether this is the bending kind."""
        return self.kind == "bending"

    @property
    def width(self) -> float:
        """Width of the block."""
        return self.chamber_width + 2 * self.outer_wall

    @property
    def length(self) -> float:
        """Length of the block."""
        n = self.chambers
        if self.alone:
            return self.chamber_length + self.inner_wall
        walls = self.clamp_wall + self.tip_wall + (n - 1) * self.inner_wall
        return walls + n * self.chamber_length

    @property
    def _wall_steps(self) -> int:
        """Of a wall between chambers; a module begins at a plane of the mesh inside of one."""
        return max(steps(self.inner_wall, self.mesh_size, self.least_steps), 2)

    @property
    def _starts(self) -> list[float]:
        """Where chambers begin."""
        if self.alone:
            number = self._wall_steps
            return [self.inner_wall * (number - number // 2) / number]
        pitch = self.chamber_length + self.inner_wall
        return [self.clamp_wall + i * pitch for i in range(self.chambers)]

    @property
    def below(self) -> float:
        """Thickness of what closes the chambers below."""
        if self.bends:
            return self.film_thickness or FILM
        return self.floor or FLOOR

    def layout(self) -> Layout:
        surfaces = [*self.ends, "cavity", "outer", "base"]
        return Layout(
            regions=("body", "film") if self.bends else ("body",),
            surfaces=(*surfaces, "symmetry") if self.symmetry else tuple(surfaces),
            cavities={"cavity": ("cavity",)},
            bending_axis=(0.0, 1.0, 0.0),
            symmetry={"symmetry": 1} if self.symmetry else {},
            length=self.length,
            clamp=self.ends[0],
            tip=self.ends[1],
            repeats=self.repeats,
        )

    def walls(self) -> tuple[Wall, ...] | None:
        if self.filleted:
            return None
        solid, below = self.solid(), "film_thickness" if self.bends else "floor"
        places = {
            "outer_wall": (1, self.chamber_width / 2, self.outer_wall),
            "roof": (2, self.below + self.chamber_height, self.roof),
            below: (2, 0.0, self.below),
        }
        if self.chambers > 1 and not self.alone:
            places["inner_wall"] = 0, self.clamp_wall + self.chamber_length, self.inner_wall
        return solid.walls(self._counts(solid), places)

    def volumes(self) -> dict[str, float]:
        n, width = len(self._starts), self.width
        between = 1 if self.alone else n - 1
        part = 0.5 if self.symmetry else 1.0
        cavity = (
            n * self.chamber_length * self.chamber_width * self.chamber_height
            + between * self.inner_wall * self.tunnel_width * self.tunnel_height
        )
        cavity -= self._rounded_off()
        height = self.chamber_height + self.roof + (0.0 if self.bends else self.below)
        end = width * height
        film_width = (self.film_width or width) if self.bends else width
        volumes = {
            "body": part * (self.length * width * height - cavity),
            "cavity": part * cavity,
            "base": part * self.length * film_width,
        }
        if self.bends:
            volumes["film"] = volumes["base"] * self.below
            end += film_width * self.below
        if self.alone:
            end -= self.tunnel_width * self.tunnel_height
        return volumes | dict.fromkeys(self.ends, part * end)

    def _sections(self) -> tuple[Rounded, Rounded]:
        """Of a chamber, across z, and of the tunnel. Where edges at the film are sharp it is half
        of one that has no film and twice the height."""
        r, times = self.fillet, 2 if self.bends else 1
        chamber = Rounded.rectangle(self.chamber_length, self.chamber_width, r)
        return chamber, Rounded.rectangle(self.tunnel_width, times * self.tunnel_height, r)

    def _rounded_off(self) -> float:
        """What the fillets take from the air, mm³."""
        if not self.fillet:
            return 0.0
        times = 2 if self.bends else 1
        (chamber, tunnel), height = self._sections(), self.chamber_height
        sharp = self.chamber_length * self.chamber_width * height
        lost = self.chambers * (sharp - chamber.prism(times * height) / times)
        across = self.tunnel_width * self.tunnel_height - tunnel.section / times
        return lost + (self.chambers - 1) * self.inner_wall * across

    def volume_tolerance(self, name: str) -> float:
        if not self.filleted or name not in ("body", "cavity"):
            return super().volume_tolerance(name)
        edges = self.chambers * self._sections()[0].round_edges(self.chamber_height)
        edges += 4 * (self.chambers - 1) * self.inner_wall
        off = edges * self.chord_error(self.fillet) * (0.5 if self.symmetry else 1.0)
        return off / self.volumes()[name]

    def solid(self) -> Boxes:
        """The block as boxes painted over each other; the underside of the film is z = 0."""
        length, width, starts = self.length, self.width, self._starts
        bottom = self.below
        ceiling = bottom + self.chamber_height
        tunnel = bottom if self.bends else bottom + (self.chamber_height - self.tunnel_height) / 2

        def box(
            name: str, x0: float, x1: float, across: float, z0: float, z1: float, *along: int
        ) -> Box:
            y0 = 0.0 if self.symmetry else -across / 2
            rounded = self.fillet if along else 0.0
            return Box(name, (x0, y0, z0), (x1, across / 2, z1), rounded, along, tuple(sharp))

        sharp = [(1, 0.0)] if self.symmetry else []
        if self.bends:
            sharp.append((2, bottom))

        boxes = [
            box("body", 0.0, length, width, bottom if self.bends else 0.0, ceiling + self.roof)
        ]
        if self.bends:
            boxes.append(box("film", 0.0, length, self.film_width or width, 0.0, bottom))
        for start in starts:
            end = start + self.chamber_length
            boxes.append(box("cavity", start, end, self.chamber_width, bottom, ceiling, 0, 1, 2))
        if self.chambers > 1:
            ends = starts[0], starts[-1] + self.chamber_length
            if self.fillet:  # not where it would cut off the corners of the last chambers
                ends = ends[0] + self.chamber_length / 2, ends[1] - self.chamber_length / 2
            ends = (0.0, length) if self.alone else ends
            height = tunnel, tunnel + self.tunnel_height
            boxes.append(box("cavity", *ends, self.tunnel_width, *height, 0))
        first, last = self.ends
        planes = [Plane(first, 0, 0.0), Plane(last, 0, length), Plane("base", 2, 0.0, True)]
        if self.symmetry:
            planes.append(Plane("symmetry", 1, 0.0))
        regions = self.layout().regions
        before = self._steps_before if self.alone else 0
        return Boxes(tuple(boxes), regions, ("cavity",), planes=tuple(planes), before=before)

    @property
    def _steps_before(self) -> int:
        """Of the block's mesh, before the cut in the wall behind its first chamber."""
        chamber = steps(
            self.chamber_length, self.cavity_mesh_size or self.mesh_size, self.least_steps
        )
        first = steps(self.clamp_wall, self.mesh_size, self.least_steps)
        return first + chamber + self._wall_steps // 2

    def _counts(self, solid: Boxes) -> Counts:
        size = self.mesh_size
        counts = solid.counts(size, self.cavity_mesh_size or size, self.least_steps)
        if not self.alone:
            return counts
        # From face to face the split of the cells fits for an even number of steps only.
        number, chamber = self._wall_steps, counts[0][1]
        chamber += (number + chamber) % 2
        return (number - number // 2, chamber, number // 2), *counts[1:]

    def cells(self) -> int | None:
        if self.filleted:
            return None
        solid = self.solid()
        return solid.cells(self._counts(solid))

    def build(self, gmsh: ModuleType) -> None:
        self.solid().build(gmsh)

    def mesh(self, gmsh: ModuleType) -> None:
        if self.filleted:
            return super().mesh(gmsh)
        solid = self.solid()
        solid.grid(self._counts(solid)).add_to(gmsh)


if __name__ == "__main__":
    main(SlowPneunet)

"""A soft core in a slit shell: the slits say whether it bends or grows longer.

Agarwal et al. (2016), Scientific Reports 6:34224. Run by itself it writes a mesh:
``python geometries/shell_reinforced.py --cuts 9 -o core.msh``.
"""

from collections.abc import Callable, Iterator
from math import asin, pi
from types import ModuleType
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import THINNEST, Layout, ThroughWall, main
from softact.geometry.boxes import Plane
from softact.geometry.chains import Chain, OneModule
from softact.geometry.cutting_pattern import Pattern
from softact.geometry.prisms import Entities, Prism, Prisms, Shapes, Skin, lacking
from softact.geometry.walls import Wall
from softact.units import Length

SHORT = 3  # modules of a shell whose middle one knows nothing of the ends


class ShellReinforced(Chain):
    """A round tube of soft material with closed ends, in a thin shell with slits across its axis.

    Bending kind: each slit runs all around but for a strip along the bottom. Linear kind: each row
    has two slits between two bridges, on the sides in the first row, above and below in the next,
    and so on. The cuts are spread evenly over the length of the chamber.

    A bonded shell is the surface ``shell``: give it a layer. A sliding one is two sheets: ``glued``
    is bonded to the core (``glue`` says where), ``shell`` is held by contact with the surface
    ``outer`` alone.
    """

    type: Literal["shell_reinforced"] = "shell_reinforced"
    kind: Literal["bending", "linear"] = Field("bending", description="pattern of the slits")
    cuts: Annotated[int, Field(ge=0, le=200)] = Field(9, description="number of rows of slits")
    shell: Literal["bonded", "sliding"] = Field(
        "bonded", description="whether all of the shell is glued to the core, or a part of it"
    )
    glue: Literal["strip", "ends", "strip and ends"] | None = Field(
        None,
        description="where a sliding shell is glued: along the strip at the bottom, around the "
        "solid ends; default: the strip of a bending actuator, the ends of a linear one",
    )
    slit: Length = Field(2.0, description="width of the slits along x")
    strip: Length = Field(3.0, description="width of the strip, or of the bridges, between slits")
    length: Length = Field(80.0, description="overall length")
    radius: Length = Field(11.0, description="radius of the core's outside, and of the shell")
    chamber_radius: Length = Field(8.0, description="radius of the chamber")
    end: Length = Field(5.0, description="thickness of the solid ends")
    symmetry: bool = Field(True, description="model the half y >= 0 only")
    mesh_size: Length = Field(4.0, description="longest edge")
    through_wall: ThroughWall = None
    module_alone: OneModule = None

    def no_chain(self) -> Iterator[tuple[str, str]]:
        if self.cuts < self._rows:
            yield "cuts", f"{self.cuts} rows of slits are no chain; write {self._rows} or more"
        if self.shell == "sliding":
            yield "shell", "a sheet does not go on in the next module; write shell: bonded"

    @property
    def _rows(self) -> int:
        """Rows of slits after which the pattern repeats."""
        return 1 if self.kind == "bending" else 2

    @property
    def pitches(self) -> float:
        return (self.length - 2 * self.end) / (self._rows * (self._ring + self.slit))

    def short(self) -> dict[str, Any]:
        if not self.cuts:
            return {}
        cuts = SHORT * self._rows
        length = 2 * self.end + (self.length - 2 * self.end) * cuts / self.cuts
        return {"cuts": cuts, "length": f"{length!r} mm"}

    @property
    def _span(self) -> float:
        """Length of what is meshed."""
        return self._rows * (self._ring + self.slit) if self.alone else self.length

    @property
    def _chamber(self) -> tuple[float, float]:
        """Where the chamber begins and ends."""
        return (0.0, self._span) if self.alone else (self.end, self.length - self.end)

    @property
    def _chamber_length(self) -> float:
        start, end = self._chamber
        return end - start

    def faults(self) -> Iterator[tuple[str, str]]:
        yield from super().faults()
        if self.chamber_radius >= self.radius:
            yield (
                "chamber_radius",
                f"{self.chamber_radius:g} mm is not less than radius ({self.radius:g} mm): the "
                "wall would vanish",
            )
        if self.length - 2 * self.end < THINNEST:
            yield "end", f"{self.end:g} mm on both sides fills the length: the chamber would vanish"
        elif self.cuts and self._ring < THINNEST:
            yield (
                "cuts",
                f"{self.cuts} slits of {self.slit:g} mm leave {self._ring:g} mm between them: the "
                "rings of the shell would vanish",
            )
        if self.strip >= self.radius:
            yield (
                "strip",
                f"{self.strip:g} mm is as wide as the radius ({self.radius:g} mm): the slits "
                "would vanish",
            )

        if self.glue and self.shell == "bonded":
            yield (
                "glue",
                "a bonded shell is glued everywhere; leave it out, or write shell: sliding",
            )
        elif self.glue and "strip" in self.glue and self.kind == "linear":
            yield "glue", "a linear actuator has no strip along the bottom; write ends"

    @property
    def _glued(self) -> str:
        """Where a sliding shell is glued."""
        return self.glue or ("strip" if self.kind == "bending" else "ends")

    @property
    def _ring(self) -> float:
        """Length of shell between two slits."""
        return (self.length - 2 * self.end - self.cuts * self.slit) / (self.cuts + 1)

    def _slits(self) -> list[tuple[float, float]]:
        """Start and end of each row of slits along x."""
        first, rows = self.end + self._ring, self.cuts
        if self.alone:
            first, rows = self._ring / 2, self._rows
        starts = [first + i * (self._ring + self.slit) for i in range(rows)]
        return [(start, start + self.slit) for start in starts]

    def layout(self) -> Layout:
        sliding = self.shell == "sliding"
        covers = {"shell": "under_shell", "glued": "under_glued"} if sliding else {}
        layers = () if sliding else ("shell",)
        surfaces = (*self.ends, "cavity", "outer", *(layers or covers.values()))
        return Layout(
            regions=("body",),
            surfaces=(*surfaces, "symmetry") if self.symmetry else surfaces,
            cavities={"cavity": ("cavity",)},
            bending_axis=(0.0, 1.0, 0.0),
            symmetry={"symmetry": 1} if self.symmetry else {},
            layers=layers,
            length=self._span,
            clamp=self.ends[0],
            tip=self.ends[1],
            repeats=self.repeats,
            sheets=tuple(covers),
            covers=covers,
            bonded=("glued",) if sliding else (),
        )

    def walls(self) -> tuple[Wall, ...]:
        thickness = self.radius - self.chamber_radius
        return self.walls_between_curves(**{"radius less chamber_radius": thickness})

    def volumes(self) -> dict[str, float]:
        half = 0.5 if self.symmetry else 1.0
        round_ = 2 * pi * self.radius
        disc = pi * self.radius**2
        cavity = pi * self.chamber_radius**2 * self._chamber_length
        face = disc - pi * self.chamber_radius**2 * self.alone
        bridges = (1 if self.kind == "bending" else 2) * 2 * asin(self.strip / 2 / self.radius)
        slits = len(self._slits()) * self.slit * (round_ - bridges * self.radius)
        shell = {"shell": half * (round_ * self._span - slits)}
        if self.shell == "sliding":
            ends = 2 * self.end if "ends" in self._glued else 0.0
            strip = (self._span - ends) * bridges * self.radius * ("strip" in self._glued)
            glued = half * (round_ * ends + strip)
            shell = {"under_shell": shell["shell"] - glued, "under_glued": glued}
        return {
            "body": half * (disc * self._span - cavity),
            "cavity": half * cavity,
            **dict.fromkeys(self.ends, half * face),
            **shell,
        }

    def volume_tolerance(self, name: str) -> float:
        wide = lacking(self.radius, self.mesh_size)
        narrow = lacking(self.chamber_radius, self.mesh_size)
        if name in self.ends and self.alone:
            part = self.chamber_radius**2 / (self.radius**2 - self.chamber_radius**2)
            return wide * (1 + part) + narrow * part
        if name == "body":
            outside = pi * self.radius**2 * self._span
            return (wide + narrow) * outside * (0.5 if self.symmetry else 1) / self.volumes()[name]
        return narrow if name == "cavity" else wide

    def pattern(self) -> Pattern:
        """The shell unrolled, its length along x; the strip at the bottom is in the middle, the
        edges meet at the top."""
        edge, half = pi * self.radius, self.radius * asin(self.strip / 2 / self.radius)
        notches, cut = [], [((x, -edge), (x, edge)) for x in (0.0, self._span)]
        for row, (start, end) in enumerate(self._slits()):
            for low, high in self._open(row, edge, half):
                cut += [((start, low), (start, high)), ((end, low), (end, high))]
                cut += [((start, s), (end, s)) for s in (low, high) if abs(s) < edge]
                notches += [(start, end)] * (high == edge)
        stops = [0.0, *np.ravel(notches).tolist(), self._span]
        for start, end in zip(stops[::2], stops[1::2], strict=True):
            cut += [((start, s), (end, s)) for s in (-edge, edge)]
        return Pattern(tuple(cut), (), pieces=1)

    def _open(self, row: int, edge: float, half: float) -> list[tuple[float, float]]:
        """Where the slits of a row begin and end around the shell, mm from the bottom."""
        if self.kind == "bending":
            return [(-edge, -half), (half, edge)]
        if row % 2:
            return [(half - edge, -half), (half, edge - half)]
        side = edge / 2
        return [(-edge, -side - half), (-side + half, side - half), (side + half, edge)]

    def _shapes(self, occ: Any) -> Shapes:
        """Discs of core and chamber, and the bridges of the shell with the core behind them."""
        size = 2 * self.radius

        def disc(radius: float) -> Entities:
            return [(2, occ.addDisk(0, 0, 0, radius, radius))]

        shapes = {"core": disc(self.radius), "chamber": disc(self.chamber_radius)}
        for number in range(1 if self.kind == "bending" else 2):
            bridge = [(2, occ.addRectangle(-self.strip / 2, -size, 0, self.strip, size))]
            if self.kind == "linear":
                bridge = [(2, occ.addRectangle(-self.strip / 2, -size, 0, self.strip, 2 * size))]
            occ.rotate(bridge, 0, 0, 0, 0, 0, 1, number * pi / 2)
            shapes[f"bridge {number}"], _ = occ.intersect(disc(self.radius), bridge)
        if self.symmetry:
            for name, faces in shapes.items():
                half = [(2, occ.addRectangle(0, -size, 0, size, 2 * size))]
                shapes[name], _ = occ.intersect(faces, half)
        return shapes

    def _bridge(self, row: int) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
        """Function that says which sides of the core are under a bridge in a row of slits."""
        half = self.strip / 2

        def below(y: np.ndarray, z: np.ndarray) -> np.ndarray:
            return (abs(y) < half) & (z < 0)

        def above_and_below(y: np.ndarray, z: np.ndarray) -> np.ndarray:
            return abs(y) < half

        def on_the_sides(y: np.ndarray, z: np.ndarray) -> np.ndarray:
            return abs(z) < half

        if self.kind == "bending":
            return below
        return above_and_below if row % 2 else on_the_sides

    def _shell(self) -> tuple[Skin, ...]:
        """Parts of the core's side under the shell; where they overlap, the first one counts."""
        slits, name = self._slits(), "shell"

        def all_around(y: np.ndarray, z: np.ndarray) -> np.ndarray:
            return np.full(len(y), True)

        skins = []
        if self.shell == "sliding":
            name = "under_shell"
            if "ends" in self._glued:
                skins.append(Skin("under_glued", 0.0, self.end, all_around))
                skins.append(Skin("under_glued", self.length - self.end, self.length, all_around))
            if "strip" in self._glued:
                skins.append(Skin("under_glued", 0.0, self._span, self._bridge(0)))
        ends = np.array([0.0, *np.ravel(slits), self._span]).reshape(-1, 2)
        skins += [Skin(name, start, end, all_around) for start, end in ends.tolist()]
        skins += [Skin(name, *slit, self._bridge(i)) for i, slit in enumerate(slits)]
        return tuple(skins)

    def solid(self) -> Prisms:
        """The core as prisms painted over each other."""
        prisms = (
            Prism("body", "core", 0.0, self._span),
            Prism("cavity", "chamber", *self._chamber),
        )
        first, last = self.ends
        planes = [Plane(first, 0, 0.0), Plane(last, 0, self._span)]
        if self.symmetry:
            planes.append(Plane("symmetry", 1, 0.0))
        return Prisms(
            self._shapes, prisms, ("body",), ("cavity",), planes=tuple(planes), skins=self._shell()
        )

    def build(self, gmsh: ModuleType) -> None:
        self.solid().build(gmsh)

    def mesh(self, gmsh: ModuleType) -> None:
        self.solid().mesh(gmsh, self.mesh_size, self.least_steps)


if __name__ == "__main__":
    main(ShellReinforced)

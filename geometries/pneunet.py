"""A fast PneuNet finger: a row of chambers with gaps between them over a common base.

Mosadegh et al. (2014) and Polygerinos et al. (2013). Run by itself it writes a mesh:
``python geometries/pneunet.py --chambers 6 -o finger.msh``.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Literal

from pydantic import Field, model_validator

from softact.geometry import Geometry, Layout
from softact.units import Length

# Two lengths that should be the same are taken to be so within this, relative.
SAME = 1e-6


@dataclass(frozen=True)
class Row:
    """How the chambers divide the length of the finger, mm."""

    chamber_length: float
    gap: float
    pitch: float
    length: float


class Pneunet(Geometry):
    """A fast PneuNet finger, straight and with flat walls.

    Along x: clamp plug, chambers (their inner walls face the gaps between them), tip plug.
    Along z from below: base, chamber, roof. Across y: outer wall, chamber, outer wall. A channel
    on the chambers' floor joins them; between the chambers it runs through a bridge of the full
    width.
    """

    type: Literal["pneunet"] = "pneunet"
    chambers: Annotated[int, Field(ge=1, le=200, strict=True)] = Field(
        8, description="number of chambers"
    )
    chamber_height: Length = Field(16.0, description="height of the air space of a chamber")
    chamber_width: Length = Field(14.0, description="width of the air space of a chamber (y)")
    chamber_length: Length | None = Field(
        None,
        description="length of the air space of a chamber (x); by default it follows from pitch "
        "or length, else 6 mm",
    )
    gap: Length | None = Field(
        None, description="gap between chambers; by default it follows or is 1 mm"
    )
    pitch: Length | None = Field(None, description="from one chamber to the next")
    length: Length | None = Field(None, description="overall length")
    outer_wall: Length = Field(1.0, description="side walls (across y)")
    inner_wall: Length = Field(1.0, description="walls of a chamber that face the gap")
    roof: Length = Field(1.0, description="wall above the chambers")
    base: Length = Field(2.0, description="thickness below the chambers")
    layer_height: Length = Field(
        1.0, description="height of the strain-limiting layer above the bottom, inside the base"
    )
    channel_width: Length = Field(4.0, description="width of the air channel")
    channel_height: Length = Field(2.0, description="height of the air channel")
    channel_roof: Length = Field(1.0, description="wall above the channel, in the gaps")
    clamp_plug: Length = Field(4.0, description="solid end at the clamp")
    tip_plug: Length = Field(4.0, description="solid end at the tip")
    symmetry: bool = Field(True, description="model the half y >= 0 only")
    mesh_size: Length = Field(3.0, description="edge length of the tetrahedra")
    cavity_mesh_size: Length | None = Field(
        None, description="edge length at the walls of the cavity; by default mesh_size"
    )

    @model_validator(mode="after")
    def _can_be_built(self):
        for fault in self._faults():
            raise ValueError(fault)
        return self

    def _faults(self):
        row = self.row
        if row.chamber_length <= 0:
            yield (
                f"no room is left for the chambers: their length would be {row.chamber_length:g} mm"
            )
        if row.gap <= 0:
            yield f"the gap between the chambers would vanish: {row.gap:g} mm are left for it"

    @cached_property
    def row(self) -> Row:
        """Chamber length, gap, pitch and overall length, from whichever of them were given."""
        ends, walls, n = self.clamp_plug + self.tip_plug, 2 * self.inner_wall, self.chambers
        chamber, gap, pitch, length = self.chamber_length, self.gap, self.pitch, self.length
        if gap is None and (chamber is None) + (pitch is None) + (length is None) > 1:
            gap = 1.0
        if chamber is None and pitch is None and length is None:
            chamber = 6.0
        if chamber is None:
            if gap is None:
                chamber = length - ends - (n - 1) * pitch
            elif pitch is not None:
                chamber = pitch - walls - gap
            else:
                chamber = (length - ends - (n - 1) * (walls + gap)) / n
        if gap is None:
            if pitch is not None:
                gap = pitch - walls - chamber
            else:
                gap = (length - ends - n * chamber) / max(n - 1, 1) - walls
        pitch = chamber + walls + gap
        return Row(chamber, gap, pitch, ends + chamber + (n - 1) * pitch)

    def layout(self) -> Layout:
        surfaces = ["clamp", "tip", "cavity", "outer", "base", "strain_limiting_layer"]
        return Layout(
            regions=("body",),
            surfaces=(*surfaces, "symmetry") if self.symmetry else tuple(surfaces),
            cavities={"cavity": ("cavity",)},
            bending_axis=(0.0, 1.0, 0.0),
            symmetry={"symmetry": 1} if self.symmetry else {},
            layers=("strain_limiting_layer",),
            length=self.row.length,
        )

    def volumes(self) -> dict[str, float]:
        n, row = self.chambers, self.row
        between = (n - 1) * (row.pitch - row.chamber_length)
        cavity = (
            n * row.chamber_length * self.chamber_width * self.chamber_height
            + between * self.channel_width * self.channel_height
        )
        width = self.chamber_width + 2 * self.outer_wall
        height = self.base + self.chamber_height + self.roof
        notch = height - self.base - self.channel_height - self.channel_roof
        outside = width * (row.length * height - (n - 1) * row.gap * notch)
        part = 0.5 if self.symmetry else 1.0
        return {
            "body": part * (outside - cavity),
            "cavity": part * cavity,
            "strain_limiting_layer": part * width * row.length,
        }

    def build(self, gmsh) -> None:
        occ = gmsh.model.occ
        row, n = self.row, self.chambers
        w, h, c = (
            self.chamber_width / 2 + self.outer_wall,
            self.base + self.chamber_height + self.roof,
            self.chamber_width / 2,
        )
        floor = self.base + self.channel_height + self.channel_roof

        def box(x0, x1, half, z0, z1):
            y0 = 0.0 if self.symmetry else -half
            return (3, occ.addBox(x0, y0, z0, x1 - x0, half - y0, z1 - z0))

        starts = [self.clamp_plug + i * row.pitch for i in range(n)]
        ends = [x + row.chamber_length for x in starts]
        t = self.inner_wall
        tools = [box(e + t, s - t, w, floor, h) for e, s in zip(ends[:-1], starts[1:], strict=True)]
        tools += [
            box(s, e, c, self.base, self.base + self.chamber_height)
            for s, e in zip(starts, ends, strict=True)
        ]
        if n > 1:
            tools.append(
                box(
                    starts[0],
                    ends[-1],
                    self.channel_width / 2,
                    self.base,
                    self.base + self.channel_height,
                )
            )
        body, _ = occ.cut([box(0.0, row.length, w, 0.0, h)], tools)
        y0 = 0.0 if self.symmetry else -w
        layer = (2, occ.addRectangle(0, y0, self.layer_height, row.length, w - y0))
        occ.fragment(body, [layer])
        occ.synchronize()
        self._name_parts(gmsh, row.length, c)
        gmsh.model.mesh.setSize(gmsh.model.getEntities(0), self.mesh_size)

    def _name_parts(self, gmsh, length, c):
        model = gmsh.model
        groups = {name: [] for name in self.layout().surfaces}
        for _, tag in model.getEntities(2):
            x0, y0, z0, x1, y1, z1 = model.getBoundingBox(2, tag)
            eps = 1e-5

            def flat(lo, hi, at, eps=eps):
                return abs(lo - at) < eps and abs(hi - at) < eps

            if flat(x0, x1, 0):
                groups["clamp"].append(tag)
            elif flat(x0, x1, length):
                groups["tip"].append(tag)
            elif self.symmetry and flat(y0, y1, 0):
                groups["symmetry"].append(tag)
            elif flat(z0, z1, self.layer_height):
                groups["strain_limiting_layer"].append(tag)
            elif (
                y1 < c + eps
                and y0 > -c - eps
                and z0 > self.base - eps
                and z1 < self.base + self.chamber_height + eps
            ):
                groups["cavity"].append(tag)
            else:
                groups["outer"].append(tag)
                if flat(z0, z1, 0):
                    groups["base"].append(tag)
        for name, tags in groups.items():
            model.setPhysicalName(2, model.addPhysicalGroup(2, tags), name)
        bodies = [tag for _, tag in model.getEntities(3)]
        model.setPhysicalName(3, model.addPhysicalGroup(3, bodies), "body")

"""A fast PneuNet finger: a row of chambers with gaps between them over a common base.

Mosadegh et al. (2014) and Polygerinos et al. (2013). Run by itself it writes a mesh:
``python geometries/pneunet.py --chambers 6 -o finger.msh``.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from types import ModuleType
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.geometry import rows
from softact.geometry.base import (
    THINNEST,
    Layout,
    ThroughWall,
    main,
)
from softact.geometry.boxes import OUTSIDE, Box, Boxes, Counts, Plane
from softact.geometry.chains import OneModule
from softact.geometry.filleted import Filleted, FilletSize
from softact.geometry.fillets import CORNER, Rounded, beside, mouth, too_large
from softact.geometry.steps import steps
from softact.geometry.walls import Wall
from softact.units import Length

SHORT = 3  # chambers of a finger whose middle one knows nothing of the ends
# Two lengths that should be the same are taken to be so within this, relative.
SAME = 1e-6


#: Lengths of each chamber or gap, and the one for all of them in whose place they stand.
OF_EACH = {
    "chamber_lengths": "chamber_length",
    "chamber_heights": "chamber_height",
    "inner_walls": "inner_wall",
    "roofs": "roof",
    "gaps": "gap",
}
Lengths = Annotated[tuple[Length, ...] | None, Field(strict=False)]


class Pneunet(Filleted):
    """A fast PneuNet finger, straight and with flat walls.

    Along x: clamp plug, chambers (their inner walls face the gaps between them), tip plug.
    Along z from below: base, chamber, roof. Across y: outer wall, chamber, outer wall. A channel
    on the chambers' floor joins them; between the chambers it runs through a bridge of the full
    width.
    """

    type: Literal["pneunet"] = "pneunet"
    chambers: Annotated[int, Field(ge=1, le=200)] = Field(8, description="number of chambers")
    chamber_height: Length = Field(16.0, description="height of the air space of a chamber")
    chamber_width: Length = Field(12.0, description="width of the air space of a chamber (y)")
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
    base: Length = Field(4.0, description="thickness below the chambers")
    layer_height: Length = Field(
        1.0, description="height of the strain-limiting layer above the bottom, inside the base"
    )
    channel_width: Length = Field(4.0, description="width of the air channel")
    channel_height: Length = Field(2.0, description="height of the air channel")
    channel_roof: Length = Field(3.0, description="wall above the channel, in the gaps")
    clamp_plug: Length = Field(4.0, description="solid end at the clamp")
    tip_plug: Length = Field(4.0, description="solid end at the tip")
    chamber_lengths: Lengths = Field(None, description="of each chamber, the first at the clamp")
    chamber_heights: Lengths = Field(None, description="of each chamber's air space")
    inner_walls: Lengths = Field(None, description="of each chamber, to both gaps")
    roofs: Lengths = Field(None, description="above each chamber")
    gaps: Lengths = Field(None, description="after each chamber but the last")
    fillet: Length = Field(
        0.0, description="radius of the edges of chambers and channel, inside; 0 mm: sharp"
    )
    gap_fillet: Length = Field(
        0.0, description="radius at the bottom of the gaps, outside; 0 mm: sharp"
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

    def faults(self) -> Iterator[tuple[str, str]]:
        yield from super().faults()
        if faults := [*self._list_faults()]:
            yield from faults
            return
        yield from self._row_faults()
        yield from self._channel_faults()
        yield from self._fillet_faults()
        if self.base - self.layer_height < THINNEST:
            yield (
                "layer_height",
                f"{self.layer_height:g} mm is not inside the base ({self.base:g} mm): the base "
                "above the layer would vanish",
            )

    def _list_faults(self) -> Iterator[tuple[str, str]]:
        for name, values in self.lists.items():
            wanted = self.chambers - (name == "gaps")
            if len(values) != wanted:
                what = "gaps between" if name == "gaps" else "chambers: one for each of"
                yield (
                    name,
                    f"{len(values)} lengths, but {wanted} are wanted, for the {what} the "
                    f"{self.chambers} chambers",
                )
        for name in ("length", "pitch"):
            if self._uneven_along and getattr(self, name) is not None:
                along = next(n for n in self.lists if n not in ("chamber_heights", "roofs"))
                yield name, f"follows from {along} and the other lengths; leave it out"
        if self.alone and self.lists:
            yield next(iter(self.lists)), "a module is one of a chain of equal chambers"
        for height in self.chamber_heights or ():
            if self.chambers > 1 and height - self.channel_height - self.channel_roof < THINNEST:
                yield (
                    "chamber_heights",
                    f"{height:g} mm is no taller than the channel with its roof "
                    f"({self.channel_height + self.channel_roof:g} mm)",
                )

    @property
    def lists(self) -> dict[str, tuple[float, ...]]:
        """The lists that are given."""
        given = {name: getattr(self, name) for name in OF_EACH}
        return {name: values for name, values in given.items() if values is not None}

    @property
    def _uneven_along(self) -> bool:
        return bool(set(self.lists) - {"chamber_heights", "roofs"})

    def _each(self, name: str, value: float, count: int) -> tuple[float, ...]:
        """The lengths of a list, or as many of the one for all."""
        return self.lists.get(name, (value,) * count)

    def _row_faults(self) -> Iterator[tuple[str, str]]:
        row, n = self.row, self.chambers
        if row.chamber_length < THINNEST:
            yield (
                self._given("length", "pitch"),
                f"leaves {row.chamber_length:g} mm for the length of a chamber: the chambers would "
                "vanish between their walls, the gaps and the ends",
            )
            return
        if n > 1 and row.gap < THINNEST:
            yield (
                self._given("pitch", "length"),
                f"leaves {row.gap:g} mm between the chambers: the gap would vanish",
            )
            return
        derived = {"pitch": row.pitch} if n > 1 else {}
        for name, value in (derived | {"length": row.length}).items():
            given = getattr(self, name)
            if given is not None and abs(given - value) > SAME * value:
                yield (
                    name,
                    f"{given:g} mm contradicts the other lengths, which make it {value:g} mm; "
                    f"leave out one of chamber_length, gap, pitch and length",
                )

    def _channel_faults(self) -> Iterator[tuple[str, str]]:
        bridge = self.channel_height + self.channel_roof
        if self.channel_height > self.chamber_height:
            yield (
                "channel_height",
                f"{self.channel_height:g} mm is taller than the chamber "
                f"({self.chamber_height:g} mm): the roof would vanish",
            )
        elif self.chambers > 1 and self.chamber_height + self.roof - bridge < THINNEST:
            yield (
                "channel_roof",
                f"{self.channel_roof:g} mm above a channel of {self.channel_height:g} mm is as "
                "tall as the chambers: the gaps would vanish",
            )
        if self.channel_width > self.chamber_width:
            yield (
                "channel_width",
                f"{self.channel_width:g} mm is wider than the chamber "
                f"({self.chamber_width:g} mm): the outer walls would vanish or be thinned",
            )

    @property
    def fillets(self) -> dict[str, float]:
        return {"fillet": self.fillet, "gap_fillet": self.gap_fillet}

    def _fillet_faults(self) -> Iterator[tuple[str, str]]:
        if self.filleted and self.lists:
            yield next(iter(self.lists)), "chambers of several sizes have no fillets yet"
        rooms = {
            "a chamber_length": self.row.chamber_length,
            "a chamber_width": self.chamber_width,
            "a chamber_height": self.chamber_height,
        }
        if self.chambers > 1:
            channel = {"channel_width": self.channel_width, "channel_height": self.channel_height}
            yield from beside(self.fillet, channel, rooms)
            yield from too_large("gap_fillet", self.gap_fillet, {"a gap": self.row.gap})
            rooms |= {f"a {name}": size for name, size in channel.items()}
        yield from too_large("fillet", self.fillet, rooms)

    def _given(self, *names: str) -> str:
        return next((name for name in names if getattr(self, name) is not None), names[0])

    @property
    def row(self) -> rows.Row:
        """Chamber length, gap, pitch and overall length, from whichever of them were given."""
        return rows.divided(
            self.chambers,
            self.clamp_plug + self.tip_plug,
            2 * self.inner_wall,
            self.chamber_length,
            self.gap,
            self.pitch,
            self.length,
        )

    @property
    def blocks(self) -> list[rows.Block]:
        """The chambers, each with its walls; the ends belong to the first and the last."""
        row, n = self.row, self.chambers
        return rows.blocks(
            (self.clamp_plug, self.tip_plug),
            self.base,
            self._each("chamber_lengths", row.chamber_length, n),
            self._each("inner_walls", self.inner_wall, n),
            self._each("gaps", row.gap, n - 1),
            self._each("chamber_heights", self.chamber_height, n),
            self._each("roofs", self.roof, n),
        )

    def no_chain(self) -> Iterator[tuple[str, str]]:
        yield from super().no_chain()
        if self.lists:
            yield next(iter(self.lists)), "chambers of several sizes are no chain of equal ones"

    def short(self) -> dict[str, Any]:
        row = self.row
        found = {"chambers": SHORT, "chamber_length": row.chamber_length, "gap": row.gap}
        if self.length is not None:
            found["length"] = row.length - (self.chambers - SHORT) * row.pitch
        return {k: v if k == "chambers" else f"{v!r} mm" for k, v in found.items()}

    def layout(self) -> Layout:
        surfaces = [*self.ends, "cavity", "outer", "base", "strain_limiting_layer"]
        return Layout(
            regions=("body",),
            surfaces=(*surfaces, "symmetry") if self.symmetry else tuple(surfaces),
            cavities={"cavity": ("cavity",)},
            bending_axis=(0.0, 1.0, 0.0),
            symmetry={"symmetry": 1} if self.symmetry else {},
            layers=("strain_limiting_layer",),
            length=self._length,
            clamp=self.ends[0],
            tip=self.ends[1],
            repeats=self.repeats,
        )

    def walls(self) -> tuple[Wall, ...] | None:
        if self.filleted:
            return None
        solid = self.solid()
        counts, ceiling = self._counts(solid), self.base + self._tallest
        places = {
            "outer_wall": (1, self.chamber_width / 2, self.outer_wall),
            "roof": (2, ceiling, self._thickest_roof),
            "base": (2, 0.0, self.base),
        }
        if self.chambers > 1:
            wall = self._each("inner_walls", self.inner_wall, 1)[0]
            places["inner_wall"] = 0, self._hollow[0][1], wall
        return solid.walls(counts, places)

    def volumes(self) -> dict[str, float]:
        if self.alone:
            profile, air, between = self._of_module()
        else:
            profile, air, between = self._of_blocks()
        cavity = air * self.chamber_width + between * self.channel_width * self.channel_height
        cavity -= self._rounded_off()
        width = self.chamber_width + 2 * self.outer_wall
        filled = 2 * CORNER * self.gap_fillet**2 * len(self._notches)
        outside = width * (profile + filled)
        part = 0.5 if self.symmetry else 1.0
        return {
            "body": part * (outside - cavity),
            "cavity": part * cavity,
            "strain_limiting_layer": part * width * self._length,
        }

    def _of_module(self) -> tuple[float, float, float]:
        """Area of a module's side, mm², of its air space there, and the way between chambers."""
        row, height = self.row, self.base + self.chamber_height + self.roof
        notch = height - self.base - self.channel_height - self.channel_roof
        hollow = sum(end - start for start, end in self._hollow)
        area = self._length * height - row.gap * notch
        return area, hollow * self.chamber_height, row.pitch - row.chamber_length

    def _of_blocks(self) -> tuple[float, float, float]:
        """The same of the finger."""
        bridge = self.base + self.channel_height + self.channel_roof
        return rows.areas(self.blocks, self.base, bridge)

    def _sections(self) -> tuple[Rounded, Rounded]:
        """Of a chamber, across x, and of the channel."""
        return (
            Rounded.rectangle(self.chamber_width, self.chamber_height, self.fillet),
            Rounded.rectangle(self.channel_width, self.channel_height, self.fillet),
        )

    def _rounded_off(self) -> float:
        """What the fillets take from the air, mm³."""
        if not self.fillet:
            return 0.0
        chamber, channel = self._sections()
        length = self.row.chamber_length
        sharp = length * self.chamber_width * self.chamber_height
        lost = self.chambers * (sharp - chamber.prism(length))
        across = self.channel_width * self.channel_height - channel.section
        between = self.row.pitch - length
        opening = 2 * mouth(self.fillet, self.channel_width - 2 * self.fillet)
        return lost + (self.chambers - 1) * (across * between - opening)

    def volume_tolerance(self, name: str) -> float:
        if not self.filleted or name == "strain_limiting_layer":
            return super().volume_tolerance(name)
        length, gaps = self.row.chamber_length, self.chambers - 1
        edges = self.chambers * self._sections()[0].round_edges(length)
        edges += 4 * gaps * (self.row.pitch - length)
        off = edges * self.chord_error(self.fillet)
        if name == "body":
            width = self.chamber_width + 2 * self.outer_wall
            off += 2 * gaps * width * self.chord_error(self.gap_fillet)
        return off * (0.5 if self.symmetry else 1.0) / self.volumes()[name]

    @property
    def _length(self) -> float:
        return self.row.pitch if self.alone else self.blocks[-1].outside[1]

    @property
    def _hollow(self) -> list[tuple[float, float]]:
        """Where chambers begin and end; a module has the ends of two."""
        row = self.row
        if self.alone:
            end = row.chamber_length * (1 - self._cut)
            return [(0.0, end), (end + row.pitch - row.chamber_length, row.pitch)]
        return [block.hollow for block in self.blocks]

    @property
    def _notches(self) -> list[tuple[float, float]]:
        """Where gaps begin and end."""
        if self.alone:
            (_, end), (start, _) = self._hollow
            return [(end + self.inner_wall, start - self.inner_wall)]
        return [(one.outside[1], two.outside[0]) for one, two in pairwise(self.blocks)]

    @property
    def _tallest(self) -> float:
        return max(self.chamber_heights or (self.chamber_height,))

    @property
    def _thickest_roof(self) -> float:
        return max(self.roofs or (self.roof,))

    @property
    def _chamber_steps(self) -> int:
        size = self.cavity_mesh_size or self.mesh_size
        return max(steps(self.row.chamber_length, size, self.least_steps), 2)

    @property
    def _cut(self) -> float:
        """Where a module begins, as a part of its chamber: at a plane of the finger's mesh."""
        return (self._chamber_steps // 2) / self._chamber_steps

    def _joined(self) -> tuple[float, float]:
        """From where to where the channel runs: with fillets to the middle of the last chambers,
        whose corners it would cut off."""
        (start, first), (last, end) = self._hollow[0], self._hollow[-1]
        return ((start + first) / 2, (last + end) / 2) if self.fillet else (start, end)

    def solid(self) -> Boxes:
        """The finger as boxes painted over each other, all chambers as tall as the tallest; the
        points of its mesh are lifted to their own heights."""
        length = self._length
        floor, ceiling = self.base, self.base + self._tallest
        top = ceiling + self._thickest_roof
        starts, ends = ([pair[k] for pair in self._hollow] for k in (0, 1))
        wide, inside = self.chamber_width / 2 + self.outer_wall, self.chamber_width / 2

        def box(
            name: str, x0: float, x1: float, half_width: float, z0: float, z1: float, *round_: Any
        ) -> Box:
            y0 = 0.0 if self.symmetry else -half_width
            return Box(name, (x0, y0, z0), (x1, half_width, z1), *round_)

        middle = ((1, 0.0),) if self.symmetry else ()
        boxes = [box("body", 0.0, length, wide, 0.0, top)]
        bridge = floor + self.channel_height + self.channel_roof
        gap_round = self.gap_fillet, (1,), ((2, top), *middle)
        for gap in self._notches:
            boxes.append(box(OUTSIDE, *gap, wide, bridge, top, *gap_round))
        for start, end in zip(starts, ends, strict=True):
            chamber_round = self.fillet, (0, 1, 2), middle
            boxes.append(box("cavity", start, end, inside, floor, ceiling, *chamber_round))
        if len(starts) > 1:
            across, height = self.channel_width / 2, floor + self.channel_height
            channel_round = self.fillet, (0,), middle
            start, end = self._joined()
            boxes.append(box("cavity", start, end, across, floor, height, *channel_round))
        layer = box("strain_limiting_layer", 0.0, length, wide, *[self.layer_height] * 2)
        first, last = self.ends
        planes = [Plane(first, 0, 0.0), Plane(last, 0, length), Plane("base", 2, 0.0, True)]
        if self.symmetry:
            planes.append(Plane("symmetry", 1, 0.0))
        before = self._steps_before if self.alone else 0
        lift = self._lifted if {"chamber_heights", "roofs"} & set(self.lists) else None
        return Boxes(tuple(boxes), ("body",), ("cavity",), (layer,), tuple(planes), before, lift)

    def _lifted(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) above the channel's roof, from the heights of the tallest chamber and the
        thickest roof to those of their own chamber."""
        channel = self.channel_height + (self.channel_roof if self.chambers > 1 else 0.0)
        ceiling = self.base + self._tallest
        top = ceiling + self._thickest_roof
        return rows.lifted(points, self.blocks, self.base + channel, ceiling, top)

    def _in_steps(self) -> Boxes:
        """The finger as boxes with their own heights, for CAD."""
        even = self.solid()
        top = self.base + self._tallest + self._thickest_roof
        wide, inside = self.chamber_width / 2 + self.outer_wall, self.chamber_width / 2
        boxes = list(even.boxes)
        for block in self.blocks:
            (x0, x1), (start, end) = block.outside, block.hollow
            y = (0.0, 0.0) if self.symmetry else (-wide, -inside)
            boxes.append(Box(OUTSIDE, (x0, y[0], block.top), (x1, wide, top)))
            solid = Box("body", (start, y[1], block.ceiling), (end, inside, block.top))
            boxes.append(solid)
        return replace(even, boxes=tuple(b for b in boxes if b.lower[2] < b.upper[2]), lift=None)

    @property
    def _steps_before(self) -> int:
        """Of the finger's mesh, before the cut in its first chamber."""
        plug = steps(self.clamp_plug, self.mesh_size, self.least_steps)
        return plug + self._chamber_steps // 2

    def _counts(self, solid: Boxes) -> Counts:
        size = self.mesh_size
        counts = solid.counts(size, self.cavity_mesh_size or size, self.least_steps)
        if not self.alone:
            return counts
        # From face to face the split of the cells fits for an even number of steps only.
        last = self._chamber_steps // 2
        _, wall, gap, _, _ = counts[0]
        gap += (self._chamber_steps + gap) % 2
        return (self._chamber_steps - last, wall, gap, wall, last), *counts[1:]

    def cells(self) -> int | None:
        if self.filleted:
            return None
        solid = self.solid()
        return solid.cells(self._counts(solid))

    def build(self, gmsh: ModuleType) -> None:
        solid = self.solid()
        (solid if solid.lift is None else self._in_steps()).build(gmsh)

    def mesh(self, gmsh: ModuleType) -> None:
        if self.filleted:
            return super().mesh(gmsh)
        solid = self.solid()
        solid.grid(self._counts(solid)).add_to(gmsh)


if __name__ == "__main__":
    main(Pneunet)

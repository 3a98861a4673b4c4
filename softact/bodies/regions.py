"""Which body each region of a model is: of a material without memory, or with one."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.bodies.remembering import RememberingSolid
from softact.bodies.solid import Solid
from softact.materials.base import Material
from softact.materials.fibres import fibre_field

if TYPE_CHECKING:
    from softact.model import Model


@dataclass(frozen=True)
class SolidParts:
    """What the regions of a model are made of.

    materials: region name -> law as the solver sees it. wall_normal: region name, points (n, 3) ->
    the wall's normal there, for fibres. pressure_degree: None where there is no pressure unknown.
    """

    materials: Mapping[str, Material]
    wall_normal: Callable[[str, np.ndarray], np.ndarray]
    pressure_degree: int | None


def build(model: Model, parts: SolidParts) -> list[Solid]:
    """The regions of a model, see ``BodyKind``."""
    mesh = model.mesh
    found = []
    for number, name in enumerate(mesh.layout.regions):
        material = parts.materials[name]
        normal = functools.partial(parts.wall_normal, name)
        layout = mesh.layout
        fibres = fibre_field(material.law, layout.axis, normal, layout.origin)
        cells = np.flatnonzero(mesh.region == number)
        degrees = model.degree, parts.pressure_degree
        kind = RememberingSolid if material.law.remembers else Solid
        found.append(kind(model.assembler, name, cells, material, *degrees, fibres))
    return found

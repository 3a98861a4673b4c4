"""Two soft pads with a room between them, and what is grasped there."""

from __future__ import annotations

import numpy as np

from softact.loads.load_step import LoadStep
from softact.mesh.msh_file import Tetrahedra
from softact.model import Support
from tests.analytic.meshes import block
from tests.analytic.solving import build, solve

GRAVITY = 9810.0
GRAM = 1e-6  # tonne


def pads(cells=(2, 4, 4), size=(4.0, 8.0, 8.0), room=10.0) -> Tetrahedra:
    """A block and its mirror image, ``room`` mm apart along x; their surfaces: ``left_x_min``,
    ``left_face``, ``right_face`` and ``right_x_max``."""
    one = block(cells, size)
    count, width = len(one.points), 2 * size[0] + room
    surfaces = {
        "left_x_min": one.surfaces["x_min"],
        "left_face": one.surfaces["x_max"],
        "right_face": one.surfaces["x_max"] + count,
        "right_x_max": one.surfaces["x_min"] + count,
    }
    return Tetrahedra(
        np.vstack([one.points, one.points * [-1, 1, 1] + [width, 0, 0]]),
        np.vstack([one.cells, one.cells[:, [1, 0, 2, 3]] + count]),
        np.zeros(2 * len(one.cells), dtype=np.int32),
        surfaces,
        one.curves,
    )


def between_pads(law, obstacles, mesh=None, **layout):
    """A model of pads and obstacles."""
    return build(mesh or pads(), law, obstacles=obstacles, **LAYOUT | layout)


LAYOUT = {"clamp": "left_x_min", "tip": "right_x_max"}


def backs(squeeze: float, *moved: tuple[float, float, float]) -> list[Support]:
    """The backs of both pads, each pressed in by ``squeeze`` and moved on by ``moved`` (mm): of the
    left one, and of the right one."""
    ways = moved * 2 if len(moved) == 1 else moved or ((0.0, 0.0, 0.0),) * 2
    found = []
    for name, inward, way in zip(("left_x_min", "right_x_max"), (1, -1), ways, strict=True):
        values = np.add(way, [inward * squeeze, 0.0, 0.0])
        found.append(Support(name, dict(enumerate(values.tolist()))))
    return found


def grasp(model, *more: LoadStep, squeeze: float = 0.5, name: str = "ball", **settings):
    """Squeeze what is held in place, under its weight, let go of it, and go on."""
    steps = [
        LoadStep("close", supports=backs(squeeze), gravity=(0.0, 0.0, -GRAVITY)),
        LoadStep("let_go", hold={name: 0.0}),
        *more,
    ]
    return solve(model, steps, backs(0.0), **{"increment": 0.5} | settings)

"""Where an actuator has its mass and its outline: all that a rod needs of its mesh."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from softact.estimate.weight import mass
from softact.geometry.base import make_mesh
from softact.mesh.layout import Layout
from softact.mesh.msh_file import Tetrahedra, read_msh
from softact.spec import Spec

Array = NDArray[np.float64]
BY_MODULE = 4
SIDES = 8  # of the outline


@dataclass(frozen=True)
class Lumps:
    """Slices of an undeformed actuator across its axis, from the clamp to the tip.

    masses (s,): tonne; centres (s, 3): mm; spreads (s, 3, 3): second moments about them, tonne mm².
    tip (3,): middle of the tip's face. outline (q, 3), tip_outline (q, 3): what reaches furthest in
    some directions across the axis, of all and of the tip's face.
    """

    masses: Array
    centres: Array
    spreads: Array
    tip: Array
    outline: Array
    tip_outline: Array


def lumps(spec: Spec) -> Lumps:
    """Of the whole actuator of a spec, by its mesh."""
    layout = spec.layout()
    with TemporaryDirectory(prefix="softact-") as scratch:
        path = Path(scratch) / "actuator.msh"
        make_mesh(spec.geometry, path)
        mesh = read_msh(path, layout)
    masses, centres, spreads = _pieces(spec, mesh)
    round_ones = mass(spec) / masses.sum()  # the mesh here has straight edges
    masses, spreads = round_ones * masses, round_ones * spreads
    axis = np.asarray(layout.axis, dtype=float)
    along = (centres - np.asarray(layout.origin)) @ axis
    count = max(1, round(BY_MODULE * spec.geometry.pitches))
    at = np.clip((along / layout.length * count).astype(int), 0, count - 1)
    whole = np.bincount(at, masses, count).astype(float)
    middles = np.zeros((count, 3))
    np.add.at(middles, at, masses[:, None] * centres)
    middles /= np.maximum(whole, np.finfo(float).tiny)[:, None]
    arms = centres - middles[at]
    moments = spreads + masses[:, None, None] * arms[:, :, None] * arms[:, None]
    summed = np.zeros((count, 3, 3))
    np.add.at(summed, at, moments)
    tip = mesh.points[mesh.surfaces[layout.tip][:, :3]]
    sizes = _areas(tip)
    middle = (sizes @ tip.mean(axis=1)) / sizes.sum()
    for plane in layout.symmetry.values():
        middle[plane] = 0.0
    everywhere = mesh.points[np.unique(mesh.cells[:, :4])]
    return Lumps(
        whole,
        middles,
        summed,
        middle,
        _outline(everywhere, layout),
        _outline(tip.reshape(-1, 3), layout),
    )


def _pieces(spec: Spec, mesh: Tetrahedra) -> tuple[Array, Array, Array]:
    """Masses (n,), centres (n, 3) and second moments (n, 3, 3) about them of all cells, and of the
    triangles of layers, of the whole actuator."""
    layout = spec.layout()
    densities = np.array([spec.materials[name].density for name in layout.regions])
    cells = mesh.points[mesh.cells[:, :4]]
    volumes = np.abs(np.linalg.det(cells[:, 1:] - cells[:, :1])) / 6
    parts = [(cells, volumes * densities[mesh.region], 1 / 20)]
    for layer in spec.layers:
        corners = mesh.points[mesh.surfaces[layer.surface][:, :3]]
        parts.append((corners, _areas(corners) * layer.thickness * layer.material.density, 1 / 12))
    masses = np.concatenate([mass for _, mass, _ in parts])
    centres = np.concatenate([corners.mean(axis=1) for corners, _, _ in parts])
    spreads = np.concatenate([_spread(c, factor * mass) for c, mass, factor in parts])
    for plane in layout.symmetry.values():
        mirror = np.ones(3)
        mirror[plane] = -1.0
        masses = np.tile(masses, 2)
        centres = np.vstack([centres, mirror * centres])
        spreads = np.concatenate([spreads, spreads * np.outer(mirror, mirror)])
    return masses, centres, spreads


def _spread(corners: Array, factors: Array) -> Array:
    """Second moments (n, 3, 3) of simplices (n, m, 3) about their middles."""
    arms = corners - corners.mean(axis=1, keepdims=True)
    return np.asarray(np.einsum("n,nmi,nmj->nij", factors, arms, arms))


def _areas(corners: Array) -> Array:
    """Of triangles (n, 3, 3)."""
    a, b, c = corners.transpose(1, 0, 2)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)


def _outline(points: Array, layout: Layout) -> Array:
    """The points (q, 3) beside the axis that reach furthest in some directions across it; in those
    of the plane alone, where the actuator bends in one. Their places along the axis count not."""
    axis = np.asarray(layout.axis, dtype=float)
    planes = set(layout.symmetry.values())
    across = [np.eye(3)[i] for i in range(3) if abs(axis[i]) < 0.5]
    turns = 2 * np.pi * np.arange(SIDES) / SIDES
    ways = [np.cos(turn) * across[0] + np.sin(turn) * across[1] for turn in turns]
    beside = points - np.outer((points - np.asarray(layout.origin)) @ axis, axis)
    for plane in planes:
        mirror = np.ones(3)
        mirror[plane] = -1.0
        beside = np.vstack([beside, mirror * beside])
        ways = [way for way in ways if abs(way[plane]) < 1e-9]
    found = np.array([beside[np.argmax(beside @ way)] for way in ways]).reshape(-1, 3)
    for plane in planes:
        found[:, plane] = 0.0
    return np.unique(found.round(9), axis=0) - np.asarray(layout.origin)

"""Why an actuator finds no further equilibrium: what its last state says of the physics."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from softact.materials.tensors import determinant
from softact.measures.strain import INCOMPRESSIBLE
from softact.model import Model
from softact.system.term import State

# A cavity with less than this part of its first volume is sucked flat.
FLAT = 0.05
# A layer wrinkles where this part of its area is in compression beyond rounding.
WRINKLED, BARELY = 0.01, 1e-6
# The load has a limit near where displacements grow so much faster than at first.
RUNAWAY = 8.0
# Stretch of half a percent of the volume beyond which the law decides more than the material.
STRETCHED, SHARE = 4.0, 0.005
# An element is crushed where this part of its volume is left, though its law allows no such change.
CRUSHED = 0.5
# Points of an element are let go where J is so far from what the pressure there allows in this part
# of the volume, and the pressure is so large by the shear modulus.
LET_GO, IN_PART, LARGE = 0.15, 0.02, 20.0


def causes(
    model: Model, state: State, unstable_modes: int, faster: float, jumps: int = 0
) -> list[str]:
    """What is physically remarkable in the last equilibrium. Collective.

    unstable_modes: of that equilibrium. faster: how much more it moves under the same change of
    the loads than in the step's first equilibrium. jumps: from one equilibrium to another one far
    away, on the step's way to it.
    """
    found = []
    if unstable_modes:
        found.append(
            f"the last equilibrium is unstable in {unstable_modes} direction(s): the actuator "
            "buckles, or its material loses its stiffness"
        )
    elif faster > RUNAWAY:
        found.append(
            f"a limit of the load is near: the displacements grow {faster:.0f} times as fast as at "
            "the step's start"
        )
    if jumps:
        found.append(
            f"the actuator has jumped {jumps} time(s) to a far equilibrium on the way: it buckles "
            "or wrinkles anew as the load grows"
        )
    found += _flat_cavities(model, state)
    found += _wrinkled_layers(model, state)
    found += _stretched_regions(model, state)
    found += list(_points_let_go(model, state)) or _crushed_elements(model, state)
    return found


def _flat_cavities(model: Model, state: State) -> Iterator[str]:
    for name, first in model.cavity_volumes_at_rest.items():
        part = model.cavity_volume(state, name) / first if first > 0 else np.inf  # sheets lie flat
        if part < FLAT:
            yield (
                f"cavity '{name}' is sucked flat ({part:.1%} of its volume is left); where its "
                "walls touch it needs contact"
            )


def _wrinkled_layers(model: Model, state: State) -> Iterator[str]:
    for layer in model.layers:
        if layer.wrinkles or layer.bending is not None:
            continue
        areas, stress = layer.smallest_stress(state.x)
        parts = zip(*model.comm.allgather((areas, stress)), strict=True)
        areas, stress = (np.concatenate(part) for part in parts)
        pressed = stress < -BARELY * layer.made_of.material.youngs_modulus
        part = areas[pressed].sum() / areas.sum()
        if part > WRINKLED:
            yield (
                f"the layer on '{layer.surface}' wrinkles: {part:.0%} of it is in compression, and "
                "without bending stiffness it carries none; wrinkling: tension_field relaxes it"
            )


def _stretched_regions(model: Model, state: State) -> Iterator[str]:
    for name, solid in model.solids.items():
        f = solid.deformation_gradient(state.x)
        stretch = np.sqrt(np.linalg.eigvalsh(np.swapaxes(f, -1, -2) @ f)[..., 2])
        over = model.sum(float(solid.volumes[stretch > STRETCHED].sum()))
        whole = model.sum(float(solid.volumes.sum()))
        largest = max(model.comm.allgather(float(stretch.max(initial=1.0))))
        if over > SHARE * whole:
            yield (
                f"region '{name}' is stretched up to {largest:.1f} times, {over / whole:.1%} of it "
                f"more than {STRETCHED:g} times: few elastomers bear that, and the elements distort"
            )


def _points_let_go(model: Model, state: State) -> Iterator[str]:
    """Where a continuous pressure no longer holds the volume at the points of its elements.

    It prescribes the volume in the mean around a vertex. Within, the energy of the stress that the
    pressure carries may fall as points gain volume and others lose it, the more the larger that is
    by the shear modulus (Auricchio et al. 2013, Comput. Mech. 52:1153); a pressure of each element
    holds them.
    """
    for name, solid in model.solids.items():
        if solid.pressure_values is None or solid.pressure_values.shape[1] == 1:
            continue
        p = solid.hydrostatic_pressure(state.x)
        off = np.abs(solid.jacobian(state.x) - solid.pressure_volume(p))
        over = model.sum(float(solid.volumes[off > LET_GO].sum()))
        part = over / model.sum(float(solid.volumes.sum()))
        largest = max(model.comm.allgather(float(np.abs(p).max(initial=0.0))))
        ratio = largest / solid.material.shear_modulus
        if part > IN_PART and ratio > LARGE:
            yield (
                f"region '{name}': {part:.0%} of the points gain or lose more volume than the law "
                f"allows, under a mean stress of {ratio:.0f} times the shear modulus, which the "
                "continuous pressure of P2/P1 does not hold; solver: {element: P2/P0} does"
            )


def _crushed_elements(model: Model, state: State) -> Iterator[str]:
    """Where a nearly incompressible element lost half of its volume at a quadrature point."""
    worst: tuple[float, tuple[float, ...]] = (np.inf, ())
    for solid in model.solids.values():
        material = solid.material
        if len(solid.cells) == 0 or material.bulk_modulus < INCOMPRESSIBLE * material.shear_modulus:
            continue
        jacobian = determinant(solid.deformation_gradient(state.x)).min(axis=1)
        least = int(np.argmin(jacobian))
        place = tuple(float(c) for c in solid.centres()[least])
        worst = min(worst, (float(jacobian[least]), place))
    part, place = min(model.comm.allgather(worst))
    if part < CRUSHED:
        where = ", ".join(f"{c:.1f}" for c in place)
        yield (
            f"the material at ({where}) mm is crushed into a fold ({part:.0%} of an element's "
            "volume is left): round the corner there, or refine the mesh"
        )

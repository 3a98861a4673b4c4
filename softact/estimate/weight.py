"""Weight and a force on the tip, on a beam whose curvature and stiffness follow the pressure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from softact.bodies.carried_mass import carried_at
from softact.estimate.beam import Beam, Curve
from softact.export.rod import Rod
from softact.loads.several import entries
from softact.spec import Spec

PIECES = 16


def last_loads(spec: Spec) -> tuple[np.ndarray, np.ndarray]:
    """(3,) gravity in mm/s² and (3,) force on the tip in N, at the end of the steps."""
    return list(loads_of_steps(spec))[-1]


def loads_of_steps(spec: Spec) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The same to which each step goes."""
    gravity, force, tip = np.zeros(3), np.zeros(3), spec.geometry.layout().tip
    carried = carried_at(spec.masses, tip, tip)
    for step in spec.steps:
        if step.gravity is not None:
            gravity = np.asarray(step.gravity, float)
        loads = [p.force for p in entries(step.payload) if p.surface in (None, tip)]
        force = np.sum(loads, axis=0, dtype=float) if loads else force
        yield gravity, force + carried * gravity


def mass(spec: Spec) -> float:
    """Tonne of the whole actuator, by the closed forms of its volumes."""
    layout, volumes = spec.geometry.layout(), spec.geometry.volumes()
    total = sum(volumes[name] * spec.materials[name].density for name in layout.regions)
    for layer in spec.layers:
        total += volumes.get(layer.surface, 0.0) * layer.thickness * layer.material.density
    return layout.copies * total


def loaded(spec: Spec, beam: Beam, curve: Curve) -> np.ndarray | None:
    """(n, 2) radians about y and about −z under weight and a force on the tip; None where the
    beam has no equilibrium under them."""
    gravity, force = last_loads(spec)
    if not (np.any(gravity) or np.any(force)):
        return curve.angle
    rod = _rod(spec, beam, curve)
    rows = (len(curve.parts), 1)
    try:
        strains = rod.solve(curve.parts, np.tile(force, rows), gravity=np.tile(gravity, rows))
    except ArithmeticError:
        return None
    turned = strains[..., 1:3].mean(axis=1) * rod.active
    return turned * [1.0, -1.0]


def _rod(spec: Spec, beam: Beam, curve: Curve) -> Rod:
    active = beam.length - beam.clamp - beam.tip
    # The parts that give are spread over all that lies between the ends.
    spread = active / sum(section.length for section in beam.sections)
    nothing = np.zeros(len(curve.parts))
    table: Mapping = {
        "pressure_kPa": curve.parts,
        "rest_twist": nothing, "rest_stretch": nothing,
        "rest_bending_y": curve.angle[:, 0] / active,
        "rest_bending_z": -curve.angle[:, 1] / active,
        "stiffness_twist": nothing + np.inf, "stiffness_stretch": nothing + np.inf,
        "stiffness_bending_y": curve.stiffness[:, 0] * spread,
        "stiffness_bending_z": curve.stiffness[:, 1] * spread,
        "rest_volume_mm3": nothing,
    }  # fmt: skip
    parts = np.array([beam.clamp, *[active / PIECES] * PIECES, beam.tip])
    return Rod({
        "pieces": PIECES, "components": ["bending_y", "bending_z"], "table": table,
        "start_mm": beam.clamp, "active_length_mm": active, "end_mm": beam.tip,
        "tip_y_mm": 0.0, "tip_z_mm": 0.0, "offset_y_mm": 0.0, "offset_z_mm": 0.0,
        "masses": {"mass_tonne": mass(spec) * parts / beam.length,
                   "centre_mm": np.zeros((len(parts), 3))},
    })  # fmt: skip

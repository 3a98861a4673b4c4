"""Thin layers that carry compression which a real one would leave to fine wrinkles."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from softact.model import Model
    from softact.system.term import State

NOTICEABLE = 0.05  # of a layer's area, where it is compressed beyond what makes it wrinkle


def compressed_layers(model: Model, state: State) -> Iterator[str]:
    """What to say of layers without bending stiffness that carry noticeable compression.
    Collective."""
    for layer in model.layers:
        if layer.wrinkles or layer.bending is not None:
            continue
        areas, stress = layer.smallest_stress(state.x)
        limit = layer.wrinkling_stress()
        pressed = model.sum(float(areas[stress < -limit].sum()))
        part = pressed / model.sum(float(areas.sum()))
        least = min(model.comm.allgather(float(np.min(stress, initial=0.0))))
        if part > NOTICEABLE:
            yield (
                f"the layer on '{layer.surface}' carries compression, down to {least:.3g} MPa; a "
                f"film of its stiffness wrinkles at {-limit:.2g} MPa, which {part:.0%} of it "
                "exceeds: it stiffens the actuator more than a real one would; compare with "
                "wrinkling: tension_field (docs/theory.md)"
            )

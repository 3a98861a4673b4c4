"""Layers of a spec as films of a section."""

from __future__ import annotations

from softact.estimate.sections import Film
from softact.estimate.uniaxial import youngs_modulus
from softact.spec import LayerSpec


def film(layer: LayerSpec, height: float, width: float) -> Film:
    """A layer at a height (mm over the sections' origin)."""
    return Film(height, width, youngs_modulus(layer.material) * layer.thickness)

"""Given compressibilities that decide the results of a solid, and what keeps its volume."""

from __future__ import annotations

from collections.abc import Iterator

from softact.materials.base import VOLUMETRIC, FibreLaw, Law
from softact.materials.laws.holzapfel import BULK_TO_FIBRES
from softact.materials.laws.linear import Linear

#: Ratio of K to the shear modulus of the softest elastomer of which a test gave it: Ecoflex, with
#: ν = 0.48.
SOFTEST = 24.0
#: Ratio of K to the shear modulus below which a material is foam, of which the Poisson's ratio is
#: told.
FOAM = 2.2
#: Ratio of K to the shear modulus that keeps the volume at all stretches that rubber bears.
KEEPS = 1000.0


def remarks(law: Law) -> Iterator[str]:
    """What to say of the bulk modulus K of a solid that is neither linear nor a foam."""
    bulk, mu = law.initial_bulk_modulus, law.shear_modulus
    if isinstance(law, FibreLaw) and bulk < law.k1:
        yield (
            f"a bulk modulus K of {bulk:.4g} MPa beside fibres of {law.k1:.4g} MPa: where fibres "
            "should stretch, volume grows instead, and K decides the result; "
            f"bulk_modulus: {_round(BULK_TO_FIBRES * law.k1)} MPa, or none of "
            f"{', '.join(VOLUMETRIC)}, lets the fibres decide"
        )
    elif not isinstance(law, Linear) and FOAM < bulk / mu < SOFTEST:
        yield (
            f"a bulk modulus K of {bulk:.4g} MPa, {bulk / mu:.3g} times the shear modulus: the "
            "volume grows as the material is stretched, and K decides the forces; elastomers have "
            f"{SOFTEST:.0f} times and more, {nearly_incompressible(law)} keeps the volume"
        )


def nearly_incompressible(law: Law) -> str:
    """The key and the value that keep a law's volume: "bulk_modulus: 27.7 MPa"."""
    factor = max(KEEPS, 10 * law.initial_bulk_modulus / law.shear_modulus)
    return f"bulk_modulus: {_round(factor * law.shear_modulus)} MPa"


def _round(value: float) -> str:
    """Three digits, as people write a number: 50000, 27.7."""
    return f"{float(f'{value:.3g}'):.10g}"

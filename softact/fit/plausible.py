"""Warnings about data that can be read but look odd."""

import numpy as np

from softact.fit.data import Test
from softact.spec.plausible import RANGES

CONFUSIONS = (
    ("MPa given as kPa, or kPa given as Pa", 1e3),
    ("MPa given as Pa", 1e6),
    ("kPa given as MPa, or Pa given as kPa", 1e-3),
    ("Pa given as MPa", 1e-6),
)
# Initial slope of nominal stress over stretch, in shear moduli.
SLOPE = {"uniaxial": 3.0, "equibiaxial": 6.0, "planar": 4.0, "biaxial": 4.0}


def secant_modulus(test: Test) -> float:
    """Return about the initial shear modulus in MPa, from the lower quarter of the stretch."""
    strain = np.abs(np.log(test.stretch))
    low = (strain > 0) & (strain <= max(0.25 * np.max(strain), np.sort(strain)[3]))
    x = np.log(test.stretch[low])
    return float(np.sum(x * test.stress[low]) / np.sum(x * x) / SLOPE[test.mode])


def warnings(test: Test) -> list[str]:
    """Return lines that say what looks odd and what it looks like."""
    lines = []
    modulus = secant_modulus(test)
    if modulus <= 0:
        lines.append(f"{test.label}: the stress does not rise with the stretch at first")
    elif not RANGES["rubber"].holds(modulus):
        for name, factor in CONFUSIONS:
            if 0.01 <= modulus * factor <= 20.0:
                looks = f"; this looks like {name}"
                break
        else:
            looks = ""
        lines.append(
            f"{test.label}: the initial shear modulus is about {modulus:.2g} MPa, which no "
            f"elastomer has{looks}"
        )
    offset = _offset(test)
    if offset is not None:
        lines.append(
            f"{test.label}: the stress at a stretch of 1 is {offset * 1e3:.3g} kPa; "
            "a law has none there (--zero or --toe removes a preload)"
        )
    return lines


def _offset(test: Test) -> float | None:
    """Stress extrapolated to a stretch of 1 where it is a notable part of the whole."""
    order = np.argsort(np.abs(test.stretch - 1.0))[:3]
    x, y = test.stretch[order], test.stress[order]
    if np.min(np.abs(x - 1.0)) > 0.02 * np.ptp(test.stretch):
        return None
    value = float(y[0] - secant_modulus(test) * SLOPE[test.mode] * (x[0] - 1.0))
    return value if abs(value) > 0.03 * np.max(np.abs(test.stress)) else None

"""Tests that are drawn from a law."""

import numpy as np

from softact.fit.data import Test
from softact.fit.modes import nominal_stress


def made(law, mode, stretch, name="made", noise=0.0, scale=1.0, seed=0):
    """A test drawn from a law, with noise relative to the largest stress."""
    stress = scale * nominal_stress(law, law, mode, stretch)
    rng = np.random.default_rng(seed)
    stress = stress + noise * np.max(np.abs(stress)) * rng.standard_normal(len(stress))
    return Test(name, mode, stretch, stress)

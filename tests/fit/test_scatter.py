"""χ² is in parts of the scatter between specimens, where there is any."""

import warnings

import numpy as np
import pytest

from softact.fit.candidates import CANDIDATES
from softact.fit.data import Test
from softact.fit.fit import Options, fit


@pytest.mark.parametrize("factor", [1.0, 1.0 + 1e-15])
def test_one_specimen_given_twice_says_nothing_of_scatter(factor):
    """A curve and its copy differ by rounding; that is nothing to divide by."""
    stretch = np.linspace(1.0, 2.0, 20)
    stress = 0.2 * (stretch - stretch**-2) + 1e-3 * np.sin(9 * stretch)
    tests = [Test(n, "uniaxial", stretch, s) for n, s in (("a", stress), ("b", factor * stress))]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = fit(tests, CANDIDATES["neo_hookean"], Options(starts=1))
    assert found.chi_square is None

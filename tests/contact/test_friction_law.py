"""The return mapping of Coulomb friction at one point, and Newton's way out of a cycle."""

from types import SimpleNamespace

import numpy as np
import pytest

from softact.contact.friction import friction, slide
from softact.solve.newton import Newton

NORMAL = np.array([[0.0, 0.0, 1.0]])
LIMIT = np.array([0.02])
FLAT = np.zeros((1, 3, 3))


@pytest.mark.parametrize("pressure", [1e-8, 1e-3, 1.0])
@pytest.mark.parametrize("slip", [0.005, 0.02, 0.5])
def test_traction_over_slip(pressure, slip):
    """It rises to μ p over the same slip at any pressure, against the motion."""
    p, trial = np.array([pressure]), np.array([[0.6 * slip, 0.8 * slip, 0.3]])
    traction, _, _, elastic = slide(0.4, p, p, LIMIT, NORMAL, trial)
    part = min(slip / LIMIT[0], 1.0)
    np.testing.assert_allclose(traction[0], -0.4 * pressure * part * np.array([0.6, 0.8, 0.0]))
    np.testing.assert_allclose(np.linalg.norm(elastic), part * LIMIT[0])
    np.testing.assert_allclose(friction(0.4, p, p, LIMIT, NORMAL, FLAT, trial)[0], traction)


def test_nothing_is_kept_where_nothing_touches():
    """A point that left has no elastic slip when it comes back."""
    none, trial = np.zeros(1), np.array([[0.01, 0.0, 0.0]])
    for law, more in ((friction, [FLAT]), (slide, [])):
        traction, *_, elastic = law(0.4, none, none, LIMIT, NORMAL, *more, trial)
        assert not traction.any() and not elastic.any()


@pytest.mark.parametrize(
    ("residuals", "cycles"),
    [
        ([1e-3, 2e-2, 1e-3, 2e-4, 1e-6, 1e-7], False),
        ([1e-5, 1e-2, 5e-3, 7e-3, 5e-3], True),
        ([1e-5, 1e-2, 4e-6, 4e-6, 4e-6, 4e-6], True),
        ([4e-6, 4e-6, 4e-6], False),
    ],
)
def test_steps_are_halved_where_they_undo_each_other(residuals, cycles):
    newton = Newton.__new__(Newton)
    newton._now = SimpleNamespace(residuals=residuals)
    assert newton._to_and_fro() is cycles

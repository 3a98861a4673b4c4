"""Fields that a spec may ask for, and the stress at probes, in states whose stress is known."""

from dataclasses import replace

import numpy as np
import pytest

from softact.materials import LAWS
from softact.measures import MEASURES
from softact.measures.further_fields import COMPONENTS, further_fields
from softact.measures.points import locate
from softact.measures.snapshot import Snapshot
from softact.system.term import State
from tests.analytic.meshes import block
from tests.analytic.solving import build

C10, SHEAR = 0.14, 0.4
# 2 C dev b of simple shear along x, across y: b = [[1 + γ², γ, 0], [γ, 1, 0], [0, 0, 1]].
MEAN = (3 + SHEAR**2) / 3
STRESS = {
    "xx": 2 * C10 * (1 + SHEAR**2 - MEAN), "yy": 2 * C10 * (1 - MEAN), "zz": 2 * C10 * (1 - MEAN),
    "xy": 2 * C10 * SHEAR, "xz": 0.0, "yz": 0.0,
}  # fmt: skip


def sheared(**layout):
    model = build(
        block((2, 1, 1), (4.0, 2.0, 2.0)),
        LAWS["neo_hookean"].of(c10=C10, bulk_modulus=1e3),
        **layout,
    )
    state = State(np.zeros(model.unknowns.local))
    state.x[model.displacement_dofs[:, 0]] = SHEAR * model.nodes.places[:, 1]
    return Snapshot(model, state)


def test_all_components_of_the_stress_of_simple_shear():
    found = further_fields(sheared(), ["stress"])
    assert list(found) == [f"stress_{c}" for c in COMPONENTS]
    for c in COMPONENTS:
        np.testing.assert_allclose(found[f"stress_{c}"], STRESS[c], atol=1e-12)


@pytest.mark.parametrize("side", [1, -1])
def test_stress_at_a_probe_and_at_its_mirror_image(side):
    """In the other half the shear stress points the other way."""
    snapshot = sheared(symmetry={"y_min": 1})
    points = {"here": (1.3, side * 0.7, 0.4)}
    snapshot = replace(snapshot, probes=locate(snapshot.model, points))
    columns = MEASURES["probe_stress"].evaluate(snapshot)
    for c in COMPONENTS:
        sign = side if c == "xy" else 1
        assert columns[f"probe_here_stress_{c}_MPa"] == pytest.approx(sign * STRESS[c], abs=1e-12)


def test_no_contact_no_pressure():
    found = further_fields(sheared(), ["contact_pressure"])
    assert not found["contact_pressure"].any()

"""A pouch of a stack of woven fabric, from passage to passage."""

import pytest
from mpi4py import MPI

from softact.run.from_spec import build_model
from softact.spec import Spec
from tests.modules.chain import Case, assert_like_an_inner_one

FABRIC = {
    "plies": [
        {
            "material": {"law": "linear", "youngs_modulus": "498 MPa", "poissons_ratio": 0.35},
            "thickness": "0.2 mm",
        }
    ],
    "wrinkling": "tension_field",
}
STACK = Case(
    {"type": "woven_elongating", "n_a": 5, "mesh_size": "10 mm"},
    pressure=80.0,
    begins=2.0,
    cavity="air",
    bends=False,
    materials={},
    more={"sheets": {"pouches": FABRIC, "ends": FABRIC}},
)


def test_a_module_is_an_inner_one_of_the_whole(tmp_path):
    assert_like_an_inner_one(STACK, tmp_path)


def test_the_air_of_a_module_is_a_pouch_s_at_rest(tmp_path):
    """That of the closed form, open at both passages; areas too."""
    spec = Spec.model_validate(STACK.spec(alone=True))
    model, wanted = build_model(MPI.COMM_SELF, spec, tmp_path), spec.geometry.volumes()
    assert model.cavity_volumes_at_rest["air"] == pytest.approx(wanted["air"], rel=1e-12)
    areas = model.sheets["pouches"].triangles.areas
    assert areas.sum() == pytest.approx(wanted["pouches"], rel=1e-12)

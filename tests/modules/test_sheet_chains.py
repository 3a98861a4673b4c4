"""Modules of woven actuators: a pouch of a stack from passage to passage, one of a row from the
middle of a pouch to that of the next."""

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
PITCH, TAB = 22.86, 20.0
CASES = {
    "woven_elongating": Case(
        {"type": "woven_elongating", "n_a": 5, "mesh_size": "10 mm"},
        pressure=80.0,
        begins=2.0,
        cavity="air",
        bends=False,
        materials={},
        more={"sheets": {"pouches": FABRIC, "ends": FABRIC}},
    ),
    "woven_contracting": Case(
        {
            "type": "woven_contracting",
            "n_a": 6,
            "h_a": f"{PITCH} mm",
            "l_i": f"{6 * PITCH + 2 * TAB} mm",
            "w_a": "36 mm",
            "mesh_size": "6 mm",
        },
        pressure=80.0,
        begins=TAB + 2.5 * PITCH,
        cavity="air",
        bends=False,
        inflate=True,
        materials={},
        more={"sheets": {"pouches": FABRIC, "tabs": FABRIC}},
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_a_module_is_an_inner_one_of_the_whole(name, tmp_path):
    assert_like_an_inner_one(CASES[name], tmp_path)


@pytest.mark.parametrize("name", CASES)
def test_the_air_of_a_module_at_rest(name, tmp_path):
    """That of the closed form, open at both faces; none where the sheets lie flat. Areas too."""
    spec = Spec.model_validate(CASES[name].spec(alone=True))
    model, wanted = build_model(MPI.COMM_SELF, spec, tmp_path), spec.geometry.volumes()
    air = model.cavity_volumes_at_rest["air"]
    assert air == pytest.approx(wanted.get("air", 0.0), rel=1e-12, abs=1e-9)
    areas = model.sheets["pouches"].triangles.areas
    assert areas.sum() == pytest.approx(wanted["pouches"], rel=1e-12)

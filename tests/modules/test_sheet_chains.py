"""Modules of woven actuators: a pouch of a stack from passage to passage, those of rows from the
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
KNIT = {
    "plies": [
        {
            "material": {"law": "neo_hookean", "c10": "0.3 MPa", "bulk_modulus": "60 MPa"},
            "thickness": "0.5 mm",
            "incompressible": True,
        }
    ],
    "wrinkling": "tension_field",
}
STRIP = {
    "material": {"law": "linear", "youngs_modulus": "305 MPa", "poissons_ratio": 0.35},
    "thickness": "0.3 mm",
}
FLOOR = {"plies": [*FABRIC["plies"], STRIP], "wrinkling": "resolved", "bending": 1}
# Its pouches stand upright: those of the paper, taller and on narrower seams, lean on each other.
ROW = {
    "fore": FABRIC,
    "aft": FABRIC,
    "clamp": FLOOR,
    "floors": FLOOR,
    "tip": FLOOR,
    "strip": {"plies": [STRIP], "wrinkling": "resolved", "bending": 1},
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
    "woven_bending": Case(
        {
            "type": "woven_bending",
            "n": 13,
            "w_a": "20 mm",
            "h_a": "12 mm",
            "pitch": "6.5 mm",
            "seam": "5 mm",
            "mesh_size": "7 mm",
            "between_lines": 2,
        },
        pressure=120.0,
        begins=6 * 6.5,
        cavity="air",
        inflate=True,
        materials={},
        more={"sheets": ROW, "contact": [{"self": ["fore", "aft"]}]},
    ),
    "knit_strips": Case(
        {
            "type": "knit_strips",
            "kind": "elongating",
            "l_i": "96 mm",
            "n_r": 8,
            "w_i": "16 mm",
            "w_r": "6 mm",
            "mesh_size": "5 mm",
        },
        pressure=60.0,
        begins=4 * 12.0,
        cavity="air",
        bends=False,
        inflate=True,
        materials={},
        more={"sheets": {"knit": KNIT, "strips": FABRIC}},
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_a_module_is_an_inner_one_of_the_whole(name, tmp_path):
    assert_like_an_inner_one(CASES[name], tmp_path)


@pytest.mark.parametrize("name", CASES)
def test_the_air_of_a_module_at_rest(name, tmp_path):
    """That of the closed form, open at both faces; none where the sheets lie flat. Areas too: those
    of walls that are bent as they lie to the second order of the mesh."""
    spec = Spec.model_validate(CASES[name].spec(alone=True))
    model, wanted = build_model(MPI.COMM_SELF, spec, tmp_path), spec.geometry.volumes()
    air = model.cavity_volumes_at_rest["air"]
    assert air == pytest.approx(wanted.get("air", 0.0), rel=1e-12, abs=1e-9)
    for sheet, part in model.sheets.items():
        off = 3e-3 if sheet in ("fore", "aft") else 1e-12
        assert part.triangles.areas.sum() == pytest.approx(wanted[sheet], rel=off)

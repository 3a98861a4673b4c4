"""A bar that is pressed along its axis buckles with a period of two and three modules: as two and
three of it in a row do, whose own factors say it."""

from types import SimpleNamespace

import numpy as np
import pytest

from softact.measures.longer_waves import asked, unstable_waves
from softact.verdict.waves import first_waves
from tests.modules.solving import stepped

SHIM = {"youngs_modulus": "2 MPa", "poissons_ratio": 0.3, "density": "1000 kg/m^3"}


def pressed(folder, length, strain, layers=()):
    """The module of a bar 4 mm high, shorter by a strain, its one state, and how many of its modes
    are unstable."""
    data = {
        "name": "bar",
        "geometry": {
            "type": "block",
            "length": f"{length} mm",
            "width": "8 mm",
            "height": "4 mm",
            "mesh_size": "2.5 mm",
        },
        "materials": {"body": {"law": "neo_hookean", "c10": "0.05 MPa", "density": "1000 kg/m^3"}},
        "layers": list(layers),
        "supports": [],
        "module": {
            "left": "x_min",
            "right": "x_max",
            "turn": dict.fromkeys("xyz", "0 deg"),
            "shift": {"x": f"{length * (1 - strain)} mm", "y": "0 mm", "z": "0 mm"},
        },
        "steps": [{"name": "wait", "wrench": {"force": ["0 N", "0 N", "0 N"]}}],
    }
    model, (state,), modes = stepped(data, folder)
    return model, state, modes


@pytest.mark.parametrize(("strain", "two", "three"), [(0.02, 0, 0), (0.08, 0, 1), (0.16, 1, 1)])
def test_as_many_modules_in_a_row(tmp_path, strain, two, three):
    """A whole period of n modules is a module, too, whose own factors count its unstable ways. Its
    left face is held at its mean turn: that can take one of them away, and no more (interlacing).
    """
    model, state, own = pressed(tmp_path / "one", 10, strain)
    found = {modules: unstable_waves(model, state, modules) for modules in (2, 3)}
    for modules in (2, 3):
        *_, seen = pressed(tmp_path / f"row{modules}", 10 * modules, strain)
        assert 0 <= own + found[modules] - seen <= 1
        assert bool(seen > own) == bool(found[modules])
    assert [bool(n) for n in found.values()] == [two, three]


@pytest.mark.parametrize(("strain", "two", "three"), [(0.02, 0, 0), (0.08, 0, 1), (0.2, 1, 1)])
def test_a_layer_that_bends_across_the_border(tmp_path, strain, two, three):
    """The same with a stiff layer on its top, half of whose bending at a border is the next
    module's."""
    layer = {"surface": "z_max", "thickness": "0.5 mm", "material": {"law": "linear", **SHIM}}
    model, state, own = pressed(tmp_path / "one", 10, strain, [layer])
    assert model.layers[0].bending.seam is not None
    found = {modules: unstable_waves(model, state, modules) for modules in (2, 3)}
    for modules in (2, 3):
        *_, seen = pressed(tmp_path / f"row{modules}", 10 * modules, strain, [layer])
        assert 0 <= own + found[modules] - seen <= 1
        assert bool(seen > own) == bool(found[modules])
    assert [bool(n) for n in found.values()] == [two, three]


def test_what_reaches_over_the_faces_is_not_asked(tmp_path):
    model, state, _ = pressed(tmp_path / "one", 10, 0.02)
    assert asked(model)
    assert unstable_waves(model, state, 2) == 0


def test_the_verdict_says_it():
    curve = {
        "pressure_kPa": np.array([0.0, 1.0, 2.0]),
        "module_unstable_waves_of_two": np.array([0.0, 0.0, 1.0]),
        "module_unstable_waves_of_three": np.array([0.0, 2.0, 2.0]),
    }
    assert first_waves(SimpleNamespace(curve=curve)) == ("three", 1)
    assert first_waves(SimpleNamespace(curve={"pressure_kPa": np.zeros(2)})) is None

"""How many steps a mesh makes of a length, and that small changes of a spec keep its mesh."""

from pathlib import Path

import numpy as np
import pytest

from softact.geometries import GEOMETRIES
from softact.geometry.boxes import Boxes
from softact.geometry.steps import steps
from softact.spec import load

CONFIGS = Path(__file__).parents[2] / "configs"
BOXES = ["pneunet_glove", "pneunet_glove_blocked", "pneunet_held_tip", "pneunet_small",
         "pneunet_small_touching", "epfl_c5_w7"]  # fmt: skip


@pytest.mark.parametrize(
    ("length", "size", "least", "wanted"),
    [
        (6.0, 2.0, 1, 3),
        (6.000006, 2.0, 1, 3),  # four, had they to be 2 mm at most
        (5.999994, 2.0, 1, 3),
        (0.1 + 0.2, 0.1, 1, 3),
        (6.1, 2.0, 1, 4),
        (1.0, 7.0, 1, 1),
        (1.0, 7.0, 3, 3),
        (10.0, 2.0, 3, 5),
    ],
)
def test_number_of_steps(length, size, least, wanted):
    assert steps(length, size, least) == wanted


def test_no_step_is_longer_than_asked_for_but_for_a_little():
    lengths = np.random.default_rng(0).uniform(0.1, 300, 2000)
    for length in lengths:
        number = steps(length, 2.0)
        assert length / number <= 2.0 * 1.0021
        assert number == 1 or length / (number - 1) > 2.0


@pytest.mark.parametrize("name", BOXES)
def test_shipped_specs_keep_their_mesh_where_a_length_changes_a_little(name):
    """Their walls and chambers are whole numbers of steps: a millionth more made one step more."""
    geometry = load(CONFIGS / f"{name}.yaml").geometry

    def counts(g) -> tuple:
        solid: Boxes = g.solid()
        return g._counts(solid)

    base, changed = counts(geometry), []
    for field in type(geometry).model_fields:
        value = getattr(geometry, field)
        if isinstance(value, float) and not field.endswith("mesh_size"):
            changed += [
                counts(geometry.model_copy(update={field: value * (1 + part)}))
                for part in (-1e-3, -1e-6, 1e-6, 1e-3)
            ]
    assert len(changed) > 30
    assert all(other == base for other in changed)


def test_a_changed_solid_is_meshed_with_the_counts_of_another():
    """A wall that has grown by a half would get a second step; with the old counts it keeps its
    cells, which move with it."""
    geometry = load(CONFIGS / "pneunet_small.yaml").geometry
    thicker = geometry.model_copy(update={"roof": 1.5 * geometry.roof, "mesh_size": 1.2})
    base = geometry.model_copy(update={"mesh_size": 1.2})
    counts = base.solid().counts(1.2, 1.2)
    assert thicker.solid().counts(1.2, 1.2) != counts
    old, new = base.solid().grid(counts), thicker.solid().grid(counts)
    assert np.array_equal(old.tetrahedra(0), new.tetrahedra(0))
    moved = new.points() - old.points()
    assert np.unique(np.round(moved, 9), axis=0).tolist() == [[0, 0, 0], [0, 0, geometry.roof / 2]]


@pytest.mark.parametrize("name", ["pneunet", "slow_pneunet"])
@pytest.mark.parametrize("size", ["3 mm", "7 mm"])
def test_a_whole_is_meshed_as_its_two_halves(name, size):
    """What lies across the plane of symmetry, such as the channel, was one step of 4 mm in the
    whole and one of 2 mm in the half."""
    whole, half = (
        GEOMETRIES[name].model_validate({"chambers": 2, "mesh_size": size, "symmetry": symmetry})
        for symmetry in (False, True)
    )
    meshes = [g.solid().grid(g._counts(g.solid())) for g in (whole, half)]
    middles = [np.round(m.points()[m.tetrahedra(0)].mean(axis=1), 6) for m in meshes]
    mirrored = np.vstack([middles[1], middles[1] * [1, -1, 1]])
    assert np.array_equal(np.unique(middles[0], axis=0), np.unique(mirrored, axis=0))

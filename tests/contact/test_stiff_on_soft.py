"""A stiff block on a soft one: both feel the same pressure."""

import numpy as np
import pytest
from mpi4py import MPI

from softact.contact.surfaces import Touching
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.mesh.layout import Layout
from softact.mesh.tetrahedra import distribute
from softact.model import Model, Support
from tests.analytic.meshes import block, together
from tests.analytic.solving import solve

SOFT = {"c10": 0.05, "bulk_modulus": 5.0}


def beside(points):
    """The upper block: its mesh lines lie beside those of the lower one."""
    inside = (points[:, :2] > 0.1) & (points[:, :2] < 1.9)
    return points + np.column_stack([0.1 * inside, np.ones(len(points))])


def test_pressure_on_both_sides():
    """Pressed together between smooth walls: each side sees force over area, though at the same
    overlap a penalty of the stiff one's own would press a hundred times as hard as that of the soft
    one. What is left is that facets are not all of one size."""
    tets = together(
        low=block((2, 2, 1), (2.0, 2.0, 1.0)), up=block((2, 2, 1), (2.0, 2.0, 1.0), beside)
    )
    names = tuple(tets.surfaces)
    sides = {name: "xyz".index(name[-5]) for name in names if name[-5] in "xy"}
    layout = Layout(("low", "up"), names, {}, clamp="low_z_min", tip="up_z_max", symmetry=sides)
    mesh = distribute(MPI.COMM_SELF, lambda: tets, layout)
    neo_hooke = LAWS["neo_hookean"]
    soft = neo_hooke.of(c10=0.05, bulk_modulus=5.0).material()
    stiff = neo_hooke.of(c10=5.0, bulk_modulus=500.0).material()
    touching = [Touching("both", (("low_z_max",), ("up_z_min",)))]
    model = Model(mesh, {"low": soft, "up": stiff}, (), "P2", touching=touching)

    def held(z):
        return [Support("low_z_min", {2: 0.0}), Support("up_z_max", {2: z})]

    solution = solve(model, LoadStep("press", supports=held(-0.2)), held(0.0), 0.25)
    force = -solution.reaction("up_z_max")[2]
    assert force > 0.5 * 5.0 * 0.2 * 4.0  # N, of half the bulk modulus
    (term,) = model.contacts
    carried = (term.pressures(solution.state) * term.facets.areas).sum(axis=1)
    hard = term.facets.modulus > 10 * term.facets.modulus.min()
    assert carried[hard].sum() == pytest.approx(force, rel=0.05)
    assert carried[~hard].sum() == pytest.approx(force, rel=0.05)

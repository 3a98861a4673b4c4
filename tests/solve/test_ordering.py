"""Order of the pivots: a true order, the one that takes fewer operations, and the same answer."""

import json
import shutil

import numpy as np
import pytest
from mpi4py import MPI
from petsc4py import PETSc

from softact.loads.support import Support
from softact.materials import LAWS
from softact.mesh.layout import Layout
from softact.mesh.tetrahedra import distribute
from softact.model import Model
from softact.run import start as runs
from softact.solve import analysis, mumps
from softact.solve.analysis import METIS
from softact.solve.newton import Newton
from softact.solve.ordering import nested_dissection
from softact.spec import loads
from tests.analytic.meshes import FACES, block
from tests.solve.two_processes import NO_MPIRUN, said_by_both

# Where PETSc's factors hold what softact does not know, MUMPS orders by itself.
NO_CHOICE = pytest.mark.skipif(
    not mumps.KNOWN[0] <= PETSc.Sys.getVersion()[:2] <= mumps.KNOWN[1],
    reason="the order is MUMPS's own with this PETSc",
)
CUBE, ROD = (7, 7, 7), (60, 2, 2)
MATERIAL = LAWS["neo_hookean"].of(c10=0.14, bulk_modulus=100.0).material()


def newton_of(cells, element="P2/P1"):
    """A held block's solver, with the values of its tangent in the matrix."""
    layout = Layout(("body",), tuple(FACES), {}, clamp="x_min")
    mesh = distribute(MPI.COMM_WORLD, lambda: block(cells, cells), layout)
    model = Model(mesh, {"body": MATERIAL}, element=element)
    newton = Newton(model, 1e-8, 15)
    state = model.initial_state()
    newton.set_supports([Support("x_min", {0: 0.0, 1: 0.0, 2: 0.0})], state)
    model.tangent(state)
    return newton


def answer(newton, ordering):
    """Of the tangent to a right-hand side, by the factors in one ordering (None: the chosen one),
    and how much of the right-hand side is left."""
    factor = newton.factor
    factor.analyst.kept = ordering
    factor.set_up()
    factor.follow_layout()
    factor.again()
    right, found = (newton.model.unknowns.create_vector() for _ in range(2))
    right.setArray(np.sin(np.arange(*right.getOwnershipRange())))
    factor.solve(right, found)
    left = newton.model.assembler.matrix * found - right
    return found, left.norm() / right.norm()


@pytest.mark.parametrize("element", ["P2/P1", "P2"])
def test_a_nested_dissection_is_an_order_with_pressures_behind_their_displacements(element):
    newton = newton_of((3, 2, 2), element)
    unknowns = newton.model.unknowns
    place = nested_dissection(newton.model.assembler).places
    assert sorted(place) == list(range(1, unknowns.local + 1))
    nodes = place[newton.model.displacement_dofs]
    np.testing.assert_array_equal(np.diff(nodes, axis=1), 1)
    if element == "P2/P1":
        for dofs in unknowns.cell_dofs:
            np.testing.assert_array_equal(place[dofs[30:]], place[dofs[2:12:3]] + 1)


@NO_CHOICE
@pytest.mark.parametrize("cells", [CUBE, ROD])
def test_the_ordering_with_fewer_operations_is_taken(cells):
    newton = newton_of(cells)
    answer(newton, None)
    said = newton.factor.analysis
    assert said.untried == "" and METIS in said.operations and len(said.operations) == 2
    assert said.operations[said.ordering] == min(said.operations.values())
    assert newton.factor._matrix.getMumpsRinfog(1) == said.operations[said.ordering]
    assert said.memory_MB > 0
    # The better one is kept: a later layout is not compared again.
    assert newton.factor.analyst.kept == said.ordering


@NO_CHOICE
@pytest.mark.parametrize("element", ["P2/P1", "P2"])
def test_operations_are_those_of_the_dense_elimination(element):
    """Of a matrix of ones and noughts, row by row in the order; MUMPS fills up blocks besides."""
    newton = newton_of((4, 3, 3), element)
    found = nested_dissection(newton.model.assembler)
    indptr, indices, _ = newton.model.assembler.matrix.getValuesCSR()
    n = len(indptr) - 1
    filled = np.zeros((n, n), dtype=bool)
    place = found.places - 1
    filled[place[np.repeat(np.arange(n), np.diff(indptr))], place[indices]] = True
    operations = 0
    for k in range(n):
        below = k + 1 + np.flatnonzero(filled[k + 1 :, k])
        filled[np.ix_(below, below)] = True
        operations += len(below) * (len(below) + 2)
    assert found.operations == pytest.approx(operations, rel=1e-3)
    answer(newton, METIS)
    assert 1 <= newton.factor.analysis.operations[METIS] / operations < 1.5


@NO_CHOICE
def test_the_order_is_kept_while_it_does(monkeypatch):
    """A later layout is analysed in the first one's order, until that takes too many operations."""
    newton, made = newton_of(CUBE), []

    def counted(assembler):
        made.append(1)
        return nested_dissection(assembler)

    monkeypatch.setattr(analysis, "nested_dissection", counted)
    first, _ = answer(newton, METIS)
    again, left = answer(newton, METIS)
    assert len(made) == 1 and left < 1e-11 and (again - first).norm() < 1e-9 * first.norm()
    monkeypatch.setattr(analysis, "WORSE", 0.5)
    answer(newton, METIS)
    assert len(made) == 2


@NO_CHOICE
def test_each_of_the_two_is_taken_somewhere():
    taken = set()
    for cells in (CUBE, ROD):
        newton = newton_of(cells)
        answer(newton, None)
        taken.add(newton.factor.analysis.ordering)
    assert len(taken) == 2


@NO_CHOICE
def test_both_orderings_give_the_same_solution():
    newton = newton_of(CUBE)
    own, left = answer(newton, "MUMPS's own")
    dissected, left_too = answer(newton, METIS)
    assert newton.factor.analysis.ordering == METIS
    assert max(left, left_too) < 1e-11
    assert (own - dissected).norm() < 1e-9 * own.norm()
    pressures = newton.model.unknowns.local - newton.model.displacement_dofs.size
    assert newton.factor._matrix.getInertia()[0] == pressures


@NO_CHOICE
def test_without_the_header_of_mumps_its_own_ordering_is_used_and_the_reason_told(monkeypatch):
    monkeypatch.setattr(mumps, "_header", lambda: None)
    newton = newton_of((3, 2, 2))
    assert answer(newton, None)[1] < 1e-11
    assert "dmumps_c.h is not there" in newton.factor.analysis.untried


@NO_CHOICE
def test_a_header_of_another_version_is_not_used(monkeypatch, tmp_path):
    header = tmp_path / "dmumps_c.h"
    text = mumps._header().read_text()
    header.write_text('#define MUMPS_VERSION "1.2.3"\n' + text)
    for part in mumps._header().parent.glob("[dm]*mumps_*.h"):
        if part.name != header.name:
            shutil.copy(part, tmp_path)
    for part in mumps._header().parent.glob("mumps_*.h"):
        shutil.copy(part, tmp_path)
    monkeypatch.setattr(mumps, "_header", lambda: header)
    newton = newton_of((3, 2, 2))
    assert answer(newton, None)[1] < 1e-11
    assert "another MUMPS" in newton.factor.analysis.untried


PROGRAM = """
from mpi4py import MPI
from tests.solve.test_ordering import METIS, answer, newton_of
newton = newton_of((4, 4, 4))
chosen, left = answer(newton, None)
said = newton.factor.analysis
assert said.operations[said.ordering] == min(said.operations.values())
assert len(said.operations) == 2 and said.untried == "", said
own, more = answer(newton, "MUMPS's own")
dissected, most = answer(newton, METIS)
assert newton.factor.analysis.ordering == METIS
assert max(left, more, most) < 1e-11, (left, more, most)
assert (own - dissected).norm() < 1e-9 * own.norm()
print("same")
"""


@NO_CHOICE
@NO_MPIRUN
def test_both_give_the_same_solution_on_two_processes():
    assert said_by_both(PROGRAM).count("same") == 2


SPEC = """
geometry: {type: block, length: 8 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm}
materials: {body: {law: neo_hookean, c10: 0.14 MPa, bulk_modulus: 100 MPa, density: 1000 kg/m^3}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{gravity: [0 m/s^2, 0 m/s^2, -9.81 m/s^2]}]
"""


def test_a_run_tells_its_ordering_and_memory(tmp_path):
    runs.run(loads(SPEC), tmp_path / "result", processes=1, report=False)
    told = json.loads((tmp_path / "result" / "run.json").read_text())["factorisation"]
    assert told["operations"][told["ordering"]] == min(told["operations"].values())
    assert told["memory_MB"] >= 1


def test_where_the_order_cannot_be_chosen_mumps_orders_and_the_reason_is_told(monkeypatch):
    monkeypatch.setattr(mumps, "KNOWN", ((1, 0), (1, 1)))
    newton = newton_of((3, 2, 2))
    assert answer(newton, None)[1] < 1e-11
    said = newton.factor.analysis
    assert "it was tried with PETSc" in said.untried and METIS not in said.operations

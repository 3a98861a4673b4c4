"""MKL's Pardiso instead of MUMPS: the same answers, inertia and curves. Skipped where no MKL is."""

import json

import numpy as np
import pytest
from mpi4py import MPI

from softact.errors import SpecError
from softact.loads.support import Support
from softact.mesh.layout import Layout
from softact.mesh.tetrahedra import distribute
from softact.model import Model
from softact.results.folder import read
from softact.run import start as runs
from softact.solve import pardiso
from softact.solve.newton import Newton
from softact.spec import loads
from tests.analytic.meshes import FACES, block
from tests.contact.test_contact_on_two import ROUGH, assert_alike
from tests.contact.test_contact_on_two import SPEC as TWO_CHAMBERS
from tests.solve.test_ordering import MATERIAL, SPEC
from tests.solve.two_processes import NO_MPIRUN, said_by_both

NO_MKL = pytest.mark.skipif(pardiso.library() is None, reason="no MKL here")
CLAMP = [Support("x_min", {0: 0.0, 1: 0.0, 2: 0.0})]
COLUMN = (24, 2, 2), (24.0, 2.0, 2.0)


def newton_of(factor, cells=(5, 4, 4), size=(5.0, 4.0, 4.0), element="P2/P1", shortened=0.0):
    """A clamped block's solver, with the factors of its tangent where it is shortened along x."""
    layout = Layout(("body",), tuple(FACES), {}, clamp="x_min")
    mesh = distribute(MPI.COMM_WORLD, lambda: block(cells, size), layout)
    model = Model(mesh, {"body": MATERIAL}, element=element)
    newton, state = Newton(model, 1e-8, 15, factor), model.initial_state()
    newton.set_supports(CLAMP, state)
    along = model.displacement_dofs[:, 0]
    state.x[along] = -shortened * model.nodes.places[:, 0]
    model.tangent(state)
    newton.factor.follow_layout()
    newton.factor.again()
    newton.factor.fresh = True
    return newton


def answers(newton):
    """Of the tangent to two right-hand sides, each by itself and both at once: (2, owned) each."""
    right, found = (newton.model.unknowns.create_vector() for _ in range(2))
    span = np.arange(*right.getOwnershipRange())
    rights, single = np.array([np.sin(span), np.cos(3.0 * span)]), []
    for values in rights:
        right.setArray(values)
        newton.factor.solve(right, found)
        single.append(found.getArray().copy())
    return np.array(single), newton.factor.solve_all(rights)


def apart(one, other):
    """Largest difference by the largest value, over all processes."""
    most = [MPI.COMM_WORLD.allreduce(np.abs(a).max(), op=MPI.MAX) for a in (one - other, other)]
    return most[0] / most[1]


@NO_MKL
@pytest.mark.parametrize("element", ["P2/P1", "P2/P0", "P2"])
def test_answers_are_those_of_mumps(element):
    (single, both), (expected, _) = (
        answers(newton_of(factor, element=element)) for factor in ("pardiso", "mumps")
    )
    assert apart(single, expected) < 1e-9 and apart(both, expected) < 1e-9


PROGRAM = """
from tests.solve.test_pardiso import answers, apart, newton_of
ours = newton_of("pardiso")
(single, both), (expected, _) = answers(ours), answers(newton_of("mumps"))
assert apart(single, expected) < 1e-9 and apart(both, expected) < 1e-9
assert ours.factor.unstable_modes() == 0
assert newton_of("pardiso", shortened=0.6).factor.unstable_modes() > 0
print("same")
"""


@NO_MKL
@NO_MPIRUN
def test_answers_are_those_of_mumps_on_two_processes():
    assert said_by_both(PROGRAM).count("same") == 2


@NO_MKL
def test_unstable_modes_are_those_of_mumps():
    """Of a column that is shortened without bending it: one half wave after another buckles."""
    seen = []
    for shortened in (0.0, 0.01, 0.05, 0.1, 0.2, 0.3):
        modes = {
            factor: newton_of(factor, *COLUMN, shortened=shortened).factor.unstable_modes()
            for factor in ("pardiso", "mumps")
        }
        assert modes["pardiso"] == modes["mumps"], shortened
        seen.append(modes["pardiso"])
    assert seen[0] == 0 and seen == sorted(seen) and len(set(seen)) > 4, seen


BALLOON = """
geometry: {type: thick_sphere, inner_radius: 10 mm, outer_radius: 12 mm, mesh_size: 6 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa, bulk_modulus: 100 MPa, density: 1000 kg/m^3}}
steps: [{pressure: 60 kPa}]
solver: {factor: %s, dynamics: false}
"""


@NO_MKL
def test_a_balloon_beyond_its_largest_pressure_is_the_same(tmp_path):
    curves = {}
    for factor in ("pardiso", "mumps"):
        outcome = runs.run(loads(BALLOON % factor), tmp_path / factor, report=False)
        assert outcome.status == "no_equilibrium", outcome.message
        curves[factor] = read(tmp_path / factor).curve
    # Where the branch is given up hangs on the number of iterations: by an increment more or less.
    rows = min(len(curve["pressure_kPa"]) for curve in curves.values())
    unstable = np.count_nonzero(curves["mumps"]["unstable_modes"][:rows])
    assert unstable > 10 and rows > 30
    for name in ("unstable_modes", "pressure_kPa", "cavity_volume_mm3"):
        ours, theirs = (np.asarray(curves[f][name], float)[:rows] for f in ("pardiso", "mumps"))
        np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=1e-9)


@NO_MKL
def test_contact_with_friction_on_two_processes_is_the_same(tmp_path):
    """There the tangent is not symmetric, and is laid out anew where other points touch."""
    spec = loads(TWO_CHAMBERS % ROUGH)
    other = spec.model_copy(update={"solver": spec.solver.model_copy(update={"factor": "pardiso"})})
    for name, each, processes in (("mumps", spec, 1), ("pardiso", other, 2)):
        outcome = runs.run(each, tmp_path / name, processes, report=False)
        assert outcome.status == "complete", outcome.message
    assert_alike(tmp_path / "pardiso", tmp_path / "mumps")


@NO_MKL
def test_a_run_tells_its_solver(tmp_path):
    spec = loads(SPEC + "solver: {factor: pardiso}\n")
    runs.run(spec, tmp_path / "result", processes=1, report=False)
    told = json.loads((tmp_path / "result" / "run.json").read_text())["factorisation"]
    assert told["solver"] == "Pardiso" and told["memory_MB"] >= 1
    assert all(operations > 1e5 for operations in told["operations"].values())


def test_without_mkl_the_run_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(pardiso, "library", lambda: None)
    with pytest.raises(SpecError, match=r"softact\[pardiso\].*mumps"):
        runs.run(loads(SPEC + "solver: {factor: pardiso}\n"), tmp_path / "result", report=False)
    assert not (tmp_path / "result").exists()

"""What is compiled for sheets, beside the same by numpy: laws, volumes, places in the matrix."""

import numpy as np
import pytest

from softact.bodies.compiled_sheet_law import compiled, relaxed
from softact.bodies.invariant_sheet import InvariantSheet
from softact.bodies.sheet import Ply, Sheet
from softact.loads.sheet_cavity import SheetCavity
from softact.materials.base import FibreLaw
from softact.materials.invariants import InvariantLaw
from softact.materials.plane_stress import IncompressibleLaw, sheet_law
from softact.materials.tension_field import TensionField
from softact.mesh.triangles import VOLUME_RULE, Triangles, shape_functions, shape_gradients
from softact.solve.newton import Newton, SolveOptions
from softact.system.term import TimeStep
from tests.materials.samples import SAMPLES
from tests.sheets.test_sheet_tangents import NYLON, RUBBER, metrics, pillow

COUNT = 300
LAWS = {name: law for name, law in SAMPLES.items() if isinstance(law, InvariantLaw)}


def at_constant_volume(law):
    """Its plane form, with fibres at the law's angle to an axis at 17 degrees."""
    fibres = None
    if isinstance(law, FibreLaw):
        axis = np.array([np.cos(0.3), np.sin(0.3), 0.0])
        both = (np.broadcast_to(v, (COUNT, 3)) for v in (axis, np.array([0.0, 0.0, 1.0])))
        fibres = law.fibre_directions(*both)
    return sheet_law(law, fibres, incompressible=True)


def assert_alike(one, other):
    for mine, theirs in zip(one, other, strict=True):
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-10 * np.abs(theirs).max())


@pytest.mark.parametrize("name", LAWS)
def test_a_compiled_formula_is_that_of_the_law(name):
    """W, S and D, without wrinkles and in a tension field, at constant volume."""
    law, c = at_constant_volume(LAWS[name]), metrics(COUNT)
    assert isinstance(compiled(law), InvariantSheet)
    assert_alike(compiled(law).evaluate(c), law.evaluate(c))
    general, folded = TensionField(law, 0.5), relaxed(law, 0.5)
    assert np.bincount(general.state(c), minlength=3).min() > 10
    np.testing.assert_array_equal(folded.state(c), general.state(c))
    assert_alike(folded.evaluate(c), general.evaluate(c))


def test_one_text_serves_all_constants_of_a_form():
    """Nothing is compiled for a sweep of constants; a formula of another form is another text."""
    knit = LAWS["holzapfel"]
    laws = [knit, knit.model_copy(update={"c10": 2 * knit.c10}), LAWS["yeoh"]]
    one, same, other = (compiled(at_constant_volume(law))._functions for law in laws)
    assert one is same and one is not other


def test_nylon_is_compiled():
    law, c = sheet_law(NYLON), metrics(COUNT)
    assert type(compiled(law)) is not type(law)
    assert_alike(compiled(law).evaluate(c), law.evaluate(c))


def test_other_laws_stay_as_they_are():
    """Those of stretches, and those whose thickness is sought, are evaluated by numpy."""
    for law in (sheet_law(RUBBER), sheet_law(RUBBER, None, True)):
        assert compiled(law) is law
        assert type(relaxed(law, 0.5)) is TensionField


def test_a_collapsed_triangle_is_not_finite():
    for law in (compiled(at_constant_volume(LAWS["yeoh"])), relaxed(sheet_law(RUBBER), 0.5)):
        with np.errstate(all="ignore"):
            assert not np.isfinite(law.evaluate(np.zeros((1, 2, 2)))[1]).all()


@pytest.mark.parametrize("flux", [(1 / 3, 1 / 3, 1 / 3), (0.0, 0.0, 1.0), (0.2, 0.5, 0.3)])
@pytest.mark.parametrize("n", [3, 6])
def test_the_volume_is_its_integral(n, flux):
    """∫ (W x) · (∂x/∂r × ∂x/∂s), which the rule integrates exactly, and its derivative, of
    triangles far from the origin."""
    draw = np.random.default_rng(n)
    places, x = draw.uniform(90, 110, (7, n, 3)), draw.uniform(-1, 1, 21 * n)
    dofs = draw.permutation(21 * n).reshape(7, n, 3).astype(np.int32)
    cavity = SheetCavity("air", [Triangles(dofs[..., 0], places, dofs, None)], flux)
    points, weights = VOLUME_RULE
    values, slopes = shape_functions(points, n), shape_gradients(points, n)

    def parts(nodes):
        r, s = (np.einsum("qn,knc->kqc", slopes[..., i], nodes) for i in (0, 1))
        return np.einsum("qn,knc->kqc", values, nodes) * flux, r, s

    place, r, s = parts(places + x[dofs])
    volume = np.einsum("q,kqc,kqc->", weights / 2, place, np.cross(r, s))
    assert cavity.volume(x) == pytest.approx(volume, rel=1e-12)
    way = draw.standard_normal(len(x))
    moved, by_r, by_s = parts(way[dofs])
    change = moved * np.cross(r, s) + place * (np.cross(by_r, s) + np.cross(r, by_s))
    found = np.zeros(len(x))
    cavity.add_volume_gradient(x, 2.0, found)
    rate = 2 * np.einsum("q,kqc->", weights / 2, change)
    assert found @ way == pytest.approx(rate, rel=1e-11, abs=1e-11 * np.abs(found).sum())


def test_element_matrices_find_their_places():
    """The matrix is the sum of the elements', without supported rows and columns; scalar ones count
    for each component."""
    model = pillow(Sheet([Ply(NYLON, 0.2)]), counts=(2, 2))
    assembler, triangles = model.assembler, model.sheets["top"].triangles
    draw, (k, n) = np.random.default_rng(1), triangles.nodes.shape
    assembler.fixed[draw.choice(model.unknowns.local, 9, replace=False)] = 1
    whole, each = draw.standard_normal((k, n, 3, n, 3)), draw.standard_normal((k, n, n))
    some = np.array([4, 1])
    assembler.clear()
    triangles.table.add(whole)
    triangles.table.add(whole[:2], some)
    triangles.table.add_scalar(each, 0.5)
    rows, columns = assembler.pattern
    size = model.unknowns.local
    found, expected = np.zeros((2, size, size))
    found[rows, columns] = assembler.values
    whole[some] += whole[:2].copy()
    whole += 0.5 * np.einsum("kab,ij->kaibj", each, np.eye(3))
    at = triangles.dofs.reshape(k, -1)
    np.add.at(expected, (at[:, :, None], at[:, None]), whole.reshape(k, 3 * n, 3 * n))
    free = assembler.fixed == 0
    np.testing.assert_allclose(found, expected * np.outer(free, free), atol=1e-13)


def test_a_line_search_evaluates_no_place_twice():
    """The force at its start is that of the residual, and that at its end the next residual."""
    model = pillow(Sheet([Ply(NYLON, 0.2)], tension_field=True), counts=(2, 2))
    model.add_inertia()
    state, places = model.initial_state(), []
    state.put("pressure", {"air": 0.01})
    state.motion = TimeStep(1e8, state.x.copy(), state.x.copy())
    force = model.force
    model.force = lambda state: places.append(state.x.tobytes()) or force(state)
    solver = Newton(model, 1e-8, 30)
    solver.set_supports([], state)
    options = SolveOptions(1e-8, line_search=True)
    outcome = solver.solve(state, solver.held(state).end, options=options)
    assert outcome.converged and outcome.iterations > 2
    assert solver.counts.residual_evaluations == outcome.iterations + 1 <= len(places)
    assert len(set(places)) == len(places)


def test_fibres_across_the_sheet_are_left_to_numpy():
    law = at_constant_volume(LAWS["holzapfel"])
    across = IncompressibleLaw(law.material, law.fibres[..., [2, 1, 0]])
    assert compiled(across) is across

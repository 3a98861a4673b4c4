"""The terms of sheets: force against energy and tangent against force, by finite differences."""

from dataclasses import replace

import numpy as np
import pytest
from petsc4py import PETSc

from softact.bodies.sheet import Ply, Sheet
from softact.errors import MeshError, SpecError
from softact.materials import LAWS
from softact.materials.plane_stress import sheet_law
from softact.materials.tension_field import SLACK, TAUT, WRINKLED, TensionField
from softact.mesh.sheets import SheetMesh
from softact.results.folder import RESTART
from softact.solve import checkpoint
from softact.solve.path import Point
from softact.system.term import EVERYTHING, State, TimeStep
from tests.analytic.sheet_meshes import build, rectangle

STEP = 1e-5
NYLON = LAWS["linear"].of(youngs_modulus=498.0, poissons_ratio=0.35)
RUBBER = LAWS["ogden"].of(mu=[0.6, 0.1], alpha=[1.8, -2.5], bulk_modulus=50.0)
KNIT = LAWS["holzapfel"].of(c10=0.5, k1=0.4, k2=0.3, kappa=0.1, angle=30.0, bulk_modulus=40.0)


def metrics(count=40, size=0.25, seed=3):
    rng = np.random.default_rng(seed)
    f = np.eye(2) + size * rng.standard_normal((count, 2, 2))
    return f.transpose(0, 2, 1) @ f


def laws():
    fibres = KNIT.fibre_directions(
        np.broadcast_to([1.0, 0, 0], (40, 3)), np.broadcast_to([0, 0, 1.0], (40, 3))
    )
    return {
        "nylon": sheet_law(NYLON),
        "rubber": sheet_law(RUBBER),
        "knit": sheet_law(KNIT, fibres),
        "knit of constant volume": sheet_law(KNIT, fibres, incompressible=True),
        "nylon relaxed": TensionField(sheet_law(NYLON), 0.35),
        "rubber relaxed": TensionField(sheet_law(RUBBER), 0.49),
        "knit relaxed": TensionField(sheet_law(KNIT, fibres), 0.49),
        "knit of constant volume relaxed": TensionField(sheet_law(KNIT, fibres, True), 0.5),
    }


@pytest.mark.parametrize("name", laws())
def test_plane_stress_laws_are_derivatives(name):
    law, c = laws()[name], metrics()
    _, stress, moduli = law.evaluate(c)
    for k, (i, j) in enumerate(((0, 0), (1, 1), (0, 1))):
        change = np.zeros((2, 2))
        change[i, j] = change[j, i] = STEP
        up, down = law.evaluate(c + change), law.evaluate(c - change)
        factor = 1 if i == j else 2
        slope = (up[0] - down[0]) / (2 * STEP)
        np.testing.assert_allclose(slope, factor * stress[:, k] / 2, atol=2e-7 * moduli.max())
        rate = (up[1] - down[1]) / (2 * STEP)
        np.testing.assert_allclose(rate, factor * moduli[:, :, k] / 2, atol=2e-6 * moduli.max())


def test_thickness_stretch_is_eliminated():
    """An incompressible neo-Hookean sheet under λ1, λ2: S11 = 2 C1 (1 − λ1⁻⁴ λ2⁻²)."""
    law = sheet_law(LAWS["neo_hookean"].of(c10=0.3, bulk_modulus=3e6))
    l1, l2 = 1.7, 1.2
    _, stress, _ = law.evaluate(np.diag([l1**2, l2**2])[None])
    expected = [0.6 * (1 - l1**-4 * l2**-2), 0.6 * (1 - l1**-2 * l2**-4)]
    np.testing.assert_allclose(stress[0, :2], expected, rtol=1e-5)


def test_constant_volume_is_the_limit_of_a_large_bulk_modulus():
    """Energy, stress and moduli of the knit differ from it as 1/K."""
    fibres = laws()["knit"].fibres
    limit = sheet_law(KNIT, fibres, incompressible=True).evaluate(metrics())
    off = []
    for bulk in (2e3, 2e4):
        near = sheet_law(KNIT.model_copy(update={"bulk_modulus": bulk}), fibres)
        parts = zip(near.evaluate(metrics()), limit, strict=True)
        off.append([np.abs(one - other).max() / np.abs(other).max() for one, other in parts])
    rates = np.log10(np.array(off[0]) / off[1])
    np.testing.assert_allclose(rates, 1.0, atol=0.1)
    assert max(off[1]) < 0.02


def test_relaxed_states():
    """Wrinkled: uniaxial, S11 = E e for nylon; slack: nothing; taut: the law itself."""
    law = TensionField(sheet_law(NYLON), 0.35)
    e = 0.01
    c = np.array([np.diag([1 + 2 * e, 0.9]), np.diag([0.9, 0.8]), np.diag([1.02, 1.02])])
    assert law.state(c).tolist() == [WRINKLED, SLACK, TAUT]
    _, stress, moduli = law.evaluate(c)
    np.testing.assert_allclose(stress[0, 0], 498 * e, rtol=3e-3)  # KEPT is what is left
    np.testing.assert_allclose(moduli[0, 0, 0], 498, rtol=3e-3)
    assert abs(stress[0, 1]) < 1e-4 * 498 * 0.06
    assert np.abs(stress[1]).max() < 1e-4 * 498 * 0.2
    np.testing.assert_allclose(stress[2], sheet_law(NYLON).evaluate(c[2:])[1][0])


@pytest.mark.parametrize("size", [0.0, 1e-9, 1e-6, 1e-3])
def test_small_folds_of_a_law_of_solids(size):
    """Its energy subtracts numbers of the order of the moduli: rounding does not keep Newton's
    method for the folds from its end. The stress is that of a linear sheet: uniaxial tension."""
    rubber = LAWS["neo_hookean"].of(c10=0.5, bulk_modulus=100.0)
    law, calls = sheet_law(rubber), []
    evaluate = law.evaluate
    law.evaluate = lambda c: calls.append(1) or evaluate(c)
    relaxed = TensionField(law, 0.5)
    c = np.broadcast_to(np.diag([1 + 2 * size, 1 - 2 * size]), (4, 2, 2))
    _, stress, moduli = relaxed.evaluate(c)
    assert len(calls) < 15
    assert np.isfinite(moduli).all()
    young = 9 * 100.0 / (3 * 100.0 + 1)  # 9 K μ/(3 K + μ), μ = 2 C10
    np.testing.assert_allclose(stress[:, 0], young * size, rtol=5e-3, atol=1e-13)


def test_a_collapsed_triangle_is_not_finite():
    """It is told as a number that is none, and the step is cut; nothing is raised."""
    collapsed = np.zeros((1, 2, 2))
    with np.errstate(all="ignore"):
        assert not np.isfinite(laws()["rubber"].evaluate(collapsed)[1]).all()


def test_wrinkles_cost_less_than_any_other_fold():
    """The relaxed energy of the knit is below that of every a on a grid, and is reached."""
    fibres = KNIT.fibre_directions(np.array([[1.0, 0, 0]]), np.array([[0, 0, 1.0]]))
    law = sheet_law(KNIT, fibres)
    c = np.array([[[1.3, 0.2], [0.2, 0.6]]])
    relaxed = TensionField(law, 0.49)
    assert relaxed.state(c)[0] == WRINKLED
    r, t = np.meshgrid(np.linspace(0, 0.9, 181), np.radians(np.arange(0, 180, 0.5)))
    a = np.column_stack([(r * np.cos(t)).ravel(), (r * np.sin(t)).ravel()])
    many = sheet_law(KNIT, np.repeat(fibres, len(a), axis=0))
    lowest = many.evaluate(c + a[:, :, None] * a[:, None])[0].min()
    here, whole = relaxed.evaluate(c)[0][0], law.evaluate(c)[0][0]
    assert here == pytest.approx((1 - 1e-4) * lowest + 1e-4 * whole, rel=1e-4)


def pillow(sheet, element="P2", counts=(4, 4)):
    """Two squares joined at their rims, the upper with its normal up, the lower down."""
    mesh = rectangle(counts, (3.0, 3.0))
    rim = np.unique(np.concatenate([edges.ravel() for edges in mesh.curves.values()]))
    count = len(mesh.points)
    lower = np.arange(count) + count
    lower[rim] = rim
    used, triangles = np.unique(
        np.vstack([mesh.triangles, lower[mesh.triangles][:, [0, 2, 1]]]), return_inverse=True
    )
    points = np.vstack([mesh.points, mesh.points])[used]
    triangles = triangles.reshape(-1, 3)
    half = len(mesh.triangles)
    parts = {"top": np.arange(half), "bottom": np.arange(half, 2 * half)}
    mesh = SheetMesh(points, triangles, parts, {})
    return build(mesh, sheet, cavities={"air": ("top", "bottom")}, element=element)


MODELS = {
    "nylon": Sheet([Ply(NYLON, 0.2)]),
    "rubber": Sheet([Ply(RUBBER, 0.2)]),
    "two plies": Sheet([Ply(KNIT, 0.3, 20.0), Ply(NYLON, 0.1)], tension_field=True),
}


@pytest.mark.parametrize("element", ["P2", "P1"])
@pytest.mark.parametrize("name", MODELS)
def test_tangent(name, element):
    model = pillow(MODELS[name], element)
    rng = np.random.default_rng(5)
    size = model.unknowns.local
    state = State(0.05 * rng.standard_normal(size))
    state.put("pressure", {"air": 0.05})
    state.put("gravity", {EVERYTHING: np.array([1e3, -2e3, 9810.0])})
    model.add_inertia()
    state.motion = TimeStep(1e8, 0.01 * rng.standard_normal(size), state.x)
    assert len(model.sheets) == len(model.inertia) == 2
    assert (element == "P2") == bool(model.sheets["top"].bend)
    direction = rng.standard_normal(size)
    for term in model.terms:
        force = np.zeros(size)
        term.add_force(state, force)
        energies, forces = [], []
        for sign in (1, -1):
            moved = replace(state, x=state.x + sign * STEP * direction)
            energies.append(term.energy(moved))
            out = np.zeros(size)
            term.add_force(moved, out)
            forces.append(out)
        scale = np.abs(force).max()
        slope = (energies[0] - energies[1]) / (2 * STEP)
        assert slope == pytest.approx(force @ direction, rel=1e-5, abs=1e-5 * scale)
        model.assembler.clear()
        term.add_tangent(state, None)
        matrix = model.assembler.finish_matrix()
        x, y = (PETSc.Vec().createSeq(size) for _ in range(2))
        x.setArray(direction)
        matrix.mult(x, y)
        difference = (forces[0] - forces[1]) / (2 * STEP)
        product = y.getArray()
        tolerance = 1e-6 * max(np.abs(difference).max(), scale)
        np.testing.assert_allclose(product, difference, rtol=0, atol=tolerance)


def test_the_enclosed_volume():
    """A pillow whose sheets are lifted to ± a curved surface; a rigid shift does not change it."""
    model = pillow(MODELS["nylon"])
    places = model.nodes.places
    state = State(np.zeros(model.unknowns.local))
    sides = {name: np.unique(part.triangles.nodes) for name, part in model.sheets.items()}
    shape = places[:, 0] * (3 - places[:, 0]) * places[:, 1] * (3 - places[:, 1])
    for name, sign in (("top", 0.1), ("bottom", -0.1)):
        inside = sides[name][shape[sides[name]] > 1e-9]
        state.x[model.displacement_dofs[inside, 2]] = sign * shape[inside]
    # ∫∫ x (3 − x) y (3 − y) = 4.5²; quadratics between exact nodes are off by h⁴ at the centres.
    exact = 2 * 0.1 * 4.5**2
    assert model.cavity_volume(state, "air") == pytest.approx(exact, rel=2e-3)
    before = model.cavity_volume(state, "air")
    state.x[model.displacement_dofs] += [3.0, -7.0, 11.0]
    assert model.cavity_volume(state, "air") == pytest.approx(before, rel=1e-12)


def test_a_restart_file_holds_the_nodes_of_sheets(tmp_path):
    """Also where two sheets lie on each other, so that places alone do not tell them apart."""
    model = pillow(MODELS["nylon"])
    state = model.initial_state()
    state.x = np.random.default_rng(0).standard_normal(model.unknowns.local)
    point = Point(0.5, state.x, np.empty(0))
    written = checkpoint.Checkpoint(0, state, state, [point], 0.1, None, 1)
    (tmp_path / RESTART).write_bytes(checkpoint.pack(model, written))
    found = checkpoint.read(model, tmp_path)
    np.testing.assert_array_equal(found.state.x, state.x)


def test_faults_have_one_line():
    mesh = rectangle((2, 2), (1.0, 1.0))
    sheet = MODELS["nylon"]
    with pytest.raises(MeshError, match="cavity 'air' is not closed: 8 edges"):
        build(mesh, sheet, cavities={"air": ("sheet",)})
    with pytest.raises(MeshError, match="more than two triangles"):
        pillow(sheet, counts=(3, 3))
    with pytest.raises(SpecError, match="normal to it"):
        build(mesh, Sheet([Ply(KNIT, 0.2)], axis=(0.0, 0.0, 1.0)))
    with pytest.raises(SpecError, match="thickness above 0"):
        Sheet([Ply(NYLON, 0.0)])
    with pytest.raises(SpecError, match="sheet 'sheet' has no material"):
        build(mesh, {})
    needle = SheetMesh(mesh.points * [1.0, 0.0, 1.0], mesh.triangles, mesh.parts, {})
    with pytest.raises(MeshError, match="have no area"):
        build(needle, sheet)

"""The measures against prescribed motions and against statics."""

import numpy as np
import pytest

from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.measures import MEASURES
from softact.measures.snapshot import Snapshot
from softact.mesh.msh_file import Tetrahedra
from softact.model import Support
from softact.system.rotation import rotation_about
from softact.system.term import State
from tests.analytic.meshes import block
from tests.analytic.solving import CLAMP, build, solve

LENGTH = 8.0  # mm
GRAVITY = 9810.0  # mm/s²
# Of values that a whole has in two places, one on each side of its plane of symmetry.
PLACES = ("max_principal", "volume_change_max", "jacobian_min")
SOFT = LAWS["neo_hookean"].of(c10=0.03, bulk_modulus=30.0, density=1.07e-9)


def bar(**layout):
    return build(block((4, 1, 1), (LENGTH, 2.0, 2.0)), SOFT, origin=(0.0, 1.0, 1.0), **layout)


def rows_of(model, displacements, names):
    """Rows of the measures for a sequence of prescribed displacement fields (points -> places)."""
    places = model.unknowns.spaces[0].tabulate_dof_coordinates()
    rows, row = [], {}
    for move in displacements:
        state = State(np.zeros(model.unknowns.local))
        state.x[model.displacement_dofs] = move(places) - places
        snapshot = Snapshot(model, state, row)
        row = {}
        for name in names:
            row |= MEASURES[name].evaluate(snapshot)
        rows.append(row)
    return rows


def rows_along(solution, names):
    """Rows of the measures at all accepted states of a solution."""
    rows, row = [], {}
    for state in solution.path:
        snapshot = Snapshot(solution.model, state, row)
        row = {}
        for name in names:
            row |= MEASURES[name].evaluate(snapshot)
        rows.append(row)
    return rows


def arc(axis, total):
    """Bend the bar's axis to an arc of ``total`` degrees about ``axis``; sections stay plane."""
    along = np.array([1.0, 0.0, 0.0])
    across = np.cross(axis, along)
    curvature = np.radians(total) / LENGTH

    def move(points):
        if not total:
            return points
        arms = (points - [0.0, 1.0, 1.0]) * [0.0, 1.0, 1.0]
        cos, sin = np.cos(curvature * points[:, :1]), np.sin(curvature * points[:, :1])
        middle = (sin * along + (1 - cos) * across) / curvature
        in_plane = (arms @ across)[:, None] * (cos * across - sin * along)
        return np.array([0.0, 1.0, 1.0]) + middle + in_plane + np.outer(arms @ axis, axis)

    return move


@pytest.mark.parametrize("total", [30.0, 170.0, 200.0, 400.0])
def test_bending_angle(total):
    """The tip's rotation, counted on past half and whole turns; a full ring has 360°, not 0."""
    axis = np.array([0.0, 1.0, 0.0])
    model = bar(bending_axis=(0.0, 1.0, 0.0))
    parts = np.linspace(0, total, 9)
    rows = rows_of(model, [arc(axis, p) for p in parts], ["bending", "twist"])
    np.testing.assert_allclose([r["bending_angle_deg"] for r in rows], parts, atol=1e-6)
    np.testing.assert_allclose([r["twist_angle_deg"] for r in rows], 0, atol=1e-6)
    # An arc's chord turns half as much.
    chord = [r["chord_angle_deg"] for r in rows[1:] if r["bending_angle_deg"] < 359]
    np.testing.assert_allclose(chord, parts[1 : len(chord) + 1] / 2, atol=1e-6)


def test_bending_the_other_way_is_negative():
    model = bar(bending_axis=(0.0, 1.0, 0.0))
    axis = np.array([0.0, 1.0, 0.0])
    rows = rows_of(model, [arc(axis, -p) for p in (0, 60, 120, 180, 240)], ["bending"])
    assert rows[-1]["bending_angle_deg"] == pytest.approx(-240, abs=1e-6)


@pytest.mark.parametrize("total", [30.0, 170.0, 200.0, 400.0])
def test_bending_angle_in_a_free_plane(total):
    """Where the layout has no bending axis it is found, and kept past half a turn."""
    axis = np.array([0.0, 0.6, -0.8])
    model = bar(bending_axis=None)
    parts = np.linspace(0, total, 8)
    rows = rows_of(model, [arc(axis, p) for p in parts], ["bending"])
    np.testing.assert_allclose([r["bending_angle_deg"] for r in rows], parts, atol=1e-5)
    found = [rows[-1][f"bending_axis_{c}"] for c in "xyz"]
    np.testing.assert_allclose(found, axis, atol=1e-6)


def test_twist():
    """Sections that turn about the axis: the tip's angle, past half a turn, and no bending."""
    model = bar(bending_axis=(0.0, 1.0, 0.0))
    centre = np.array([0.0, 1.0, 1.0])

    def twist(total):
        def move(points):
            turned = [
                rotation_about((1.0, 0.0, 0.0), p[0] / LENGTH * total) @ (p - centre)
                for p in points
            ]
            return np.array(turned) + centre

        return move

    parts = np.linspace(0, 250, 6)
    rows = rows_of(model, [twist(p) for p in parts], ["bending", "twist"])
    np.testing.assert_allclose([r["twist_angle_deg"] for r in rows], parts, atol=1e-6)
    np.testing.assert_allclose([r["bending_angle_deg"] for r in rows], 0, atol=1e-6)


def test_tip_elongation_and_strain():
    """x -> 1.25 x with free contraction: tip at 10 mm, stretch 1.25, volume unchanged."""

    def stretch(points):
        return points * [1.25, 1.25**-0.5, 1.25**-0.5]

    (row,) = rows_of(bar(), [stretch], ["tip", "elongation", "strain"])
    assert row["elongation_mm"] == pytest.approx(2.0, rel=1e-12)
    tip = [row[f"tip_{c}_mm"] for c in "xyz"]
    np.testing.assert_allclose(tip, [10.0, 1.25**-0.5, 1.25**-0.5], rtol=1e-12)
    assert row["max_principal_stretch"] == pytest.approx(1.25, rel=1e-9)
    assert row["volume_change_max"] < 1e-12


def test_volume_change_by_parts_of_the_volume():
    """x -> x + a x²/(2 L): J − 1 = a x/L, so above 20 % in the part 1 − 0.2/a of the volume, above
    0.99 a in one percent of it, a/2 on average, and largest at the end. A material that may change
    its volume does not count."""
    a = 0.5

    def swell(points):
        x, y, z = points.T
        return np.column_stack([x + a * x**2 / (2 * LENGTH), y, z])

    fine = block((40, 1, 1), (LENGTH, 2.0, 2.0))
    (row,) = rows_of(build(fine, SOFT), [swell], ["strain"])
    assert row["volume_change_beyond_percent"] == pytest.approx(100 * (1 - 0.2 / a), abs=0.5)
    assert row["volume_change_p99"] == pytest.approx(0.99 * a, abs=a / 160)
    assert row["volume_change_mean"] == pytest.approx(a / 2, rel=1e-6)
    assert row["volume_change_max"] == pytest.approx(a, abs=a / 80)
    assert row["volume_change_max_x_mm"] == pytest.approx(LENGTH, abs=LENGTH / 80)
    foam = LAWS["neo_hookean"].of(c10=0.03, bulk_modulus=0.1, density=1.07e-9)
    (row,) = rows_of(build(fine, foam), [swell], ["strain"])
    assert "volume_change_p99" not in row and "volume_change_beyond_percent" not in row
    assert row["volume_change_mean"] == pytest.approx(a / 2, rel=1e-6)


def test_the_smallest_jacobian_is_that_of_a_corner():
    """x -> x − a x²/(2 L): J = 1 − a x/L, smallest at the end, where no quadrature point is."""
    a = 1.02

    def fold(points):
        x, y, z = points.T
        return np.column_stack([x - a * x**2 / (2 * LENGTH), y, z])

    (row,) = rows_of(bar(), [fold], ["strain"])
    assert row["jacobian_min"] == pytest.approx(1 - a, abs=1e-9)
    assert row["jacobian_min_x_mm"] == pytest.approx(LENGTH)
    assert row["volume_change_max"] < 1.0  # J is above 0 in all quadrature points


def test_stress_of_a_stretched_bar():
    """Uniaxial stretch 1.5: Cauchy stress 2 C10 (λ² − 1/λ), which is also von Mises's."""
    law = LAWS["neo_hookean"].of(c10=0.14, bulk_modulus=1e6)
    model = build(block((2, 1, 1), (4.0, 1.0, 1.0)), law)
    rollers = [Support(f"{axis}_min", {number: 0.0}) for number, axis in enumerate("xyz")]
    pull = LoadStep("pull", supports=[*rollers, Support("x_max", {0: 2.0})])
    row = rows_along(solve(model, pull, rollers, 0.5), ["stress"])[-1]
    exact = 0.28 * (1.5**2 - 1 / 1.5)
    assert row["max_principal_stress_MPa"] == pytest.approx(exact, rel=1e-5)
    assert row["max_von_mises_MPa"] == pytest.approx(exact, rel=1e-5)


def test_reaction_to_weight():
    """The clamp carries the weight ρ V g and its moment about the clamp's centre."""
    model = bar()
    load = LoadStep("gravity", gravity=(0.0, 0.0, -GRAVITY))
    solution = solve(model, load, [CLAMP], 0.5)
    row = rows_along(solution, ["reaction"])[-1]
    weight = SOFT.density * GRAVITY * LENGTH * 4
    solid = model.solids["body"]
    places = solution.model.unknowns.spaces[0].tabulate_dof_coordinates()
    moved = places + solution.state.x[model.displacement_dofs]
    # The centre of gravity: the weight term of each component weighs the quadratic functions.
    unit = model.weights[0]._unit[0][model.displacement_dofs[:, 0]]
    centre = unit @ moved / unit.sum()
    assert unit.sum() == pytest.approx(SOFT.density * solid.volumes.sum(), rel=1e-12)
    force = [row[f"reaction_{c}_N"] for c in "xyz"]
    np.testing.assert_allclose(force, [0, 0, weight], atol=1e-7 * weight)
    moment = [row[f"reaction_moment_{c}_Nmm"] for c in "xyz"]
    arm = centre - [0.0, 1.0, 1.0]
    np.testing.assert_allclose(moment, np.cross(-arm, [0, 0, -weight]), atol=1e-6 * weight * LENGTH)
    assert abs(moment[1]) > 0.4 * weight * LENGTH


def test_reactions_of_what_is_held_and_of_nothing_else():
    """A block pressed between its bottom and its top: the free end face, whose edges both hold, has
    no reaction, and the two supports press on each other alone."""
    model = bar()
    held = [
        Support("z_min", {0: None, 1: None, 2: None}),
        Support("z_max", {0: None, 1: None, 2: -0.3}),
    ]
    row = rows_along(solve(model, LoadStep("press"), held), ["reaction", "held_tip"])[-1]
    assert not [name for name in row if name.startswith(("reaction_x", "reaction_moment", "tip_"))]
    below, above = ([row[f"reaction_z_{end}_{c}_N"] for c in "xyz"] for end in ("min", "max"))
    np.testing.assert_allclose(np.add(below, above), 0, atol=1e-7 * below[2])
    # Stiffer than in uniaxial compression, for both faces are held across.
    assert below[2] > 3 * 0.06 * 0.15 * LENGTH * 2


def test_supports_share_the_force_at_their_common_edge():
    """The clamp and the bottom hold one edge: together they carry the weight, and no less."""
    model = bar()
    load = LoadStep("gravity", gravity=(0.0, 0.0, -GRAVITY))
    bottom = Support("z_min", {0: 0.0, 1: 0.0, 2: 0.0})
    row = rows_along(solve(model, load, [CLAMP, bottom], 0.5), ["reaction"])[-1]
    weight = SOFT.density * GRAVITY * LENGTH * 4
    assert row["reaction_z_N"] + row["reaction_z_min_z_N"] == pytest.approx(weight, rel=1e-7)
    assert 0 < row["reaction_z_N"] < row["reaction_z_min_z_N"]


def hollow(**layout):
    """6 × 3 × 3 mm with a cavity of 2 × 1 × 1 mm that lies above the middle."""

    def keep(centres):
        inside = np.abs(centres - [3.0, 1.5, 1.875]) < [1.0, 0.5, 0.375]
        return ~inside.all(axis=1)

    tets = block((3, 3, 4), (6.0, 3.0, 3.0), keep=keep)
    return build(tets, SOFT, cavities={"cavity": ("inside",)}, **layout)


def test_cavity_volume():
    """V = det F V0 under any affine motion, V0 = 2 × 1 × 0.75 mm³."""
    turn = rotation_about((0.6, 0.0, 0.8), 50.0)
    stretched = turn @ np.diag([1.3, 0.8, 1.1]) + 0.1 * np.array([[0, 1, 0], [0, 0, 0], [1, 0, 0]])

    def move(points):
        return points @ stretched.T + [5.0, -3.0, 2.0]

    rows = rows_of(hollow(), [lambda p: p, move], ["volume"])
    found = [row["cavity_volume_mm3"] for row in rows]
    np.testing.assert_allclose(found, [1.5, 1.5 * np.linalg.det(stretched)], rtol=1e-12)


def test_work_of_pressure_is_stored():
    """Quasi-static inflation: ∫ p dV equals the strain energy; trapezoids, so within 1 %."""
    inflate = LoadStep("inflate", pressure={"cavity": 0.06})
    solution = solve(hollow(), inflate, [CLAMP], 0.05)
    rows = rows_along(solution, ["pressure", "volume", "energy"])
    assert len(rows) >= 21  # more near the limit of pressure just beyond
    assert rows[-1]["pressure_kPa"] == pytest.approx(60.0)
    assert rows[-1]["cavity_volume_mm3"] > 1.2 * rows[0]["cavity_volume_mm3"]
    assert rows[-1]["pressure_work_mJ"] == pytest.approx(rows[-1]["strain_energy_mJ"], rel=0.01)


def mirrored(tets):
    """A mesh and its image across y = 0; the face y_min becomes inner and is dropped."""
    count = len(tets.points)
    number = np.where(np.abs(tets.points[:, 1]) < 1e-12, np.arange(count), count + np.arange(count))
    points = np.vstack([tets.points, tets.points * [1.0, -1.0, 1.0]])
    used, cells = np.unique(np.vstack([tets.cells, number[tets.cells]]), return_inverse=True)
    place = np.full(2 * count, -1)
    place[used] = np.arange(len(used))
    surfaces = {
        name: np.vstack([place[triangles], place[number[triangles]]])
        for name, triangles in tets.surfaces.items()
        if name != "y_min"
    }
    cells = cells.reshape(-1, 4)
    return Tetrahedra(points[used], cells, np.zeros(len(cells), dtype=np.int32), surfaces)


def test_half_gives_the_figures_of_the_whole():
    """All measures of half an actuator with a plane of symmetry are those of the whole."""

    def keep(centres):
        return ~(np.abs(centres - [3.0, 0.0, 1.875]) < [1.0, 0.5, 0.375]).all(axis=1)

    half = block((3, 3, 4), (6.0, 1.5, 3.0), keep=keep)
    layout = dict(cavities={"cavity": ("inside",)}, bending_axis=(0.0, 1.0, 0.0))
    steps = [
        LoadStep("gravity", gravity=(0.0, 0.0, -GRAVITY)),
        LoadStep("inflate", pressure={"cavity": 0.03}),
    ]
    models = (
        build(half, SOFT, symmetry={"y_min": 1}, **layout),
        build(mirrored(half), SOFT, **layout),
    )
    rows = [rows_along(solve(model, steps, [CLAMP], 0.5), MEASURES)[-1] for model in models]
    assert set(rows[0]) == set(rows[1])
    for title in rows[0]:
        if title.startswith(PLACES) and title.endswith("y_mm"):
            assert abs(rows[0][title]) == pytest.approx(abs(rows[1][title]))
        else:
            scale = max(abs(rows[1][title]), 1e-6)
            assert rows[0][title] == pytest.approx(rows[1][title], abs=1e-6 * scale), title
    assert rows[0]["bending_angle_deg"] != 0


def test_the_pull_is_what_hangs_on_the_clamp():
    """Its weight along the axis, in tension and, upside down, in compression."""
    model = bar()
    weight = SOFT.density * GRAVITY * LENGTH * 4
    for sign in (1.0, -1.0):
        load = LoadStep("gravity", gravity=(sign * GRAVITY, 0.0, 0.0))
        row = rows_along(solve(model, load, [CLAMP], 0.5), ["reaction"])[-1]
        assert row["pull_N"] == pytest.approx(sign * weight, rel=1e-7)

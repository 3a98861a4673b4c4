"""Failure pressures against the exact stress of a thick sphere; the percentile by counting."""

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
from mpi4py import MPI

from softact.geometries.thick_sphere import ThickSphere
from softact.geometry.base import make_mesh
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.materials.breaking import breaking
from softact.measures import MEASURES
from softact.measures.failure import percentile, reached
from softact.measures.snapshot import Snapshot
from softact.mesh.msh_file import read_msh
from softact.mesh.tetrahedra import distribute
from softact.model import Model
from tests.analytic.solving import solve

INNER, OUTER = 10.0, 14.0  # mm
C10, C20 = 0.11, 0.02  # MPa
LIMIT = 0.25  # MPa, nominal strength; reached well before the last pressure
BREAK = 1.3  # stretch
LAST = 0.12  # MPa


def slope(stretch):
    """λ dŴ/dλ of the equibiaxial Yeoh law, W(λ, λ, λ⁻²), in MPa."""
    excess = 2 * stretch**2 + stretch**-4 - 3
    return (C10 + 2 * C20 * excess) * (4 * stretch**2 - 4 * stretch**-4)


def exact(inner_stretch):
    """Pressure, largest Cauchy stress and largest nominal stress (MPa) that 0.1 % of the volume
    exceeds.

    σθ = σr + λ Ŵ'/2 and σr = −∫ Ŵ'/(λ³ − 1) dλ from the outer stretch (Ogden 1984, 5.3.2); the
    nominal stress is σθ/λ. Both fall outwards, so the volume below the radius R,
    R³ = A³ + 0.001 (B³ − A³), exceeds them.
    """
    grown = (inner_stretch**3 - 1) * INNER**3

    def stretch(radius):
        return np.cbrt(1 + grown / radius**3)

    def from_outside(inner):
        def integrand(s):
            return slope(s) / s / (s**3 - 1)

        return scipy.integrate.quad(integrand, stretch(OUTER), inner, epsabs=1e-13)[0]

    radius = np.cbrt(INNER**3 + 1e-3 * (OUTER**3 - INNER**3))
    here = stretch(radius)
    cauchy = slope(here) / 2 - from_outside(here)
    return from_outside(inner_stretch), cauchy, cauchy / here


def bar(stretch):
    """Nominal stress (MPa) of an incompressible Yeoh bar, by hand."""
    excess = stretch**2 + 2 / stretch - 3
    return 2 * (C10 + 2 * C20 * excess) * (stretch - stretch**-2)


def exact_failure_pressures():
    """By nominal stress and by Cauchy stress; the latter reaches what a bar has at the strength."""
    stretches = np.linspace(1.01, 2.0, 400)
    pressures, cauchy, nominal = np.array([exact(s) for s in stretches]).T
    at_break = scipy.optimize.brentq(lambda s: bar(s) - LIMIT, 1.0, 5.0)
    return tuple(
        np.interp(limit, stresses, pressures)
        for limit, stresses in ((LIMIT, nominal), (LIMIT * at_break, cauchy))
    )


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """Rows of the failure measure while the sphere is inflated."""
    sphere = ThickSphere.model_validate(
        {"inner_radius": f"{INNER} mm", "outer_radius": f"{OUTER} mm", "mesh_size": "2 mm"}
    )
    path, layout = tmp_path_factory.mktemp("sphere") / "mesh.msh", sphere.layout()
    make_mesh(sphere, path)
    mesh = distribute(MPI.COMM_SELF, lambda: read_msh(path, layout), layout)
    law = LAWS["yeoh"].of(
        c10=C10,
        c20=C20,
        bulk_modulus=1e4 * C10,
        strength=LIMIT,
        stretch_range=(1.0, 1.25),
        elongation=BREAK - 1,
    )
    model = Model(mesh, {"body": law.material()})
    solution = solve(model, LoadStep("inflate", pressure={"cavity": LAST}), [], 0.1)
    found, row = [], {}
    for state in solution.path:
        snapshot = Snapshot(model, state, row, safety_factor=2.5)
        row = MEASURES["pressure"].evaluate(snapshot) | MEASURES["failure"].evaluate(snapshot)
        found.append(row)
    return found


def test_failure_pressures_of_the_thick_sphere(rows):
    """By all three criteria; 3 %: at the quadrature points of straight-edged tetrahedra."""
    last = rows[-1]
    exact_ones = [1e3 * pressure for pressure in exact_failure_pressures()]
    radius = np.cbrt(INNER**3 + 1e-3 * (OUTER**3 - INNER**3))
    inner = np.cbrt(1 + (BREAK**3 - 1) * (radius / INNER) ** 3)
    exact_ones.append(1e3 * exact(inner)[0])
    told = [last[f"failure_pressure_{name}_kPa"] for name in ("nominal", "cauchy", "stretch")]
    assert told == pytest.approx(exact_ones, rel=0.03)
    # The mesh's error is the same in both, so that their ratio is known better.
    assert told[0] / told[1] == pytest.approx(exact_ones[0] / exact_ones[1], rel=0.005)
    assert abs(exact_ones[0] / exact_ones[1] - 1) > 0.02, "the criteria must differ here"
    assert last["failure_pressure_kPa"] == min(told)
    assert last["safe_pressure_kPa"] == pytest.approx(min(told) / 2.5, rel=1e-12)
    place = np.linalg.norm([last[f"failure_{c}_mm"] for c in "xyz"])
    assert 0.98 * INNER < place < INNER + 0.5


def test_a_bar_breaks_at_one_load_by_both_stresses():
    """The Cauchy limit is the bar's at its nominal strength, by hand; true strengths go back."""
    at_break = scipy.optimize.brentq(lambda s: bar(s) - LIMIT, 1.0, 5.0)
    given = {"c10": C10, "c20": C20, "bulk_modulus": 1e4 * C10}
    bears = breaking(LAWS["yeoh"].of(strength=LIMIT, **given).material())
    assert bears.cauchy == pytest.approx(LIMIT * at_break, rel=1e-3)
    true = LAWS["yeoh"].of(strength=LIMIT * at_break, strength_is="true", **given)
    assert breaking(true.material()).nominal == pytest.approx(LIMIT, rel=1e-3)


def test_failure_is_told_once_and_from_then_on(rows):
    """Empty before, the same number afterwards; it lies between the rows around it."""
    told = [row for row in rows if "failure_pressure_kPa" in row]
    assert 0 < len(told) < len(rows)
    assert len({row["failure_pressure_kPa"] for row in told}) == 1
    first = rows.index(told[0])
    before, after = rows[first - 1]["pressure_kPa"], rows[first]["pressure_kPa"]
    assert before < told[0]["failure_pressure_kPa"] <= after
    assert rows[first - 1]["principal_nominal_stress_p999_MPa"] < LIMIT


def test_tested_stretch_is_reached_where_the_inner_stretch_says(rows):
    """The stretch of 0.1 % of the volume is λ(R) < λa: pressure at λ(R) = 1.25 from the exact
    solution; 3 % as above."""
    radius = np.cbrt(INNER**3 + 1e-3 * (OUTER**3 - INNER**3))
    inner = np.cbrt(1 + (1.25**3 - 1) * (radius / INNER) ** 3)
    assert rows[-1]["tested_stretch_pressure_kPa"] == pytest.approx(1e3 * exact(inner)[0], rel=0.03)


def test_percentile_counts_volume_and_not_points():
    """Ten points, one of which has 0.05 % of the volume and the largest value: the next decides."""
    values = np.arange(10.0)
    volumes = np.full(10, 1.0)
    volumes[9] = 0.0005 * 9
    tensors = np.zeros((10, 6))
    tensors[:, 0] = values

    def places(chosen):
        return np.column_stack(3 * [values[chosen]])

    value, place, _ = percentile(MPI.COMM_SELF, tensors, volumes, places)
    assert value == pytest.approx(8, rel=1e-14) and place.tolist() == [8, 8, 8]
    assert percentile(MPI.COMM_SELF, tensors, np.ones(10), places)[0] == pytest.approx(9, rel=1e-14)


def test_percentile_leaves_out_only_what_cannot_count():
    """Against the eigenvalues of all points, sorted."""
    draw = np.random.default_rng(7)
    full = draw.normal(size=(20_000, 3, 3)) * draw.exponential(size=(20_000, 1, 1))
    full = full + full.transpose(0, 2, 1)
    volumes = draw.uniform(size=20_000)
    largest = np.linalg.eigvalsh(full)[:, 2]
    order = np.argsort(-largest)
    above = np.cumsum(volumes[order])
    chosen = order[np.searchsorted(above, 1e-3 * above[-1])]
    tensors = full[:, [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    value, place, _ = percentile(
        MPI.COMM_SELF, tensors, volumes, lambda n: np.column_stack(3 * [n])
    )
    assert value == pytest.approx(largest[chosen], rel=1e-12) and place[0] == chosen


def test_crossing_is_linear_between_rows_and_a_vacuum_counts():
    columns = {"stress": 1.0, "pressure_a_kPa": -10.0, "pressure_b_kPa": 4.0}
    later = {"stress": 3.0, "pressure_a_kPa": -20.0, "pressure_b_kPa": 4.0}
    assert reached(later, columns, "stress", 1.5, ("a", "b")) == pytest.approx(-12.5)
    assert reached(columns, {}, "stress", 1.5, ("a", "b")) is None
    assert reached(later, {}, "stress", 1.5, ("a", "b")) == -20.0

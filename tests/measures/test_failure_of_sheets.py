"""Failure pressures of cylindrical sheets against the hoop tension p r = strength x thickness."""

import numpy as np
import pytest

from softact.bodies.sheet import Ply, Sheet
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.measures import MEASURES
from softact.measures.snapshot import Snapshot
from softact.mesh.sheets import SheetMesh
from softact.model import Support
from tests.analytic.sheet_meshes import build, edges_of, grid
from tests.analytic.solving import solve

E, NU, T, R, LENGTH = 498.0, 0.35, 0.2, 10.0, 6.0
STRENGTH, BREAK = 5.0, 1.01  # MPa; stretch
LAST = 0.13  # MPa, beyond both


def fabric(young=E, **card):
    """A linear fabric with a card of its own."""
    return LAWS["linear"].of(youngs_modulus=young, poissons_ratio=NU, **card)


def quarter_tube(m=40) -> SheetMesh:
    """A quarter of a tube along x, y and z >= 0, with a curve on each of its sides."""

    def place(s):
        angle = np.pi / 2 * s[:, 1]
        return np.column_stack([LENGTH * s[:, 0], R * np.cos(angle), R * np.sin(angle)])

    points, triangles, ends = grid((2, m), place)
    points[np.abs(points) < 1e-12] = 0.0
    curves = {n: edges_of(row) for n, row in zip(("x_0", "x_1", "z_0", "y_0"), ends, strict=True)}
    outwards = triangles[:, [0, 2, 1]]
    return SheetMesh(points, outwards, {"wall": np.arange(len(triangles))}, curves)


def burst(*plies):
    """The last row of the failure measure of a tube that is held at its length."""
    model = build(
        quarter_tube(),
        Sheet(plies, bending=0.0),
        cavities={"air": ("wall",)},
        symmetry={"z_0": 2, "y_0": 1},
        flux=(0.0, 0.5, 0.5),  # both ends are open
    )
    held = [Support(end, {0: 0.0}) for end in ("x_0", "x_1")]
    solution = solve(model, LoadStep("inflate", pressure={"air": LAST}), held, 0.25)
    row = {}
    for state in solution.path:
        snapshot = Snapshot(model, state, row, safety_factor=2.0)
        row = MEASURES["pressure"].evaluate(snapshot) | MEASURES["failure"].evaluate(snapshot)
    return row


def hoop(stress, thickness):
    """Pressure, kPa: p r = σ t/λ, as the wall gets wider by λ and thinner; λ = 1 + (1 − ν²) σ/E."""
    return 1e3 * stress * thickness / (R * (1 + (1 - NU**2) * stress / E))


def test_a_cylindrical_pouch_bursts_by_its_hoop_tension():
    row = burst(Ply(fabric(strength=STRENGTH, elongation=BREAK - 1), T))
    assert row["failure_pressure_nominal_kPa"] == pytest.approx(hoop(STRENGTH, T), rel=5e-3)
    # p = S t/R with the stress S of St. Venant and Kirchhoff, which is linear in Green's strain.
    by_stretch = 1e3 * E / (1 - NU**2) * (BREAK**2 - 1) / 2 * T / R
    assert row["failure_pressure_stretch_kPa"] == pytest.approx(by_stretch, rel=5e-3)
    told = [row[f"failure_pressure_{name}_kPa"] for name in ("nominal", "cauchy", "stretch")]
    assert row["failure_pressure_kPa"] == min(told)
    assert row["safe_pressure_kPa"] == pytest.approx(row["failure_pressure_kPa"] / 2, rel=1e-12)
    stress = 1e-3 * row["pressure_kPa"] * R / T * row["principal_stretch_p999"]
    assert row["principal_nominal_stress_p999_MPa"] == pytest.approx(stress, rel=5e-3)
    place = [row[f"failure_{c}_mm"] for c in "yz"]
    assert np.linalg.norm(place) == pytest.approx(R, rel=5e-3)


def test_each_ply_is_judged_by_a_stress_of_its_own():
    """Of two plies the stiffer carries twice the stress; the soft one's card has no strength."""
    row = burst(Ply(fabric(E / 2), T), Ply(fabric(strength=STRENGTH), T / 2))
    assert row["failure_pressure_wall_1_kPa"] == pytest.approx(hoop(STRENGTH, T), rel=5e-3)
    assert "failure_pressure_wall_0_kPa" not in row
    stresses = [row[f"principal_nominal_stress_p999_wall_{n}_MPa"] for n in (0, 1)]
    assert stresses[1] == pytest.approx(2 * stresses[0], rel=1e-6)

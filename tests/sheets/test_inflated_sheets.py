"""Sheets inflated from the flat state, by implicit dynamics and then statics: exact solutions."""

import re
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from softact.bodies.sheet import Ply, Sheet
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.mesh.sheets import SheetMesh
from softact.model import Support
from softact.solve.rungs.inflation import PACE, _Inflation
from tests.analytic.sheet_meshes import build, edges_of, grid, quarter_disc
from tests.analytic.solving import solve

E, NU, T = 498.0, 0.35, 0.2
NYLON = LAWS["linear"].of(youngs_modulus=E, poissons_ratio=NU)
DISC = {"x_0": 0, "y_0": 1, "rim": 2}


def hencky(radius, pressure) -> float:
    """Rise of the centre of a clamped circular membrane, mm (Hencky 1915; Fichter 1997).

    Radial force f(r) per length: f'' + 3 f'/r = −E t p²/(8 f²), f + r f' = ν f at the rim,
    and the slope −p r/(2 f).
    """
    k = E * T * pressure**2 / 8
    start = 1e-6 * radius

    def shot(f0):
        def rates(r, y):
            return [y[1], -3 * y[1] / r - k / y[0] ** 2, pressure * r / (2 * y[0])]

        begin = [f0, -k * start / (4 * f0**2), 0.0]
        return solve_ivp(rates, (start, radius), begin, rtol=1e-10, atol=1e-14).y[:, -1]

    def miss(f0):
        f, slope, _ = shot(f0)
        return (1 - NU) * f + radius * slope

    scale = (k * radius**2) ** (1 / 3)
    return shot(brentq(miss, 0.6 * scale, 5 * scale))[2]


def inflated(model, pressure, supports=(), increment=0.25):
    return solve(model, LoadStep("inflate", pressure={"air": pressure}), supports, increment)


def test_hencky():
    radius, pressure = 50.0, 5e-4
    sheet = Sheet([Ply(NYLON, T)], bending=0.0)
    model = build(quarter_disc(4, radius), sheet, cavities={"air": ("sheet",)}, symmetry=DISC)
    clamped = [Support("rim", {0: 0.0, 1: 0.0, 2: 0.0})]
    solution = inflated(model, pressure, clamped)
    # Fichter (NASA TP-3658, table 1): w/a = 0.6534 (p a/(E t))^(1/3) at ν = 0.3; less at 0.35.
    known = 0.6534 * radius * (pressure * radius / (E * T)) ** (1 / 3)
    assert 0.96 * known < hencky(radius, pressure) < known
    assert solution.displacement((0, 0, 0))[2] == pytest.approx(hencky(radius, pressure), rel=0.02)


def test_mylar_balloon():
    """Two inextensible discs of radius a welded at the rim: inflated radius 0.7627 a, thickness
    by diameter 0.599, volume 1.2185 a³ (Paulsen, Am. Math. Mon. 101 (1994) 953)."""
    a = 50.0
    sheet = Sheet([Ply(NYLON, T)], tension_field=True, bending=0.0)
    model = build(quarter_disc(4, a), sheet, cavities={"air": ("sheet",)}, symmetry=DISC)
    solution = inflated(model, 0.005)
    state = solution.state
    places = model.nodes.places + state.x[model.nodes.dofs]
    rim = np.linalg.norm(places[np.unique(model.surfaces.curves["rim"])], axis=1).mean()
    top = solution.displacement((0, 0, 0))[2]
    assert rim / a == pytest.approx(0.7627, rel=0.02)
    assert top / rim == pytest.approx(0.599, rel=0.02)
    assert 8 * model.cavity_volume(state, "air") / a**3 == pytest.approx(1.2185, rel=0.02)
    # The way there is told: quasi-static once the sheets carry something.
    remark = solution.stepper.progress.remarks[0]
    assert "quasi-static from" in remark and "more than quasi-static" not in remark
    check_energies(solution, remark)
    wrinkled = model.sheets["sheet"].membrane.wrinkling(state.x)
    assert (wrinkled == 1).mean() > 0.5  # the meridians carry, the hoops do not


def check_energies(solution, remark):
    """All of the work is told, to 1 %; the work is ∫ p dV over the accepted states, of the whole
    balloon, and strain energy what the sheets hold in the end."""
    told = r"of the loads' work of (.*?) mJ, (.*?) mJ became strain energy and (.*?) mJ motion, "
    told += r"damping took (.*?) mJ and the time steps (.*?) mJ; (.*?)% are unexplained"
    work, stored, moving, damped, lost, unexplained = map(float, re.search(told, remark).groups())
    assert abs(work - stored - moving - damped - lost) < 0.01 * work
    assert unexplained < 1.0 and min(stored, damped, lost) > 0
    model, copies = solution.model, solution.model.mesh.layout.copies
    assert "to 100.00%" in remark  # so that all states belong to it
    p = np.array([state["pressure"].get("air", 0.0) for state in solution.path])
    v = np.array([model.cavity_volume(state, "air") for state in solution.path])
    through = copies * float((p[1:] + p[:-1]) @ np.diff(v)) / 2
    assert work == pytest.approx(through, rel=0.02)
    assert stored == pytest.approx(copies * model.strain_energy(solution.state), rel=1e-3)


def pouch(length, width) -> SheetMesh:
    """A quarter of the upper sheet of a long pouch: x from its middle to the seam, y along it."""

    def place(s):
        return np.column_stack([s[:, 0] * length / 2, s[:, 1] * width, np.zeros(len(s))])

    points, triangles, ends = grid((6, 1), place)
    names = ("middle", "seam", "y_0", "y_1")
    curves = {name: edges_of(row) for name, row in zip(names, ends, strict=True)}
    return SheetMesh(points, triangles, {"sheet": np.arange(len(triangles))}, curves)


@pytest.mark.parametrize("theta", [0.4, 0.8])
def test_pouch_motor(theta):
    """Long pouch, seams held at the distance L sin θ/θ: circular arcs of the half angle θ enclose
    L² (θ − sin θ cos θ)/(2 θ²) per width and pull with p L cos θ/θ (Niiyama et al., Soft Robotics 2
    (2015) 59, eqs. 1 to 4)."""
    length, width, pressure = 40.0, 3.0, 0.002
    sheet = Sheet([Ply(NYLON, T)], tension_field=True, bending=0.0)
    model = build(
        pouch(length, width),
        sheet,
        cavities={"air": ("sheet",)},
        symmetry={"middle": 0, "y_0": 1, "seam": 2},
        flux=(0.0, 0.0, 1.0),
    )
    held = length * np.sin(theta) / theta
    supports = [Support("y_1", {1: 0.0}), Support("seam", {0: (held - length) / 2})]
    solution = solve(
        model,
        LoadStep("inflate", pressure={"air": pressure}, supports=supports),
        supports,
        increment=0.25,
    )
    area = length**2 * (theta - np.sin(theta) * np.cos(theta)) / (2 * theta**2)
    volume = 4 * model.cavity_volume(solution.state, "air") / width
    assert volume == pytest.approx(area, rel=0.03)
    pull = 2 * solution.reaction("seam")[0] / width
    assert pull == pytest.approx(pressure * length * np.cos(theta) / theta, rel=0.03)


def test_the_end_does_not_depend_on_the_way():
    """Statics has the last word: the time steps of the inflation leave no trace."""
    sheet = Sheet([Ply(NYLON, T)], bending=0.0)
    model = build(quarter_disc(3, 20.0), sheet, cavities={"air": ("sheet",)}, symmetry=DISC)
    clamped = [Support("rim", {0: 0.0, 1: 0.0, 2: 0.0})]
    straight = inflated(model, 5e-3, clamped)
    ends = inflated(model, 5e-3, clamped, increment=0.1)
    np.testing.assert_allclose(ends.state.x, straight.state.x, atol=1e-5)


@pytest.mark.parametrize("part", [0.999, 0.9])
def test_a_balloon_falls_back(part):
    """A clamped disc of rubber, blown up beyond its largest pressure, is unstable when the pressure
    is held. Let go inside of that state it falls back to the disc that is blown up by the same
    pressure from the start, and gets there by motion: neither statics nor a long time step may take
    it to the unstable state, nor statics to the other from afar."""
    rubber = LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=100.0)
    sheet = Sheet([Ply(rubber, 1.0, incompressible=True)], bending=0.0)
    mesh, walls = quarter_disc(2, 20.0), {"air": ("sheet",)}
    model = build(mesh, sheet, cavities=walls, symmetry=DISC)
    clamped = [Support("rim", {0: 0.0, 1: 0.0, 2: 0.0})]
    fill = LoadStep("fill", pressure={"air": 3e-3}), LoadStep("blow", inject={"air": 12e3})
    solution = solve(model, fill, clamped, increment=0.1)
    stepper, state = solution.stepper, solution.state
    pressure, first = float(state["pressure"]["air"]), len(solution.path)
    assert max(s["pressure"].get("air", 0.0) for s in solution.path) > 1.1 * pressure

    begun = part * state.x
    state.x = begun.copy()
    step = LoadStep("let go")
    walk = stepper.walk
    walk.begin(2, step)
    walk.largest = 0.25
    assert _Inflation(walk, pressure).run() is None
    straight = inflated(build(mesh, sheet, cavities=walls, symmetry=DISC), pressure, clamped)
    np.testing.assert_allclose(state.x, straight.state.x, atol=1e-4)
    moved = [np.abs(b.x - a.x).max() for a, b in pairwise(solution.path[first:])]
    assert len(moved) > 3 and moved[-1] < 0.1 < 1.0 < np.abs(state.x - begun).max()


@pytest.mark.parametrize("found", [True, False])
def test_a_time_step_that_leaves_the_sheets_where_they_are_is_solved_further(found):
    """In balance to TIGHT they would stay at any time step, though a long limb has far to go."""
    inflation = object.__new__(_Inflation)
    inflation.walk = SimpleNamespace(state=SimpleNamespace(x=np.zeros(2)))
    asked = []

    def solved(x, s, q, tolerance):
        asked.append(tolerance)
        finer = tolerance == PACE.tighter
        inflation.walk.state.x = np.full(2, 7.0 if finer else 1e-7)
        return SimpleNamespace(converged=not finer or found, iterations=3 * finer)

    inflation._solve = solved
    outcome = inflation._next(np.zeros(2), 1.0, None)
    assert asked == [PACE.tight, PACE.tighter]
    assert inflation.tight
    assert outcome.converged
    assert (outcome.iterations, inflation.walk.state.x[0]) == ((3, 7.0) if found else (0, 0.0))

"""Fits to published data beside the constants that were published with them."""

from pathlib import Path

import numpy as np
import pytest

from softact.fit.candidates import CANDIDATES, as_candidate, chosen
from softact.fit.data import read_tests
from softact.fit.fit import Options, fit, ranked
from softact.fit.modes import nominal_stress, sheet_stress
from softact.fit.sheet import sheets_from_argument
from softact.fit.tell import tell_comparison
from softact.materials import LAWS, load_card
from tests.fit.made import made

REPOSITORY = Path(__file__).parents[2]


DATA = REPOSITORY.parent / "shared" / "data"


needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="the test data are not here")


def test_palacios_lazo_choice_of_yeoh():
    """Five specimens of its Yeoh law, 16 % scatter in strength and 11 % in elongation."""
    law = load_card("elastic-50a-v2")
    # Five values of unit standard deviation, in different orders for stiffness and elongation.
    even = np.array([-2.0, -1.0, 0.0, 1.0, 2.0]) / np.sqrt(2.5)
    tests = []
    for i, (stiffer, longer) in enumerate(zip(even, even[[2, 4, 1, 3, 0]], strict=True)):
        # The law reaches the 3.4 MPa of the data sheet at a stretch of 2.02.
        end = 1 + 1.02 * (1 + 0.107 * longer)
        tests.append(made(law, "uniaxial", np.linspace(1, end, 60), f"specimen {i + 1}",
                          0.005, 1 + 0.163 * stiffer, seed=i))  # fmt: skip
    names = ("neo_hookean", "mooney_rivlin", "yeoh")
    order = ranked([fit(tests, c) for name in names for c in chosen(name, False)])
    assert order[0].name == "yeoh"
    assert order[0].information.bic < min(f.information.bic for f in order[1:]) - 10
    best = order[0]
    # The joint curve stays within the specimens' scatter of the law that they were drawn from.
    path = np.array([1.2, 1.5, 1.8, 2.0])
    mine = nominal_stress(
        best.candidate.law, best.candidate.constants(best.vector), "uniaxial", path
    )
    assert np.allclose(mine, nominal_stress(law, law, "uniaxial", path), rtol=0.163)
    (spread,) = best.spreads
    assert spread.specimens == 5 and spread.stress == pytest.approx(0.163, rel=0.02)
    assert len(best.specimens) == 5
    assert 0.3 < best.chi_square < 3.0


NGUYEN = ("uncoated-uniaxial", "coated-uniaxial", "uncoated-biaxial", "coated-biaxial")


@pytest.mark.parametrize("name", NGUYEN)
def test_the_four_fits_of_nguyen_and_zhang(name):
    """Evaluated with k2 = 0 or nearly so: the fibre stress is the limit k1 E dE/dλ."""
    law = load_card(f"knit-fabric-{name}")
    mode = "equibiaxial" if "biaxial" in name else "uniaxial"
    stretch = np.linspace(1.0, 1.6, 13)
    for direction in ("course", "wale"):
        stress = sheet_stress(law, law, mode, direction, stretch)
        assert stress[0] == pytest.approx(0, abs=1e-14) and np.all(np.diff(stress) > 0)
    if mode == "equibiaxial":
        s = stretch
        strain = s**2 - 1  # both families lie along course, κ = 0
        course = sheet_stress(law, law, mode, "course", s)
        expected = 2 * law.c10 * (s - s**-5) + 2 * law.k1 * strain * 2 * s
        assert np.allclose(course, expected, rtol=1e-8)
        wale = sheet_stress(law, law, mode, "wale", s)
        assert np.allclose(wale, 2 * law.c10 * (s - s**-5), rtol=1e-8)


def treloar():
    tests = []
    for name, mode in (("UT", "uniaxial"), ("ET", "equibiaxial"), ("PS", "planar")):
        path = DATA / "rubber" / f"treloar_1944_{name}.txt"
        options = {"columns": ("nominal_stress MPa", "stretch")}
        for sheet in sheets_from_argument(f"{path}:{mode}", options):
            tests += read_tests(sheet)
    return tests


@needs_data
def test_ogdens_published_constants_on_treloar():
    """R² .97454, .99738, .99809 are published; the printed moduli give .97444, .99704, .99808.

    The difference is the rounding of the printed moduli: no usual definition of R² closes it (nor
    leaving out or adding a point, nor the stress per deformed area), but moduli that print as 0.63,
    0.0012 and -0.01 do.
    """
    published = [0.97454, 0.99738, 0.99809]
    for mu, tolerance in (((0.63, 0.0012, -0.01), 4e-4), ((0.62918, 0.00120091, -0.0101139), 1e-5)):
        law = LAWS["ogden"].of(convention="classic", mu=list(mu), alpha=[1.3, 5, -2])
        found = fit(treloar(), as_candidate(law))
        assert [q.r2 for q in found.qualities] == pytest.approx(published, abs=tolerance)
        assert (round(mu[0], 2), round(mu[1], 4), round(mu[2], 2)) == (0.63, 0.0012, -0.01)


@needs_data
def test_blind_fit_of_treloar_ranks_ogden_3_above_yeoh_and_mooney_rivlin():
    names = ("ogden_3", "yeoh", "mooney_rivlin_2", "mooney_rivlin_3", "mooney_rivlin_5")
    order = ranked([fit(treloar(), CANDIDATES[name]) for name in names])
    assert order[0].name == "ogden_3"
    assert all(q.r2 > 0.99 for q in order[0].qualities)
    assert order[0].sound
    assert all(f.r2 < 0.95 for f in order[1:])


@needs_data
def test_ecoflex_of_the_epfl_beside_agarwals_constants():
    sheets = sheets_from_argument(str(REPOSITORY / "tests" / "fit" / "ecoflex_00_30.yaml"), {})
    tests = [test for sheet in sheets for test in read_tests(sheet)]
    found = fit(tests, CANDIDATES["ogden_3"], Options(balance=True))
    assert all(q.r2 > 0.99 for q in found.qualities) and not found.failures
    uniaxial, planar = tell_comparison(found, load_card("ecoflex-00-30"), "Agarwal")
    # The published constants are stiffer than this specimen: by about half in uniaxial tension.
    assert "+57.6 % on average" in uniaxial
    assert "-8.3 % on average" in planar


@needs_data
def test_epfls_own_constants_beside_its_uniaxial_test():
    """Within 6 % of the test as recorded at strains of 50 to 200 %; Agarwal's are up to 28 % off,
    and 2.6 times as stiff in two directions at 100 %."""
    own, agarwal = (load_card(name) for name in ("ecoflex-00-30-epfl", "ecoflex-00-30"))
    file = DATA / "ecoflex30_epfl" / "uniaxial.csv"
    stress, strain = np.loadtxt(file, delimiter=",").T
    middle = (strain > 0.5) & (strain < 2.0)
    deviation = [
        abs(nominal_stress(law, law, "uniaxial", 1 + strain[middle]) / stress[middle] - 1).max()
        for law in (own, agarwal)
    ]
    assert deviation[0] < 0.06 and deviation[1] == pytest.approx(0.28, abs=0.01)
    both = [nominal_stress(law, law, "equibiaxial", np.array([2.0]))[0] for law in (agarwal, own)]
    assert both[0] / both[1] == pytest.approx(2.58, abs=0.01)

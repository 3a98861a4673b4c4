"""`softact fit` from the command line: files, exit codes, and a card that a spec takes."""

import json
import re
from itertools import pairwise

import numpy as np
import pytest
import yaml
from matplotlib.image import imread

from softact.cli import main as cli
from softact.fit.modes import nominal_stress
from softact.materials import LAWS, parse_material
from softact.materials.breaking import breaking
from softact.spec import load

LAW = LAWS["yeoh"].of(c10=0.11, c20=-0.004, c30=0.003)
STRETCH = np.linspace(1.0, 2.5, 30)


# Nine aliases of nine aliases of ...: 400 bytes for 9^9 values.
BOMB = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{b}: &{b} [{', '.join([f'*{a}'] * 9)}]\n" for a, b in pairwise("abcdefghi")
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for mode in ("uniaxial", "planar"):
        stress = nominal_stress(LAW, LAW, mode, STRETCH) * 1e3
        rows = [f"{100 * (s - 1):.8f};{p:.8f}" for s, p in zip(STRETCH, stress, strict=True)]
        text = "\n".join(["strain %;nominal stress (kPa)", *rows])
        (tmp_path / f"{mode}.csv").write_text(text)
    return tmp_path


def softact(capsys, *arguments):
    with pytest.raises(SystemExit) as stop:
        cli.main(["fit", *arguments])
    out = capsys.readouterr()
    return stop.value.code, out.out, out.err


def test_fit_writes_card_plot_and_numbers(folder, capsys):
    code, out, err = softact(
        capsys, "uniaxial.csv", "planar.csv:planar", "--law", "yeoh", "--name", "mine",
        "--density", "1.13 g/cm^3", "--strength", "3 MPa", "-o", "out",
    )  # fmt: skip
    assert (code, err) == (0, "")
    assert "c10" in out and "R² 1.00000" in out and "Drucker, equibiaxial: stable" in out
    card = yaml.safe_load((folder / "out" / "mine.yaml").read_text())
    law = parse_material(card)
    assert (law.c10, law.c20, law.c30) == pytest.approx((0.11, -0.004, 0.003), rel=1e-6)
    assert law.density == pytest.approx(1.13e-9) and law.strength == 3.0
    assert law.stretch_range == (1.0, 2.5)
    numbers = json.loads((folder / "out" / "mine.json").read_text())
    assert numbers[0]["constants"]["c10"] == pytest.approx(0.11)
    assert numbers[0]["stable_over_the_tests"] is True
    assert imread(folder / "out" / "mine.png").std() > 0.05
    assert sorted(p.name for p in (folder / "out").iterdir()) == [
        ".softact.json", "mine.html", "mine.json", "mine.png", "mine.yaml",
    ]  # fmt: skip
    page = (folder / "out" / "mine.html").read_text()
    found = re.findall(r"<script type='application/json'>(.*?)</script>", page, re.S)
    plots = {plot["title"]: plot for plot in map(json.loads, found)}
    assert list(plots) == [
        "Uniaxial", "Planar", "Equibiaxial: prediction, not tested", "Residuals of yeoh",
    ]  # fmt: skip
    data, law_drawn = plots["Uniaxial"]["traces"]
    expected = nominal_stress(LAW, LAW, "uniaxial", np.array(law_drawn["x"])) * 1e3
    assert law_drawn["y"] == pytest.approx(expected, abs=1e-3)
    assert data["x"] == pytest.approx(STRETCH, rel=1e-6)
    assert "Download mine.yaml" in page and "0.11" in page


def test_specimens_that_broke_give_strength_and_elongation(folder, capsys):
    """Two tests of one law that end at 2.5 and, torn off within a point, at 2.0; half is fitted."""
    lines = (folder / "uniaxial.csv").read_text().splitlines()
    torn = [*lines[:22], *(f"{105 + i};{p}" for i, p in enumerate((20, 3, 2, 1)))]
    (folder / "torn.csv").write_text("\n".join(torn))
    code, out, err = softact(
        capsys, "uniaxial.csv", "torn.csv", "--broke", "--to", "1.9", "--name", "mine", "-o", "out"
    )
    assert (code, err) == (0, "")
    ends = STRETCH[[-1, 20]]
    stresses = nominal_stress(LAW, LAW, "uniaxial", ends)
    assert f"broke at a stretch of 2.034 and {1e3 * stresses[1]:.4g} kPa (nominal)" in out
    law = parse_material(yaml.safe_load((folder / "out" / "mine.yaml").read_text()))
    assert law.strength == pytest.approx(stresses.mean(), rel=1e-5)
    assert law.strength_is == "nominal" and "2 specimens" in law.strength_source
    assert law.elongation == pytest.approx(ends.mean() - 1, rel=1e-5)
    assert law.stretch_range[1] < 1.9
    assert breaking(law.material()).nominal == law.strength


def test_the_card_goes_into_a_spec_as_it_is(folder, capsys):
    softact(capsys, "uniaxial.csv", "--name", "mine", "-o", "own")
    card = yaml.safe_load((folder / "own" / "mine.yaml").read_text())
    spec = {
        "geometry": {"type": "block", "mesh_size": "10 mm"},
        "materials": {"body": card},
        "steps": [{"traction": {"surface": "x_max", "value": ["1 kPa", "0 kPa", "0 kPa"]}}],
    }
    (folder / "cube.yaml").write_text(yaml.safe_dump(spec))
    inline = load(folder / "cube.yaml").materials["body"]
    assert inline.c10 == pytest.approx(0.11, rel=1e-6)
    spec["materials"] = {"body": "own/mine.yaml"}
    (folder / "cube.yaml").write_text(yaml.safe_dump(spec))
    assert load(folder / "cube.yaml").materials["body"] == inline.model_copy(
        update={"name": "mine"}
    )


def test_all_laws_are_ranked_and_the_law_of_the_data_wins(folder, capsys):
    rng = np.random.default_rng(2)
    stress = nominal_stress(LAW, LAW, "uniaxial", STRETCH) + 3e-4 * rng.standard_normal(30)
    rows = [f"{s:.8f},{p:.8f}" for s, p in zip(STRETCH, stress, strict=True)]
    (folder / "noisy.csv").write_text("\n".join(["stretch,nominal_stress MPa", *rows]))
    code, out, _ = softact(capsys, "noisy.csv", "--law", "all", "--starts", "1", "-o", "out")
    assert code == 0
    table = out[out.index("law  ") :].splitlines()
    assert table[1].split()[0] == "yeoh"
    assert len(json.loads((folder / "out" / "noisy.json").read_text())) > 12


def test_comparison_with_a_card_is_said_in_numbers(folder, capsys):
    code, out, _ = softact(capsys, "uniaxial.csv", "--compare", "elastosil-m4601", "-o", "out")
    assert code == 0
    other = LAWS["yeoh"].of(c10=0.11, c20=0.02)
    mine = nominal_stress(LAW, LAW, "uniaxial", STRETCH)
    large = mine > 0.05 * mine[-1]
    ratio = (nominal_stress(other, other, "uniaxial", STRETCH) / np.where(large, mine, 1) - 1)[
        large
    ]
    assert f"differs from the fit by {100 * ratio.mean():+.1f} % on average" in out


def test_a_fitted_card_is_compared_with_a_later_fit(folder, capsys):
    softact(capsys, "uniaxial.csv", "--name", "mine", "-o", "own")
    code, out, _ = softact(capsys, "planar.csv:planar", "--compare", "own/mine.yaml", "-o", "out")
    assert code == 0
    assert "own/mine.yaml on planar (planar): R² 1.0000" in out


def test_held_constant_and_warning_of_a_wrong_unit(folder, capsys):
    text = (folder / "uniaxial.csv").read_text().replace("(kPa)", "(Pa)")
    (folder / "uniaxial.csv").write_text(text)
    code, out, _ = softact(capsys, "uniaxial.csv", "--fix", "c30=0 MPa", "-o", "out")
    assert code == 0
    assert "kPa given as Pa" in out and "c30       = 0.0 (held)" in out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["none.csv"], "there is no such file"),
        (["uniaxial.csv:shear"], "is no mode"),
        (["uniaxial.csv", "--law", "yoeh"], "did you mean 'yeoh'"),
        (["uniaxial.csv", "--thickness", "0 mm"], "greater than 0"),
        (["uniaxial.csv", "--thickness", "3"], "no unit"),
        (["uniaxial.csv", "--method", "simplex"], "Nelder-Mead"),
        (["uniaxial.csv", "--fix", "c30"], "name=value"),
        (["uniaxial.csv", "--fix", "c40=0 MPa"], "no constant 'c40'"),
        (["uniaxial.csv", "--law", "all", "--fix", "c30=0 MPa"], "--law all"),
        (["uniaxial.csv", "--compare", "elastosil"], "did you mean 'elastosil-m4601'"),
        (["uniaxial.csv", "--compare", "./none.yaml"], "none.yaml: there is no such file"),
        (["uniaxial.csv", "--density", "3 mm"], "density"),
        (["uniaxial.csv", "--columns", "strain %, -"], "no column for the load"),
        (["uniaxial.csv", "--stress", "cauchy"], "is not the cauchy stress"),
        (["uniaxial.csv", "--name", "../x"], "no name for files"),
        (["uniaxial.csv", "--cycle", "0"], "is no cycle"),
        (["."], "this is a folder"),
        (["bomb.yaml"], "aliases expand to more than 20000 values"),
        (["uniaxial.csv", "--seed", "-1"], "is not in the range"),
        (["planar.csv:planar", "--broke"], "come from uniaxial tension; this is planar"),
        (["uniaxial.csv", "--broke", "--loading"], "leave out loading"),
        (["uniaxial.csv", "--broke", "--strength", "3 MPa"], "give one"),
        (["uniaxial.csv", "--broke", "--cyclic"], "--broke does not go with --cyclic"),
        ([], "FILE"),
    ],
)
def test_wrong_input_is_told_and_writes_nothing(folder, capsys, arguments, said):
    (folder / "bomb.yaml").write_text(BOMB)
    before = sorted(folder.iterdir())
    code, _, err = softact(capsys, *arguments)
    assert code == 2
    assert said in err and "Traceback" not in err
    assert sorted(folder.iterdir()) == before

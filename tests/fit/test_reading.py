"""Reading test data: units, kinds of stress, branches, and data that cannot be right."""

import numpy as np
import pytest

from softact.errors import SpecError
from softact.fit.data import read_tests
from softact.fit.plausible import secant_modulus, warnings
from softact.fit.sheet import make_sheet, sheets_from_argument
from softact.fit.trimming import turning_points

STRETCH = np.linspace(1.0, 2.5, 16)
NOMINAL = 2 * 0.14 * (STRETCH - STRETCH**-2)  # MPa, neo-Hookean


def write(folder, heading, *columns, name="data.csv", separator=","):
    rows = [separator.join(f"{v:.10g}" for v in row) for row in zip(*columns, strict=True)]
    path = folder / name
    path.write_text("\n".join([heading, *rows]) + "\n")
    return path


def read(path, **fields):
    return read_tests(make_sheet({"file": path, **fields}, str(path)))


@pytest.mark.parametrize(
    ("heading", "x", "y"),
    [
        ("stretch,nominal_stress_MPa", STRETCH, NOMINAL),
        ("Engineering Strain,Engineering Stress (kPa)", STRETCH - 1, NOMINAL * 1e3),
        ("strain %,nominal stress [Pa]", 100 * (STRETCH - 1), NOMINAL * 1e6),
        ("strain_percent,cauchy_stress_MPa", 100 * (STRETCH - 1), NOMINAL * STRETCH),
        ("True Strain,True Stress (MPa)", np.log(STRETCH), NOMINAL * STRETCH),
        ("displacement mm,force N", 33 * (STRETCH - 1), NOMINAL * 18),
        ("extension cm,load kN", 3.3 * (STRETCH - 1), NOMINAL * 18e-3),
        ("length mm,force mN", 33 * STRETCH, NOMINAL * 18e3),
        ("stretch,nominal stress psi", STRETCH, NOMINAL / 6.894757293168361e-3),
    ],
)
def test_units_and_measures_come_to_the_same(tmp_path, heading, x, y):
    path = write(tmp_path, heading, x, y)
    (test,) = read(path, length="33 mm", width="6 mm", thickness="3 mm")
    assert np.allclose(test.stretch, STRETCH, rtol=1e-9)
    assert np.allclose(test.stress, NOMINAL, rtol=1e-8, atol=1e-12)
    assert secant_modulus(test) == pytest.approx(0.28, rel=0.1)
    assert warnings(test) == []


def test_separators_comments_and_specimen_sizes_in_the_file(tmp_path):
    path = tmp_path / "machine.csv"
    rows = "\n".join(
        f"{i};{33 * (s - 1):.8f};{p * 18:.8f}"
        for i, (s, p) in enumerate(zip(STRETCH, NOMINAL, strict=True))
    )
    path.write_text(
        "# a comment\nMachine;Instron;;\nSpecimen Thickness (mm);3;;\nSpecimen Width (cm);0.6;;\n"
        "Specimen Length (mm);33;;\nTime (s);Displacement (mm);Force (N)\n" + rows
    )
    (test,) = read(path)
    assert np.allclose(test.stretch, STRETCH) and np.allclose(test.stress, NOMINAL, atol=1e-8)


def test_file_without_headings_and_columns_in_another_order(tmp_path):
    path = tmp_path / "plain.txt"
    path.write_text(
        "\n".join(f"  {p:.8f}   {s:.8f}" for s, p in zip(STRETCH, NOMINAL, strict=True))
    )
    (test,) = read(path, columns=("nominal_stress MPa", "stretch"))
    assert np.allclose(test.stress, NOMINAL, atol=1e-8)
    with pytest.raises(SpecError, match="--columns"):
        read(path)


def test_specimen_column_makes_several_tests(tmp_path):
    path = tmp_path / "many.csv"
    rows = [f"{n},{s},{p * k}" for n, k in (("a", 1), ("b", 2)) for s, p in zip(STRETCH, NOMINAL)]  # noqa: B905
    path.write_text("specimen,stretch,nominal_stress MPa\n" + "\n".join(rows))
    first, second = read(path)
    assert (first.name, second.name) == ("many:a", "many:b")
    assert np.allclose(second.stress, 2 * first.stress)


def test_biaxial_file_gives_a_test_per_direction(tmp_path):
    other = 1 + 0.5 * (STRETCH - 1)
    path = write(
        tmp_path,
        "course stretch,wale stretch,course nominal_stress MPa,wale nominal_stress kPa",
        STRETCH, other, NOMINAL, NOMINAL * 500,
    )  # fmt: skip
    course, wale = read(path, mode="biaxial")
    assert (course.direction, wale.direction) == ("course", "wale")
    assert np.allclose(course.other, other) and np.allclose(wale.other, STRETCH)
    assert np.allclose(wale.stress, NOMINAL / 2)


def test_compression_may_be_written_with_positive_numbers(tmp_path):
    strain = np.linspace(0, 0.4, 12)
    stress = -2 * 0.14 * ((1 - strain) - (1 - strain) ** -2)
    path = write(tmp_path, "strain,nominal_stress MPa", strain, stress)
    (test,) = read(path, mode="compression")
    assert test.mode == "uniaxial" and test.stretch[-1] == pytest.approx(0.6)
    assert np.all(test.stress <= 0)


def cycles():
    up, down = np.linspace(1, 2, 40), np.linspace(2, 1.05, 40)
    x = np.concatenate([up, down, np.linspace(1.05, 2.4, 50), np.linspace(2.4, 1.1, 30)])
    return x, 2 * 0.14 * (x - x**-2) * np.where(np.arange(len(x)) < 40, 1.0, 0.8)


def test_turning_points_of_cycles_and_noise():
    x, _ = cycles()
    assert [round(float(x[i]), 3) for i in turning_points(x)] == [1, 2, 1.05, 2.4, 1.1]
    noisy = np.linspace(1, 2, 200) + 0.004 * np.sin(np.arange(200))
    assert len(turning_points(noisy)) == 2


def test_loading_and_cycles(tmp_path):
    path = write(tmp_path, "stretch,nominal_stress MPa", *cycles())
    with pytest.raises(SpecError, match=r"turns back at point 41.*--loading"):
        read(path)
    (first,) = read(path, loading=True)
    assert (len(first.stretch), first.stretch[-1]) == (41, 2.0)
    (last,) = read(path, cycle="last")
    assert last.stretch[-1] == pytest.approx(2.4)
    assert np.allclose(last.stress, 0.8 * 2 * 0.14 * (last.stretch - last.stretch**-2))
    assert any("2 of 2" in message for message in last.messages)
    with pytest.raises(SpecError, match="no cycle 3"):
        read(path, cycle=3)


def test_toe_moves_the_zero_of_strain_back(tmp_path):
    # A slack specimen: 5 % of travel before it carries anything.
    strain = np.concatenate([np.linspace(0, 0.05, 10), np.linspace(0.051, 0.6, 200)])
    true = np.maximum(strain - 0.05, 0) / 1.05 + 1
    path = write(tmp_path, "strain,nominal_stress MPa", strain, 2 * 0.14 * (true - true**-2))
    (test,) = read(path, toe="5 kPa")
    true = 1 + (test.stretch - 1)
    assert np.allclose(test.stress, 2 * 0.14 * (true - true**-2), atol=2e-3)
    assert any("toe" in message for message in test.messages)


def test_smoothing_and_thinning_are_told(tmp_path):
    x = np.linspace(1, 2, 400)
    path = write(tmp_path, "stretch,nominal_stress MPa", x, 2 * 0.14 * (x - x**-2))
    (test,) = read(path, smooth=11, points=40, stretch_to=1.8, zero=True)
    assert len(test.messages) == 4 and len(test.stretch) == 40 and test.stretch[-1] <= 1.8
    assert np.allclose(test.stress, 2 * 0.14 * (test.stretch - test.stretch**-2), atol=1e-4)


def text(heading, *rows):
    return "\n".join([heading, *rows])


GOOD = [f"{s:.4f},{p:.6f}" for s, p in zip(STRETCH, NOMINAL, strict=True)]
H = "stretch,nominal_stress MPa"


@pytest.mark.parametrize(
    ("content", "fields", "said"),
    [
        (text(H, "1.0,0.0", "1.1,abc", *GOOD[3:]), {}, r":3: column .* 'abc' is not a number"),
        (text(H, "1.0,0.0", "1.1,inf", *GOOD[3:]), {}, "not a finite number"),
        (text(H, "1.0,0.0", "1.1,1e999", *GOOD[3:]), {}, "not a finite number"),
        (text(H, "1.0,0.0", *["1.1,N/A"] * 20), {}, "1 points are left"),
        (text("stretch;nominal_stress MPa", *[r.replace(",", ";").replace(".", ",") for r in GOOD],
              "2.6;0.7"), {}, "decimal points and decimal commas"),
        (text(H, *[r.replace(".", ",") for r in GOOD]), {},
         "4 values under 2 headings; decimal commas in a table separated by commas"),
        (text(H, *GOOD[:2]), {}, "2 points are left"),
        (text(H), {}, "0 points are left"),
        ("", {}, "holds no data"),
        ("\0\1\2", {}, "not a text file"),
        (text(H, *GOOD, *reversed(GOOD)), {}, "unloading or cycles"),
        (text(H, *[f"{s - 1},{p}" for s, p in zip(STRETCH, NOMINAL, strict=True)]), {},
         "looks like engineering strain"),
        (text(H, *[f"{s - 0.6},{p}" for s, p in zip(STRETCH, NOMINAL, strict=True)]), {},
         "tensile at a stretch"),
        (text("strain,nominal_stress MPa", *GOOD), {}, "looks like stretch"),
        (text("strain,nominal_stress MPa",
              *[f"{100 * s - 100},{p}" for s, p in zip(STRETCH, NOMINAL, strict=True)]), {},
         "looks like a percentage"),
        (text("stretch,stress MPa", *GOOD), {}, "does not say which stress"),
        (text("stretch,nominal_stress MPa", *GOOD), {"stress": "cauchy"}, "not the cauchy"),
        (text("stretch,nominal_stress", *GOOD), {}, "has no unit"),
        (text("stretch,nominal_stress mm", *GOOD), {}, "length"),
        (text("stretch,nominal_stress bananas", *GOOD), {}, "no unit"),
        (text("displacement mm,force N", *GOOD), {}, "gauge length"),
        (text("displacement mm,force N", *GOOD), {"length": "30 mm"}, "cross-section"),
        (text("Thickness (mm),0", "Width (mm),5", "stretch,force N", *GOOD), {},
         "thickness is 0 mm"),
        (text("stretch,stretch,nominal_stress MPa",
              *[f"{r.split(',')[0]},{r}" for r in GOOD]), {}, "several columns"),
        (text("force N,nominal_stress MPa", *GOOD), {}, "deformation"),
        (text(H, *[f"{s},{-p}" for s, p in zip(STRETCH, NOMINAL, strict=True)]), {},
         "compressive at a stretch"),
        (text(H, *[f"1.0,{p}" for p in NOMINAL]), {}, "no deformation"),
    ],
)  # fmt: skip
def test_wrong_data_is_refused_with_what_it_looks_like(tmp_path, content, fields, said):
    path = tmp_path / "bad.csv"
    path.write_text(content)
    with pytest.raises(SpecError, match=said):
        read(path, **fields)


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"thickness": "0 mm"}, "greater than 0"),
        ({"thickness": 3}, "no unit"),
        ({"mode": "torsion"}, "uniaxial"),
        ({"area": "3 mm^2", "width": "2 mm"}, "give one"),
        ({"loading": True, "cycle": 2}, "give one"),
        ({"thikness": "3 mm"}, "unknown key 'thikness'"),
    ],
)
def test_wrong_options_are_refused(fields, said):
    with pytest.raises(SpecError, match=said):
        make_sheet({"file": "x.csv", **fields}, "x.csv")


def test_missing_file_and_mode_in_the_argument(tmp_path):
    with pytest.raises(SpecError, match="no such file"):
        read(tmp_path / "none.csv")
    (sheet,) = sheets_from_argument("a.csv:equibiaxial@wale", {})
    assert (sheet.file.name, sheet.mode, sheet.direction) == ("a.csv", "equibiaxial", "wale")
    with pytest.raises(SpecError, match="'shear' is no mode"):
        sheets_from_argument("a.csv:shear", {})


def test_yaml_of_tests(tmp_path):
    write(tmp_path, H, STRETCH, NOMINAL)
    sheet = tmp_path / "tests.yaml"
    sheet.write_text("tests:\n  - {file: data.csv, mode: planar}\n  - {file: data.csv}\n")
    modes = [read_tests(s)[0].mode for s in sheets_from_argument(str(sheet), {})]
    assert modes == ["planar", "uniaxial"]
    sheet.write_text("tests: {file: data.csv}\n")
    with pytest.raises(SpecError, match="list of mappings"):
        sheets_from_argument(str(sheet), {})


@pytest.mark.parametrize(
    ("unit", "said"),
    [("Pa", "MPa given as Pa"), ("kPa", "MPa given as kPa"), ("GPa", "kPa given as MPa")],
)
def test_implausible_modulus_warns_with_what_it_looks_like(tmp_path, unit, said):
    path = write(tmp_path, f"stretch,nominal_stress {unit}", STRETCH, NOMINAL)
    (test,) = read(path)
    lines = warnings(test)
    assert len(lines) == 1
    assert "no elastomer has" in lines[0] and said in lines[0]


def test_preload_is_noticed(tmp_path):
    path = write(tmp_path, H, STRETCH, NOMINAL + 0.03)
    (test,) = read(path)
    assert any("30" in line and "--zero" in line for line in warnings(test))

"""Tables as testing machines write them: read rightly (refusals: test_table_refusals.py).

Every table here is made from a neo-Hookean law of C10 = 0.14 MPa on a strip of 33 × 6 × 2 mm, so
that what is read is known.
"""

import re

import numpy as np
import pytest

from softact.errors import SpecError
from tests.fit.strip import (
    BLUEHILL,
    CAUCHY,
    FORCE,
    NOMINAL,
    SIZES,
    SQUEEZE,
    SQUEEZED,
    STRETCH,
    TIME,
    TRAVEL,
    assert_is_the_strip,
    read,
    rows,
    write,
)

HEADS = {
    # heading of the deformation, its values; heading of the load, its values
    "lambda": ("lambda", STRETCH, "P11 nominal stress [MPa]", NOMINAL),
    "greek": ("λ", STRETCH, "nominal σ (kPa)", 1e3 * NOMINAL),
    "stretch ratio": ("Stretch ratio", STRETCH, "Engineering stress N/mm²", NOMINAL),
    "tensile strain": ("Tensile strain", STRETCH - 1, "Tensile stress (MPa)", NOMINAL),
    "load cell": ("Extension (mm)", TRAVEL, "Load Cell (N)", FORCE),
    "zwick": ("Standard travel [mm]", TRAVEL, "Standard force [N]", FORCE),
    "german": ("Standardweg in mm", TRAVEL, "Prüfkraft / N", FORCE),
    "french": ("Déplacement (mm)", TRAVEL, "Force (kN)", FORCE / 1e3),
    "strain 1": ("Strain 1 (%)", 100 * (STRETCH - 1), "Nominal stress (MPa)", NOMINAL),
    "dots": ("Disp.(mm)", TRAVEL, "Force(N)", FORCE),
    "inches": ("Extension (in)", TRAVEL / 25.4, "Load (lbf)", FORCE / 4.4482216152605),
    "inch words": ("Crosshead [inches]", TRAVEL / 25.4, "Stress, nominal (PSI)",
                   NOMINAL / 6.894757293168361e-3),
    "kgf": ("Stretch", STRETCH, "Nominal stress [Kgf/cm2.]", NOMINAL / 0.0980665),
    "kg": ("Stroke mm", TRAVEL, "Load (kg)", FORCE / 9.80665),
    "g": ("Stroke mm", TRAVEL, "Force [g]", FORCE / 9.80665e-3),
    "capitals": ("STRAIN (MM/MM)", STRETCH - 1, "NOMINAL STRESS (KPA)", 1e3 * NOMINAL),
    "true": ("True strain (Strain 1) (%)", 100 * np.log(STRETCH), "True stress (MPa)", CAUCHY),
    "sigma_c": ("lambda", STRETCH, "sigma_c_data_MPa", CAUCHY),
    "camel": ("TensileStrain(%)", 100 * (STRETCH - 1), "NominalStress(MPa)", NOMINAL),
    "named by its unit": ("Stroke (mm)", TRAVEL, "F (N)", FORCE),
    "elongation in %": ("Elongation (%)", 100 * (STRETCH - 1), "Nominal stress MN/m2", NOMINAL),
    "mislabelled": ("Strain (mm)", TRAVEL, "Load (N)", FORCE),
    "micro": ("Strain (µε)", 1e6 * (STRETCH - 1), "nominal stress mPa", NOMINAL),
}  # fmt: skip


@pytest.mark.parametrize("case", HEADS)
def test_headings_are_understood_by_their_words(tmp_path, case):
    first, x, second, y = HEADS[case]
    lines = rows(TIME, x, y, separator=";")
    (test,) = read(write(tmp_path, f"Time (s);{first};{second}", *lines), **SIZES)
    assert_is_the_strip(test)


BRACKETED = re.compile(r"(.*?)\s*[(\[]([^()\[\]]+)[)\]]")


IN_BRACKETS = [c for c, (x, _, y, _) in HEADS.items() if all(map(BRACKETED.fullmatch, (x, y)))]


@pytest.mark.parametrize("case", IN_BRACKETS)
def test_a_row_of_units_under_a_row_of_names(tmp_path, case):
    first, x, second, y = HEADS[case]
    parts = [BRACKETED.fullmatch(head) for head in (first, second)]
    names, units = (";".join(part[i] for part in parts) for i in (1, 2))
    for line in (units, f"({units.replace(';', ');(')})"):
        (test,) = read(write(tmp_path, names, line, *rows(x, y, separator=";")), **SIZES)
        assert_is_the_strip(test)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16", "utf-16-le",
                                      "utf-16-be", "utf-32"])  # fmt: skip
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_a_results_table_decimal_commas_and_encodings(tmp_path, encoding, end):
    lines = rows(TIME, TRAVEL, FORCE, separator=";", comma=True, quoted=True)
    (test,) = read(write(tmp_path, *BLUEHILL, *lines, encoding=encoding, end=end))
    assert_is_the_strip(test)
    assert "gauge length 33 mm, as the file says" in test.messages
    assert "cross-section 12 mm², as the file says" in test.messages


def test_sizes_in_lines_above_the_table(tmp_path):
    for above in (
        ['"Width : 6.00 mm"', '"Thickness : 0.2 cm"', '"Gage length : 33 mm"'],
        ["Specimen width b0;6;mm", "Specimen thickness a0;2;mm", "L0;33;mm"],
        ["Cross-section (mm^2);12", "Length (mm);33"],
        ["Diameter: 3.90882 mm", "Grip separation (in);1.29921260"],
    ):
        lines = [*above, "Travel (mm);Force (N)", *rows(TRAVEL, FORCE, separator=";")]
        (test,) = read(write(tmp_path, *lines))
        assert_is_the_strip(test)


def test_numbers_with_marks_of_thousands(tmp_path):
    force = [f"{1e3 * f:,.3f}" for f in FORCE]
    swiss = [text.replace(",", "’") for text in force]
    german = [text.translate(str.maketrans(",.", ".,")) for text in force]
    travel = [f"{t:.6f}" for t in TRAVEL]
    for forces, comma in ((force, False), (swiss, False), (german, True)):
        body = rows([t.replace(".", ",") if comma else t for t in travel], forces, separator=";")
        (test,) = read(write(tmp_path, "Extension (mm);Load (mN)", *body), **SIZES)
        assert_is_the_strip(test)


def test_decimal_commas_between_blanks_and_headings_with_blanks(tmp_path):
    body = [f" {line}" for line in rows(STRETCH, NOMINAL, separator="   ", comma=True)]
    for head in ("stretch   nominal stress (MPa)", "stretch, nominal_stress MPa"):
        (test,) = read(write(tmp_path, head, *body))
        assert_is_the_strip(test)


def test_heading_in_a_comment_as_numpy_writes_it(tmp_path):
    path = tmp_path / "saved.txt"
    np.savetxt(path, np.c_[STRETCH, NOMINAL], header="stretch nominal_stress_MPa")
    (test,) = read(path)
    assert_is_the_strip(test)


def test_cells_without_a_value(tmp_path):
    empty = ["N/A", "", "--", "#NV", "nan"] * 5
    body = rows(TIME, FORCE, empty, [""] * 25, TRAVEL)
    body[7] = "0.7,N/A,,,1.2"
    body[11] = "1.1,2.0"
    head = "Time (sec), Load (N), Stress (KPa), Strain (mm), Extension (mm)"
    (test,) = read(write(tmp_path, "", head, *body), **SIZES)
    assert_is_the_strip(test, np.delete(STRETCH, [7, 11]), np.delete(NOMINAL, [7, 11]))
    assert "2 of 25 rows lack a value and are left out, first line 10" in test.messages


def test_what_follows_the_table_is_told(tmp_path):
    tail = ["Test ended; 12:30", "Maximum;4.1"]
    lines = ["stretch;nominal stress MPa", *rows(STRETCH, NOMINAL, separator=";"), *tail]
    (test,) = read(write(tmp_path, *lines))
    assert_is_the_strip(test)
    assert any("line 28 is no row of numbers and left out" in m for m in test.messages)


def test_a_row_of_words_within_the_table_is_refused(tmp_path):
    body = rows(STRETCH, NOMINAL, separator=";")
    for place in (3, 12, 22):
        lines = ["stretch;nominal stress MPa", *body[:place], "pause;operator", *body[place:]]
        try:
            (test,) = read(write(tmp_path, *lines))
        except SpecError as error:
            assert f"line {place + 2}: 'pause;operator' stands between rows" in str(error)
        else:  # a few rows after it are another table, and that is told
            assert any("another table, lines 25 to 27" in m for m in test.messages)


def test_several_tables_under_the_same_headings_are_specimens(tmp_path):
    one = ["Extension;Load", "(mm);(N)", *rows(TRAVEL, FORCE, separator=";")]
    two = ["Extension;Load", "(mm);(N)", *rows(TRAVEL, 2 * FORCE, separator=";")]
    first, second = read(write(tmp_path, "Specimen 1", *one, "", "Specimen 2", *two), **SIZES)
    assert (first.name, second.name) == ("strip:1", "strip:2")
    assert_is_the_strip(first)
    assert_is_the_strip(second, stress=2 * NOMINAL)


def test_a_counter_named_specimen_makes_no_specimens(tmp_path):
    lines = ["Specimen,stretch,nominal stress MPa", *rows(np.arange(25.0), STRETCH, NOMINAL)]
    (test,) = read(write(tmp_path, *lines))
    assert_is_the_strip(test)


BOTH = "Time (s),Extension (mm),Load (N),Tensile strain (%),Tensile stress (MPa)"


def both(stress=NOMINAL, travel=TRAVEL, force=FORCE, strain=STRETCH - 1):
    return [BOTH, *rows(TIME, travel, force, 100 * strain, stress)]


def test_strain_and_stress_win_over_extension_and_load_and_it_is_said(tmp_path):
    # The crosshead moves more than the extensometer, since the shoulders stretch too.
    lines = both(travel=1.3 * TRAVEL, force=FORCE + 1.0)
    (test,) = read(write(tmp_path, "Length (mm),33", "Area (mm^2),12", *lines))
    assert_is_the_strip(test)
    (said,) = [m for m in test.messages if "taken" in m]
    assert said == (
        "'Tensile strain (%)' and 'Tensile stress (MPa)' taken; "
        "left out: 'Extension (mm)', 'Load (N)'"
    )


def test_sizes_that_are_given_ask_for_extension_and_load(tmp_path):
    path = write(tmp_path, *both(stress=1.1 * NOMINAL, strain=0.9 * (STRETCH - 1)))
    (test,) = read(path, **SIZES)
    assert_is_the_strip(test)
    assert any("'Extension (mm)' and 'Load (N)' taken" in m for m in test.messages)
    (test,) = read(path, area="12 mm^2")
    assert_is_the_strip(test, 1 + 0.9 * (STRETCH - 1))
    (test,) = read(path, length="33 mm")
    assert_is_the_strip(test, stress=1.1 * NOMINAL)


def test_columns_win_over_all(tmp_path):
    path = write(tmp_path, *both(stress=1.1 * NOMINAL))
    (test,) = read(path, columns="-, displacement mm, -, -, nominal_stress MPa", length="33 mm")
    assert_is_the_strip(test, stress=1.1 * NOMINAL)


def test_a_cross_section_that_the_columns_contradict_is_told(tmp_path):
    path = write(tmp_path, "Width: 6 mm", "Thickness: 2 mm", *both(stress=NOMINAL / 1.1))
    (test,) = read(path)
    assert_is_the_strip(test, stress=NOMINAL / 1.1)
    (said,) = [m for m in test.messages if "attention" in m]
    assert "is a cross-section of 13.2 mm², the sizes say 12 mm²" in said
    assert "--area '12 mm^2'" in said
    (test,) = read(path, area="12 mm^2")
    assert_is_the_strip(test)
    same = write(tmp_path, "Width: 6 mm", "Thickness: 2 mm", *both())
    assert not any("attention" in m for m in read(same)[0].messages)


def test_a_stress_beside_its_load_says_which_it_is(tmp_path):
    head = "Strain (%),Stress (MPa),Load (N)"
    for stress, kind in ((NOMINAL, "nominal"), (CAUCHY, "Cauchy")):
        lines = [head, *rows(100 * (STRETCH - 1), stress, FORCE)]
        (test,) = read(write(tmp_path, *lines))
        assert_is_the_strip(test)
        assert any(f"read as {kind} stress" in m for m in test.messages)


def test_true_stress_and_a_fit_beside_it(tmp_path):
    lines = ["lambda,sigma_c_data_MPa,sigma_c_fit_MPa", *rows(STRETCH, CAUCHY, 1.2 * CAUCHY)]
    (test,) = read(write(tmp_path, *lines))
    assert_is_the_strip(test)
    assert "'sigma_c_data_MPa' read as Cauchy stress" in test.messages


def test_a_channel_that_was_not_connected_is_not_taken(tmp_path):
    head = "Strain 1 (%),Extension (mm),Nominal stress (MPa),Load (N)"
    lines = [head, *rows(0 * STRETCH, TRAVEL, NOMINAL, FORCE)]
    (test,) = read(write(tmp_path, *lines), length="33 mm")
    assert_is_the_strip(test)


@pytest.mark.parametrize("sign", [(1, 1), (-1, -1), (1, -1), (-1, 1)])
def test_compression_by_its_headings_and_with_any_signs(tmp_path, sign):
    travel, force = sign[0] * 12 * (1 - SQUEEZED), sign[1] * -SQUEEZE * 400
    lines = ["Compressive extension (mm),Compressive load (N)", *rows(travel, force)]
    (test,) = read(write(tmp_path, *lines), length="12 mm", area="400 mm^2")
    assert_is_the_strip(test, SQUEEZED, SQUEEZE)
    assert any("headings say compression" in m for m in test.messages)


def test_true_measures_of_compression_in_positive_numbers(tmp_path):
    lines = ["True strain (-),True stress (MPa)",
             *rows(-np.log(SQUEEZED), -SQUEEZE * SQUEEZED)]  # fmt: skip
    (test,) = read(write(tmp_path, *lines), mode="compression")
    assert_is_the_strip(test, SQUEEZED, SQUEEZE)


def test_a_position_counts_from_where_it_begins(tmp_path):
    lines = ["Position (mm),Load (N)", *rows(112.0 + TRAVEL, FORCE)]
    (test,) = read(write(tmp_path, *lines), **SIZES)
    assert_is_the_strip(test)


def test_the_name_of_the_file_asks_for_a_mode(tmp_path):
    lines = ["stretch,nominal stress MPa", *rows(STRETCH, NOMINAL)]
    path = write(tmp_path, *lines, name="soft_planar.csv")
    assert any("soft_planar.csv:planar if it is not" in m for m in read(path)[0].messages)
    assert not any("if it is not" in m for m in read(path, mode="uniaxial")[0].messages)


def test_the_break_is_left_out_and_told(tmp_path):
    strain = np.append(STRETCH, [2.52, 2.54, 2.56]) - 1
    stress = np.append(NOMINAL, [0.4, 0.05, -0.002])
    path = write(tmp_path, "strain %,nominal stress MPa", *rows(100 * strain, stress))
    (test,) = read(path)
    assert_is_the_strip(test)
    (said,) = [m for m in test.messages if "breaks" in m]
    assert said.startswith("the specimen breaks at a stretch of 2.5: the last 3 of 28 points")
    (whole,) = read(path, whole=True)
    assert len(whole.stretch) == 28


@pytest.mark.parametrize("noise", [0.0, 0.005, 0.02])
@pytest.mark.parametrize("points", [15, 60, 900])
def test_breaks_are_found_in_noise_and_nothing_else_is_one(noise, points, tmp_path):
    rng = np.random.default_rng(points)
    for law in (NOMINAL, np.sqrt(STRETCH - 1), np.exp(STRETCH) - np.e, np.minimum(NOMINAL, 0.3)):
        x = np.linspace(1, 2.5, points)
        y = np.interp(x, STRETCH, law) + noise * np.max(law) * rng.standard_normal(points)
        path = write(tmp_path, "stretch,nominal stress MPa", *rows(x, y))
        (test,) = read(path, loading=True)
        assert not any("breaks" in m for m in test.messages)
        x = np.append(x, x[-1] + 0.01 * np.arange(1, 7))
        y = np.append(y, np.max(law) * np.array([0.5, 0.1, 0.0, 0.01, 0.0, 0.02]))
        path = write(tmp_path, "stretch,nominal stress MPa", *rows(x, y))
        (test,) = read(path, loading=True)
        assert any("breaks" in m for m in test.messages)
        assert points - 2 <= len(test.stretch) <= points


def test_an_extensometer_that_snaps_back_with_the_specimen(tmp_path):
    x = np.append(STRETCH, [1.3, 1.28, 1.29, 1.28])
    y = np.append(NOMINAL, [0.01, 0.0, 0.002, 0.0])
    (test,) = read(write(tmp_path, "stretch,nominal stress MPa", *rows(x, y)))
    assert_is_the_strip(test)


def test_unloading_is_no_break(tmp_path):
    x, y = (np.append(v, v[-2::-4]) for v in (STRETCH, NOMINAL))
    with pytest.raises(SpecError, match="turns back"):
        read(write(tmp_path, "stretch,nominal stress MPa", *rows(x, y)))


def test_a_hold_at_the_end_is_left_out_and_told(tmp_path):
    x = np.append(STRETCH, [2.5] * 20)
    y = np.append(NOMINAL, NOMINAL[-1] * (0.9 + 0.1 * np.exp(-np.arange(20) / 5.0)))
    path = write(tmp_path, "stretch,nominal stress MPa", *rows(x, y))
    (test,) = read(path)
    assert_is_the_strip(test)
    assert any("stands still at 2.5 over the last 21 of 45 points" in m for m in test.messages)

"""Tables that are refused with the command that reads them; the files of the field."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from softact.cli.fit import fit as fit_command
from softact.errors import SpecError
from tests.fit.strip import (
    FORCE,
    NOMINAL,
    SIZES,
    SQUEEZE,
    SQUEEZED,
    STRETCH,
    TIME,
    TRAVEL,
    read,
    rows,
    write,
)


def command_of(error) -> list[str]:
    (command,) = re.findall(r"softact (fit .*?)(?:, with .*)?$", str(error.value))
    return shlex.split(command)


def run_command(error, folder, sizes=SIZES, **answers) -> tuple[list[str], str]:
    """Run the command of a refusal, with the sizes that only the user knows: words and output."""
    words = command_of(error)
    assert "--columns" in words
    for i, word in enumerate(words):
        if "?" in word:
            words[i] = answers.get(words[i - 1].strip("-")) or sizes[words[i - 1].strip("-")]
    done = CliRunner().invoke(
        fit_command, [*words[1:], "--law", "neo_hookean", "-o", str(folder / "out")]
    )
    assert done.exit_code == 0, f"{words}: {done.exception}"
    return words, done.output


def assert_the_command_reads(error, folder, **answers) -> list[str]:
    """The command of a refusal finds the strip's constant."""
    words, output = run_command(error, folder, **answers)
    found = re.search(r"c10\s+=\s+(\S+)", output)
    assert float(found[1]) == pytest.approx(0.14, rel=1e-3)
    return words


MTS = ["Time,Displacement,Force", "(s),(mm),(kN)"]


def test_two_lines_of_heading_quoted_cells_and_unloading(tmp_path):
    path = tmp_path / "a strip.csv"
    travel, force = (np.append(v, v[-2::-1]) for v in (TRAVEL, FORCE / 1e3))
    body = rows(np.arange(49) / 10, travel, force, quoted=True)
    path.write_text("\n".join([*MTS, *body]))
    with pytest.raises(SpecError, match="needs the gauge length") as error:
        read(path)
    words = assert_the_command_reads(error, tmp_path)
    assert words[2:4] == ["--columns", "-, displacement mm, force kN"]
    assert "--loading" in words


REFUSED = {
    "no headings": (rows(STRETCH, NOMINAL), "no headings"),
    "strange headings": (["foo,bar (MPa)", *rows(STRETCH, NOMINAL)], "no headings"),
    "strange headings, strain in percent": (
        ["foo,bar", *rows(100 * (STRETCH - 1), NOMINAL)], "no headings"),
    "strange headings with units": (
        ["t (s),u (mm),F (N)", *rows(TIME, TRAVEL, FORCE)], "no headings"),
    "another language": (["時間,変位,荷重", *rows(TIME, STRETCH - 1, NOMINAL)], "no headings"),
    "no unit": (["stretch,nominal stress", *rows(STRETCH, NOMINAL)], "has no unit"),
    "no unit of a length": (["Extension,Load (N)", *rows(TRAVEL, FORCE)], "has no unit"),
    "an unknown unit": (["stretch,nominal stress (bananas)", *rows(STRETCH, NOMINAL)], "bananas"),
    "another unit": (["Extension (mm),Load (MPa)", *rows(TRAVEL, FORCE)], "is a pressure"),
    "which stress": (["stretch,stress MPa", *rows(STRETCH, NOMINAL)], "does not say which stress"),
    "two strains": (["Strain 1 (%),Strain 2 (%),Nominal stress (MPa)",
                     *rows(100 * (STRETCH - 1), 90 * (STRETCH - 1), NOMINAL)], "several columns"),
    "a percentage": (["strain,nominal stress MPa", *rows(100 * (STRETCH - 1), NOMINAL)],
                     "looks like a percentage"),
    "a stretch": (["strain,nominal stress MPa", *rows(STRETCH, NOMINAL)], "looks like stretch"),
    "a strain": (["stretch,nominal stress MPa", *rows(STRETCH - 1, NOMINAL)],
                 "looks like engineering strain"),
    "no gauge length": (["Extension (mm),Nominal stress MPa", *rows(TRAVEL, NOMINAL)],
                        "gauge length"),
    "no cross-section": (["Strain (%),Load (N)", *rows(100 * (STRETCH - 1), FORCE)],
                         "cross-section"),
    "cycles": (["stretch,nominal stress MPa", *rows(np.append(STRETCH, STRETCH[-2::-1]),
                                                    np.append(NOMINAL, 0.9 * NOMINAL[-2::-1]))],
               "turns back"),
    "a name with blanks": (["Stretch of it all;Belastung", *rows(STRETCH, NOMINAL, separator=";")],
                           "no headings"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_each_refusal_names_the_command_that_reads_the_file(tmp_path, case):
    lines, said = REFUSED[case]
    path = write(tmp_path, *lines, name="the strip.csv")
    with pytest.raises(SpecError, match=said) as error:
        read(path)
    assert_the_command_reads(error, tmp_path)


def test_the_command_keeps_what_was_given(tmp_path):
    path = write(tmp_path, "Extension,Load (N)", *rows(TRAVEL, FORCE))
    with pytest.raises(SpecError, match="no unit") as error:
        read(path, mode="uniaxial", width="6 mm", thickness="2 mm", stretch_to=2.0, points=10)
    words = assert_the_command_reads(error, tmp_path)
    assert words[1].endswith("strip.csv:uniaxial")
    assert {"6 mm", "2 mm", "--to", "--points"} <= set(words)


def test_a_squeezed_puck_is_refused_with_the_mode_that_its_headings_say(tmp_path):
    lines = ["Compressive position (mm),Load (N)", *rows(12 * (1 - SQUEEZED), -SQUEEZE * 400)]
    with pytest.raises(SpecError, match="gauge length") as error:
        read(write(tmp_path, *lines))
    words = assert_the_command_reads(error, tmp_path, length="12 mm", area="400 mm^2")
    assert words[1].endswith("strip.csv:compression")


def test_files_that_are_no_tables(tmp_path):
    for content, said in (
        (b"PK\x03\x04rest", "an Excel or OpenDocument file, not a text file"),
        (b"\xd0\xcf\x11\xe0", "an Excel file of the old kind"),
        (b"a\0b\0\0\0", "not a text file"),
        (b"\n\n  \n", "holds no data"),
        (b"# stretch\n", "holds no data"),
        (b"words and more words\n", "there is no table of numbers"),
    ):
        path = tmp_path / "x.csv"
        path.write_bytes(content)
        with pytest.raises(SpecError, match=said):
            read(path)


def test_a_pipe_is_refused_at_once(tmp_path):
    import os

    path = tmp_path / "pipe"
    os.mkfifo(path)
    with pytest.raises(SpecError, match="this is a pipe or a device"):
        read(path)


def test_an_impossible_stretch_is_refused(tmp_path):
    lines = ["Extension (m),Nominal stress MPa", *rows(TRAVEL, NOMINAL)]
    with pytest.raises(SpecError, match="which no material bears; is the gauge length right"):
        read(write(tmp_path, *lines), length="33 mm")


FIELD = Path(__file__).parents[2].parent / "shared" / "field"


needs_field = pytest.mark.skipif(not FIELD.is_dir(), reason="the files of the field are not here")


@needs_field
@pytest.mark.parametrize("mode", ["uni", "equi", "planar"])
def test_field_kgf_in_four_spellings(mode):
    found = [read(FIELD / f"01-kgf_{mode}_{letter}.csv", mode="uniaxial")[0] for letter in "abcd"]
    first = {"uni": 0.247, "equi": 0.495, "planar": 0.336}[mode]
    for test in found:
        assert len(test.stretch) == 24
        assert test.stress[0] == pytest.approx(first * 0.0980665)


@needs_field
def test_field_mts(tmp_path):
    with pytest.raises(SpecError, match="needs the gauge length") as error:
        read(FIELD / "02-mts-two-line-header_strip.csv")
    words, output = run_command(error, tmp_path)
    assert words[3] == "-, displacement mm, force kN" and "--loading" in words
    assert "87 points, stretch 1 to 2.818, stress to 508 kPa" in output
    (test,) = read(FIELD / "02-mts-two-line-header_strip.csv", **SIZES, loading=True)
    assert test.stretch[-1] == pytest.approx(1 + 60 / 33)
    assert test.stress[-2] == pytest.approx(6.1 / 12)


@needs_field
def test_field_bluehill():
    (test,) = read(FIELD / "03-bluehill-locale_probe.csv")
    assert (test.stretch[-1], test.stress[-1]) == pytest.approx((3.38, 0.461539))
    assert any("13.2 mm², the sizes say 12 mm²" in m for m in test.messages)
    (test,) = read(FIELD / "03-bluehill-locale_probe.csv", area="12 mm^2", length="25 mm")
    assert (test.stretch[-1], test.stress[-1]) == pytest.approx((3.38, 6.09231 / 12))


@needs_field
def test_field_cauchy():
    (test,) = read(FIELD / "31-cauchy_strip.csv")
    assert test.stress[-1] == pytest.approx(0.798192746 / 2)


@needs_field
def test_field_puck(tmp_path):
    path = FIELD / "32-squisher_puck.csv"
    with pytest.raises(SpecError, match="needs the gauge length") as error:
        read(path)
    words, output = run_command(error, tmp_path, length="12 mm", area="400 mm^2")
    assert words[1].endswith(":compression")
    assert words[3] == "-, force N, -, -, position mm"
    assert "621 points, stretch 0.625 to 1" in output
    (test,) = read(path, mode="compression", columns=words[3], length="12 mm", area="400 mm^2")
    assert (test.stretch[-1], len(test.stretch)) == (pytest.approx(1 - 4.5 / 12), 621)


@needs_field
def test_field_break():
    (test,) = read(FIELD / "33-strain500fit_soft.csv")
    assert test.stretch[-1] == pytest.approx(9.73383)
    assert test.stress[-1] == pytest.approx(0.198255)

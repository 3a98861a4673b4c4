"""Files: those of the user are read within bounds, and CSV holds no formula of anybody's."""

import csv
import os
import socket

import pytest
from hypothesis import given
from hypothesis import strategies as st

from softact.errors import SpecError
from softact.files.text import csv_rows, csv_text, read_file


def refused(path, most=10):
    with pytest.raises(SpecError) as caught:
        read_file(path, most, "a spec")
    (line,) = caught.value.lines
    assert "\n" not in line
    return line


def test_a_file_is_read_up_to_its_bound(tmp_path):
    (tmp_path / "ten").write_bytes(b"0123456789")
    assert read_file(tmp_path / "ten", 10, "a spec") == b"0123456789"
    assert "larger than 0 kB; give a spec" in refused(tmp_path / "ten", 9)


def test_what_is_no_file_is_refused_and_not_waited_for(tmp_path):
    """A pipe without a writer would be waited for, /dev/zero read until memory ends."""
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", "/dev/zero", "/dev/null"):
        assert "is a pipe or a device and no file; give a spec" in refused(path)
    with socket.socket(socket.AF_UNIX) as endpoint:
        endpoint.bind(str(tmp_path / "s"))
        assert "cannot be read: No such device or address" in refused(tmp_path / "s")
    assert "this is a folder; give a spec" in refused(tmp_path)
    assert "there is no such file" in refused(tmp_path / "none")
    assert "there is no such file" in refused(tmp_path / "a\nb")
    assert "cannot be read" in refused(tmp_path / "a\0b")
    (tmp_path / "round").symlink_to(tmp_path / "round")
    assert "Too many levels of symbolic links" in refused(tmp_path / "round")


FORMULAS = [
    "=1+1",
    "+1+1",
    "-1-cmd|' /C calc'!A0",
    "@SUM(A1)",
    "\t=1",
    "\n=1",
    "'=1",
    "=",
    "-",
    "\r=1",
]
TEXTS = ["-3 mm", "+30 kPa", "-9.81 m/s^2", "-1e-3", "card", "'quoted'", "a=b", "", "x\ny", 'q"']


@pytest.mark.parametrize("text", FORMULAS)
def test_a_formula_gets_an_apostrophe(text):
    heading, cell = csv.reader(csv_text([{text: text}]).splitlines(keepends=True))
    assert heading == cell
    # What a spreadsheet would compute begins with one of these signs.
    assert heading[0][0] not in "=+-@\t\r"


@pytest.mark.parametrize("text", TEXTS)
def test_other_texts_and_values_are_written_as_they_are(text):
    heading, cells = csv.reader(csv_text([{text: text, "x": -1}]).splitlines(keepends=True))
    assert heading == [text, "x"]
    assert cells == [text, "-1"]
    assert csv_text([{"x": -1.5, "y": -2}]) == "x,y\n-1.5,-2\n"


def test_softact_reads_its_own_csv_back(tmp_path):
    rows = [{"name": text, "-x": -1.5} for text in FORMULAS + TEXTS]
    (tmp_path / "t.csv").write_text(csv_text(rows), encoding="utf-8")
    assert csv_rows(tmp_path / "t.csv") == [
        ["name", "-x"], *([row["name"].replace("\r", "\n"), "-1.5"] for row in rows)
    ]  # fmt: skip


@given(st.lists(st.text(st.characters(codec="utf-8", exclude_characters="\r\0")), min_size=1))
def test_any_text_comes_back(tmp_path_factory, texts):
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_text(csv_text([{"a": text, "b": 1} for text in texts]), encoding="utf-8")
    assert [row[0] for row in csv_rows(path)[1:]] == texts

"""Measured curves of an actuator as devices write them, for --measured and calibrate --data."""

import re
import shlex

import numpy as np
import pytest

from softact.errors import SpecError
from softact.measured.curve import read_measured

COLUMNS = ["pressure_kPa", "bending_angle_deg", "tip_x_mm", "cavity_volume_mm3", "reaction_x_N"]
PRESSURE = np.array([1.0, 5.0, 12.5, 20.25, 30.0])  # kPa
ANGLE = np.array([0.5, 3.0, 11.25, 31.5, 60.125])  # degrees


def write(folder, *lines, encoding="utf-8"):
    path = folder / "angle.csv"
    path.write_bytes("\n".join(lines).encode(encoding))
    return path


def rows(*columns, separator=";", comma=False):
    lines = [separator.join(f"{v:.9f}" for v in row) for row in zip(*columns, strict=True)]
    return [line.replace(".", ",") if comma else line for line in lines]


def assert_is_the_curve(found):
    assert list(found.values) == ["pressure_kPa", "bending_angle_deg"]
    assert found.values["pressure_kPa"] == pytest.approx(PRESSURE)
    assert found.values["bending_angle_deg"] == pytest.approx(ANGLE, rel=1e-6)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "latin-1"])
def test_preamble_units_in_a_row_decimal_commas_and_a_time(tmp_path, encoding):
    body = rows(PRESSURE * 0, PRESSURE / 100, np.radians(ANGLE), comma=True)
    head = ["Prüfstand 3;;", "Regler;7;2", "", "Time;Pressure;Bending angle", "(s);(bar);(rad)"]
    found = read_measured(write(tmp_path, *head, *body, encoding=encoding), COLUMNS)
    assert_is_the_curve(found)
    assert found.messages == ("'Time (s)' left out",)


@pytest.mark.parametrize(
    ("pressure", "angle", "factors"),
    [
        ("pressure (KPa)", "bending angle [°]", (1, 1)),
        ("PRESSURE kgf/cm2", "Bending_Angle deg", (1 / 98.0665, 1)),
        ("pressure / N/mm²", "bending angle / rad", (1e-3, np.pi / 180)),
        ("Pressure in psi", "bending_angle_deg", (1 / 6.894757293168361, 1)),
    ],
)
def test_units_as_devices_write_them(tmp_path, pressure, angle, factors):
    body = rows(PRESSURE * factors[0], ANGLE * factors[1])
    assert_is_the_curve(read_measured(write(tmp_path, f"{pressure};{angle}", *body), COLUMNS))


def test_cells_without_a_value_are_left_out_and_told(tmp_path):
    body = rows(PRESSURE, ANGLE)
    body.insert(2, "9.0;N/A")
    body.insert(4, "15;")
    found = read_measured(write(tmp_path, "pressure_kPa;bending_angle_deg", *body), COLUMNS)
    assert_is_the_curve(found)
    assert found.messages == ("2 of 7 rows lack a value and are left out, first line 4",)


def test_a_first_row_that_is_wrong_is_refused_and_not_skipped(tmp_path):
    body = rows(PRESSURE, ANGLE)
    body[0] = "1;x"
    with pytest.raises(SpecError, match=r"angle.csv:2: column 'bending_angle_deg': 'x' is not a"):
        read_measured(write(tmp_path, "pressure_kPa;bending_angle_deg", *body), COLUMNS)


@pytest.mark.parametrize(
    ("head", "columns", "said"),
    [
        ("P (kPa);bending_angle_deg", "pressure_kPa, bending_angle_deg", "no column of a run"),
        ("colour;Pressure (kPa);Bending angle (deg)",
         "-, Pressure (kPa), Bending angle (deg)", "'colour' is no column"),
        ("pressure;bending angle (deg)", "pressure_kPa, bending angle (deg)", "names no unit"),
        (None, "pressure_kPa, bending_angle_deg", "the table has no headings"),
    ],
)  # fmt: skip
def test_each_refusal_names_the_command_that_reads_the_file(tmp_path, head, columns, said):
    extra = [PRESSURE] if head and head.startswith("colour") else []
    lines = [*([head] if head else []), *rows(*extra, PRESSURE, ANGLE)]
    path = write(tmp_path, *lines)
    call = "softact report results/finger --measured angle.csv"
    with pytest.raises(SpecError, match=said) as error:
        read_measured(path, COLUMNS, command=call)
    (command,) = re.findall(r"read it with: (softact .*?)(?:, with .*)?$", str(error.value))
    assert command.startswith(call)
    words = shlex.split(command)
    assert words[-2:] == ["--columns", columns]
    given = [name.strip() for name in words[-1].split(",")]
    assert_is_the_curve(read_measured(path, COLUMNS, headings=given))

"""Values with units: what is read, what is refused and in which words, and the way back."""

import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, Field, ValidationError

from softact.unit_lookup import KINDS, by_pint
from softact.units import (
    ACCELERATION,
    ANGLE,
    COMPLIANCE,
    DENSITY,
    DIMENSIONS,
    FORCE,
    LENGTH,
    PRESSURE,
    TIME,
    VOLUME,
    Angle,
    Density,
    Dimensionless,
    Length,
    Pressure,
    conversion,
    dimension_of,
    split,
)
from softact.usual_units import USUAL


class Part(BaseModel):
    wall: Length = Field("3 mm", gt=0, validate_default=True)
    pressure: Pressure | None = None
    density: Density = 1e-9
    angle: Angle = 0.0
    number: Dimensionless = 1.0


# Factors by definition of the units; psi = 0.45359237 kg * 9.80665 m/s^2 / (25.4 mm)^2.
@pytest.mark.parametrize(
    ("dimension", "text", "value"),
    [
        (LENGTH, "3 mm", 3.0),
        (LENGTH, "3mm", 3.0),
        (LENGTH, " 1.5e-1  cm ", 1.5),
        (LENGTH, "1 in", 25.4),
        (LENGTH, "250 µm", 0.25),
        (LENGTH, "-2 m", -2000.0),
        (LENGTH, '1"', 25.4),
        (LENGTH, "1 mil", 0.0254),
        (LENGTH, "３ｍｍ", 3.0),
        (PRESSURE, "50 kPa", 0.05),
        (PRESSURE, "-50 kPa", -0.05),
        (PRESSURE, "6.5 GPa", 6500.0),
        (PRESSURE, "1 bar", 0.1),
        (PRESSURE, "1 N/mm^2", 1.0),
        (PRESSURE, "1 N/mm2", 1.0),
        (PRESSURE, "1 N·mm⁻²", 1.0),
        (PRESSURE, "1 N mm-2", 1.0),
        (PRESSURE, "1 N/cm2", 0.01),
        (PRESSURE, "1 kgf/cm2", 0.0980665),
        (PRESSURE, "1 kgf/mm²", 9.80665),
        (PRESSURE, "1 kp/cm²", 0.0980665),
        (PRESSURE, "1 kN/m2", 0.001),
        (PRESSURE, "\N{MINUS SIGN}1 mbar", -1e-4),
        (PRESSURE, "1 barg", 0.1),
        (PRESSURE, "1 cmH2O", 9.80665e-5),
        (PRESSURE, "1 mmHg", 1.33322387415e-4),
        (PRESSURE, "1 Torr", 0.101325 / 760),
        (PRESSURE, "1 ksi", 453.59237 * 9.80665 / 25.4**2),
        (PRESSURE, "1 psig", 0.45359237 * 9.80665 / 25.4**2),
        (PRESSURE, "1 lbf/in2", 0.45359237 * 9.80665 / 25.4**2),
        (PRESSURE, "1 psi", 0.45359237 * 9.80665 / 25.4**2),
        (DENSITY, "1130 kg/m^3", 1.13e-9),
        (DENSITY, "1130 kg/m³", 1.13e-9),
        (DENSITY, "1.2 g/cm^3", 1.2e-9),
        (DENSITY, "1.2 g/cc", 1.2e-9),
        (DENSITY, "1.2 g/ml", 1.2e-9),
        (DENSITY, "1.2 kg/dm3", 1.2e-9),
        (VOLUME, "1 ccm", 1000.0),
        (VOLUME, "1 µl", 1.0),
        (VOLUME, "1 cm3", 1000.0),
        (ANGLE, "30 deg", 30.0),
        (ANGLE, "30°", 30.0),
        (ANGLE, 30, 30.0),
        (ANGLE, "100 gon", 90.0),
        (ANGLE, "1 rev", 360.0),
        (ACCELERATION, "-9.81 m/s^2", -9810.0),
        (FORCE, "1 kN", 1000.0),
        (FORCE, "1 gf", 0.00980665),
        (FORCE, "1 tf", 9806.65),
        (TIME, "2 ms", 0.002),
        (COMPLIANCE, "2.9259 1/MPa", 2.9259),
        (COMPLIANCE, "1 / GPa", 0.001),
    ],
)
def test_a_value_is_held_in_internal_units(dimension, text, value):
    # The arithmetic is exact up to the last rounding; the expected products here round too.
    assert dimension.parse(text) == pytest.approx(value, rel=4e-16)


def test_a_radian_is_converted_to_degrees():
    assert ANGLE.parse("3.141592653589793 rad") == pytest.approx(180.0, rel=1e-15)


@pytest.mark.parametrize(
    ("dimension", "value", "words"),
    [
        (LENGTH, "3", "'3' has no unit; write a length, for example '3 mm'"),
        (LENGTH, 3, "'3' has no unit"),
        (LENGTH, 0.0, "'0.0' has no unit"),
        (LENGTH, "50 kPa", "'50 kPa' is a pressure; write a length"),
        (PRESSURE, "50 mm", "'50 mm' is a length; write a pressure, for example '50 kPa'"),
        (PRESSURE, "5 kg", "'5 kg' is a mass"),
        (PRESSURE, "5 degC", "'5 degC' is a temperature"),
        (LENGTH, "5 %", "a bare ratio"),
        (ANGLE, "5 %", "a bare ratio"),
        (PRESSURE, "50 kpa", "there is no unit 'kpa'; did you mean 'kPa'?"),
        (LENGTH, "3 m3", "'3 m3' is a volume; write a length"),
        (LENGTH, "3 mm1", "there is no unit 'mm1'"),
        (PRESSURE, "1 kg/cm^2", "is a mass per area; did you mean 'kgf/cm^2'?"),
        (PRESSURE, "1 lb/in^2", "is a mass per area; did you mean 'lbf/in^2'?"),
        (PRESSURE, "1 N/m^3", "is a weight per volume; write a pressure"),
        (PRESSURE, "1 mm^4", "is a second moment of area; write a pressure"),
        (PRESSURE, "1 kPa^3", "is of another kind; write a pressure"),
        (PRESSURE, "1 Nmm", "is a moment; write a pressure"),
        (PRESSURE, "15 psia", "this is an absolute pressure"),
        (PRESSURE, "30 Shore A", "a hardness gives no modulus"),
        (
            PRESSURE,
            "Shore 00-30",
            "is not a pressure such as '50 kPa': a hardness gives no modulus",
        ),
        (PRESSURE, "3,5 N/mm2", "decimal comma"),
        (FORCE, "1 kg", "'1 kg' is a mass; did you mean 'kgf'?"),
        (FORCE, "1 tonf", "a ton is 907 kg, 1000 kg or 1016 kg"),
        (DENSITY, "1e-9 ton/mm^3", "write 'tonne' for 1000 kg"),
        (DENSITY, "1 gr/cm3", "'gr' is a grain"),
        (ACCELERATION, "1 g", "multiples of g are bare numbers: gravity: [0, 0, -1]"),
        (LENGTH, "3 MM", "did you mean 'mm'?"),
        (LENGTH, "1/2 in", "there is no unit"),
        (LENGTH, "1e-400 mm", "out of the range"),
        (LENGTH, "3 mm 4", "there is no unit 'mm 4'"),
        (LENGTH, "9**9**9 mm", "there is no unit"),
        (LENGTH, "3 mm^99999999", "there is no unit"),
        (LENGTH, '3 __import__("os")', "there is no unit"),
        (LENGTH, "nan mm", "not a finite number"),
        (LENGTH, "-inf mm", "not a finite number"),
        (LENGTH, math.nan, "not a finite number"),
        (LENGTH, "1e999 mm", "too large"),
        (LENGTH, "1e308 km", "out of the range"),
        (LENGTH, "1e-323 um", "out of the range"),
        (LENGTH, "3,5 mm", "decimal comma"),
        (LENGTH, "thick", "'thick' is not a length such as '3 mm'"),
        (LENGTH, "", "'' is not a length"),
        (LENGTH, True, "'True' is not a length"),
        (LENGTH, None, "no value is given; write a length"),
        (LENGTH, ["3 mm"], "is not a length"),
        (ACCELERATION, "9.81 m/s", "'9.81 m/s' is a velocity; write an acceleration"),
    ],
)
def test_what_is_no_value_is_refused_with_what_would_be_right(dimension, value, words):
    with pytest.raises(ValueError) as caught:
        dimension.parse(value)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@given(
    st.sampled_from(DIMENSIONS),
    st.floats(allow_nan=False, allow_infinity=False),
)
def test_any_float_survives_the_way_to_text_and_back(dimension, value):
    assert dimension.parse(dimension.format(value)) == value


def unit_texts():
    """Texts that look like units: names of units with prefixes, powers and signs between them."""
    names = [
        "m",
        "g",
        "N",
        "Pa",
        "psi",
        "ton",
        "Nm",
        "H2O",
        "degC",
        "dB",
        "lb",
        "in",
        "%",
        "°",
        "µm",
    ]
    name = st.builds(str.__add__, st.sampled_from(["", "k", "M", "m", "µ"]), st.sampled_from(names))
    powers = ["", "2", "-3", "^2", "²", "⁻¹", "**2", "^0.5", "^1e9", "^9^9", "^9^9^9^9", "^(9)^9"]
    factor = st.builds(str.__add__, name, st.sampled_from(powers))
    between = st.sampled_from(["*", "/", " ", "·", "//", "^", "-", "(", ")", "per"])
    return st.lists(st.one_of(factor, between), max_size=7).map("".join)


@given(st.sampled_from(DIMENSIONS), unit_texts())
def test_any_unit_is_read_or_refused_in_a_line(dimension, unit):
    for read in (
        lambda: dimension.parse(f"2 {unit}"),
        lambda: conversion(dimension.internal, unit),
    ):
        try:
            assert math.isfinite(read())
        except ValueError as error:
            assert str(error)
            assert "\n" not in str(error)


@pytest.mark.parametrize("unit", ["m^9^9^9", "m**9**9**9", "((m^9)^9)^9^9", "m^1e9", "m^999999999"])
def test_a_power_of_a_power_is_not_computed(unit):
    with pytest.raises(ValueError, match="there is no unit"):
        LENGTH.parse(f"1 {unit}")


MANY = 1_000_000
LONG = {
    "blanks after a decimal comma": "1,1" + " " * MANY + "1",
    "blanks before a unit": "1" + " " * MANY + "x" + " " * MANY + "y",
    "digits, then two lines": "1" * MANY + " a\nb",
    "digits and commas": "1,1" * MANY,
    "digits and points": "1." * MANY,
    "blanks alone": " " * MANY,
    "signs": "+" * MANY,
    "exponents": "1e" * MANY,
    "words": "1 " + "mm " * MANY,
}


@pytest.mark.parametrize("text", LONG.values(), ids=LONG)
def test_a_long_text_is_refused_and_not_searched_for_ever(text):
    """With expressions that backtrack each of the first three takes hours."""
    for dimension in (LENGTH, PRESSURE):
        with pytest.raises(ValueError):
            dimension.parse(text)
    with pytest.raises(ValidationError):
        Part(number=text)
    assert split(text) == split(" " * MANY + text + " " * MANY)


def test_what_a_value_is_called_covers_every_dimension():
    for dimension in DIMENSIONS:
        if dimension is not ANGLE:
            article = "an" if dimension.name[0] in "aeiou" else "a"
            assert KINDS[dimension.internal] == f"{article} {dimension.name}"


@given(st.sampled_from(DIMENSIONS), st.text(max_size=60))
def test_any_text_is_a_finite_float_or_a_value_error(dimension, text):
    try:
        assert math.isfinite(dimension.parse(text))
    except ValueError as error:
        assert str(error)


@pytest.mark.parametrize(
    ("dimension", "text"),
    [
        (LENGTH, "0.1 mm"),
        (LENGTH, "0 mm"),
        (PRESSURE, "50 kPa"),
        (PRESSURE, "-30 kPa"),
        (PRESSURE, "6.5 GPa"),
        (DENSITY, "750 kg/m^3"),
        (ACCELERATION, "-9.81 m/s^2"),
        (ANGLE, "30 deg"),
    ],
)
def test_a_value_is_written_as_people_write_it(dimension, text):
    assert dimension.format(dimension.parse(text)) == text


def test_a_model_holds_floats_and_writes_units():
    part = Part(pressure="50 kPa", density="1130 kg/m^3", angle=30, number="1e-4")
    assert (part.wall, part.pressure, part.density) == (3.0, 0.05, 1.13e-9)
    assert (part.angle, part.number) == (30.0, 1e-4)
    assert part.model_dump(mode="json") == {
        "wall": "3 mm",
        "pressure": "50 kPa",
        "density": "1130 kg/m^3",
        "angle": "30 deg",
        "number": 1e-4,
    }
    assert Part.model_validate(part.model_dump(mode="json")) == part


@pytest.mark.parametrize("value", ["nan", ".inf", math.nan, math.inf, "3 mm", True, None, 10**400])
def test_a_dimensionless_number_is_finite_and_bare(value):
    with pytest.raises(ValidationError) as caught:
        Part(number=value)
    assert "number" in str(caught.value)


def test_a_bound_holds_for_the_value_in_internal_units():
    with pytest.raises(ValidationError, match="greater than 0"):
        Part(wall="-1 mm")


def test_the_dimension_of_a_field_is_known():
    fields = Part.model_fields
    assert dimension_of(fields["wall"]) is LENGTH
    assert dimension_of(fields["pressure"]) is PRESSURE
    assert dimension_of(fields["number"]) is None


@pytest.mark.parametrize(
    ("internal", "unit"), [(internal, unit) for internal in USUAL for unit in USUAL[internal]]
)
def test_the_usual_units_are_those_of_pint(internal, unit):
    assert by_pint(unit, internal) == ("", USUAL[internal][unit])


def test_what_a_spec_is_shown_in_is_usual():
    """So that a resolved spec, which the solver reads, needs no pint."""
    for dimension in DIMENSIONS:
        assert {dimension.internal, *dimension.shown} <= set(USUAL[dimension.internal])


def test_a_spec_in_usual_units_does_not_wait_for_pint():
    program = (
        "import sys; from softact import spec\n"
        "spec.loads('geometry: {type: pneunet, mesh_size: 4 mm}\\n'"
        "'materials: {body: elastosil-m4601}\\nsteps: [{name: up, pressure: 20 kPa}]').to_yaml()\n"
        "sys.exit('pint' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_whole_number_too_long_to_write_is_refused():
    with pytest.raises(ValueError, match="more than 4300 digits' is not a length"):
        LENGTH.parse(10**5000)

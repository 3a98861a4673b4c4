"""Values with units: what is read, what is refused and in which words, and the way back."""

import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, Field, ValidationError

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
    Angle,
    Density,
    Dimensionless,
    Length,
    Pressure,
    by_pint,
    dimension_of,
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
        (PRESSURE, "50 kPa", 0.05),
        (PRESSURE, "-50 kPa", -0.05),
        (PRESSURE, "6.5 GPa", 6500.0),
        (PRESSURE, "1 bar", 0.1),
        (PRESSURE, "1 N/mm^2", 1.0),
        (PRESSURE, "1 psi", 0.45359237 * 9.80665 / 25.4**2),
        (DENSITY, "1130 kg/m^3", 1.13e-9),
        (DENSITY, "1130 kg/m³", 1.13e-9),
        (DENSITY, "1.2 g/cm^3", 1.2e-9),
        (ANGLE, "30 deg", 30.0),
        (ANGLE, "30°", 30.0),
        (ANGLE, 30, 30.0),
        (ACCELERATION, "-9.81 m/s^2", -9810.0),
        (FORCE, "1 kN", 1000.0),
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
        (LENGTH, "3 m3", "there is no unit 'm3'"),
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

"""Whatever stands in a file of test data: it is read, or refused in lines; nothing else happens."""

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from softact.errors import SpecError
from softact.fit.data import read_tests
from softact.fit.sheet import make_sheet
from softact.fit.trimming import MIN_POINTS
from softact.measured.cells import cell_kind, decimal_mark, value
from softact.measured.curve import read_measured
from softact.measured.headings import read_heading

HEADS = st.sampled_from(
    ["stretch", "strain %", "Strain 1 (%)", "Tensile strain", "λ", "Extension (in)", "Weg", "Zeit",
     "Load (N)", "Kraft in kN", "Nominal stress (KPa)", "Stress", "True stress [Kgf/cm2.]", "Cycle",
     "Specimen", "Position (mm)", "course stretch", "wale stretch", "course force N", "-", "",
     "wale nominal_stress MPa", "pressure_kPa", "bending angle (rad)", "Load (MPa)", "Thickness"]
)  # fmt: skip
UNITS = st.sampled_from(["(mm)", "N", "[%]", "kgf/cm^2", "s", "", "-", "bananas", "mPa", "°C"])
NUMBERS = st.one_of(
    st.floats(-10, 10).map(repr),
    st.floats().map(repr),
    st.floats(0, 3).map(lambda v: f"{v:.3f}"),
    st.floats(0, 3).map(lambda v: f"{v:.3f}".replace(".", ",")),
    st.integers(0, 10**7).map(lambda v: f"{v:,}"),
    st.sampled_from(["N/A", "", "--", "1e999", "inf", "12:30:01", '="1.5"', "1'000", "−3", "abc"]),
)
RISING = st.integers(1, 40).map(lambda n: [f"{v:.4f}" for v in np.linspace(1, 2.5, n)])
SEPARATORS = st.sampled_from([",", ";", "\t", " ", "|", ", "])


@st.composite
def tables(draw):
    """Something between a proper table and rubbish."""
    mark, width = draw(SEPARATORS), draw(st.integers(1, 5))
    lines = draw(st.lists(st.text(max_size=20), max_size=3))
    lines.append(mark.join(draw(st.lists(HEADS, min_size=width, max_size=width))))
    if draw(st.booleans()):
        lines.append(mark.join(draw(st.lists(UNITS, min_size=width, max_size=width))))
    body = draw(RISING)
    quote = draw(st.sampled_from(["", '"']))
    if draw(st.booleans()):
        lines += [mark.join(f"{quote}{v}{quote}" for _ in range(width)) for v in body]
    cell = st.lists(NUMBERS, min_size=width, max_size=width + draw(st.integers(0, 1)))
    lines += [mark.join(row) for row in draw(st.lists(cell, max_size=12))]
    if draw(st.booleans()):
        lines += draw(st.lists(st.text(max_size=12), max_size=2)) + lines
    return draw(st.sampled_from(["\n", "\r\n", "\r"])).join(lines)


CONTENT = st.one_of(
    st.binary(max_size=200),
    st.tuples(tables(), st.sampled_from(["utf-8", "utf-16", "latin-1", "utf-16-le", "utf-32"])).map(
        lambda pair: pair[0].encode(pair[1], errors="replace")
    ),
)
OPTIONS = st.fixed_dictionaries(
    {},
    optional={
        "mode": st.sampled_from(
            ["uniaxial", "compression", "planar", "equibiaxial", "biaxial"]
        ),
        "length": st.just("30 mm"), "area": st.just("12 mm^2"), "loading": st.just(True),
        "stress": st.sampled_from(["nominal", "cauchy"]), "zero": st.just(True),
        "toe": st.just("10 kPa"), "smooth": st.just(5), "points": st.just(10),
        "whole": st.just(True), "columns": st.lists(HEADS, min_size=1, max_size=4).map(tuple),
    },
)  # fmt: skip
LOOSE = settings(
    max_examples=400,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)


@LOOSE
@given(content=CONTENT, options=OPTIONS)
@example(content=b"strain,nominal stress MPa\n" + b"1.5,-3\n" * 9, options={"mode": "compression"})
@example(content=b"\x00", options={})
@example(content=b'"', options={})
def test_any_file_is_read_or_refused_in_lines(tmp_path, content, options):
    path = tmp_path / "data.csv"
    path.write_bytes(content)
    try:
        tests = read_tests(make_sheet({"file": path, **options}, str(path)))
    except SpecError as error:
        assert error.lines and all(line.isprintable() and line for line in error.lines)
        return
    for test in tests:
        assert len(test.stretch) >= MIN_POINTS and len(test.stretch) == len(test.stress)
        assert np.all(test.stretch > 0) and np.all(np.isfinite(test.stretch))
        assert np.all(np.isfinite(test.stress))


COLUMNS = ["pressure_kPa", "bending_angle_deg", "tip_x_mm"]


@LOOSE
@given(content=CONTENT, headings=st.none() | st.lists(HEADS, min_size=1, max_size=4))
def test_any_measured_file_is_read_or_refused_in_lines(tmp_path, content, headings):
    path = tmp_path / "data.csv"
    path.write_bytes(content)
    try:
        found = read_measured(path, COLUMNS, headings=headings)
    except SpecError as error:
        assert error.lines and all(line.isprintable() and line for line in error.lines)
        return
    for values in found.values.values():
        assert len(values) and np.all(np.isfinite(values))


@LOOSE
@given(text=st.text(max_size=40) | st.tuples(HEADS, UNITS).map(" ".join))
def test_any_text_is_a_heading_of_something(text):
    column = read_heading(text)
    assert column.factor is not None or column.fault
    again = read_heading(column.written)
    if not column.fault and column.quantity.role:
        assert again.factor == column.factor and again.quantity.role == column.quantity.role


@settings(max_examples=300, deadline=None, derandomize=True)
@given(number=st.floats(-1e9, 1e9), digits=st.integers(1, 6))
def test_a_number_is_read_as_it_is_written_in_every_habit(number, digits):
    number = round(number, digits)
    plain = f"{number:.{digits}f}"
    grouped = f"{number:,.{digits}f}"
    for text, mark in (
        (plain, "."), (grouped, "."), (plain.replace(".", ","), ","),
        (grouped.translate(str.maketrans(",.", ".,")), ","), (grouped.replace(",", "\u00a0"), "."),
        (grouped.replace(",", "'"), "."), (plain.replace("-", "\N{MINUS SIGN}"), "."),
        (f'="{plain}"', "."), (f'"{plain}"', "."),
    ):  # fmt: skip
        assert cell_kind(text) == "number"
        assert value(text, mark) == pytest.approx(number, abs=1e-12)
        assert decimal_mark([text, "0" + mark + "5"]) == mark


LONG = 200_000


@pytest.mark.parametrize(
    "cell",
    ["1" * LONG, "1," * LONG, "1.1" * LONG, "1:" * LONG, "1,111" * LONG, "(" * LONG, '"' * LONG,
     " 1" * LONG, "1e" * LONG, "-" * LONG, "a b" * LONG, "#" * LONG, "=" * LONG, "1: " * LONG],
)  # fmt: skip
def test_long_runs_of_anything_are_refused_soon(tmp_path, cell):
    path = tmp_path / "long.csv"
    for text in (
        f"stretch,nominal_stress MPa\n1,2\n{cell},{cell}\n",
        f"{cell},{cell}\n1,2\n2,3\n3,4\n4,5\n5,6\n",
    ):
        path.write_text(text)
        with pytest.raises(SpecError) as error:
            read_tests(make_sheet({"file": path}, str(path)))
        assert max(map(len, error.value.lines)) < 2000

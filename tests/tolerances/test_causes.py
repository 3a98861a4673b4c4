"""Tolerances as a spec has them: distributions of its parameters, and what is refused."""

from __future__ import annotations

import pytest

from softact import spec as specs
from softact.errors import SpecError
from softact.inputs import validate
from softact.run.resuming import identity
from softact.sensitivities.choosing import Chosen
from softact.sweep.spec import Sweep, read
from softact.tolerances.causes import causes

BLOCK = """
geometry: {type: block, length: 6 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: mooney_rivlin, c10: 20 kPa, c01: 5 kPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{name: pull, traction: {surface: x_max, value: [1 kPa, 0 kPa, 0 kPa]}}]
"""


def loaded(tolerances: str):
    return specs.loads(f"{BLOCK}tolerances: {{{tolerances}}}")


def test_a_standard_deviation_scatters_normally():
    (cause,) = causes(loaded("geometry.length: 0.3 mm"))
    assert (cause.means, cause.deviations) == ((6.0,), (0.3,))
    assert cause.values(0.5) == pytest.approx((6.0,))
    # Φ(1) = 0.841345: one standard deviation.
    assert cause.values(0.841345) == pytest.approx((6.3,), abs=1e-5)


def test_a_part_is_of_the_value_and_paths_scatter_together():
    (cause,) = causes(loaded("'materials.body.c10, materials.body.c01': 16 %"))
    assert cause.deviations == pytest.approx((0.16 * 0.02, 0.16 * 0.005))
    first, second = cause.values(0.9)
    assert first / second == pytest.approx(4.0)
    assert cause.along(first) == pytest.approx((first, second))


def test_limits_are_even():
    one, other = causes(loaded(
        "geometry.width: {limits: 0.1 mm}, geometry.height: {limits: [3.9 mm, 4.3 mm]}"
    ))  # fmt: skip
    assert one.deviations == pytest.approx((0.2 / 12**0.5,))
    assert [one.values(f)[0] for f in (0.0, 1.0)] == pytest.approx([3.9, 4.1])
    assert other.shifts == pytest.approx((0.1,))
    assert [other.values(f)[0] for f in (0.0, 1.0)] == pytest.approx([3.9, 4.3])


def test_units_are_those_of_the_parameter():
    (cause,) = causes(loaded("steps.pull.traction.value.0: 20 Pa"))
    assert cause.deviations == pytest.approx((2e-5,))


FAULTS = {
    "geometry.lenght: 1 mm": "geometry has no value 'lenght'; did you mean 'length'?",
    "geometry.type: 1 mm": "'block' is no number",
    "geometry.mesh_size: 1 mm": "how fine the mesh is",
    "geometry.length: 1 kPa": "'kPa' is a pressure, and a unit such as 'mm' is wanted",
    "geometry.length: 1": "write for example '1 mm'",
    "materials.body.poissons_ratio: 0.001 mm": "write for example '0.001'",
    "geometry.length: {limits: [7 mm, 8 mm]}": "the value of the spec, 6 mm, is not between",
    "geometry.length: {limits: [1 %, 2 %]}": "in % write one, for both sides",
    "steps.pull.traction.value.1: 2 %": "of 0 is nothing",
    "geometry.length: 1 mm, 'geometry.width, geometry.length': 2 mm": "has a tolerance already",
}


@pytest.mark.parametrize("text", FAULTS)
def test_what_is_no_tolerance_is_told_in_a_line(text):
    with pytest.raises(SpecError) as raised:
        causes(loaded(text))
    (line,) = raised.value.lines
    assert line.startswith("tolerances: ")
    assert FAULTS[text] in line


def test_a_whole_number_has_no_tolerance():
    spec = specs.loads(
        "geometry: {type: pneunet}\nmaterials: {body: ecoflex-00-30}\n"
        "steps: [{pressure: 1 kPa}]\ntolerances: {geometry.chambers: 1}"
    )
    with pytest.raises(SpecError, match=r"tolerances: geometry.chambers: '8' is a whole number"):
        causes(spec)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("-0.1 mm", "'-0.1 mm' has to be above 0"),
        ("0 mm", "'0 mm' has to be above 0"),
        ("thick", "'thick' is no number with its unit"),
        (".nan mm", "is no number with its unit"),
        ("[1 mm, 2 mm]", "is no number with its unit"),
        ("{std: 1 mm, limits: 2 mm}", "write either 'std' or 'limits'"),
        ("{}", "write either 'std' or 'limits'"),
        ("{limits: -1 mm}", "'-1 mm' has to be above 0"),
        ("{limits: [1 mm, 2 mm, 3 mm]}", "the lower and the upper"),
    ],
)
def test_a_wrong_value_is_told_with_its_place(text, why):
    with pytest.raises(SpecError) as raised:
        loaded(f"geometry.length: {text}")
    (line,) = raised.value.lines
    assert "tolerances.geometry.length" in line
    assert why in line


def test_validate_tells_of_them_with_file_and_line(tmp_path):
    file = tmp_path / "spec.yaml"
    file.write_text(f"{BLOCK}tolerances: {{geometry.lenght: 1 mm}}\n", encoding="utf-8")
    with pytest.raises(SpecError, match=r"spec.yaml:6: tolerances: geometry.lenght: geometry has"):
        validate(file)


def test_they_change_neither_the_run_nor_what_it_is_kept_under():
    with_, without = loaded("geometry.length: 1 mm"), specs.loads(BLOCK)
    assert with_.hash == without.hash
    assert "tolerances" not in identity(without)
    assert specs.loads(with_.to_yaml()) == with_


def test_a_length_that_the_mesh_cannot_follow_is_refused_by_its_tolerance(tmp_path):
    """The tunnel is as wide as the chambers, see tests/sensitivities/test_runs.py."""
    spec = specs.loads(
        "geometry: {type: slow_pneunet, tunnel_width: 8 mm, mesh_size: 8 mm}\n"
        "materials: {body: ecoflex-00-30, film: ecoflex-00-30}\nsteps: [{pressure: 1 kPa}]\n"
        "tolerances: {geometry.tunnel_width: 0.1 mm}"
    )
    some = [p for cause in causes(spec) for p in cause.parameters]
    with pytest.raises(SpecError, match=r"tolerances: geometry.tunnel_width: planes .* would part"):
        Chosen(spec, None, some).job(tmp_path)


SWEEP = "name: sample\nbase: base.yaml\ndesign: {kind: tolerances, samples: 40, seed: 3}\n"


def opened(folder, tolerances: str, sweep: str = SWEEP):
    (folder / "base.yaml").write_text(f"{BLOCK}{tolerances}\n", encoding="utf-8")
    (folder / "sweep.yaml").write_text(sweep, encoding="utf-8")
    return read(folder / "sweep.yaml", Sweep)


def test_a_sweep_draws_from_the_same_distributions(tmp_path):
    text = (
        "tolerances: {geometry.length: 0.3 mm, geometry.width: {limits: 0.1 mm}, "
        "'materials.body.c10, materials.body.c01': 16 %}"
    )
    study, _ = opened(tmp_path, text)
    points = study.design.points(study.axes)
    assert points == study.design.points(study.axes)
    lengths = [float(point["geometry.length"].split()[0]) for point in points]
    mean = sum(lengths) / 40
    # A Latin hypercube: one sample in each fortieth, so both are much nearer than 1/√40.
    assert mean == pytest.approx(6.0, abs=0.02)
    assert (sum((v - mean) ** 2 for v in lengths) / 39) ** 0.5 == pytest.approx(0.3, rel=0.06)
    widths = [float(point["geometry.width"].split()[0]) for point in points]
    assert 3.9 <= min(widths) < 3.91 and 4.09 < max(widths) <= 4.1
    axis = study.axes[2]
    (one, first), (other, second) = axis.changes(points[0][axis.title])
    assert (one, other) == ("materials.body.c10", "materials.body.c01")
    assert float(first.split()[0]) / float(second.split()[0]) == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("tolerances", "sweep", "why"),
    [
        ("", SWEEP, "has no tolerances; write for example"),
        ("tolerances: {geometry.length: 1 mm}",
         SWEEP + "axes: [{path: geometry.width, values: [4 mm]}]\n", "leave them out"),
        ("tolerances: {geometry.length: 1 mm}", SWEEP.replace("40", "4"), "at least 8 samples"),
        ("tolerances: {geometry.lenght: 1 mm}", SWEEP, "did you mean 'length'?"),
    ],
)  # fmt: skip
def test_a_sweep_that_cannot_draw_says_why(tolerances, sweep, why, tmp_path):
    with pytest.raises(SpecError, match=why.replace("?", r"\?")):
        opened(tmp_path, tolerances, sweep)

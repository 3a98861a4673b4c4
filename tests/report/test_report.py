"""The report says the numbers of the run, and survives what is missing."""

import json
import re

import numpy as np
import pytest

from softact.errors import SpecError
from softact.report import (
    curves,
    frames,
    labels,
    pictures,
    surface,
    view,
    write_report,
)
from softact.results.folder import read
from softact.results.writer import ResultsWriter
from tests import bent_beam

LENGTH, HEIGHT = bent_beam.LENGTH, bent_beam.HEIGHT
ANGLE, INCREMENTS = bent_beam.ANGLE, bent_beam.INCREMENTS


@pytest.fixture
def no_drawing(monkeypatch):
    """Leave out the pictures, which take seconds and are not what the test is about."""
    monkeypatch.setattr(pictures, "drawing", bent_beam.undrawn)


def page_of(directory):
    """The page without scripts and pictures, its plots, and the data of the 3-D view."""
    text = write_report(directory).read_text()
    return visible(text), plots_of(text), view_of(text)


def visible(text):
    text = re.sub(r"<(script|style)\b.*?</\1>", "", text, flags=re.S)
    return re.sub(r"base64,[A-Za-z0-9+/=]+", "", text)


def view_of(text):
    return json.loads(re.search(r'id="data">(.*?)</script>', text, re.S)[1])["view"]


def plots_of(text):
    """Title -> plot, as the page's script reads them."""
    found = re.findall(r"<script type='application/json'>(.*?)</script>", text, re.S)
    return {plot["title"]: plot for plot in map(json.loads, found)}


def table_row(text, name):
    row = re.search(rf"<tr><th scope='row'>{name}</th>(.*?)</tr>", text)[1]
    return re.findall(r"<td[^>]*>(.*?)</td>", row)


def test_figures_are_those_of_the_closed_form(reported_beam):
    text = visible((reported_beam / "report.html").read_text())
    heads = re.findall(r"<th scope='col'>(.*?)</th>", text)
    assert heads[2:] == ["0 kPa", "10 kPa", "20 kPa", "30 kPa", "40 kPa", "50 kPa (last)"]
    # The angle is in proportion to the pressure, so interpolation is exact.
    assert table_row(text, "Bending angle") == [
        "°", "0.0", "40.0", "80.0", "120.0", "160.0", "200.0",
    ]  # fmt: skip
    # The base is an arc of its own length L over the angle a: x = L sin(a)/a, z = L (cos(a)-1)/a.
    a = np.radians(ANGLE)
    tip = table_row(text, "Tip z")
    assert float(tip[-1].replace("−", "-")) == pytest.approx(LENGTH * (np.cos(a) - 1) / a, abs=6e-3)
    # Largest stress: at the roof, where sigma_rr = 0, sigma_theta = mu (l^2 - 1/l^2).
    squared = 1 + 2 * a / LENGTH * HEIGHT
    stress = bent_beam.SHEAR_MODULUS * (squared - 1 / squared)
    assert float(table_row(text, "Largest principal stress")[-1]) == pytest.approx(stress, abs=6e-5)
    assert f"{stress:.4g} <span class='unit'>MPa" in text
    # (116 x 12 x 10) mm^3 in mL
    assert table_row(text, "Cavity volume")[1:] == ["13.92"] * 6


def test_it_tells_status_assumptions_history_and_provenance(reported_beam):
    text = visible((reported_beam / "report.html").read_text())
    assert "<strong>Solved and trusted.</strong>" in text and "banner good" in text
    assert "the last state is at 50 kPa" in text and "bending angle 200°" in text
    assert "How far the mesh is from converged was not looked at" in text
    assert "The wall thickness of &lt;2 mm&gt; is not in the paper" in text
    assert "9 increments were tried, 1 of them" in text and "39 Newton iterations" in text
    assert table_row(text, "solve") == ["20.25"]
    assert table_row(text, "dolfinx") == ["0.5.2"]
    assert "spec hash 0f3a" in text and "softact run spec.yaml -n 2" in text


def test_the_page_needs_nothing_else(reported_beam):
    text = (reported_beam / "report.html").read_text()
    assert len(text) < 10e6
    outside = re.findall(r"""(?:src|href)\s*=\s*["']?(?!data:|#)([^"'>\s]+)""", visible(text))
    assert outside == []
    script = text.rsplit("<script>", 1)[1]
    style = re.search(r"<style>(.*?)</style>", text, re.S)[1]
    assert not re.search(r"https?:|@import|url\(", script + style)


def test_the_data_stand_safely_in_the_page(tmp_path, no_drawing):
    writer = ResultsWriter(tmp_path / "r", "name: '</script><b>x'\n", {})
    writer.increment({"step": "</script>", "step_fraction": 1.0, "force_N": 2.0})
    writer.finish("complete", {}, {"history": [
        {"step": "</script>", "fraction": 1.0, "iterations": 3, "converged": True,
         "residuals": [1.0, float("nan"), 0.0]}]})  # fmt: skip
    text, plots, _ = page_of(tmp_path / "r")
    assert "<b>x" not in text
    table = plots["Newton iterations of each increment"]["table"]
    assert table["step and part of it"] == ["</script> 100.0 %"]
    assert plots["Residual in each increment"]["traces"][0]["y"] == [1.0]


def test_an_early_end_is_told(tmp_path, no_drawing):
    message = "beyond 19.95 kPa: too many Newton iterations"
    bent_beam.write(tmp_path / "r", 90.0, 2, "no_equilibrium", messages=[message])
    text, _, _ = page_of(tmp_path / "r")
    assert "<strong>Not solved.</strong>" in text and message in text and "banner bad" in text
    assert "Solved" not in text


def test_an_incomplete_run_is_told(tmp_path, no_drawing):
    bent_beam.write(tmp_path / "r", 90.0, 2, status=None)
    text, _, view = page_of(tmp_path / "r")
    assert "<strong>Not solved.</strong> The run has not ended, or was stopped" in text
    assert len(view["states"]) == 3


def test_a_run_without_any_increment(tmp_path, no_drawing):
    ResultsWriter(tmp_path / "r", "name: r\n", {}).finish("no_equilibrium", {}, {"messages": ["x"]})
    text, plots, view = page_of(tmp_path / "r")
    assert "no equilibrium state at all" in text and "there are no figures" in text
    assert (plots, view) == ({}, None) and "href='#view'" not in text


def test_a_torn_field_file_leaves_the_rest(tmp_path):
    bent_beam.write(tmp_path / "r", 90.0, 2)
    (tmp_path / "r" / "fields.h5").write_bytes(b"torn")
    text, plots, view = page_of(tmp_path / "r")
    assert "fields.h5: is damaged" in text
    assert view is None and len(plots) > 5
    assert table_row(text, "Bending angle")[-1] == "90.00"


def test_failed_drawing_is_told_and_the_rest_stands(tmp_path, monkeypatch):
    bent_beam.write(tmp_path / "r", 90.0, 2)
    monkeypatch.setattr(frames, "_TIME_LIMIT_S", 0.05)
    monkeypatch.setattr(frames, "command", lambda *of: ["/bin/sh", "-c", "exec sleep 60"])
    text, _, view = page_of(tmp_path / "r")
    assert "The pictures of the actuator are missing: drawing took longer than 0.05 s" in text
    assert view["outer"] > 0 and "<img" not in text


def test_a_crash_while_drawing_is_told(tmp_path, monkeypatch):
    bent_beam.write(tmp_path / "r", 90.0, 1)
    monkeypatch.setattr(frames, "command", lambda *of: ["/bin/sh", "-c", "echo no GL >&2; exit 3"])
    results = read(tmp_path / "r")
    with pictures.drawing(results, lambda: surface.skin(results)) as finish:
        assert finish().fault == "drawing ended with code 3: no GL"


def test_a_folder_of_something_else_is_refused(tmp_path):
    with pytest.raises(SpecError, match="not a result folder"):
        write_report(tmp_path)


def test_several_cavities(tmp_path, no_drawing):
    writer = ResultsWriter(tmp_path / "r", "name: r\n", {})
    for n in range(5):
        writer.increment({
            "step": "push", "step_fraction": n / 4, "pressure_upper_kPa": 10.0 * n,
            "pressure_lower_kPa": -1.0 * n, "cavity_volume_upper_mm3": 1000.0 + n,
            "cavity_volume_lower_mm3": 2000.0 - n, "twist_angle_deg": 3.0 * n,
        })  # fmt: skip
    writer.finish("complete")
    text, plots, _ = page_of(tmp_path / "r")
    assert plots["Twist"]["x"] == "Pressure upper (kPa)"
    assert [line["name"] for line in plots["Pressures"]["traces"]] == [
        "Pressure upper", "Pressure lower",
    ]  # fmt: skip
    assert len(plots["Cavity volume"]["traces"]) == 2
    assert table_row(text, "Twist angle")[1:] == ["0.00", "3.00", "6.00", "9.00", "12.00"]
    assert table_row(text, "Cavity volume lower")[-1] == "1.996"


def test_a_run_without_pressure_is_drawn_against_the_step(tmp_path, no_drawing):
    writer = ResultsWriter(tmp_path / "r", "name: r\n", {})
    for step in ("gravity", "pull"):
        for n in range(3):
            writer.increment({"step": step, "step_fraction": n / 2, "reaction_x_N": 1.0 + n})
    writer.finish("complete")
    _, plots, _ = page_of(tmp_path / "r")
    (plot,) = plots.values()
    assert plot["x"].startswith("Load")
    assert plot["traces"][0]["x"] == [0.0, 0.5, 1.0, 1.0, 1.5, 2.0]


# ---- what it computes ----


@pytest.mark.parametrize(
    "low, high, expected",
    [
        (0, 50, [10, 20, 30, 40]),
        (0, 43, [10, 20, 30, 40]),
        (0, 7, [2, 4, 6]),
        (0, 6, [1, 2, 3, 4, 5]),
        (0, -30, [-5, -10, -15, -20, -25]),
        (0, 0.2, [0.05, 0.1, 0.15]),
        (5, 5, []),
    ],
)
def test_round_loads(low, high, expected):
    assert curves.round_loads(low, high) == pytest.approx(expected)


@pytest.mark.parametrize(
    "value, text",
    [(0.27786, "0.2779"), (200.0, "200"), (-66.681, "−66.68"), (12345.6, "12346"),
     (1e-14, "0"), (2.5e-5, "2.5e−05"), (float("nan"), "–"), (0.1, "0.1")],
)  # fmt: skip
def test_numbers(value, text):
    assert labels.number(value) == text


@pytest.mark.parametrize(
    "name, text",
    [("pressure_upper_kPa", "Pressure upper (kPa)"), ("cavity_volume_mm3", "Cavity volume (mL)"),
     ("max_von_mises_MPa", "Largest von Mises stress (MPa)"), ("tip_x_mm", "Tip x (mm)"),
     ("reaction_moment_y_Nmm", "Reaction moment y (N·mm)"),
     ("max_principal_stretch", "Largest principal stretch"), ("mass_g", "Mass (g)"),
     ("air_flow_nl_per_min", "Air flow (nl/min)"),
     ("contact_area_pad_mm2", "Contact area pad (mm²)"),
     ("principal_stretch_p999_g", "Principal stretch exceeded in 0.1 % of the volume, g")],
)  # fmt: skip
def test_column_labels(name, text):
    assert str(labels.column(name)) == text


def test_places_of_largest_values_are_not_measures(tmp_path):
    writer = ResultsWriter(tmp_path / "r", "", {})
    row = {"tip_x_mm": 1.0, "max_principal_stress_MPa": 2.0, "max_principal_stress_x_mm": 3.0}
    writer.increment({**row, "zero_N": 1e-15, "step": "s", "residual": 1e-3})
    assert curves.measures(read(tmp_path / "r")) == ["tip_x_mm", "max_principal_stress_MPa"]


def test_states_at_even_loads(reported_beam):
    results = read(reported_beam)  # at 0, 6.25, 12.5 ... 50 kPa
    assert view.states(results, 4) == [2, 4, 6, 8]
    assert view.states(results, 3) == [3, 5, 8]

"""The report says the numbers of the run, draws to scale, and survives what is missing."""

import base64
import gzip
import json
import re
from contextlib import nullcontext
from dataclasses import replace

import bent_beam
import numpy as np
import pytest
from PIL import Image

from softact.errors import SpecError
from softact.geometry import Layout
from softact.report import (
    curves,
    frames,
    labels,
    obstacles,
    pictures,
    surface,
    view,
    viewer,
    write_report,
)
from softact.results import read
from softact.results_writer import ResultsWriter

LENGTH, HALF, HEIGHT = bent_beam.LENGTH, bent_beam.HALF_WIDTH, bent_beam.HEIGHT
WALL = bent_beam.WALL
ANGLE, INCREMENTS = 200.0, 8


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    directory = tmp_path_factory.mktemp("report") / "beam"
    bent_beam.write(directory, ANGLE, INCREMENTS)
    write_report(directory)
    return directory


@pytest.fixture
def no_drawing(monkeypatch):
    """Leave out the pictures, which take seconds and are not what the test is about."""
    monkeypatch.setattr(pictures, "drawing", lambda results, parts: nullcontext(lambda: "left out"))


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


# ---- what it says ----


def test_figures_are_those_of_the_closed_form(folder):
    text = visible((folder / "report.html").read_text())
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


def test_it_tells_status_assumptions_history_and_provenance(folder):
    text = visible((folder / "report.html").read_text())
    assert "<strong>Complete.</strong>" in text and "50 kPa" in text
    assert "The wall thickness of &lt;2 mm&gt; is not in the paper" in text
    assert "9 increments were tried, 1 of them" in text and "39 Newton iterations" in text
    assert table_row(text, "solve") == ["20.25"]
    assert table_row(text, "dolfinx") == ["0.5.2"]
    assert "spec hash 0f3a" in text and "softact run spec.yaml -n 2" in text


def test_the_page_needs_nothing_else(folder):
    text = (folder / "report.html").read_text()
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
    assert "No equilibrium found beyond this point." in text and message in text
    assert "Complete." not in text


def test_an_incomplete_run_is_told(tmp_path, no_drawing):
    bent_beam.write(tmp_path / "r", 90.0, 2, status=None)
    text, _, view = page_of(tmp_path / "r")
    assert "<strong>Incomplete.</strong>" in text and "Complete.<" not in text
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
    assert "fields.h5 cannot be read" in text
    assert view is None and len(plots) > 5
    assert table_row(text, "Bending angle")[-1] == "90.00"


def test_failed_drawing_is_told_and_the_rest_stands(tmp_path, monkeypatch):
    bent_beam.write(tmp_path / "r", 90.0, 2)
    monkeypatch.setattr(frames, "_TIME_LIMIT_S", 0.05)
    monkeypatch.setattr(frames, "_COMMAND", ("/bin/sh", "-c", "exec sleep 60"))
    text, _, view = page_of(tmp_path / "r")
    assert "The pictures of the actuator are missing: drawing took longer than 0.05 s" in text
    assert view["outer"] > 0 and "<img" not in text


def test_a_crash_while_drawing_is_told(tmp_path, monkeypatch):
    bent_beam.write(tmp_path / "r", 90.0, 1)
    monkeypatch.setattr(frames, "_COMMAND", ("/bin/sh", "-c", "echo no GL >&2; exit 3"))
    results = read(tmp_path / "r")
    with pictures.drawing(results, lambda: surface.skin(results)) as finish:
        assert finish() == "drawing ended with code 3: no GL"


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
     ("max_principal_stretch", "Largest principal stretch")],
)  # fmt: skip
def test_column_labels(name, text):
    assert str(labels.column(name)) == text


def test_places_of_largest_values_are_not_measures(tmp_path):
    writer = ResultsWriter(tmp_path / "r", "", {})
    row = {"tip_x_mm": 1.0, "max_principal_stress_MPa": 2.0, "max_principal_stress_x_mm": 3.0}
    writer.increment({**row, "zero_N": 1e-15, "step": "s", "residual": 1e-3})
    assert curves.measures(read(tmp_path / "r")) == ["tip_x_mm", "max_principal_stress_MPa"]


def test_states_at_even_loads(folder):
    results = read(folder)  # at 0, 6.25, 12.5 ... 50 kPa
    assert view.states(results, 4) == [2, 4, 6, 8]
    assert view.states(results, 3) == [3, 5, 8]


# ---- what it draws ----


def area(points, triangles):
    a, b, c = (points[triangles[:, n]] for n in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def volume(points, triangles):
    a, b, c = (points[triangles[:, n]] for n in range(3))
    return (a * np.cross(b, c)).sum() / 6


def test_skin_of_the_block(folder):
    results = read(folder)
    skin = surface.skin(results)
    points = results.points[skin.nodes]
    channel = (LENGTH - 2 * WALL) * (HALF - WALL) * (HEIGHT - 2 * WALL)
    both = np.vstack([skin.outer, skin.inner])
    assert volume(points, both) == pytest.approx(LENGTH * HALF * HEIGHT - channel)
    outside = 2 * LENGTH * HALF + LENGTH * HEIGHT + 2 * HALF * HEIGHT
    assert area(points, skin.outer) == pytest.approx(outside)
    # Creases of the half block: two sides along x and z, four along y; none in the cut.
    ends = points[skin.edges]
    length = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum()
    each = 2 * LENGTH + 2 * HEIGHT + 4 * HALF
    assert length == pytest.approx(2 * each)  # once for each of the two faces that meet


def test_mirrored_whole(folder):
    results = read(folder)
    skin = surface.skin(results)
    points, triangles = surface.mirrored(results.points[skin.nodes], skin.outer, skin.mirrors)
    assert volume(points, triangles) == pytest.approx(LENGTH * 2 * HALF * HEIGHT)


def test_many_triangles_are_drawn_by_their_corners(folder):
    results = read(folder)
    full, coarse = surface.skin(results), surface.skin(results, most=100)
    assert len(full.outer) == 4 * len(coarse.outer)
    assert area(results.points[coarse.nodes], coarse.outer) == pytest.approx(
        area(results.points[full.nodes], full.outer)
    )


def unpacked(packed):
    """What report.js does with the data."""
    raw = gzip.decompress(base64.b64decode(packed["data"]))
    n, states = packed["vertices"], len(packed["states"])
    faces = packed["outer"] + packed["inner"]
    triangles = np.frombuffer(raw, "<u4", 3 * faces).reshape(-1, 3)
    steps = np.frombuffer(raw, "<u2", 3 * n * states, 12 * faces).reshape(states, 3, n)
    shades = np.frombuffer(raw, "u1", -1, 12 * faces + 6 * n * states).reshape(-1, states, n)
    steps = np.cumsum(steps, axis=0, dtype=np.uint16)
    places = np.array(packed["low"])[:, None] + packed["scale"] * steps
    return triangles, places.transpose(0, 2, 1), np.cumsum(shades, axis=1, dtype=np.uint8)


def test_the_3d_view_holds_the_deformed_surface(folder):
    results = read(folder)
    packed = viewer.pack(results)
    triangles, places, shades = unpacked(packed)
    assert len(places) == INCREMENTS + 1
    skin = surface.skin(results)
    k = np.radians(ANGLE) / LENGTH
    # Of the last state: area of base and roof by their arcs, r k = l, of the sides by the rings
    # (r2^2 - r1^2) a / 2, of the ends by H' = r2 - r1.
    roof = np.sqrt(1 + 2 * k * HEIGHT)
    depth = (roof - 1) / k
    exact = LENGTH * HALF * (1 + roof) + HEIGHT * LENGTH + 2 * HALF * depth
    outer = triangles[: packed["outer"]]
    assert len(outer) == len(skin.outer)
    assert area(places[-1], outer) == pytest.approx(exact, rel=2e-4)
    assert area(places[0], outer) == pytest.approx(
        2 * LENGTH * HALF + LENGTH * HEIGHT + 2 * HALF * HEIGHT, rel=2e-4
    )
    stress = packed["fields"][0]
    seen = stress["low"] + (stress["high"] - stress["low"]) * shades[0, -1] / 255.0
    on_roof = places[0][:, 2] > HEIGHT - 1e-3
    expected = bent_beam.state(np.array([[0, 0, HEIGHT]]), ANGLE)["von_mises"][0]
    assert seen[on_roof] == pytest.approx(min(expected, stress["high"]), abs=stress["high"] / 250)


def test_the_view_has_a_state_at_rest(tmp_path):
    points, cells, surfaces = bent_beam.mesh(nx=2, ny=2, nz=7)
    writer = ResultsWriter(tmp_path / "r", "", {})
    writer.mesh(points, cells, np.zeros(len(cells)), ["body"], surfaces, bent_beam.LAYOUT)
    fields = bent_beam.state(points, 30.0)
    writer.increment(bent_beam.row(points, fields, 1.0, 30.0), fields)
    packed = viewer.pack(read(tmp_path / "r"))
    _, places, _ = unpacked(packed)
    assert packed["states"][0] == "undeformed" and len(places) == 2
    assert places[0][:, 0].max() == pytest.approx(LENGTH, abs=0.01)


def test_the_colour_range_leaves_out_a_lonely_peak(tmp_path):
    points, cells, surfaces = bent_beam.mesh()
    writer = ResultsWriter(tmp_path / "r", "", {})
    writer.mesh(points, cells, np.zeros(len(cells)), ["body"], surfaces, bent_beam.LAYOUT)
    stress = np.linspace(0, 0.123, len(points))
    stress[0] = 7.0
    fields = {"displacement": np.zeros_like(points), "von_mises": stress}
    writer.increment({"step": "s", "step_fraction": 1.0}, fields)
    everywhere = np.arange(len(points))
    low, high, largest = view.colour_range(read(tmp_path / "r"), "von_mises", everywhere)
    assert (low, high, largest) == pytest.approx((0.0, 0.13, 7.0))


@pytest.mark.parametrize(
    "layout, seen",
    [
        ({}, (1, 0)),  # nothing known but the axis: it runs to the right
        ({"bending_axis": (0, 1, 0)}, (1, 0)),
        ({"bending_axis": (0, -1, 0)}, (1, 0)),
        ({"axis": (0, 0, 1), "bending_axis": (0, 1, 0)}, (0, 1)),  # upright: it runs up
        ({"axis": (0, 1, 0), "symmetry": {"symmetry": 0}}, (1, 0)),
    ],
)
def test_the_bending_plane_is_seen(folder, layout, seen):
    """The axis is drawn nearly at full length, to the right or up; the frame is orthonormal."""
    plain = Layout(regions=("body",), surfaces=(), cavities={}, **layout)
    looked = view.bending_view(replace(read(folder), layout=plain, surfaces={}))
    frame = np.array([looked.right, looked.up, looked.eye])
    assert frame @ frame.T == pytest.approx(np.eye(3))
    assert np.linalg.det(frame) == pytest.approx(1)
    axis = np.array(plain.axis, float)
    drawn = looked.project(axis[None])[0]
    assert drawn @ np.array(seen) > 0.9


def test_pictures_are_drawn_to_scale(folder):
    """Extent of the opaque pixels against that of the projected block."""
    results = read(folder)
    scene = frames.make_scene(results)
    group = scene.group([8], ghost=False, pixels=600)
    with frames.renderer() as renderer:
        renderer.draw(scene, group)
        ((image,),) = renderer.drawn()
    opaque = (image < 250).any(axis=-1)
    columns, rows = np.flatnonzero(opaque.any(axis=0)), np.flatnonzero(opaque.any(axis=1))
    low, high = group.low, group.high
    pixel = (high[0] - low[0]) / image.shape[1]
    margin = 0.04 / 1.08 * (high - low).max()  # at most: the frame's margin on either side
    drawn = np.array([np.ptp(columns) + 1, np.ptp(rows) + 1]) * pixel
    exact = scene.view.project(
        np.vstack([
            (results.points + results.field(8, "displacement")) * (1, sign, 1) for sign in (1, -1)
        ])
    )  # fmt: skip
    assert drawn == pytest.approx(np.ptp(exact, axis=0), abs=3 * pixel)
    assert columns[0] * pixel == pytest.approx(margin, rel=0.1)


def test_picture_files_show_colours_on_white(folder):
    for name, width in (("states.png", 1200), ("shape.png", 700), ("curve.png", 1200)):
        with Image.open(folder / name) as image:
            assert image.width >= width
            pixels = np.asarray(image.convert("RGB"), float)
        white = (pixels > 250).all(axis=2).mean()
        coloured = (np.ptp(pixels, axis=2) > 60).mean()
        assert 0.3 < white < 0.99
        assert coloured > (0.002 if name == "curve.png" else 0.05)


def test_obstacles_are_drawn(tmp_path):
    """An obstacle stands beside each state where its columns say, and is left out when removed."""
    directory = tmp_path / "beam"
    bent_beam.write(directory, 90.0, 2)
    text = (directory / "spec.yaml").read_text()
    block = "{type: block, center: [60 mm, 0 mm, -9 mm], size: [10 mm, 30 mm, 4 mm]}"
    (directory / "spec.yaml").write_text(f"{text}obstacles:\n  cell: {block}\n")
    table = (directory / "curve.csv").read_text().splitlines()
    columns = ["obstacle_cell_x_mm,obstacle_cell_y_mm,obstacle_cell_z_mm,contact_gap_cell_mm"]
    columns += ["0,0,-3,0.5"] * (len(table) - 2) + [",,,"]
    rows = [f"{row},{more}" for row, more in zip(table, columns, strict=True)]
    (directory / "curve.csv").write_text("\n".join(rows) + "\n")
    (body,) = obstacles.bodies(read(directory), np.zeros(3), np.full(3, 100.0))
    np.testing.assert_allclose(np.ptp(body.points, axis=0), [10, 30, 4])
    np.testing.assert_allclose(body.at(0)[:, 2].min(), -9 - 2 - 3)
    last = len(table) - 2
    assert body.seen(0) and not body.seen(last)
    (drawn,) = viewer.pack(read(directory))["bodies"]
    assert drawn["there"][-1] is False and drawn["shift"][-2][2] == -3

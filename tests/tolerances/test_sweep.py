"""A sweep of a spec's tolerances, from its command to its table and page."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from softact.cli.main import main

SPEC = """
name: bar
geometry: {type: block, length: 8 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 20 kPa}}
supports: [{surface: x_min, fix: [x]}, {surface: y_min, fix: [y]}, {surface: z_min, fix: [z]}]
solver: {initial_increment: 1, max_increment: 1}
measures: [tip]
steps: [{name: pull, traction: {surface: x_max, value: [10 kPa, 0 kPa, 0 kPa]}}]
tolerances: {geometry.length: 0.2 mm, materials.body.c10: 4 %}
"""


def stretch(c10: float, stress: float = 10.0) -> float:
    """λ of an incompressible bar: nominal stress = 2 c10 (λ − λ⁻²)."""
    return next(
        float(r.real)
        for r in np.roots([2 * c10, -stress, 0.0, -2 * c10])
        if abs(r.imag) < 1e-9 and r.real > 0
    )


def test_samples_and_first_order_agree_with_a_bar_that_is_pulled(tmp_path, capfd):
    """tip_x, its place, is λ L; the bar is incompressible to the digits that count here."""
    (tmp_path / "bar.yaml").write_text(SPEC, encoding="utf-8")
    text = "name: sample\nbase: bar.yaml\ndesign: {kind: tolerances, samples: 8, seed: 2}\n"
    (tmp_path / "sample.yaml").write_text(text, encoding="utf-8")
    words = ["sweep", str(tmp_path / "sample.yaml"), "-o", str(tmp_path / "out"), "-j", "1",
             "--cache", str(tmp_path / "cache")]  # fmt: skip
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 0
    said = "".join(capfd.readouterr())
    with (tmp_path / "out/tolerances.csv").open(encoding="utf-8") as file:
        (line,) = (x for x in csv.DictReader(file) if x["measure"] == "tip_x_mm")
    change = (stretch(20.2) - stretch(19.8)) / 0.4
    exact = np.hypot(stretch(20.0) * 0.2, 8 * change * 0.8)
    first = float(line["standard_deviation_first_order"])
    assert first == pytest.approx(exact, rel=0.01)
    with (tmp_path / "out/sweep.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    drawn = [
        stretch(float(row["materials.body.c10_kPa"])) * float(row["geometry.length_mm"])
        for row in rows
    ]
    # What is computed is what was drawn, and what is told of the samples is what was computed.
    assert [float(row["tip_x_mm"]) for row in rows] == pytest.approx(drawn, rel=5e-3)
    assert float(line["standard_deviation_samples"]) == pytest.approx(
        np.std(drawn, ddof=1), rel=0.02
    )
    assert "second order" not in said
    page = (tmp_path / "out/sweep.html").read_text(encoding="utf-8")
    assert "Tolerances: first order and samples" in page
    assert "differ by no more than a fifth" in page

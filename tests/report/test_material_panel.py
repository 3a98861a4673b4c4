"""Materials on the page: the law's curve, how far it was tested, where the run went."""

import numpy as np
import pytest

from softact.errors import SpecError
from softact.report import material_panel
from softact.results.folder import read
from softact.results.writer import ResultsWriter
from tests import bent_beam

SPEC = """
name: bar
geometry: {type: pneunet}
materials:
  body: {law: neo_hookean, c10: 0.2 MPa, poissons_ratio: 0.4999, name: rubber,
         stretch_range: [1.0, 1.5]}
steps: [{name: pull, pressure: 1 kPa}]
"""


def folder(path, stretch_of, spec=SPEC):
    points, cells, surfaces = bent_beam.mesh()
    writer = ResultsWriter(path, spec, {})
    writer.mesh(points, cells, np.zeros(len(cells)), ["body"], surfaces, bent_beam.LAYOUT)
    fields = {"displacement": np.zeros_like(points), "max_principal_stretch": stretch_of(points)}
    writer.increment({"step": "pull", "step_fraction": 1.0}, fields)
    writer.finish("complete")
    return read(path)


def linear(points):
    """1 at the clamp to 2 at the tip."""
    return 1 + points[:, 0] / bent_beam.LENGTH


def test_the_curve_is_the_laws_and_the_bars_are_the_volume(tmp_path):
    results = folder(tmp_path / "r", linear)
    (section,) = material_panel.sections(results)
    assert "rubber" in section.body and "neo hookean" in section.body and "1.5" in section.body
    law = material_panel._laws(results)["body"]
    cells = results.cells
    at, part = material_panel._stretches(results, cells, linear(results.points))
    bars, curve, node = material_panel._plot("body", law, at, part, 2.0).traces
    stretch, stress = (np.array(curve[axis]) for axis in "xy")
    # Of a bar of nearly constant volume: 2 c10 (l - 1/l^2).
    np.testing.assert_allclose(stress, 0.4 * (stretch - stretch**-2), atol=2e-4)
    assert (node["x"][0], node["y"][0]) == pytest.approx((2.0, 0.7), abs=1e-3)
    assert sum(bars["y"]) == pytest.approx(100.0, abs=1e-3)
    middle = np.dot(bars["x"], bars["y"]) / 100
    assert middle == pytest.approx(1.5, abs=0.005)  # the channel is in the middle, too


def test_a_spec_that_cannot_be_read_is_told(tmp_path):
    results = folder(tmp_path / "r", linear, "name: bar\n")
    with pytest.raises(SpecError, match="The materials are missing"):
        material_panel.sections(results)

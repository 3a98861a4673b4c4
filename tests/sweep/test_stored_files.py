"""Every file in configs/sweeps can be run: its specs are right, and its measures are columns."""

from pathlib import Path

import pytest

from softact import spec as specs
from softact.files import document
from softact.measured.curve import run_columns
from softact.optimise.spec import Optimisation
from softact.sweep.points import Plan, changes_of, spec_at
from softact.sweep.spec import Sweep, read

CONFIGS = Path(__file__).parents[2] / "configs"
FILES = sorted((CONFIGS / "sweeps").glob("*.yaml"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_points_are_right_and_measures_known(path):
    model = Optimisation if "parameters" in document.read(path).data else Sweep
    study, base = read(path, model)
    if model is Sweep:
        points = Plan(base).points(study.axes, study.design.points(study.axes))
        assert points and not [fault for point in points for fault in point.faults]
        spec, measures = spec_at(base, points[0].changes), [t.measure for t in study.trends]
    else:
        spec = spec_at(base, changes_of(study.parameters, study.reference))
        measures = [part.measure for part in (*study.objectives, *study.constraints)]
    assert set(measures) <= set(run_columns(spec))


def test_the_gloves_reference_is_the_published_finger():
    """So the optimisation beats the finger of pneunet_glove.yaml, whose chambers and length stay
    as they are there."""
    study, base = read(CONFIGS / "sweeps" / "pneunet_glove_optimise.yaml", Optimisation)
    published = specs.load(CONFIGS / "pneunet_glove.yaml").geometry
    reference = spec_at(base, changes_of(study.parameters, study.reference)).geometry
    coarse = {"mesh_size": published.mesh_size}
    assert reference.model_copy(update=coarse) == published
    varied = {path for path, _ in changes_of(study.parameters, study.reference)}
    assert not varied & {"geometry.chambers", "geometry.length", "geometry.base"}

"""A finger, solved coarsely under three forces on its tip, and its reduced model."""

import pytest
import yaml

from softact import spec as specs
from softact.export import job
from softact.results.folder import read
from softact.run import start as runs

FORCES = ("-50 mN", "0 N", "50 mN")
FINGER = """
name: short-finger
geometry: {type: pneunet, chambers: 3, chamber_length: 7 mm, mesh_size: 8 mm}
materials: {body: elastosil-m4601}
contact: none  # touching walls make kinks, which a reduced model rounds off
layers:
  - {surface: strain_limiting_layer, thickness: 0.1 mm, material: paper}
steps:
  - {name: gravity, gravity: [0, 0, -1]}
  - {name: load, payload: {force: [0 N, 0 N, FORCE]}, max_increment: 0.5}
  - {name: inflate, pressure: 24 kPa, max_increment: 0.25}
"""


@pytest.fixture(scope="session")
def solved(tmp_path_factory):
    """Results of the finger under FORCES."""
    folder, found = tmp_path_factory.mktemp("fingers"), []
    for number, force in enumerate(FORCES):
        spec = specs.loads(yaml.safe_dump(yaml.safe_load(FINGER.replace("FORCE", force))))
        outcome = runs.run(spec, folder / str(number), report=False)
        assert outcome.status == "complete", outcome.message
        found.append(read(folder / str(number)))
    return found


@pytest.fixture(scope="session")
def prepared(solved):
    """The ``Job`` of all three runs."""
    return job.prepare(solved)

"""Runs that are made up, by the closed form of tests/bent_beam.py: the angle is given."""

from tests import bent_beam

CUBE = """
base:
  geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
  materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
  steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]
  solver: {initial_increment: 1, max_increment: 1}
"""


def angle(spec):
    """The angle that is made up for a spec, degrees: 10 for each mm of length."""
    return 10.0 * spec.geometry.length


def instead_of_run(spec, directory, status="complete", **options):
    """Stands in for ``softact.run.start.run``: a result folder without a solver."""
    bent_beam.write(directory, angle(spec), 4, status, {"nx": 6, "ny": 2, "nz": 7})

"""A core that slides in its shell: a solid and sheets in one spec, run by the command."""

import h5py
import numpy as np
import pytest

from softact.errors import SoftactError
from softact.report.body import mass
from softact.results.folder import read
from softact.run.start import run
from softact.spec import load

SPEC = """
geometry:
  {{type: shell_reinforced, shell: {shell}, cuts: 2, length: 34 mm, slit: 4 mm, mesh_size: 7 mm}}
materials: {{body: ecoflex-00-30}}
{made_of}
steps:
  - {{name: inflate, pressure: 3 kPa}}
"""
BONDED = "layers: [{surface: shell, thickness: 0.1 mm, material: pet}]"
SLIDING = """
sheets:
  shell: &pet {plies: [{material: pet, thickness: 0.1 mm}], wrinkling: resolved, bending: 1}
  glued: *pet
contact: [{between: [outer, shell], friction: 0.2, distance: 0.005 mm}]
solver: {curved: false}
"""


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Result folders of the same actuator with a bonded shell and with a sliding one."""
    folder, found = tmp_path_factory.mktemp("sliding"), {}
    for shell, made_of in (("bonded", BONDED), ("sliding", SLIDING)):
        spec = folder / f"{shell}.yaml"
        spec.write_text(SPEC.format(shell=shell, made_of=made_of))
        assert run(load(str(spec)), folder / shell).status == "complete"
        found[shell] = read(folder / shell)
    return found


def test_a_shell_that_bends_along_a_curved_wall_is_refused(tmp_path):
    """Its bending is that of flat sides of the mesh; the line says how to have these."""
    made_of = SLIDING.replace("solver: {curved: false}", "")
    (tmp_path / "spec.yaml").write_text(SPEC.format(shell="sliding", made_of=made_of))
    with pytest.raises(SoftactError, match=r"'shell'.* write curved: false under solver"):
        run(load(str(tmp_path / "spec.yaml")), tmp_path / "out")


def test_it_bends_further_than_a_bonded_one(runs):
    """The bonded core can stretch in the slits alone; the free one has all its length for it."""
    bonded, sliding = (runs[name].summary["bending_angle_deg"] for name in ("bonded", "sliding"))
    assert sliding > 1.2 * bonded > 1.0


def test_stress_of_core_and_shell(runs):
    """Two orders apart, as in Agarwal et al. 2016, Fig. 2; hoop stress of the rings p r/t."""
    summary = runs["sliding"].summary
    shell, core = summary["max_von_mises_shell_MPa"], summary["max_von_mises_body_MPa"]
    assert shell > 50 * core
    assert shell > 3e-3 * 11 / 0.1
    assert summary["max_von_mises_MPa"] == pytest.approx(max(shell, core), rel=1e-6)


def test_the_shell_slides(runs):
    """At the open end of the bent side, the core comes out of its shell; at the strip, which is
    glued, both are one."""
    results = runs["sliding"]
    moved = results.field(-1, "displacement")
    shell = np.unique(results.surfaces["shell"])
    shell = shell[shell > results.cells.max()]
    core = np.arange(results.cells.max() + 1)
    places = results.points
    apart = np.linalg.norm(places[shell, None] - places[core], axis=2)
    twin = core[apart.argmin(axis=1)]
    slip = np.linalg.norm(moved[shell] - moved[twin], axis=1)
    top = (places[shell, 2] > 10) & (places[shell, 0] > 30)
    assert slip[top].max() > 0.03  # the elastic stick is 0.02 mm at most
    glued = np.unique(results.surfaces["glued"])
    assert glued.max() <= results.cells.max()


def test_what_is_written(runs):
    """ParaView's file holds tets and triangles; the mass is that of
    the core and of the film."""
    results = runs["sliding"]
    triangles = sum(len(results.surfaces[name]) for name in ("shell", "glued"))
    text = (results.directory / "fields.xdmf").read_text()
    assert f'TopologyType="Mixed" NumberOfElements="{len(results.cells) + triangles}"' in text
    with h5py.File(results.directory / "fields.h5") as file:
        mixed, part = file["mesh/mixed"][()], file["mesh/part"][()]
    tets = mixed[: 11 * len(results.cells)].reshape(-1, 11)
    sheets = mixed[11 * len(results.cells) :].reshape(-1, 7)
    assert (tets[:, 0] == 38).all() and (sheets[:, 0] == 36).all()  # XDMF's tet_10 and tri_6
    np.testing.assert_array_equal(tets[:, 1:], results.cells)
    assert len(sheets) == triangles
    assert np.bincount(part).tolist() == [
        len(results.cells), *(len(results.surfaces[name]) for name in ("shell", "glued")),
    ]  # fmt: skip
    film = 2 * sum(
        np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        for a, b, c in (
            np.moveaxis(results.points[results.surfaces[n][:, :3]], 1, 0)
            for n in ("shell", "glued")
        )
    )
    # PET 1380 kg/m³ on the card; the core's 1070 kg/m³.
    solid = mass(runs["bonded"])
    assert mass(results) == pytest.approx(solid + film * 0.1 * 1380e-9, rel=1e-3)
    assert (results.directory / "report.html").is_file()

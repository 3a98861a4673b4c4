"""The order of the tests, one headless Chromium for all tests of pages, and the folder of the tests
of the report."""

import os
from pathlib import Path

import pytest

from softact.system import blas

os.environ.update(blas.variables())  # for the processes of xdist, in which tests solve
pytest.register_assert_rewrite("tests.browsing")

from softact.report import write_report  # noqa: E402
from tests import bent_beam, browsing  # noqa: E402

# Modules that solve much, start many processes or wait: after all others, so that a fault that a
# cheap test sees is seen early; the longest first, so that two processes end at the same time.
SLOW = """
house/test_killed_studies contact/test_nothing_passes run/test_killed run/test_resume
run/test_run contact/test_contact_on_two run/test_resume_loads run/test_resume_in_time
solve/test_dynamics geometries/test_slow_pneunet contact/test_rigid_contact
contact/test_ironing contact/test_rolling
geometries/test_knit_strips sheets/test_inflated_sheets contact/test_sheet_contact
house/test_fuzz house/test_contributing house/test_isolation geometries/test_woven_contracting
geometries/test_woven_bending geometries/test_woven_elongating geometries/test_woven_stiffening
geometries/test_sliding_shell contact/test_sheet_friction contact/test_surface_contact
sheets/test_inflated_beam sheets/test_sheets solve/test_volume_control solve/test_diagnosis
house/test_invariants loads/test_load_cases bodies/test_soundness sweep/test_cli
sweep/test_cluster sweep/test_faults sweep/test_inputs check/test_check converge/test_converge
optimise/test_optimise analytic/test_viscoelastic loads/test_air analytic/test_calculix
analytic/test_thick_walls analytic/test_homogeneous analytic/test_fibres analytic/test_beams
fit/test_calibrate fit/test_every_start system/test_jit geometries/test_every_geometry
geometries/test_refinement geometries/test_imported sensitivities/test_runs
sensitivities/test_whole_runs sensitivities/test_closed_forms geometry/test_field_files
report/test_study_pages_browser report/test_pages_browser report/test_report_browser
report/test_animation export/test_formats estimate/test_estimate test_api starter/test_starter
preview/test_preview geometries/test_from_mesh geometries/test_step_slivers
geometries/test_bending_tube geometries/test_own_parts cli/test_progress
modules/test_wound_chain modules/test_round_chains modules/test_box_chains modules/test_command
sweep/test_modules run/test_staying
modules/test_tube modules/test_antagonistic modules/test_sheet_chains modules/test_walker
house/test_tutorials geometries/test_five_files geometries/test_gripper
modules/test_segments modules/test_imported_module
contact/test_free_bodies contact/test_resting_bodies contact/test_mesh_obstacles
contact/test_free_bodies_on_two run/test_gripper_lifts_ball
""".split()


def pytest_configure(config):
    """xdist keeps to the order below, instead of beginning with the files of the most tests."""
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False


def pytest_collection_modifyitems(items):
    """Put the slow modules last."""
    place = {name: number for number, name in enumerate(SLOW, 1)}
    here = Path(__file__).parent
    items.sort(
        key=lambda item: place.get(item.path.relative_to(here).with_suffix("").as_posix(), 0)
    )


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """A ``browsing.Browser``."""
    started = browsing.start(tmp_path_factory.mktemp("chromium"))
    try:
        yield started
    finally:
        started.quit()


@pytest.fixture(scope="module")
def reported_beam(tmp_path_factory):
    """Result folder of a block bent to ``bent_beam.ANGLE``, with its report."""
    directory = tmp_path_factory.mktemp("report") / "beam"
    bent_beam.write(directory, bent_beam.ANGLE, bent_beam.INCREMENTS)
    write_report(directory)
    return directory

"""One headless Chromium for all tests of pages, and the folder of the tests of the report."""

import pytest

pytest.register_assert_rewrite("tests.browsing")

from softact.report import write_report  # noqa: E402
from tests import bent_beam, browsing  # noqa: E402


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

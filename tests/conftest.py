"""One headless Chromium for all tests of pages."""

import pytest

pytest.register_assert_rewrite("browsing")

import browsing  # noqa: E402


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    """A ``browsing.Browser``."""
    started = browsing.start(tmp_path_factory.mktemp("chromium"))
    try:
        yield started
    finally:
        started.quit()

"""What tests of pages share: a browser."""

import pytest

from pages.chromium import Browser, executable


@pytest.fixture(scope="session")
def browser():
    """A browser for all tests of pages; they are skipped where none is installed."""
    path = executable()
    if path is None:
        pytest.skip("no chromium is installed; $CHROMIUM may name one")
    with Browser(path) as browser:
        yield browser

"""The command line without the wait: results are made up, and what was asked for is remembered."""

import pytest
from computed import stand_in


@pytest.fixture
def computed(monkeypatch, tmp_path):
    """The command line with made-up results, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return stand_in(monkeypatch)

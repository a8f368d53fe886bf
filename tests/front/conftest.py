"""The command line without the wait: results are made up, and what was asked for is remembered."""

import pytest
from computed import stand_in


@pytest.fixture
def computed(monkeypatch, tmp_path):
    """The command line with made-up results, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return stand_in(monkeypatch)


@pytest.fixture
def no_figures(monkeypatch):
    """Commands write small files in place of figures, for tests of what else they write."""
    monkeypatch.setattr(
        "jaxbuffer.output.style.both",
        lambda name, draw: {f"{name}.png": lambda: b"\x89PNG", f"{name}.svg": lambda: b"<svg/>"},
    )

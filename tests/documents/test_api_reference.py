"""The reference of the documentation: every public name has an entry, and every entry says something."""

import importlib.util
from pathlib import Path
from types import SimpleNamespace

import pytest

import jaxbuffer as jb

FILE = Path(__file__).parents[2] / "docs" / "_ext" / "reference.py"


@pytest.fixture
def reference(monkeypatch):
    """The extension, with its warnings in a list."""
    spec = importlib.util.spec_from_file_location("reference", FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.said = []
    monkeypatch.setattr(module.LOGGER, "warning", lambda text, *names: module.said.append(text % names))
    return module


def test_a_public_name_without_an_entry_is_warned_of(reference):
    entries = {f"jaxbuffer.{name}": None for name in jb.__all__ if name != "tune"}
    reference.complete(None, SimpleNamespace(get_domain=lambda _: SimpleNamespace(objects=entries)))
    assert reference.said == ["jaxbuffer.tune is public, and docs/api has no entry of it"]


def test_an_entry_without_a_docstring_is_warned_of(reference):
    reference.docstring(None, "function", "jaxbuffer.tune", jb.tune, None, ["Tune it."])
    assert not reference.said
    reference.docstring(None, "function", "jaxbuffer.tune", jb.tune, None, ["", " "])
    assert reference.said == ["jaxbuffer.tune has an entry in the reference, and no docstring"]

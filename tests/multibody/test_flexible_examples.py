"""The examples in the docstrings of `multibody.flexible` run."""

import doctest
import importlib
import pkgutil

import pytest

from jaxbuffer.multibody import flexible

MODULES = [module.name for module in pkgutil.iter_modules(flexible.__path__)]


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name):
    failed, tried = doctest.testmod(importlib.import_module(f"{flexible.__name__}.{name}"))
    assert not failed
    assert tried or name not in ("bar", "bars", "damping", "plates")

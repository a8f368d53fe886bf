"""Examples in the docstrings of rooms whose names are not among the package's own."""

import doctest
import importlib
import pkgutil

import jax.numpy as jnp
import pytest

import jaxbuffer

ROOMS = ("composites", "shock", "structures")
MODULES = [
    module.name
    for room in ROOMS
    for module in pkgutil.walk_packages(importlib.import_module(f"jaxbuffer.{room}").__path__, f"jaxbuffer.{room}.")
]


def examples(name):
    module = importlib.import_module(name)
    room = importlib.import_module(".".join(name.split(".")[:2]))
    names = {**vars(room), **vars(module), "jnp": jnp, "jb": jaxbuffer}
    return [test for test in doctest.DocTestFinder(exclude_empty=True).find(module, globs=names) if test.examples]


@pytest.mark.parametrize("name", [name for name in MODULES if examples(name)])
def test_examples_run(name):
    for test in examples(name):
        said: list[str] = []
        doctest.DocTestRunner(verbose=False).run(test, out=said.append)
        assert not said, "".join(said)


def test_there_are_some_in_each_room():
    assert {name.split(".")[1] for name in MODULES if examples(name)} == set(ROOMS)

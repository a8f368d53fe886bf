"""Which values of a parameter `make test` takes."""

from collections.abc import Callable, Iterable
from typing import Any

import pytest


def quick(values: Iterable[Any], *chosen: Any, names: Callable[[Any], Any] = lambda value: value) -> list[Any]:
    """Return the values as parameters of a test, of which all but those that are ``chosen``, by name, are slow; a tuple
    is the values of several parameters."""
    values = list(values)
    assert set(chosen) <= set(map(names, values)), "each of those chosen is a value"
    each = [value if isinstance(value, tuple) else (value,) for value in values]
    marks = [() if names(value) in chosen else pytest.mark.slow for value in values]
    return [pytest.param(*parts, marks=mark) for parts, mark in zip(each, marks, strict=True)]

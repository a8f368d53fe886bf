"""Which values of a parameter `make test` takes, and which `make test-slow`."""

from collections.abc import Callable, Iterable
from typing import Any

import pytest


def quick(values: Iterable[Any], *chosen: Any, names: Callable[[Any], Any] = lambda value: value) -> list[Any]:
    """Return the values as parameters of a test, of which all but those that are ``chosen``, by name, are slow; a tuple
    is the values of several parameters."""
    return _marked(values, chosen, names, pytest.mark.slow)


def often(values: Iterable[Any], *chosen: Any, names: Callable[[Any], Any] = lambda value: value) -> list[Any]:
    """Return the values as parameters of a slow test, of which all but those that are ``chosen`` are long."""
    return _marked(values, chosen, names, pytest.mark.long)


def _marked(values: Iterable[Any], chosen: Iterable[Any], names: Callable[[Any], Any], mark: Any) -> list[Any]:
    values = list(values)
    assert set(chosen) <= set(map(names, values)), "each of those chosen is a value"
    each = [value if isinstance(value, tuple) else (value,) for value in values]
    return [
        pytest.param(*parts, marks=() if names(value) in chosen else mark)
        for value, parts in zip(values, each, strict=True)
    ]

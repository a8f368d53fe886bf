"""Numbers of parts: an array of one entry where one number belongs is that number."""

import functools
import typing
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np

T = TypeVar("T")


def with_scalars(part: T) -> T:
    """Return a part, or several, whose one-entry arrays are plain numbers wherever their classes declare a number.

    Most operations broadcast such arrays, so that a run would be right, and whatever needs a number after it would
    fail: stacks of rows, drawings, records.
    """
    leaves, structure = jax.tree_util.tree_flatten_with_path(part)
    return jax.tree_util.tree_unflatten(structure, [_number(part, path, leaf) for path, leaf in leaves])


def _number(part: Any, path: tuple[Any, ...], leaf: Any) -> Any:
    """Return a leaf, as a number if its field is one."""
    if np.ndim(leaf) == 0 or np.size(leaf) != 1 or not _is_number(part, path):
        return leaf
    return jnp.reshape(leaf, ()) if isinstance(leaf, jax.Array) else np.reshape(leaf, ())[()]


def _is_number(part: Any, path: tuple[Any, ...]) -> bool:
    """Return whether the field that a leaf stands in is declared as a number or as several of them."""
    owner: type | None = None
    field, here = "", part
    for key in path:
        if isinstance(key, jax.tree_util.GetAttrKey):
            owner, field, here = type(here), key.name, getattr(here, key.name)
        elif isinstance(key, jax.tree_util.SequenceKey):
            here = here[key.idx]
        else:  # no point or tuple of numbers, such as a mapping
            return False
    return owner is not None and field in _numbers(owner)


@functools.cache
def _numbers(kind: type) -> frozenset[str]:
    """Return the fields of a class that are declared as a number: `Scalar`, or a point of such, or None beside it."""
    return frozenset(name for name, annotation in typing.get_type_hints(kind).items() if _has_number(annotation))


def _has_number(annotation: Any) -> bool:
    return annotation is float or any(_has_number(it) for it in typing.get_args(annotation))

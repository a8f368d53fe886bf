"""What XLA's compiler would evaluate again and again, evaluated once."""

from typing import Any, TypeVar

import jax
from jax import lax

T = TypeVar("T")


def evaluated_once(values: T) -> T:
    """Return the same numbers, each of which a compiled program computes once.

    XLA puts cheap operations into each of the loops that use their result, and so evaluates and compiles them anew,
    whole chains of them; but it never does so with a division by what it cannot know to be one. It pays where a chain
    is long and its result is used in many places.

    **Arguments:** ``values``: a tree of floating-point arrays; Python's numbers in it stay as they are. What is
    infinite becomes NaN.
    """

    def divided_by_one(value: Any) -> Any:
        # Held fixed, the divisor keeps what is linear in something linear.
        return value / (1.0 + 0.0 * lax.stop_gradient(value)) if isinstance(value, jax.Array) else value

    return jax.tree.map(divided_by_one, values)

"""How the runs of a `vmap` are stepped: on a CPU one after the other, on an accelerator all together."""

from collections.abc import Callable
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jax.custom_batching import custom_vmap, sequential_vmap
from jaxtyping import Array, Bool


def in_turn() -> bool:
    """Return whether the runs of a `vmap` are stepped one after the other: on a CPU, where none then waits for the
    slowest; on an accelerator all are stepped together."""
    return jax.default_backend() == "cpu"


def one_by_one(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call ``function``; under `vmap` for one batch element after the other where that is to be."""
    arrays, static = eqx.partition(arguments, eqx.is_array)

    def call(arrays: Any) -> Any:
        return function(*eqx.combine(arrays, static))

    return sequential_vmap(call)(arrays) if in_turn() else call(arrays)


@custom_vmap
def in_any_lane(condition: Bool[Array, ""]) -> Bool[Array, ""]:
    """Return whether a condition holds in any of the lanes of a `vmap`: one answer for all of them."""
    return condition


# One answer for all lanes keeps the condition of a `while_loop` unbatched (see `loop._iterate_where_running`).
@in_any_lane.def_vmap
def _in_any_lane(size: int, batched: list[bool], condition: Array) -> tuple[Array, bool]:
    return in_any_lane(jnp.any(condition, axis=0) if batched[0] else condition), False

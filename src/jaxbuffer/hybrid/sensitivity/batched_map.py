"""A linear map of many scalars on several vectors at once.

The linearised right-hand side, as JAX traces it, is a graph of some thousand sums and products. Here each of its
scalars becomes a vector with one entry for each sensitivity row, for which the compiler has vector instructions.
"""

from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .graph import Vertex, scaled
from .linear_map import read
from .stored import Store

USED_OFTEN = 2  # users from which on a vector is stored rather than evaluated anew for each


def on_columns(linear: Callable[..., Array], *examples: Any) -> Callable[..., Float[Array, "out columns"]]:
    """Apply a linear map to several vectors at once.

    **Arguments:** ``linear``: a linear function of trees of arrays to one array, such as `jax.linearize` gives;
    ``examples``: arguments of the right shapes. **Returns:** a function of trees of the same structure, each array with
    a trailing axis of columns, to the columns of each number of the output. **Raises:** `Unsupported`.
    """
    inputs, output = read(linear, *examples)
    results = list(np.ravel(output))
    order = _needed(vertex for vertex in results if vertex is not None)
    users = Counter(source for vertex in order for source in vertex.sources)

    def multiplied(*arguments: Any) -> Float[Array, "out columns"]:
        vectors: dict[Vertex, Array] = {}
        example = jax.tree.leaves(arguments)[-1]
        zero, stored = jnp.zeros(example.shape[-1]), Store.of(example)
        for vertices, leaf in zip(inputs, jax.tree.leaves(arguments), strict=True):
            for vertex, vector in zip(vertices.ravel(), jnp.reshape(leaf, (-1, leaf.shape[-1])), strict=True):
                vectors[vertex] = vector
        for vertex in order:
            if vertex in vectors:
                continue
            terms = [scaled(coefficient, vectors[source]) for source, coefficient in vertex.sources.items()]
            vectors[vertex] = sum(terms[1:], terms[0])
            if users[vertex] >= USED_OFTEN:
                vectors[vertex] = stored(vectors[vertex])
        return jnp.stack([zero if vertex is None else vectors[vertex] for vertex in results])

    return multiplied


def _needed(results: Iterable[Vertex]) -> list[Vertex]:
    """Return the results and all that they are made from, sources first."""
    needed, stack = set[Vertex](), list(results)
    while stack:
        vertex = stack.pop()
        if vertex not in needed:
            needed.add(vertex)
            stack += vertex.sources
    return sorted(needed, key=lambda vertex: vertex.number)

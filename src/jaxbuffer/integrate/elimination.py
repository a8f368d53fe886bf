"""A linear map of many scalars, made short by eliminating what lies between its inputs and outputs.

The linearised right-hand side, as JAX traces it, is a graph of some thousand sums and products, run through anew for
each sensitivity row. Most of its vertices have one edge in or one out: multiplying their edges together, once for all
rows, leaves a quarter of the edges (vertex elimination: Griewank and Walther, Evaluating Derivatives, 2008, chapter 9).
What is left are sums of scalars times lanes, one lane a row, which the compiler turns into vector instructions.
"""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .reading import read
from .vertices import Vertex, scaled

MORE_EDGES = 4  # that eliminating a vertex may add: it makes the graph shallower
USED_OFTEN = 3  # times, from which on a lane is kept rather than evaluated anew


def eliminated(linear: Callable[..., Array], *examples: Any) -> Callable[..., Float[Array, "out lanes"]]:
    """The same linear map on lanes, with the edges that are left.

    **Arguments:** ``linear``: a linear function of trees of arrays to one array, such as `jax.linearize` gives;
    ``examples``: arguments of the right shapes. **Returns:** a function of trees of the same structure, each array with
    a trailing axis of lanes, to the lanes of each number of the output. **Raises:** `Unsupported`.
    """
    inputs, output = read(linear, *examples)
    results = list(np.ravel(output))
    order = _eliminate([v for leaf in inputs for v in leaf.ravel()], [v for v in results if v is not None])

    def on_lanes(*arguments: Any) -> Float[Array, "out lanes"]:
        lanes: dict[Vertex, Array] = {}
        example = jax.tree.leaves(arguments)[-1]
        zero, one = jnp.zeros(example.shape[-1]), 1.0 + 0.0 * example.ravel()[0]  # which XLA cannot know
        for vertices, leaf in zip(inputs, jax.tree.leaves(arguments), strict=True):
            for vertex, lane in zip(vertices.ravel(), jnp.reshape(leaf, (-1, leaf.shape[-1])), strict=True):
                lanes[vertex] = lane
        for vertex in order:
            terms = [scaled(coefficient, lanes[source]) for source, coefficient in vertex.sources.items()]
            lanes[vertex] = sum(terms[1:], terms[0])
            if len(vertex.users) >= USED_OFTEN:  # XLA evaluates sums and products anew for every user, but no division
                lanes[vertex] = lanes[vertex] / one
        return jnp.stack([zero if vertex is None else lanes[vertex] for vertex in results])

    return on_lanes


def _eliminate(inputs: Sequence[Vertex], results: Sequence[Vertex]) -> list[Vertex]:
    """Take out the vertices in between, but those that leave many more edges; those that stay, sources first."""
    order: dict[Vertex, None] = {}
    keep = {*inputs, *results}

    def visit(vertex: Vertex) -> None:
        stack = [(vertex, iter(vertex.sources))]
        while stack:
            at, sources = stack[-1]
            following = next((s for s in sources if s not in order), None)
            if following is not None:
                stack.append((following, iter(following.sources)))
                continue
            stack.pop()
            order.setdefault(at)

    for vertex in results:
        visit(vertex)
    for vertex in order:  # what no result uses has no say
        vertex.users = {user: None for user in vertex.users if user in order}
    left = [vertex for vertex in order if vertex not in keep]
    while True:
        chosen = [vertex for vertex in left if vertex.gain >= -MORE_EDGES]
        if not chosen:
            break
        for vertex in chosen:
            if vertex.gain >= -MORE_EDGES:
                vertex.eliminate()
                vertex.sources, vertex.users = {}, {}
                del order[vertex]
        left = [vertex for vertex in left if vertex in order]
    first = set(inputs)
    return [vertex for vertex in order if vertex not in first]

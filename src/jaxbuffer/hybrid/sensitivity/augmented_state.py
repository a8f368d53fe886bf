"""Tangents as extra rows of the state: row 0 is y, row i is ∂y/∂p_i times a scale, all under one error control.

AD through an adaptive loop bounds the error of the state only; carrying S = ∂y/∂p as state bounds its error too
(docs/decisions.md). Every function of (parameters, state) is lifted to rows by one push-forward a row.
"""

from collections.abc import Callable
from typing import Any, Generic, NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import Literal
from jaxtyping import Array, Float

from .batched_map import on_columns
from .linear_map import Unsupported

Rows = Float[Array, "rows state"]
Columns = Float[Array, "state columns"]  # the rows transposed and padded with columns of zeros: what steps work on
VECTOR = 8  # numbers in a vector register: so many columns or a multiple, of few columns half as many
P = TypeVar("P")
S = TypeVar("S")
T = TypeVar("T")


class Tangents(eqx.Module, Generic[P]):
    """Parameters and the directions in which derivatives are wanted: one tangent of the state for each.

    ``primal``: the parameters; ``directions``: the same structure with a leading axis on each array, one entry for
    each direction; None for no tangents.
    """

    primal: P
    directions: P | None = None

    @property
    def count(self) -> int:
        """Return the number of tangents."""
        leaves = jax.tree.leaves(self.directions)
        return leaves[0].shape[0] if leaves else 0

    def start(self, function: Callable[[P], tuple[Float[Array, " state"], T]]) -> tuple[Rows, T]:
        """Return state and tangents of a function of the parameters alone, and what it returns besides the state."""
        if not self.count:
            state, rest = function(self.primal)
            return state[None], rest
        # One push-forward gives both, so that the function itself is evaluated once.
        push = lambda direction: jax.jvp(function, (self.primal,), (direction,), has_aux=True)  # noqa: E731
        state, tangents, rest = jax.vmap(push, out_axes=(None, 0, None))(self.directions)
        return jnp.concatenate([state[None], tangents]), rest

    def lift(self, function: Callable[[P, Array], Float[Array, " out"]]) -> Callable[[Rows], Float[Array, "rows out"]]:
        """Turn f(parameters, state) into a function of rows: its value, and its change along each tangent."""

        def lifted(rows: Rows) -> Float[Array, "rows out"]:
            if not self.count:
                return function(self.primal, rows[0])[None]
            # Linearised once for all tangents, so that the function itself is evaluated once.
            value, push = jax.linearize(function, self.primal, rows[0])
            return jnp.concatenate([value[None], jax.vmap(push)(self.directions, rows[1:])])

        return lifted

    def field(self, function: Callable[[P, Array], Float[Array, " state"]]) -> Callable[[Columns], Columns]:
        """Do as `lift` on columns, with the linear part by `on_columns`: it is most of the cost of a step with
        tangents."""
        if not self.count:
            return lambda columns: function(self.primal, columns[:, 0])[:, None]

        def field(columns: Columns) -> Columns:
            state, padding = columns[:, 0], columns.shape[1] - 1 - self.count
            value, push = jax.linearize(function, self.primal, state)
            widen = lambda x: jnp.moveaxis(jnp.pad(x, [(1, padding)] + [(0, 0)] * (x.ndim - 1)), 0, -1)  # noqa: E731
            directions = jax.tree.map(widen, self.directions)
            try:
                moved = on_columns(push, self.primal, state)(directions, columns)
            except Unsupported:
                # A mechanism of a user may hold any operation: it runs all the same, more slowly.
                moved = jax.vmap(push, in_axes=-1, out_axes=-1)(directions, columns)
            # The linear map has nothing to say about column 0, the state itself.
            return jnp.where(jnp.arange(columns.shape[1]) == 0, value[:, None], moved)

        return field


def columns(rows: Rows) -> Columns:
    """Transpose rows, and pad those with tangents to whole vector registers with columns of zeros."""
    count = rows.shape[0]
    whole = 1 if count == 1 else VECTOR // 2 if count <= VECTOR // 2 else VECTOR
    return jnp.pad(rows, [(0, -count % whole), (0, 0)]).T


class Pushed(NamedTuple):
    """What the loop steps with tangents.

    ``fill`` puts numbers that depend on the parameters into the assembled system; ``tangents``: these numbers, with a
    tangent for each of the parameters that are ``moving``. The system's other numbers stay constant, and the other
    parameters' tangents are zero: they cost nothing in the loop.
    """

    fill: Callable[[list[Array]], Any]
    tangents: Tangents[list[Array]]
    moving: list[int]


def push_through_assembly(
    assemble: Callable[[list[Array]], S],
    motion: Callable[[S], Any],
    values: list[Array],
    sizes: Float[Array, " values"],
) -> Pushed:
    """Push tangents through the assembly of a system once, before the loop.

    **Arguments:** ``assemble``: from parameters to a system; ``motion``: all of a system that tangents are lifted
    through; ``values`` of the parameters, numbers; ``sizes``: how large each one's tangent is.
    """
    system = assemble(values)
    arrays, rest = eqx.partition(system, eqx.is_inexact_array)
    leaves, structure = jax.tree.flatten(arrays)

    def numbers(values: list[Array]) -> list[Array]:
        return jax.tree.leaves(eqx.filter(assemble(values), eqx.is_inexact_array))

    def filled(numbers: list[Array]) -> S:
        return eqx.combine(jax.tree.unflatten(structure, numbers), rest)

    # By the traced operations rather than by values: a derivative may happen to be zero at these parameters alone.
    # A system also holds numbers that its motion does not depend on, those of parts that it has not, say.
    sources, used = _sources(numbers, values), [True] * len(leaves)
    if len(values) >= VECTOR:  # fewer tangents take as long as none, and tracing the motion takes half a second
        used = _used(lambda numbers: motion(filled(numbers)), leaves)
    depending = [i for i, them in enumerate(sources) if them and used[i]]
    moving = sorted({k for i in depending for k in sources[i]})
    own = np.array(moving, int)[:, None] == np.arange(len(values))[None]
    directions = list(jnp.where(own, sizes[None], 0.0).T)

    def pick(values: list[Array]) -> list[Array]:
        picked = numbers(values)
        return [picked[i] for i in depending]

    pushed = jax.vmap(lambda direction: jax.jvp(pick, (values,), (direction,))[1])(directions) if moving else []

    def fill(moved: list[Array]) -> S:
        of = dict(zip(depending, moved, strict=True))
        return filled([of.get(i, leaf) for i, leaf in enumerate(leaves)])

    return Pushed(fill, Tangents([leaves[i] for i in depending], pushed), moving)


def _used(function: Callable[[list[Array]], Any], numbers: list[Array]) -> list[bool]:
    """Return which inputs any output depends on, followed back through the traced operations."""
    traced = jax.make_jaxpr(function)(numbers).jaxpr
    live = {x for x in traced.outvars if not isinstance(x, Literal)}
    for equation in reversed(traced.eqns):
        if not live.isdisjoint(equation.outvars):
            live.update(x for x in equation.invars if not isinstance(x, Literal))
    return [x in live for x in traced.invars]


def _sources(function: Callable[[list[Array]], list[Array]], values: list[Array]) -> list[frozenset[int]]:
    """Return for each output the inputs that it depends on at all, followed through the traced operations."""
    traced = jax.make_jaxpr(function)(values).jaxpr
    of = {variable: frozenset((k,)) for k, variable in enumerate(traced.invars)}
    none = frozenset[int]()
    for equation in traced.eqns:
        them = none.union(*(of.get(x, none) for x in equation.invars if not isinstance(x, Literal)))
        if them:
            of.update(dict.fromkeys(equation.outvars, them))
    return [none if isinstance(x, Literal) else of.get(x, none) for x in traced.outvars]

"""A linear function, as JAX traces it, read number by number into the graph of its scalars."""

from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.extend.core import Literal
from jaxtyping import Array

from .graph import Coefficient, Mask, Vertex


class Unsupported(Exception):
    """The map holds an operation that is not known here."""


def read(linear: Callable[..., Array], *examples: Any) -> tuple[list[np.ndarray], np.ndarray]:
    """Read a linear function, and return the vertices of each array that goes in and of the one that comes out (None
    for zeros there).

    **Arguments:** ``linear``: a linear function of trees of arrays to one array, such as `jax.linearize` gives;
    ``examples``: arguments of the right shapes. **Raises:** `Unsupported`.
    """
    closed = jax.make_jaxpr(linear)(*examples)
    inputs = [_vertices(np.shape(leaf)) for leaf in jax.tree.leaves(examples)]
    (output,) = _traced(closed.jaxpr, closed.consts, inputs)
    return inputs, output


def _vertices(shape: tuple[int, ...]) -> np.ndarray:
    vertices = np.empty(shape, dtype=object)
    for index in np.ndindex(*shape):
        vertices[index] = Vertex()
    return vertices


def _is_linear(value: Any) -> bool:
    """Return whether a value is an array of vertices; None among them is a zero."""
    return isinstance(value, np.ndarray) and value.dtype == object


def _traced(jaxpr: Any, consts: Sequence[Any], arguments: Sequence[Any]) -> list[Any]:
    values: dict[Any, Any] = dict(zip([*jaxpr.constvars, *jaxpr.invars], [*consts, *arguments], strict=True))
    value = lambda x: x.val if isinstance(x, Literal) else values[x]  # noqa: E731
    for equation in jaxpr.eqns:
        given, name = [value(x) for x in equation.invars], equation.primitive.name
        shape = equation.outvars[0].aval.shape
        inner = equation.params.get("jaxpr") or equation.params.get("call_jaxpr")
        # What acts on coefficients alone stays an operation on whole arrays.
        if not any(map(_is_linear, given)):
            outputs = equation.primitive.bind(*given, **equation.params)
            outputs = outputs if equation.primitive.multiple_results else [outputs]
        elif inner is not None and name in CALLS:
            outputs = _traced(inner.jaxpr, inner.consts, given)
        elif name in MOVES:
            outputs = [MOVES[name](given[0], shape, equation.params)]
        elif name in OPERATIONS:
            outputs = [OPERATIONS[name](given, shape, equation.params)]
        else:
            raise Unsupported(name)
        values.update(zip(equation.outvars, outputs, strict=True))
    return [value(x) for x in jaxpr.outvars]


def _each(function: Callable[..., Vertex | None], shape: tuple[int, ...], *arrays: np.ndarray) -> np.ndarray:
    results = np.empty(shape, dtype=object)
    spread = [np.broadcast_to(array, shape) for array in arrays]
    for index in np.ndindex(*shape):
        results[index] = function(*(array[index] for array in spread))
    return results


def _elements(value: Any) -> np.ndarray:
    """Return the numbers of a coefficient array; those known when tracing stay Python numbers."""
    # Zeros and ones known when tracing drop out of the graph (see `_times` and `scaled`).
    known = isinstance(value, (np.ndarray, np.generic, float, int))
    elements = np.empty(np.shape(value), dtype=object)
    for index in np.ndindex(*elements.shape):
        elements[index] = float(np.asarray(value)[index]) if known else value[index] if index else value
    return elements


def _times(vertex: Vertex | None, coefficient: Coefficient) -> Vertex | None:
    if vertex is None or (isinstance(coefficient, float) and coefficient == 0.0):
        return None
    return Vertex((vertex, coefficient))


def _plus(a: Vertex | None, b: Vertex | None) -> Vertex | None:
    if a is None or b is None:
        return a if b is None else b
    return Vertex((a, 1.0), (b, 1.0))


def _multiplied(given: Sequence[Any], shape: tuple[int, ...], _: Any) -> np.ndarray:
    linear, other = given if _is_linear(given[0]) else given[::-1]
    return _each(_times, shape, linear, _elements(other))


def _divided(given: Sequence[Any], shape: tuple[int, ...], _: Any) -> np.ndarray:
    if _is_linear(given[1]):
        raise Unsupported("div by what is linear")
    return _each(_times, shape, given[0], _elements(1.0 / given[1]))


def _zeros_for(value: Any) -> np.ndarray:
    """Return the value, or lifted zeros for a constant: the only one that a linear map can add."""
    return value if _is_linear(value) else np.full(np.shape(value), None, dtype=object)


def _added(given: Sequence[Any], shape: tuple[int, ...], _: Any) -> np.ndarray:
    return _each(_plus, shape, *map(_zeros_for, given))


def _subtracted(given: Sequence[Any], shape: tuple[int, ...], _: Any) -> np.ndarray:
    return _each(lambda a, b: _plus(a, _times(b, -1.0)), shape, *map(_zeros_for, given))


def _selected(given: Sequence[Any], shape: tuple[int, ...], _: Any) -> np.ndarray:
    which, *cases = given
    if len(cases) != 2:
        raise Unsupported("select_n of several cases")
    second = jnp.asarray(which, bool)

    def chosen(off: Vertex | None, on: Vertex | None, flag: Array) -> Vertex | None:
        # A mask and not a factor of zero, which would not switch off an infinite coefficient.
        return _plus(_times(off, Mask(~flag)), _times(on, Mask(flag)))

    return _each(chosen, shape, *map(_zeros_for, cases), _elements(second))


def _summed(given: Sequence[Any], shape: tuple[int, ...], params: Any) -> np.ndarray:
    moved = np.moveaxis(given[0], params["axes"], range(len(params["axes"])))
    total = np.full(shape, None, dtype=object)
    for term in moved.reshape(-1, *shape):
        total = _each(_plus, shape, total, term)
    return total


def _joined(given: Sequence[Any], _: Any, params: Any) -> np.ndarray:
    return np.concatenate([_zeros_for(x) for x in given], axis=params["dimension"])


def _stacked(given: Sequence[Any], _: Any, params: Any) -> np.ndarray:
    return np.stack([_zeros_for(x) for x in given], axis=params["axis"])


def _spread(given: np.ndarray, shape: tuple[int, ...], params: Any) -> np.ndarray:
    full = [1] * len(shape)
    for axis, size in zip(params["broadcast_dimensions"], given.shape, strict=True):
        full[axis] = size
    return np.broadcast_to(given.reshape(full), shape)


def _cut(given: np.ndarray, _: Any, params: Any) -> np.ndarray:
    strides = params["strides"] or [1] * given.ndim
    return given[tuple(map(slice, params["start_indices"], params["limit_indices"], strides))]


CALLS = ("pjit", "jit", "closed_call", "core_call", "custom_jvp_call", "remat", "checkpoint")
MOVES: dict[str, Callable[..., np.ndarray]] = {
    "slice": _cut,
    "broadcast_in_dim": _spread,
    "transpose": lambda given, _, params: given.transpose(params["permutation"]),
    "neg": lambda given, shape, _: _each(lambda v: _times(v, -1.0), shape, given),
    **dict.fromkeys(("squeeze", "reshape", "expand_dims"), lambda given, shape, _: given.reshape(shape)),
    **dict.fromkeys(("copy", "convert_element_type"), lambda given, *_: given),
}
OPERATIONS: dict[str, Callable[..., np.ndarray]] = {
    "mul": _multiplied,
    "div": _divided,
    "add": _added,
    "add_any": _added,
    "sub": _subtracted,
    "select_n": _selected,
    "reduce_sum": _summed,
    "concatenate": _joined,
    "stack": _stacked,
}

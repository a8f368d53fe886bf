"""A function of one run turned into one of several, one in each lane of a vector register.

Every array gets a trailing axis of lanes: what was a number is a vector, for which the compiler has vector
instructions. `jax.vmap` does not do: it moves the axis to the front, writes by scatter where lanes write to different
places (which splits the loop's kernel), and evaluates both branches of every condition.
"""

import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax
from jax.extend.core import Literal
from jaxtyping import Array, Bool, Int

CHEAP = 12  # operations: a branch no longer than this is evaluated without asking whether a lane needs it
FEW = 16  # numbers: of so many one is picked by comparisons, of more by its address
TERMS = 6  # of a reduction that LLVM writes out: of a longer one, innermost, the lanes are no vectors


@jax.jit
def anywhere(flag: Bool[Array, ""]) -> Bool[Array, ""]:
    """Whether it holds in any lane; of a run that is stepped alone: whether it holds."""
    return flag


class Lanes(NamedTuple):
    """A value that differs between lanes, its last axis."""

    array: Array


class Stored(NamedTuple):
    """A buffer for many runs, its first axis: each lane writes to the place of its own run, and nothing reads it."""

    array: Array


class Mapped:
    """Evaluates traced functions in all lanes; ``places``: of each lane's run in `Stored` buffers; ``busy``: which
    lanes have a run."""

    def __init__(self, places: Int[Array, " lanes"], busy: Bool[Array, " lanes"]) -> None:
        self.count, self.places, self.busy = places.shape[0], places, busy

    def call(self, jaxpr: Any, consts: Sequence[Any], arguments: Sequence[Any]) -> list[Any]:
        """What the traced function returns; arguments and results are plain arrays, `Lanes` or `Stored`."""
        values: dict[Any, Any] = dict(zip([*jaxpr.constvars, *jaxpr.invars], [*consts, *arguments], strict=True))
        value = lambda x: x.val if isinstance(x, Literal) else values[x]  # noqa: E731
        for equation in jaxpr.eqns:
            found = self._evaluated(equation, [value(x) for x in equation.invars])
            values.update(zip(equation.outvars, found, strict=True))
        return [value(x) for x in jaxpr.outvars]

    def _evaluated(self, equation: Any, given: Sequence[Any]) -> Sequence[Any]:
        name, params = equation.primitive.name, equation.params
        if not any(isinstance(x, (Lanes, Stored)) for x in given):
            found = equation.primitive.bind(*given, **params)
            return found if equation.primitive.multiple_results else [found]
        if name in RULES:
            return RULES[name](self, equation, given)
        if name in ELEMENTWISE:
            shape = (*equation.outvars[0].aval.shape, self.count)
            return [Lanes(equation.primitive.bind(*(self._shaped(x, shape) for x in given), **params))]
        if name in CALLS:
            if params.get("name") == "anywhere":
                return [jnp.any(given[0].array & self.busy)]
            inner = next(params[k] for k in ("jaxpr", "call_jaxpr") if k in params)
            return self.call(inner.jaxpr, inner.consts, given)
        return self.by_vmap(equation, given)

    def spread(self, value: Any) -> Array:
        """A value's array with an axis of lanes."""
        if isinstance(value, Lanes):
            return value.array
        return jnp.broadcast_to(jnp.asarray(value)[..., None], (*np.shape(value), self.count))

    def _shaped(self, value: Any, shape: tuple[int, ...]) -> Array:
        array = value.array if isinstance(value, Lanes) else jnp.asarray(value)[..., None]
        array = array.reshape((1,) * (len(shape) - array.ndim) + array.shape)  # a predicate may be a number
        return jnp.broadcast_to(array, shape)

    def by_vmap(self, equation: Any, given: Sequence[Any]) -> list[Any]:
        """Any other operation."""
        axes = [-1 if isinstance(x, Lanes) else None for x in given]
        arrays = [x.array if isinstance(x, Lanes) else x for x in given]
        found = jax.vmap(lambda *x: equation.primitive.bind(*x, **equation.params), axes, -1)(*arrays)
        return [Lanes(x) for x in (found if equation.primitive.multiple_results else [found])]


def _with_axis(**changes: Callable[[Any, int], Any]) -> Callable[..., list[Any]]:
    """A rule for an operation of one array whose parameters name axes or sizes: each gets that of the lanes too."""

    def rule(mapped: Mapped, equation: Any, given: Sequence[Any]) -> list[Any]:
        (operand,) = given
        changed = {name: change(equation.params[name], mapped.count) for name, change in changes.items()}
        return [Lanes(equation.primitive.bind(operand.array, **{**equation.params, **changed}))]

    return rule


def _broadcast_in_dim(mapped: Mapped, equation: Any, given: Sequence[Any]) -> list[Any]:
    (operand,), shape = given, equation.params["shape"]
    dimensions = (*equation.params["broadcast_dimensions"], len(shape))
    return [Lanes(lax.broadcast_in_dim(operand.array, (*shape, mapped.count), dimensions))]


def _reshape(mapped: Mapped, equation: Any, given: Sequence[Any]) -> list[Any]:
    return [Lanes(given[0].array.reshape((*equation.outvars[0].aval.shape, mapped.count)))]


def _pad(mapped: Mapped, equation: Any, given: Sequence[Any]) -> list[Any]:
    operand, filling = given
    return [Lanes(lax.pad(mapped.spread(operand), filling, (*equation.params["padding_config"], (0, 0, 0))))]


def _concatenate(mapped: Mapped, equation: Any, given: Sequence[Any]) -> list[Any]:
    return [Lanes(lax.concatenate([mapped.spread(x) for x in given], equation.params["dimension"]))]


def _stack(mapped: Mapped, equation: Any, given: Sequence[Any]) -> list[Any]:
    return [Lanes(jnp.stack([mapped.spread(x) for x in given], equation.params["axis"]))]


def _reduce(combine: Callable[[Array, Array], Array]) -> Callable[..., list[Any]]:
    def rule(mapped: Mapped, equation: Any, given: Sequence[Any]) -> list[Any]:
        array = given[0].array
        for axis in sorted(equation.params["axes"], reverse=True):
            size, params = array.shape[axis], {**equation.params, "axes": (axis,)}
            parts = [
                equation.primitive.bind(lax.slice_in_dim(array, k, min(k + TERMS, size), axis=axis), **params)
                for k in range(0, max(size, 1), TERMS)
            ]
            array = functools.reduce(combine, parts)
        return [Lanes(array)]

    return rule


def _first_best(better: Callable[[Array, Array], Array]) -> Callable[..., list[Any]]:
    """The first index of the best entry along the only axis."""

    def rule(mapped: Mapped, equation: Any, given: Sequence[Any]) -> list[Any]:
        array, kind = given[0].array, equation.params["index_dtype"]
        best, index = array[0], jnp.zeros(array.shape[1:], kind)
        for k in range(1, array.shape[0]):
            found = better(array[k], best) | (jnp.isnan(array[k]) & ~jnp.isnan(best))
            best, index = jnp.where(found, array[k], best), jnp.where(found, k, index)
        return [Lanes(index)]

    return rule


def _dynamic_slice(mapped: Mapped, equation: Any, given: Sequence[Any]) -> list[Any]:
    operand, *starts = given
    sizes = equation.params["slice_sizes"]
    if not any(isinstance(start, Lanes) for start in starts):
        zero = jnp.zeros((), jnp.asarray(starts[0]).dtype)
        return [Lanes(lax.dynamic_slice(operand.array, [*starts, zero], (*sizes, mapped.count)))]
    if sizes[0] > 1 or not (isinstance(operand, Lanes) or np.size(operand) <= FEW):
        return mapped.by_vmap(equation, given)
    entries, index = mapped.spread(operand), starts[0].array
    picked = entries[:1]
    for k in range(1, entries.shape[0]):
        picked = jnp.where(index == k, entries[k : k + 1], picked)
    return [Lanes(picked)]


def _dynamic_update_slice(mapped: Mapped, equation: Any, given: Sequence[Any]) -> list[Any]:
    operand, update, *starts = given
    if isinstance(operand, Stored):
        return [Stored(_written(mapped, operand.array, mapped.spread(update), starts))]
    entries, entry = mapped.spread(operand), mapped.spread(update)
    if not any(isinstance(start, Lanes) for start in starts):
        starts = [*starts, jnp.zeros((), jnp.asarray(starts[0]).dtype)]
        return [Lanes(lax.dynamic_update_slice(entries, entry, starts))]
    assert entry.shape[0] == 1 and entry.shape[1:] == entries.shape[1:], "whole entries along the first axis only"
    here = jnp.arange(entries.shape[0])[:, None] == mapped.spread(starts[0])[None]
    return [Lanes(jnp.where(here.reshape(len(here), *(1,) * (entries.ndim - 2), mapped.count), entry, entries))]


def _written(mapped: Mapped, buffer: Array, update: Array, starts: Sequence[Any]) -> Array:
    """Each lane's update at the place of its own run."""
    for lane in range(mapped.count):
        mine = [start.array[lane] if isinstance(start, Lanes) else start for start in starts]
        place = mapped.places[lane].astype(jnp.asarray(mine[0]).dtype)
        buffer = lax.dynamic_update_slice(buffer, update[None, ..., lane], [place, *mine])
    return buffer


def _while(mapped: Mapped, equation: Any, given: Sequence[Any]) -> list[Any]:
    """A lane that is through keeps what it has."""
    goes_on, body = equation.params["cond_jaxpr"], equation.params["body_jaxpr"]
    first = equation.params["cond_nconsts"]
    second = first + equation.params["body_nconsts"]
    own, shared, start = given[:first], given[first:second], given[second:]

    def lasts(carry: Sequence[Any]) -> Any:
        return mapped.call(goes_on.jaxpr, goes_on.consts, [*own, *carry])[0]

    def following(carry: Sequence[Any]) -> list[Any]:
        return mapped.call(body.jaxpr, body.consts, [*shared, *carry])

    kinds = _kinds_of_loop(mapped, following, lasts, start)
    wrap = lambda arrays: [kind(x) if kind else x for x, kind in zip(arrays, kinds, strict=True)]  # noqa: E731
    plain = lambda values: [_plain(mapped, x, kind) for x, kind in zip(values, kinds, strict=True)]  # noqa: E731

    def step(arrays: list[Array]) -> list[Array]:
        carry = wrap(arrays)
        found, on = plain(following(carry)), lasts(carry)
        if not isinstance(on, Lanes):
            return found
        return [jnp.where(on.array, new, old) for new, old in zip(found, arrays, strict=True)]

    def condition(arrays: list[Array]) -> Array:
        on = lasts(wrap(arrays))
        return jnp.any(on.array) if isinstance(on, Lanes) else on

    return wrap(lax.while_loop(condition, step, plain(start)))


def _plain(mapped: Mapped, value: Any, kind: Any) -> Array:
    """The array of a value of a kind."""
    if kind is Lanes:
        return mapped.spread(value)
    return value.array if kind is Stored else jnp.asarray(value)


def _kinds_of_loop(mapped: Mapped, following: Callable, lasts: Callable, start: Sequence[Any]) -> list[Any]:
    """Which parts of what a loop carries differ between lanes: those that depend on one that does."""
    kinds = [type(x) if isinstance(x, (Lanes, Stored)) else None for x in start]
    while True:
        carry = [Lanes(mapped.spread(x)) if kind is Lanes else x for x, kind in zip(start, kinds, strict=True)]
        made: list[Any] = []

        def once(carry: Any = carry, made: Any = made) -> list[Array]:
            masked = isinstance(lasts(carry), Lanes)
            made[:] = [
                Lanes if masked else type(x) if isinstance(x, (Lanes, Stored)) else None for x in following(carry)
            ]
            return []

        jax.eval_shape(once)
        before, kinds = kinds, [kind or new for kind, new in zip(kinds, made, strict=True)]
        if kinds == before:
            return kinds


def _cond(mapped: Mapped, equation: Any, given: Sequence[Any]) -> list[Any]:
    index, *operands = given
    branches = equation.params["branches"]
    in_lanes = [
        lambda branch=branch: [mapped.spread(x) for x in mapped.call(branch.jaxpr, branch.consts, operands)]
        for branch in branches
    ]
    if not isinstance(index, Lanes):
        return [Lanes(x) for x in lax.switch(index, in_lanes)]
    off, on = in_lanes
    chosen = index.array > 0
    off, on = (
        _if_any(wanted, len(branch.jaxpr.eqns) <= CHEAP, make)
        for wanted, branch, make in zip((~chosen, chosen), branches, in_lanes, strict=True)
    )
    return [Lanes(jnp.where(chosen, b, a)) for a, b in zip(off, on, strict=True)]


def _if_any(wanted: Array, cheap: bool, make: Callable[[], list[Array]]) -> list[Array]:
    """What a branch gives in all lanes, or zeros where no lane wants it."""
    if cheap:
        return make()
    shapes = jax.eval_shape(make)
    return lax.cond(jnp.any(wanted), make, lambda: [jnp.zeros(x.shape, x.dtype) for x in shapes])


CALLS = ("pjit", "jit", "closed_call", "core_call", "custom_jvp_call", "custom_vjp_call", "remat", "checkpoint")
ELEMENTWISE = frozenset(
    (
        *("abs", "acos", "add", "add_any", "and", "asin", "atan", "atan2", "cbrt", "ceil", "clamp"),
        *("convert_element_type", "copy", "cos", "cosh", "div", "eq", "exp", "exp2", "expm1", "floor", "ge"),
        *("gt", "integer_pow", "is_finite", "le", "log", "log1p", "lt", "max", "min", "mul", "ne", "neg"),
        *("nextafter", "not", "or", "pow", "rem", "round", "rsqrt", "select_n", "sign", "sin", "sinh", "sqrt"),
        *("square", "stop_gradient", "sub", "tan", "tanh", "xor"),
    )
)
RULES: dict[str, Callable[..., list[Any]]] = {
    "broadcast_in_dim": _broadcast_in_dim,
    "reshape": _reshape,
    "squeeze": _reshape,
    "expand_dims": _reshape,
    "transpose": _with_axis(permutation=lambda axes, _: (*axes, len(axes))),
    "slice": _with_axis(
        start_indices=lambda starts, _: (*starts, 0),
        limit_indices=lambda limits, count: (*limits, count),
        strides=lambda strides, _: None if strides is None else (*strides, 1),
    ),
    "pad": _pad,
    "concatenate": _concatenate,
    "stack": _stack,
    "dynamic_slice": _dynamic_slice,
    "dynamic_update_slice": _dynamic_update_slice,
    "reduce_sum": _reduce(jnp.add),
    "reduce_max": _reduce(jnp.maximum),
    "reduce_min": _reduce(jnp.minimum),
    "reduce_and": _reduce(jnp.logical_and),
    "reduce_or": _reduce(jnp.logical_or),
    "argmin": _first_best(jnp.less),
    "argmax": _first_best(jnp.greater),
    "rev": _with_axis(),
    "cumsum": _with_axis(),
    "while": _while,
    "cond": _cond,
}

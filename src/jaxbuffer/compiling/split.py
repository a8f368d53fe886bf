"""A program cut behind its loop, so that what follows is compiled beside it.

XLA compiles most of a program on one core, and a loop that is one kernel cannot be taken apart (see `runtime`). What is
computed from the loop's results need not wait for that.
"""

import contextlib
import gc
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax
from jax.extend.core import ClosedJaxpr, JaxprEqn, Literal, jaxpr_as_fun
from jax.stages import Compiled

WORTH = 6000  # operations of either part; a capture's after its loop are fewer: a second program costs 0.05 ms a call


@contextlib.contextmanager
def _uncollected() -> Iterator[None]:
    """Without garbage collections, which go through everything that is being traced again and again."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


@_uncollected()
def compiled(function: Callable[..., list[Any]], arguments: Sequence[Any]) -> list[Compiled]:
    """A function of arrays compiled for arguments like these, in one part or in two; for `run`."""
    traced = jax.jit(function).trace(*arguments)
    parts = _cut(traced.jaxpr)
    if parts is None:
        return [traced.lower().compile()]
    first, second = parts
    carried = [jax.ShapeDtypeStruct(v.aval.shape, v.aval.dtype) for v in first.jaxpr.outvars]
    until_loop = jax.jit(jaxpr_as_fun(first)).lower(*arguments)
    with ThreadPoolExecutor(1) as beside:
        loop = beside.submit(until_loop.compile)
        rest = jax.jit(jaxpr_as_fun(second)).lower(*arguments, *carried).compile()
        return [loop.result(), rest]


def run(parts: Sequence[Compiled], arguments: Sequence[Any]) -> list[Any]:
    """What the function returns: a second part gets the arguments and what the first one found."""
    found = parts[0](*arguments)
    return parts[1](*arguments, *found) if len(parts) > 1 else found


def _cut(program: ClosedJaxpr) -> tuple[ClosedJaxpr, ClosedJaxpr] | None:
    """All that leads to the largest loop, or function that holds it, and the rest; None where one of them is not worth
    a program of its own.

    What both need is in both: little, and cheaper than handing it over number by number.
    """
    jaxpr, sizes = program.jaxpr, [_operations(equation) for equation in program.jaxpr.eqns]
    if not sizes:
        return None
    place = sizes.index(max(sizes))
    loop = jaxpr.eqns[place]
    rest = _needed([equation for equation in jaxpr.eqns if equation is not loop], jaxpr.outvars)
    if min(sizes[place], sum(map(_operations, rest))) < WORTH:
        return None
    used = _variables([*jaxpr.outvars, *(x for equation in rest for x in equation.invars)])
    carried = [variable for variable in loop.outvars if variable in used]
    first = jaxpr.replace(eqns=_needed(jaxpr.eqns[: place + 1], carried), outvars=carried)
    second = jaxpr.replace(eqns=rest, invars=[*jaxpr.invars, *carried])
    return ClosedJaxpr(first, program.consts), ClosedJaxpr(second, program.consts)


def _needed(equations: Sequence[JaxprEqn], results: Sequence[Any]) -> list[JaxprEqn]:
    """Those that the results depend on."""
    wanted, found = _variables(results), []
    for equation in reversed(equations):
        if not wanted.isdisjoint(equation.outvars):
            wanted |= _variables(equation.invars)
            found.append(equation)
    return found[::-1]


def _variables(atoms: Sequence[Any]) -> set[Any]:
    return {atom for atom in atoms if not isinstance(atom, Literal)}


def _operations(equation: JaxprEqn) -> int:
    """How many an equation stands for, functions and loops in it included."""
    values = [x for value in equation.params.values() for x in (value if isinstance(value, tuple) else (value,))]
    inner = [getattr(value, "jaxpr", value) for value in values]
    return 1 + sum(_operations(e) for jaxpr in inner if hasattr(jaxpr, "eqns") for e in jaxpr.eqns)

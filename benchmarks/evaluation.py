"""One evaluation of Table 2's right-hand side: alone, with rows, with a covector: ``python -m benchmarks evaluation``.

Rows by n variables push n tangents through the linearised right-hand side; an adjoint pulls one covector a quantity
back through it. Each is a loop of its own, timed in turns with the others; the shortest time counts. A probe in
contact.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from .ours import jax, jb  # configures, before any computation of JAX's
from .variables import VARIABLES, in_turns

jnp, lax = jax.numpy, jax.lax

COUNTS, EVALUATIONS = (7, 20, 33), 1500
SMALL = 1e-12  # [s] of the rate that each turn of the loop adds, so that none can be left out


def looped(count: int, kind: str) -> Callable[[int], Any]:
    """A compiled loop of so many evaluations, of a ``kind``: "value", "rows" by ``count`` variables or "covector"."""
    from jaxbuffer.fields import get, with_values
    from jaxbuffer.hybrid.sensitivity.augmented_state import Tangents, columns, push_through_assembly
    from jaxbuffer.mechanisms.registry import mechanism_of

    design, scenario = jb.table2(), jb.Scenario()
    paths = VARIABLES[:count]
    of = lambda path: get({"scenario": scenario}.get(path.split(".")[0], design), path.removeprefix("scenario."))  # noqa: E731
    values = [float(of(path)) for path in paths]

    def run(values: list[Any], evaluations: Any) -> Any:
        directions = [jnp.zeros(count).at[k].set(value) for k, value in enumerate(values)]
        system = lambda values: mechanism_of(design).system(  # noqa: E731
            *with_values(design, scenario, dict(zip(paths, values, strict=True))), 20.0
        )
        build, tangents = push_through_assembly(system, values, directions)
        if kind != "rows":
            tangents = Tangents(tangents.primal)
        rows = tangents.start(lambda p: build(p).start()[0])
        active = build(tangents.primal).start()[1].at[0].set(1.0)
        rate = lambda p, y: build(p).derivative(0.0, y, active)  # noqa: E731

        def pulled(at: Any) -> Any:
            state, covector, _ = at
            value, pull = jax.vjp(rate, tangents.primal, state)
            return jax.tree.map(lambda x, change: x + SMALL * change, at, (value, *pull(covector)[::-1]))

        start, turn = columns(rows), lambda at: at + SMALL * tangents.field(rate)(at)
        if kind == "covector":
            start, turn = (rows[0], jnp.ones_like(rows[0]), jax.tree.map(jnp.zeros_like, tangents.primal)), pulled
        return lax.fori_loop(0, evaluations, lambda _, at: turn(at), start)

    compiled = jax.jit(run).lower(values, 1).compile()
    return lambda evaluations: jax.block_until_ready(compiled(values, evaluations))


def main(rounds: int = 60) -> int:
    """Measure and print."""
    options = {"value alone": (1, "value"), "and one covector": (COUNTS[1], "covector")}
    options |= {f"and rows by {count} variables": (count, "rows") for count in COUNTS}
    calls = {name: partial(looped(*kind), EVALUATIONS) for name, kind in options.items()}
    best = in_turns(calls, rounds)
    for name, seconds in best.items():
        print(f"{name:<26}{1e6 * seconds / EVALUATIONS:>8.3f} µs{seconds / best['value alone']:>8.2f}")
    return 0

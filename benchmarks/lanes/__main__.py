"""How much quicker are captures in the lanes of a vector register?

    python -m benchmarks.lanes --lanes 8 --runs 128 --rtol 3e-4

The right-hand side alone and in lanes; then random captures by the loop, one after the other as `jb.sweep` has them,
and in lanes by the loop's own methods on a fixed schedule. In turns, by the processor's time; the least counts.
"""

import argparse
import dataclasses
import sys
import time
from collections.abc import Callable
from typing import Any

import jaxbuffer.compiling.process

jaxbuffer.compiling.process.configure()

import equinox as eqx  # noqa: E402
import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402

import jaxbuffer as jb  # noqa: E402
from jaxbuffer.hybrid import Result, Tolerance, solve_at_fixed_times  # noqa: E402
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE  # noqa: E402
from jaxbuffer.run.request import options_of, with_tolerances  # noqa: E402

from .queue import run_all  # noqa: E402
from .side_by_side import SideBySide  # noqa: E402
from .transform import Lanes, Mapped  # noqa: E402

DURATION, GAIN = 8.0, 20.0  # s, 1/s
EVALUATIONS, ROUNDS = 20_000, 5


def captures(count: int) -> tuple[Any, Any, Any]:
    """Table 2 at random speeds, misalignments and contact distances; each number an array (count,)."""
    draw = np.random.default_rng(0).uniform
    scenario = jb.Scenario(
        approach_speed=draw(0.05, 0.3, count),
        misalignment=draw(-0.07, 0.07, count),
        contact_distance=draw(0.02, 0.06, count),
    )
    spread = lambda x: jnp.broadcast_to(jnp.asarray(x, float), (count,))  # noqa: E731
    return jax.tree.map(spread, (jb.table2(), scenario, GAIN))


def compiled(function: Callable[..., Any], *arguments: Any) -> tuple[Any, float]:
    """A function compiled for these arguments, and the processor time that took [s]."""
    begin = time.process_time()
    return jax.jit(function).lower(*arguments).compile(), time.process_time() - begin


def in_turns(*calls: Callable[[], Any]) -> list[float]:
    """The least processor time of each call [s]."""
    least = [np.inf] * len(calls)
    for _ in range(ROUNDS):
        for k, call in enumerate(calls):
            begin = time.process_time()
            jax.block_until_ready(call())
            least[k] = min(least[k], time.process_time() - begin)
    return least


def right_hand_sides(lanes: int) -> tuple[float, float]:
    """A right-hand side alone and in lanes, of each lane [µs]."""
    system = PROBE_CONE.system(jb.table2(), jb.Scenario(), GAIN)
    state, active = system.start()
    arrays, static = eqx.partition(system, eqx.is_array)
    given = [*jax.tree.leaves(arrays), state, active]
    structure = jax.tree.structure(arrays)

    def rate(*given: Any) -> Any:
        *leaves, state, active = given
        return eqx.combine(jax.tree.unflatten(structure, leaves), static).derivative(0.0, state, active)

    traced = jax.make_jaxpr(rate)(*given)
    mapped = Mapped(jnp.arange(lanes), jnp.ones(lanes, bool))

    def in_lanes(*given: Any) -> Any:
        return mapped.call(traced.jaxpr, traced.consts, [Lanes(x) for x in given])[0].array

    def often(step: Callable[..., Any]) -> Callable[..., Any]:
        def loop(*given: Any) -> Any:
            *others, state, active = given
            return jax.lax.fori_loop(0, EVALUATIONS, lambda _, y: y + 1e-12 * step(*others, y, active), state)

        return loop

    wide = [jnp.repeat(x[..., None], lanes, -1) for x in map(jnp.asarray, given)]
    alone, _ = compiled(often(rate), *given)
    together, _ = compiled(often(in_lanes), *wide)
    a, b = in_turns(lambda: alone(*given), lambda: together(*wide))
    return 1e6 * a / EVALUATIONS, 1e6 * b / EVALUATIONS / lanes


def one_by_one(parameters: Any, rtol: float) -> Result:
    """By the loop."""
    options = options_of()

    def one(parameters: Any) -> Result:
        mine = with_tolerances(options, parameters, (rtol, rtol))
        return solve_at_fixed_times(PROBE_CONE.system, parameters, DURATION, mine)

    return jax.vmap(one)(parameters)


def side_by_side(parameters: Any, rtol: float, lanes: int) -> tuple[Result, Any]:
    """In lanes."""
    options = dataclasses.replace(options_of(), solver=SideBySide(), tolerance=Tolerance(rtol, rtol))

    def location(parameters: Any) -> tuple[Any, Any]:
        mine = with_tolerances(options, parameters, (rtol, rtol))
        return jnp.asarray(mine.event_time), jnp.asarray(mine.shortfall)

    count = jax.tree.leaves(parameters)[0].shape[0]
    durations = jnp.full(count, DURATION)
    return run_all(PROBE_CONE.system, parameters, durations, options, jax.vmap(location)(parameters), lanes)


def peaks(result: Result) -> np.ndarray:
    """The largest contact force of each run [N]."""
    return np.asarray(jnp.max(result.log.values[:, :, :2], axis=(1, 2)))


def main() -> int:
    """Measure and tell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--lanes", type=int, default=8)
    parser.add_argument("--runs", type=int, default=128)
    parser.add_argument("--rtol", type=float, default=3e-4)
    asked = parser.parse_args()
    alone, shared = right_hand_sides(asked.lanes)
    print(f"right-hand side: alone {alone:.3f} µs, in {asked.lanes} lanes {shared:.3f} µs each: {alone / shared:.1f} ×")
    parameters = captures(asked.runs)
    loop, loop_seconds = compiled(lambda p: one_by_one(p, asked.rtol), parameters)
    lanes, lanes_seconds = compiled(lambda p: side_by_side(p, asked.rtol, asked.lanes), parameters)
    print(f"compiled: the loop in {loop_seconds:.0f} s, lanes in {lanes_seconds:.0f} s")
    a, b = in_turns(lambda: loop(parameters), lambda: lanes(parameters))
    one, (many, iterations) = loop(parameters), lanes(parameters)
    attempts = float(np.mean(one.attempts)), float(np.mean(many.attempts))
    used = float(np.sum(many.attempts)) / (asked.lanes * float(iterations))
    print(f"trial steps a capture: {attempts[0]:.0f} and {attempts[1]:.0f}; lanes used to {100 * used:.0f} %")
    print(f"a capture: {1e3 * a / asked.runs:.2f} and {1e3 * b / asked.runs:.2f} ms: {a / b:.2f} ×")
    apart = np.abs(peaks(many) / peaks(one) - 1.0)
    print(
        f"peak forces apart by {np.median(apart):.1e} (median), {apart.max():.1e} (most); all ended alike: "
        f"{bool(np.all(np.asarray(one.status) == np.asarray(many.status)))}"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())

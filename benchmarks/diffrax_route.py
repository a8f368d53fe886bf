"""Table 2's capture through `diffrax.diffeqsolve` beside our own: ``python -m benchmarks diffrax_route``.

Prints the table of docs/diffrax.md: steps, warm time, error of the peak force, and time and worst error of its five
elasticities, against the reference capture.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

import jaxbuffer as jb

PATHS = ("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T", "probe.tip_mass")
# The reference capture "table2": peak force [N], and d ln peak_force / d ln p in the order of PATHS.
PEAK = 253.13152694328107
ELASTICITIES = (
    0.3413881083469929,
    -0.045941219293836134,
    0.004230201866723959,
    0.002598194871687751,
    0.07761053499837997,
)
SHORT = 2.0  # s, what takes less is timed three times


class Row(NamedTuple):
    """One line: who, relative tolerance, accepted steps, warm times of a capture and of its gradient [s], relative
    errors of the peak force and of the worst elasticity."""

    name: str
    rtol: float
    steps: int
    seconds: float
    peak: float
    gradient_seconds: float
    elasticity: float


def timed(function: Callable[..., Any], *arguments: Any) -> tuple[Any, float]:
    """The result of a call and its shortest time [s], compilation left out."""
    jax.block_until_ready(function(*arguments))
    shortest = np.inf
    for _ in range(3):
        begin = time.perf_counter()
        result = jax.block_until_ready(function(*arguments))
        shortest = min(shortest, time.perf_counter() - begin)
        if shortest > SHORT:
            break
    return result, shortest


def rows(name: str, solver: Any, tolerances: Sequence[float]) -> Iterator[Row]:
    """Captures and gradients at each tolerance, by two programs."""
    logs = jnp.log(jnp.array([jb.get(jb.table2(), path) for path in PATHS]))

    def capture(logs: jax.Array, rtol: jax.Array) -> tuple[jax.Array, jax.Array]:
        design = jb.replace(jb.table2(), dict(zip(PATHS, jnp.exp(logs), strict=True)))
        run = jb.simulate(design, rtol=rtol, solver=solver)
        return jnp.log(run.peak_force), run.accepted

    value, gradient = jax.jit(capture), jax.jit(jax.jacfwd(lambda *given: capture(*given)[0]))
    for rtol in tolerances:
        (log_peak, steps), seconds = timed(value, logs, jnp.asarray(rtol))
        elasticities, gradient_seconds = timed(gradient, logs, jnp.asarray(rtol))
        off = np.max(np.abs(np.asarray(elasticities) / np.array(ELASTICITIES) - 1.0))
        yield Row(name, rtol, int(steps), seconds, float(jnp.exp(log_peak)) / PEAK - 1.0, gradient_seconds, float(off))


def printed(row: Row) -> str:
    """A line of the table."""
    return (
        f"| {row.name} | {row.rtol:.0e} | {row.steps} | {row.seconds:.3g} | {row.peak:+.1e} | "
        f"{row.gradient_seconds:.3g} | {row.elasticity:.1e} |"
    )


def main() -> int:
    """Print the table; the exit status."""
    jb.configure()
    print("| solver | rtol | steps | capture [s] | peak force | gradient [s] | worst elasticity |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    runs = [
        ("ours, located events", None, (1e-6, 1e-9)),
        ("diffrax Tsit5", jb.Diffrax(diffrax.Tsit5()), (1e-6, 1e-8, 1e-10)),
        ("diffrax Kvaerno5", jb.Diffrax(diffrax.Kvaerno5()), (1e-5, 1e-6, 1e-8)),
    ]
    for name, solver, tolerances in runs:
        for row in rows(name, solver, tolerances):
            print(printed(row), flush=True)
    return 0

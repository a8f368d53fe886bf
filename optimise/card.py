"""(j) The first words of this project beside its default route.

An implicit method of diffrax on the smooth contact law, `jax.grad` in k_A, c_A, k_T, c_T and the tip's mass, a step of
optax, `jax.vmap` over misalignment and approach speed; then `jb.tune` with located events, on the same problem.
"""

import time
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import NamedTuple

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optax

from jaxbuffer import Diffrax, Problem, replace, simulate
from jaxbuffer.output.formats import csv_text

from .study import config, tuned, write

STEPS, RATE = 30, 0.08  # of Adam, the rate in the variables' ranges
PENALTY = 20.0  # on the relative excess over a limit, squared
METHOD = Diffrax(diffrax.Kvaerno5())


class Way(NamedTuple):
    """How one way ended: the ``values`` of the variables; ``peak`` [N] and ``stroke`` [m], the largest of all scenarios
    by the default solver at rtol 1e-9; the ``seconds`` that it took."""

    name: str
    values: np.ndarray
    peak: float
    stroke: float
    seconds: float


def literal(problem: Problem) -> np.ndarray:
    """Tune by diffrax, `jax.grad`, `jax.vmap` and optax, and return the variables' values."""
    met = problem.scenarios_met
    speeds = jnp.array([scenario.approach_speed for scenario in met])
    angles = jnp.array([scenario.misalignment for scenario in met])
    low, high = (jnp.array([getattr(v, end) for v in problem.variables]) for end in ("low", "high"))
    limit = problem.limits.at_most["stroke"]

    def capture(values: jax.Array, speed: jax.Array, angle: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
        design = replace(problem.design, dict(zip(problem.paths, values, strict=True)))
        scenario = replace(met[0], {"approach_speed": speed, "misalignment": angle})
        run = simulate(design, scenario, problem.duration, rtol=problem.rtol, solver=METHOD)
        return run.peak_force, run.stroke, run.capture_share

    def objective(scaled: jax.Array) -> jax.Array:
        values = low * (high / low) ** scaled
        peaks, strokes, share = jax.vmap(capture, in_axes=(None, 0, 0))(values, speeds, angles)
        excess = jnp.maximum(strokes / limit - 1.0, 0.0) + jnp.maximum(-share, 0.0)
        return jnp.log(jnp.max(peaks)) + PENALTY * jnp.sum(excess**2)

    scaled = jnp.array(problem.start())
    optimizer = optax.adam(optax.cosine_decay_schedule(RATE, STEPS))
    state, gradient = optimizer.init(scaled), jax.jit(jax.value_and_grad(objective))
    best, least = scaled, jnp.inf
    for _ in range(STEPS):
        value, slope = gradient(scaled)
        if value < least:
            best, least = scaled, value
        change, state = optimizer.update(slope, state, scaled)
        scaled = jnp.clip(optax.apply_updates(scaled, change), 0.0, 1.0)
    return problem.values(best)


def way(problem: Problem, name: str, search: Callable[[], np.ndarray]) -> Way:
    """Run a search, and look at what it ends with by located events at rtol 1e-9."""
    began = time.perf_counter()
    values = search()
    seconds = time.perf_counter() - began
    design = replace(problem.design, dict(zip(problem.paths, map(float, values), strict=True)))
    runs = [simulate(design, scenario, problem.duration, rtol=1e-9) for scenario in problem.scenarios_met]
    peak, stroke = (max(float(getattr(run, name)) for run in runs) for name in ("peak_force", "stroke"))
    return Way(name, values, peak, stroke, seconds)


def ways(folder: Path, resume: bool = False, executor: Executor | None = None) -> list[Way]:
    """The default way, whose result is written as that of other studies, and the literal one."""
    study = config("card")
    problem = study.problem()
    return [
        way(
            problem,
            "jb.tune, located events",
            lambda: problem.values(tuned(study, folder, resume, executor).after.scaled),
        ),
        way(problem, "diffrax Kvaerno5, jax.grad, optax, vmap", lambda: literal(problem)),
    ]


def main(folder: Path, resume: bool = False, executor: Executor | None = None) -> None:
    """Both ways, as a table."""
    rows = ways(folder, resume, executor)
    header = ["way", *config("card").problem().paths, "peak_force [N]", "stroke [m]", "time, compiling included [s]"]
    table = [[w.name, *map(float, w.values), w.peak, w.stroke, w.seconds] for w in rows]
    write(folder, "card.csv", csv_text(header, table))
    for one in rows:
        print(f"{one.name}: {one.peak:.2f} N, stroke {1e3 * one.stroke:.2f} mm, {one.seconds:.1f} s", flush=True)

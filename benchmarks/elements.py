"""Elements a second: our explicit dynamics beside a loop in numba of the same: ``python -m benchmarks elements``.

A cantilever of square elements, plastic after von Mises, swings under its weight. Ours and numba's on one thread take
turns and are timed by processor time, several threads by the clock; the shortest counts. Memory is what XLA reports of
the compiled run; the gradient is that of the tip's displacement by Young's modulus.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer

from .ours import jax  # configures, before any computation of JAX's
from .peers.elements import Peer
from .variables import in_turns

jnp = jax.numpy

SIZES = ((25, 2), (100, 2), (250, 4), (500, 10), (1000, 20))  # elements along and across
BLOCKS = 4  # of steps in a run, at least
UPDATES = 4e5  # element updates a run, at least
GRADIENT = ((25, 2), (100, 2), (250, 4))
SIDE, YOUNG, POISSON, DENSITY, YIELD, HARDENING = 0.01, 1e9, 0.4, 950.0, 25e6, 40e6
SAME = 1e-9  # of the largest displacement: by how much ours and numba's may differ
GRAVITY = 2e4  # m/s²: some elements yield soon


class Problem(NamedTuple):
    """One size: positions, corners, inverse masses, the step and how many blocks of steps to take."""

    positions: np.ndarray
    corners: np.ndarray
    inverse: np.ndarray
    step: float
    blocks: int


def problem(along: int, across: int) -> Problem:
    """The cantilever, held at its left end."""
    x, y = np.meshgrid(SIDE * np.arange(along + 1.0), SIDE * np.arange(across + 1.0), indexing="ij")
    node = np.arange(x.size).reshape(x.shape)
    cells = [node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]]
    corners = np.stack(cells, axis=-1).reshape(-1, 4)
    mass = np.zeros(x.size)
    np.add.at(mass, corners.ravel(), 0.25 * DENSITY * SIDE**2)
    inverse = np.repeat(1.0 / mass[:, None], 2, axis=1)
    inverse[node[0]] = 0.0
    lame = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    fastest = np.sqrt((lame + YOUNG / (1.0 + POISSON)) / DENSITY)
    blocks = max(BLOCKS, int(UPDATES / (50 * along * across)))
    return Problem(np.stack([x.ravel(), y.ravel()], axis=1), corners, inverse, 0.5 * SIDE / fastest, blocks)


def system_of(given: Problem, young: Any) -> Any:
    """Ours."""
    from jaxbuffer.structures import FiniteElementSystem, Plane, Plastic, Quads

    material = Plastic(DENSITY, young, POISSON, YIELD, HARDENING, 1e9)
    quads = Quads.of(jnp.asarray(given.positions), given.corners)
    return FiniteElementSystem(
        jnp.asarray(given.positions),
        jnp.asarray(given.inverse),
        (Plane(quads, material),),
        gravity=jnp.asarray([0.0, -GRAVITY]),
    )


def moved(given: Problem, young: Any, blocks: Any, backwards: bool = False) -> Any:
    """Displacements (nodes, 2) after so many blocks."""
    from jaxbuffer.structures import march

    system = system_of(given, young)
    state, _ = march(
        system, system.start(), given.step, blocks, lambda carry, instant: carry, jnp.zeros(()), backwards=backwards
    )
    return state.displacement


def ours(given: Problem) -> tuple[Callable[[], Any], float]:
    """A compiled run, and the memory it takes beside its arguments [B]."""
    compiled = jax.jit(partial(moved, given)).lower(YOUNG, given.blocks).compile()
    memory = compiled.memory_analysis().temp_size_in_bytes
    return lambda: np.asarray(compiled(YOUNG, given.blocks)), memory


def theirs(given: Problem, threads: int) -> Callable[[], Any]:
    """The same in numba, on one thread or several."""
    peer = Peer(given.positions, given.corners, given.inverse, (YOUNG, POISSON, YIELD, HARDENING), GRAVITY, threads)
    return lambda: peer.run(given.step, 50 * given.blocks)


def gradient(given: Problem) -> tuple[Callable[[], Any], Callable[[], Any], float]:
    """A run, its gradient, and the memory of the latter [B]."""
    tip = lambda young, backwards: moved(given, young, given.blocks, backwards)[-1, 1]  # noqa: E731
    plain = jax.jit(lambda young: tip(young, False)).lower(YOUNG).compile()
    pulled = jax.jit(jax.value_and_grad(lambda young: tip(young, True))).lower(YOUNG).compile()
    return (
        lambda: np.asarray(plain(YOUNG)),
        lambda: np.asarray(pulled(YOUNG)[1]),
        pulled.memory_analysis().temp_size_in_bytes,
    )


def tank_gradient() -> tuple[Callable[[], Any], Callable[[], Any]]:
    """A drop onto a tank, and the gradient of its peak force by two walls and the cushion's stiffness."""
    import jaxbuffer as jb

    names = ("wall.top", "wall.lower_side", "cushion.stiffness")

    def peak(values: Any) -> Any:
        design = jb.replace(jb.TankDrop(), dict(zip(names, values, strict=True)))
        return jb.simulate(design, jb.TankDropScenario(height=0.1), duration=0.02).peak_force

    at = tuple(float(jb.get(jb.TankDrop(), name)) for name in names)
    plain, pulled = (jax.jit(f).lower(at).compile() for f in (peak, jax.grad(peak)))
    return lambda: np.asarray(plain(at)), lambda: jax.block_until_ready(pulled(at))


def by_the_clock(call: Callable[[], Any], rounds: int) -> float:
    """The shortest time [s] of a call that keeps several threads busy."""
    times = []
    for _ in range(rounds):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return min(times)


def main(
    rounds: int = 9, sizes: Annotated[int, typer.Option(help="only so many of the smallest meshes")] = len(SIZES)
) -> int:
    """Measure and print."""
    cores = len(os.sched_getaffinity(0))
    print(f"element updates a second, in millions; numba on 1 and on {cores} threads")
    print("elements      ours   numba 1   numba " + f"{cores}   ours/numba 1   memory [MB]   apart [-]")
    for size in SIZES[:sizes]:
        given = problem(*size)
        run, memory = ours(given)
        calls = {"ours": run, "one": theirs(given, 1), "all": theirs(given, cores)}
        end = {name: call() for name, call in calls.items()}
        apart = max(np.abs(end[name] - end["ours"]).max() for name in ("one", "all")) / np.abs(end["ours"]).max()
        if not apart < SAME:
            print(f"{len(given.corners)} elements: not the same: displacements {apart:.1e} of the largest apart")
            return 1
        best = in_turns({name: calls[name] for name in ("ours", "one")}, rounds)
        best["all"] = by_the_clock(calls["all"], rounds)
        rate = {name: 50e-6 * given.blocks * len(given.corners) / seconds for name, seconds in best.items()}
        print(
            f"{len(given.corners):>8}{rate['ours']:>10.2f}{rate['one']:>10.2f}{rate['all']:>10.2f}"
            f"{rate['ours'] / rate['one']:>15.2f}{1e-6 * memory:>14.2f}{apart:>12.1e}"
        )
    print("elements   steps   run [ms]   gradient [runs]   memory [MB]")
    for size in GRADIENT[:sizes]:
        given = problem(*size)._replace(blocks=40)
        run, pulled, memory = gradient(given)
        best = in_turns({"run": run, "gradient": pulled}, rounds)
        print(
            f"{len(given.corners):>8}{50 * given.blocks:>8}{1e3 * best['run']:>11.1f}"
            f"{best['gradient'] / best['run']:>18.2f}{1e-6 * memory:>14.2f}"
        )
    run, pulled = tank_gradient()
    best = in_turns({"run": run, "gradient": pulled}, rounds)
    print(f"a drop onto a tank: run {1e3 * best['run']:.1f} ms, gradient {best['gradient'] / best['run']:.2f} runs")
    return 0

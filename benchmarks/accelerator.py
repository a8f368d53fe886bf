"""Captures and gradients in one `jax.vmap`, all stepped together: `python -m benchmarks accelerator COUNT …`.

On an accelerator `jax.vmap(jb.simulate)` steps all runs of a batch together; on a CPU one after the other, which is
faster there and what ``--together`` turns off.
"""

import importlib
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Annotated, Any

import jax
import jax.numpy as jnp
import numpy as np
import typer

import jaxbuffer as jb

from .names import chosen

LOW = {"buffer.k_A": 200.0, "buffer.c_A": 5.0, "probe.tip_mass": 0.03}
HIGH = {"buffer.k_A": 1500.0, "buffer.c_A": 50.0, "probe.tip_mass": 0.15}
SPEED, ANGLE = (0.05, 0.2), (0.02, 0.05)  # m/s, rad


def inputs(count: int) -> np.ndarray:
    """(count, 5) random numbers of design and approach, the same for every device."""
    unit = np.random.default_rng(0).uniform(size=(count, 5))
    low, high = (np.array([*ends.values(), SPEED[k], ANGLE[k]]) for k, ends in enumerate((LOW, HIGH)))
    return low + (high - low) * unit


def peak(numbers: jax.Array) -> tuple[jax.Array, jax.Array]:
    """The largest force [N] of one capture, and the code of its outcome."""
    design = jb.replace(jb.table2(), dict(zip(LOW, numbers[:3], strict=True)))
    run = jb.simulate(design, jb.Scenario(approach_speed=numbers[3], misalignment=numbers[4]))
    return run.peak_force, run.code


def gradient(numbers: jax.Array) -> tuple[tuple[jax.Array, jax.Array], jax.Array]:
    """`peak`, and the derivatives of the force by all five numbers."""
    return jax.value_and_grad(peak, has_aux=True)(numbers)


def captures(numbers: jax.Array) -> tuple[tuple[jax.Array, jax.Array], jax.Array]:
    """`peak`, and no derivatives."""
    return peak(numbers), jnp.zeros(0)


KINDS: dict[str, Callable[[jax.Array], Any]] = {"captures": captures, "gradients": gradient}


def timed(call: Any, *arguments: Any) -> tuple[Any, float]:
    """What a call returns, once it is there, and the seconds that it took."""
    began = time.perf_counter()
    answer = jax.block_until_ready(call(*arguments))
    return answer, time.perf_counter() - began


def compiled(kind: str, count: int) -> tuple[Any, float]:
    """The program for one kind and count, and the seconds that tracing and compiling took."""
    batch = jax.jit(jax.vmap(KINDS[kind]))
    return timed(lambda: batch.lower(jnp.asarray(inputs(count))).compile())


def main(
    counts: list[int],
    kinds: Annotated[list[str] | None, typer.Option(help="default: both")] = None,
    together: Annotated[bool, typer.Option(help="step all runs together on a CPU too")] = False,
    output: Path = Path("results/accelerator"),
    against: Annotated[Path | None, typer.Option(help="folder of another device's results, to compare with")] = None,
) -> int:
    """Compile everything side by side; run each program as soon as it is there, and print a line."""
    jb.configure()
    if together:
        importlib.import_module("jaxbuffer.hybrid.lanes").in_turn = lambda: False  # type: ignore[attr-defined]
    print(jax.devices()[0].device_kind, "JAX", jax.__version__, flush=True)
    output.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor() as pool:
        pairs = [(kind, count) for count in counts for kind in chosen(kinds, KINDS, "kind")]
        programs = [(kind, count, pool.submit(compiled, kind, count)) for kind, count in pairs]
        for kind, count, program in programs:
            (call, compiling), numbers = program.result(), jnp.asarray(inputs(count))
            ((forces, codes), slopes), seconds = timed(call, numbers)
            none = int(np.sum(~np.isfinite(np.asarray(forces))))
            rate = f"{seconds:.2f} s, {count / seconds:.0f} a second, compiled in {compiling:.0f} s"
            print(f"{kind}, {count}: {rate}, {none} without a force", flush=True)
            columns = np.column_stack([np.asarray(forces), np.asarray(codes), np.asarray(slopes)])
            name = f"{kind}-{count}.csv"
            np.savetxt(output / name, columns[:1000], delimiter=",", fmt="%.17g")
            if against is not None:
                other = np.loadtxt(against / name, delimiter=",", ndmin=2)
                off = np.max(np.abs(columns[: len(other), 0] / other[:, 0] - 1.0))
                ends = np.sum(columns[: len(other), 1] != other[:, 1])
                print(f"the other device's: forces within {off:.1e}, {ends} outcomes differ")
    return 0

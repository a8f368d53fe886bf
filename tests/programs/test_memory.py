"""Compiled programs are dropped from memory, and read from their folder again."""

import os
import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.programs.cache import stored
from jaxbuffer.programs.store import store_in


def executables() -> set[str]:
    """The names of all programs that XLA holds; no two that this package stores have the same."""
    return {it.hlo_modules()[0].name for it in jax.devices()[0].client.live_executables()}


def test_what_is_dropped_is_held_by_nothing_and_read_again_without_tracing(tmp_path):
    """Programs, those of JAX's own, and what was traced: once more from the folder, and not from Python."""
    store_in(tmp_path)
    traces = []

    def doubled(value):
        traces.append(value)
        return 2.0 * value

    function, before = stored(doubled), executables()
    assert float(function(3.0)) == 6.0
    of_jax = jax.jit(lambda value: jnp.sin(value) + 0.123)
    of_jax(1.0)
    new = executables() - before
    assert len(new) >= 2
    jb.clear_caches()
    assert not executables() & new
    assert not function.programs
    assert float(function(4.0)) == 8.0
    assert len(traces) == 1


def test_a_program_that_runs_may_be_dropped():
    """A host callback drops it from within: the call still ends with its result."""

    def dropped(value):
        jb.clear_caches()
        return np.asarray(value) + 1.0

    @stored
    def function(value):
        return 2.0 * jax.pure_callback(dropped, jax.ShapeDtypeStruct((), float), value)

    assert float(function(1.0)) == 4.0
    assert not function.programs


MEASURED = """
from pathlib import Path
import jaxbuffer as jb
jb.configure()

def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 2**20

jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.01), 0.06)
jb.clear_caches()
empty = resident()
jb.simulate(jb.table2())
full = resident()
jb.clear_caches()
print(empty, full, resident())
"""


@pytest.mark.slow
def test_a_captures_memory_is_given_back(programs):
    """XLA, the C library and Python give back three quarters of what a capture's program holds, over 0.1 GB."""
    environment = os.environ | {"JAXBUFFER_CACHE": str(programs)}
    measured = subprocess.run(
        [sys.executable, "-c", MEASURED], capture_output=True, text=True, check=True, env=environment, timeout=300
    )
    empty, full, after = map(float, measured.stdout.split())
    assert full - empty > 100.0, "MiB"
    assert after - empty < 0.25 * (full - empty)

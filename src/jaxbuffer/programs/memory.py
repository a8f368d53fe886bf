"""Compiled programs dropped from memory.

XLA keeps a program's instructions beside its machine code, about 3 kB for each, as long as the program is in memory.
"""

import gc

import equinox as eqx
import jax

from .cache import drop_programs
from .process import trim


def clear_caches() -> None:
    """Drop all compiled programs from memory: those of jaxbuffer, of Equinox and of JAX.

    The programs of each structure of a design (another contact law, a free tip, an end stop) hold 0.1 to 0.2 GB, and
    `jax.clear_caches` does not know them. Call this in a notebook or a service that works through many structures.
    Designs, results and programs on disk stay: the next call loads its program, in about a second for a capture, and
    compiles only where no folder keeps it (`jb.configure`).

    **Example:**

    >>> peak = float(jb.simulate(jb.table2()).peak_force)
    >>> jb.clear_caches()
    >>> float(jb.simulate(jb.table2()).peak_force) == peak
    True
    """
    drop_programs()
    eqx.clear_caches()
    jax.clear_caches()
    gc.collect()
    trim()

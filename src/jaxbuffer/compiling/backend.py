"""JAX's backend in this process: whether it is up, makes one kernel of a loop, and may be computed with."""

import os
import sys
import warnings

from ..errors import InputError

THRESHOLD = "xla_cpu_small_while_loop_byte_threshold"

_told = False  # of slow loops
_forked = False  # after JAX's backend had started


def told_of_slow_loops() -> bool:
    """Whether the user was told of slow loops before; from now on, yes."""
    global _told  # once per process
    before, _told = _told, True
    return before


def check_ready() -> None:
    """Raise unless this process computes in double precision and JAX can work in it; warn, once, if loops are slow."""
    import jax
    import numpy as np

    if _forked:
        raise RuntimeError(
            "this process was forked from one in which JAX had started, and would hang: start it by "
            "multiprocessing.get_context('spawn') or 'forkserver', or fork before the first computation"
        )
    if jax.dtypes.canonicalize_dtype(float) != np.float64:
        raise InputError(
            "jaxbuffer needs double precision: call jb.configure() before the first JAX computation, or set "
            "JAX_ENABLE_X64=1 (slower: see jb.configure)"
        )
    if told_of_slow_loops():
        return
    if jax.default_backend() == "cpu" and not one_kernel():
        warnings.warn(
            "jb.configure() was not called before JAX's backend started: captures take about ten times longer. "
            "Call it before the first JAX computation.",
            RuntimeWarning,
            stacklevel=4,
        )


def one_kernel() -> bool:
    """Whether loops become one kernel: by the flags JAX's backend started with, or, before, by those it would."""
    if not backend_is_up():
        return THRESHOLD in os.environ.get("XLA_FLAGS", "")
    from jax._src.lib import xla_client

    return THRESHOLD.encode() in xla_client.CompileOptions().SerializeAsString()


def _note_fork() -> None:
    global _forked  # noqa: PLW0603 # of this process
    _forked = _forked or backend_is_up()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)


def backend_is_up() -> bool:
    """Whether JAX's backend has started, after which XLA's flags are read no more."""
    if "jax" not in sys.modules:
        return False
    from jax._src import xla_bridge

    return bool(xla_bridge._backends)

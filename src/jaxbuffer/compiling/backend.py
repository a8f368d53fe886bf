"""JAX's backend in this process: whether it is up, makes one kernel of a loop, and may be computed with."""

import os
import sys
import warnings

from ..errors import InputError

THRESHOLD = "xla_cpu_small_while_loop_byte_threshold"
DISALLOWED = ("disallow", "disallow_explicit")
UNSUITABLE: dict[str, tuple[tuple[object, ...], str]] = {
    "jax_debug_nans": ((True,), "results hold NaN where there is no number"),
    "jax_check_tracer_leaks": ((True,), "gradients are traced with rules of their own, which it takes for leaks"),
    "jax_disable_jit": ((True,), "only compiled programs are fast enough"),
    "jax_numpy_dtype_promotion": (("strict",), "whole and real numbers are combined here"),
    "jax_transfer_guard": (DISALLOWED, "arguments are NumPy's numbers"),
    "jax_transfer_guard_host_to_device": (DISALLOWED, "arguments are NumPy's numbers"),
    "jax_no_tracing": ((True,), "programs are traced when they are first called"),
    "jax_no_execution": ((True,), "nothing can be computed"),
}
"""JAX's switches that jaxbuffer cannot work with: the values, and why."""

_told = False  # of slow loops
_forked = False  # after JAX's backend had started


def told_of_slow_loops() -> bool:
    """Whether the user was told of slow loops before; from now on, yes."""
    global _told  # once per process
    before, _told = _told, True
    return before


def check_ready() -> None:
    """Raise unless this process computes in double precision and JAX can work in it; warn, once, if loops are slow.

    **Raises:** `InputError` that names the switch of JAX that is in the way.
    """
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
    _check_switches()
    backend = _backend()
    if told_of_slow_loops():
        return
    if backend == "cpu" and not one_kernel():
        warnings.warn(
            "jb.configure() was not called before JAX's backend started: captures take about ten times longer. "
            "Call it before the first JAX computation.",
            RuntimeWarning,
            stacklevel=4,
        )


def _check_switches() -> None:
    """Raise `InputError` for a switch in `UNSUITABLE`: it would end in JAX's own traceback."""
    import jax

    for name, (values, why) in UNSUITABLE.items():
        value = getattr(jax.config, name)
        value = getattr(value, "value", value)  # of an enumeration
        if value in values:
            wanted = "False" if value is True else {"strict": "'standard'"}.get(value, "'allow'")
            raise InputError(
                f"{name.upper()}={value}: jaxbuffer cannot work with this switch of JAX, because {why};"
                f" take it out of the environment, or call jax.config.update({name!r}, {wanted})"
            )


def _backend() -> str:
    """The name of the backend that JAX computes with. **Raises:** `InputError` where it cannot start."""
    import jax

    try:
        return jax.default_backend()
    except (RuntimeError, AssertionError) as error:
        platforms, name = getattr(jax.config, "jax_platforms", None), os.environ.get("JAX_PLATFORM_NAME")
        chosen = f"JAX_PLATFORMS={platforms}" if platforms else f"JAX_PLATFORM_NAME={name}"
        why = str(error).partition(" (set ")[0] or "it has no such device, or the device's plugin is not installed"
        raise InputError(f"{chosen}: JAX cannot start there: {why}") from None


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

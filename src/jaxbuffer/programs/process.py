"""Process-wide settings that make JAX fast here, whether JAX is ready for them, and what the numbers depend on.

Importing jaxbuffer changes nothing; calling `configure` does.

XLA's CPU backend runs each operation of a loop on its own unless the loop is small. The option below lets it compile a
whole loop into one function, which makes a capture about ten times faster; it must be set before JAX's backend starts.
`xla_flags` has it and the others.
"""

import ctypes
import functools
import hashlib
import os
import platform
import sys
import warnings
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

import jax
import numpy as np
from jax.extend.backend import get_compile_options

from ..errors import InputError
from ..files import cache_folder, user_path
from .store import folder, store_in
from .xla_flags import THRESHOLD, added

PACKAGES = ("jax", "jaxlib", "equinox", "diffrax", "jaxtyping", "lineax", "numpy", "optax", "optimistix")
Kind = Mapping[str, str]
NO_HOME = "the home folder is not known; set JAXBUFFER_CACHE to a folder of your own"
HOST = ("processor", "backend", "XLA")  # what a machine has, rather than an installation
# JAX does not write its files whole in one go, so processes that start together could read a half of what each of them
# compiles all the time, single operations; these take no longer to compile than to read.
WORTH_KEEPING = 0.1  # s of compilation

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

_warned = False  # of slow loops
_forked = False  # after JAX's backend had started


def configure(*, cache: str | Path | bool | None = True) -> None:
    """Switch on one-kernel loops, quick compilation and double precision, and keep compiled programs on disk.

    Call it first, before any JAX computation: the command line, the tests and the benchmarks do. It warns if JAX's
    backend is already up, when the loop option can't take effect any more (all else still does).

    **Arguments:**

    - ``cache``: folder of compiled programs, in which JAX's persistent compilation cache is kept as well. By default it
      is that of the command line, ``$JAXBUFFER_CACHE`` or ``~/.cache/jaxbuffer``; a folder that was given before, to
      jaxbuffer or to JAX, stays. None changes nothing: unless a folder was given before, programs are in memory only.
      Programs are code: a folder to which others can write is not used, and a line on stderr says so
      (docs/security.md).

    **Example:**

    >>> import jaxbuffer as jb
    >>> jb.configure()  # or jb.configure(cache="programs"), or, to keep nothing on disk, jb.configure(cache=None)
    >>> import jax
    >>> jax.numpy.zeros(1).dtype
    dtype('float64')
    """
    jax.config.update("jax_enable_x64", True)
    # A folder that was given before, to jaxbuffer or to JAX, stays.
    if cache is True and folder() is None:
        if (usual := cache_folder()) is None:
            print(f"note: compiled programs are not stored: {NO_HOME}", file=sys.stderr)
        else:
            _keep_programs(usual, jax.config.jax_compilation_cache_dir)  # type: ignore[attr-defined]
    elif cache and cache is not True:
        _keep_programs(user_path(cache))
    flags = os.environ.get("XLA_FLAGS", "")
    if THRESHOLD not in flags:
        if backend_is_up():
            warned_of_slow_loops()
            warnings.warn(
                "jaxbuffer.configure() came after JAX's backend started: loops stay about ten times slower. "
                "Call it before the first JAX computation.",
                RuntimeWarning,
                stacklevel=2,
            )
        else:
            os.environ["XLA_FLAGS"] = " ".join([flags, *added(flags, version("jaxlib"))]).strip()


def _keep_programs(cache: Path, of_jax: str | None = None) -> None:
    """Keep programs in a folder; ``of_jax``: the folder of JAX's own cache where that is to stay what it is."""
    if wrong := store_in(cache):
        print(f"note: compiled programs are not stored: {wrong}", file=sys.stderr)
    elif of_jax is None:
        jax.config.update("jax_compilation_cache_dir", str(cache.resolve()))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", WORTH_KEEPING)


def warned_of_slow_loops() -> bool:
    """Return whether the user was told of slow loops before, and take it that they are now."""
    global _warned  # once per process
    before, _warned = _warned, True
    return before


def check_ready() -> None:
    """Raise unless this process computes in double precision and JAX can work in it; warn, once, if loops are slow.

    **Raises:** `InputError` that names the switch of JAX that is in the way.
    """
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
    try:
        backend = jax.default_backend()
    except (RuntimeError, AssertionError) as error:
        platforms, name = getattr(jax.config, "jax_platforms", None), os.environ.get("JAX_PLATFORM_NAME")
        chosen = f"JAX_PLATFORMS={platforms}" if platforms else f"JAX_PLATFORM_NAME={name}"
        why = str(error).partition(" (set ")[0] or "it has no such device, or the device's plugin is not installed"
        raise InputError(f"{chosen}: JAX cannot start there: {why}") from None
    if warned_of_slow_loops():
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
    for name, (values, why) in UNSUITABLE.items():
        # Read each time, since a switch may be changed at any time.
        value = getattr(jax.config, name)
        value = getattr(value, "value", value)  # of an enumeration
        if value in values:
            remedy = "False" if value is True else {"strict": "'standard'"}.get(value, "'allow'")
            raise InputError(
                f"{name.upper()}={value}: jaxbuffer cannot work with this switch of JAX, because {why};"
                f" take it out of the environment, or call jax.config.update({name!r}, {remedy})"
            )


def one_kernel() -> bool:
    """Return whether loops become one kernel, by the flags JAX's backend started with, or, before, by those it
    would."""
    if not backend_is_up():
        return THRESHOLD in os.environ.get("XLA_FLAGS", "")
    options = get_compile_options(num_replicas=1, num_partitions=1)
    return THRESHOLD.encode() in options.SerializeAsString()


def trim() -> None:
    """Return memory that is free to the system, where the C library (glibc) can."""
    try:
        ctypes.CDLL(None).malloc_trim(0)
    except (AttributeError, OSError, TypeError):
        # Other C libraries have no such function.
        return


def _note_fork() -> None:
    global _forked  # noqa: PLW0603 # of this process
    _forked = _forked or backend_is_up()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)


def backend_is_up() -> bool:
    """Return whether JAX's backend has started, after which XLA's flags are read no more."""
    # JAX refuses another number of devices once its backend is up; there is no other public way to ask.
    devices = jax.config.jax_num_cpu_devices  # type: ignore[attr-defined]
    try:
        jax.config.update("jax_num_cpu_devices", devices + 1)
    except RuntimeError:
        return True
    jax.config.update("jax_num_cpu_devices", devices)
    return False


@functools.cache
def source() -> str:
    """Return a hash of this package's own source."""
    content, top = hashlib.sha256(), Path(__file__).parent.parent
    # Sorted, since file systems list files in orders of their own.
    for file in sorted(top.rglob("*.py")):
        content.update(f"{file.relative_to(top)}\0".encode() + file.read_bytes())
    return content.hexdigest()[:16]


def processor() -> str:
    """Return what the machine's code may use."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    return next((line for line in lines if line.startswith(("flags", "Features"))), platform.platform())


def kind() -> dict[str, str]:
    """Return what numbers depend on, in short words by name: two processes that agree in it compute the same bits."""
    return {
        "jaxbuffer": source(),
        "Python": sys.version.split()[0],
        **{name: version(name) for name in PACKAGES},
        "processor": hashlib.sha256(processor().encode()).hexdigest()[:16],
        "backend": f"{jax.default_backend()} {jax.dtypes.canonicalize_dtype(float)}",
        "XLA": hashlib.sha256(f"{os.environ.get('XLA_FLAGS', '')} {one_kernel()}".encode()).hexdigest()[:16],
    }


@functools.cache
def prepared(address: str, cache: str | None) -> dict[str, str]:
    """Set this process up for computing, once, and return what its numbers depend on.

    **Arguments:** ``address``: of the process that it is, for which a fork is another one; ``cache``: folder of
    compiled programs where $JAXBUFFER_CACHE names none.
    """
    if one_kernel() or not backend_is_up():
        configure(cache=os.environ.get("JAXBUFFER_CACHE") or cache)
    return kind()

"""Process-wide settings that make JAX fast here. Importing jaxbuffer changes nothing; calling this does.

XLA's CPU backend runs each operation of a loop on its own unless the loop is small. The option below lets it compile a
whole loop into one function, which makes a capture about ten times faster; it must be set before JAX's backend starts.
"""

import os
import sys
import warnings
from importlib.metadata import version
from pathlib import Path

from .errors import InputError

THRESHOLD = "xla_cpu_small_while_loop_byte_threshold"
ONE_KERNEL = f"--xla_backend_extra_options={THRESHOLD}=1000000000"
# XLA ends the process at a flag that it does not know: what follows is set only with versions that it was tried on.
TRIED = "0.10."  # of jaxlib
# Our programs compile in two thirds of the time and run as fast without two passes that XLA repeats two dozen times,
# and with all operations in one module instead of one each (docs/numerics.md).
QUICK_COMPILATION = (
    "--xla_disable_hlo_passes=while-loop-invariant-code-motion,simplify-while-loops",
    "--xla_cpu_use_fusion_emitters=false",
    "--xla_cpu_parallel_codegen_split_count=1",
)
# A loop over the lanes of sensitivities becomes vector instructions only if LLVM does not unroll it first, as it does
# with loops this short unless told otherwise: a gradient in three quarters of the time.
SHORT_LOOPS = ",-unroll-full-max-count=7"
WIDE_VECTORS = "--xla_cpu_prefer_vector_width=512"


_told = False  # of slow loops
_forked = False  # after JAX's backend had started


def configure(*, cache: str | Path | None = None) -> None:
    """Switch on one-kernel loops, quick compilation and double precision, and (with ``cache``) keep compiled programs
    on disk.

    Call it first, before any JAX computation: the command line, the tests and the benchmarks do. It warns if JAX's
    backend is already up, when the loop option can't take effect any more (all else still does).

    **Arguments:** ``cache``: folder of JAX's persistent compilation cache and of our own programs (`programs`), or None
    to leave those alone. Programs are code: a folder to which others can write is not used, and a line on stderr says
    so (docs/security.md).
    """
    global _told  # noqa: PLW0603 # once per process
    flags = os.environ.get("XLA_FLAGS", "")
    if THRESHOLD not in flags:
        if _backend_is_up():
            _told = True
            warnings.warn(
                "jaxbuffer.configure() came after JAX's backend started: loops stay about ten times slower. "
                "Call it before the first JAX computation.",
                RuntimeWarning,
                stacklevel=2,
            )
        else:
            os.environ["XLA_FLAGS"] = " ".join([flags, *_flags(flags)]).strip()
    import jax

    jax.config.update("jax_enable_x64", True)
    if cache is not None:
        _keep_programs(Path(cache))


def _keep_programs(cache: Path) -> None:
    import jax

    from .programs import keep_in

    if wrong := keep_in(cache):
        print(f"note: compiled programs are not kept: {wrong}", file=sys.stderr)
        return
    jax.config.update("jax_compilation_cache_dir", str(cache.resolve()))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)


def check_ready() -> None:
    """Raise unless this process computes in double precision and JAX can work in it; warn, once, if loops are slow."""
    global _told  # noqa: PLW0603 # once per process
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
    if _told:
        return
    _told = True
    if jax.default_backend() == "cpu" and not one_kernel():
        warnings.warn(
            "jb.configure() was not called before JAX's backend started: captures take about ten times longer. "
            "Call it before the first JAX computation.",
            RuntimeWarning,
            stacklevel=4,
        )


def one_kernel() -> bool:
    """Whether loops become one kernel: by the flags JAX's backend started with, or, before, by those it would."""
    if not _backend_is_up():
        return THRESHOLD in os.environ.get("XLA_FLAGS", "")
    from jax._src.lib import xla_client

    return THRESHOLD.encode() in xla_client.CompileOptions().SerializeAsString()


def _note_fork() -> None:
    global _forked  # noqa: PLW0603 # of this process
    _forked = _forked or _backend_is_up()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)


def _flags(present: str) -> list[str]:
    """One-kernel loops, and what else this version knows and is not set already."""
    if not version("jaxlib").startswith(TRIED):
        return [ONE_KERNEL]
    others = [flag for flag in (*QUICK_COMPILATION, WIDE_VECTORS) if flag.split("=")[0] not in present]
    return [ONE_KERNEL + SHORT_LOOPS, *others]


def _backend_is_up() -> bool:
    if "jax" not in sys.modules:
        return False
    from jax._src import xla_bridge

    return bool(xla_bridge._backends)

"""Process-wide settings that make JAX fast here. Importing jaxbuffer changes nothing; calling this does.

XLA's CPU backend runs each operation of a loop on its own unless the loop is small. The option below lets it compile a
whole loop into one function, which makes a capture about ten times faster; it must be set before JAX's backend starts.
"""

import os
import sys
import warnings
from importlib.metadata import version
from pathlib import Path

from .backend import THRESHOLD, backend_is_up, told_of_slow_loops

ONE_KERNEL = f"--xla_backend_extra_options={THRESHOLD}=1000000000"
# XLA ends the process at a flag that it does not know: what follows is set only with versions that it was tried on.
TRIED = "0.10."  # of jaxlib
# Our programs compile in two thirds of the time and run as fast without two passes that XLA repeats two dozen times,
# and with all operations in one module instead of one each (docs/decisions.md).
QUICK_COMPILATION = (
    "--xla_disable_hlo_passes=while-loop-invariant-code-motion,simplify-while-loops",
    "--xla_cpu_use_fusion_emitters=false",
    "--xla_cpu_parallel_codegen_split_count=1",
)
# A loop over the lanes of sensitivities becomes vector instructions only if LLVM does not unroll it first, as it does
# with loops this short unless told otherwise: a gradient in three quarters of the time.
SHORT_LOOPS = ",-unroll-full-max-count=7"
WIDE_VECTORS = "--xla_cpu_prefer_vector_width=512"


def configure(*, cache: str | Path | None = None) -> None:
    """Switch on one-kernel loops, quick compilation and double precision, and (with ``cache``) keep compiled programs
    on disk.

    Call it first, before any JAX computation: the command line, the tests and the benchmarks do. It warns if JAX's
    backend is already up, when the loop option can't take effect any more (all else still does).

    **Arguments:**

    - ``cache``: folder of JAX's persistent compilation cache and of our own programs (`programs`), or None to leave
      those alone. Programs are code: a folder to which others can write is not used, and a line on stderr says so
      (docs/security.md).

    **Example:**

    >>> import jaxbuffer as jb
    >>> jb.configure()  # or jb.configure(cache="programs"): the next process need not compile again
    >>> import jax
    >>> jax.numpy.zeros(1).dtype
    dtype('float64')
    """
    flags = os.environ.get("XLA_FLAGS", "")
    if THRESHOLD not in flags:
        if backend_is_up():
            told_of_slow_loops()
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

    from .programs import store_in

    if wrong := store_in(cache):
        print(f"note: compiled programs are not stored: {wrong}", file=sys.stderr)
        return
    jax.config.update("jax_compilation_cache_dir", str(cache.resolve()))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)


def _flags(present: str) -> list[str]:
    """One-kernel loops, and what else this version knows and is not set already."""
    if not version("jaxlib").startswith(TRIED):
        return [ONE_KERNEL]
    others = [flag for flag in (*QUICK_COMPILATION, WIDE_VECTORS) if flag.split("=")[0] not in present]
    return [ONE_KERNEL + SHORT_LOOPS, *others]

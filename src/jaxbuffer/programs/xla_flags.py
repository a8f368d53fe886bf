"""XLA's flags that make JAX fast here, and which of them a version of jaxlib takes.

XLA ends the process at a flag that it does not know, and flags come and go. What the versions of `TAKEN` take was
tried when this was written. With any other version each flag is tried once, in a process of its own, and the answers
are kept beside the compiled programs.
"""

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from .. import files
from . import store

THRESHOLD = "xla_cpu_small_while_loop_byte_threshold"
ONE_KERNEL = f"--xla_backend_extra_options={THRESHOLD}=1000000000"
# A loop over the lanes of sensitivities becomes vector instructions only if LLVM does not unroll it first, as it does
# with loops this short unless told otherwise: a gradient in three quarters of the time.
SHORT_LOOPS = f"{ONE_KERNEL},-unroll-full-max-count=7"
WIDE_VECTORS = "--xla_cpu_prefer_vector_width=512"
# Our programs compile in two thirds of the time and run as fast without two passes that XLA repeats two dozen times,
# and with all operations in one module instead of one each (docs/decisions.md).
FEW_PASSES = "--xla_disable_hlo_passes=while-loop-invariant-code-motion,simplify-while-loops"
ONE_MODULE = "--xla_cpu_parallel_codegen_split_count=1"
NO_EMITTERS = "--xla_cpu_use_fusion_emitters=false"

TRIALS = (SHORT_LOOPS, FEW_PASSES, NO_EMITTERS, ONE_MODULE, WIDE_VECTORS)
TAKEN: dict[str, tuple[str, ...]] = {
    "0.10.": TRIALS,
    "0.12.": (SHORT_LOOPS, FEW_PASSES, ONE_MODULE, WIDE_VECTORS),
}
"""The flags that jaxlib takes, by the beginning of its version."""
COMPILES = "import jax; jax.jit(lambda x: x + 1.0)(1.0)"  # LLVM reads its options when it compiles
PATIENCE = 60.0  # s for a trial; it takes about one


def added(present: str, jaxlib: str) -> list[str]:
    """Return the flags to add to those that are ``present``, for a version of jaxlib.

    A version that is not in `TAKEN` gets one-kernel loops alone where nothing can be kept, because every start would
    wait some seconds for trials.
    """
    taken = next((flags for series, flags in TAKEN.items() if jaxlib.startswith(series)), None)
    if taken is None:
        folder = store.folder()
        taken = () if folder is None else tried(folder, jaxlib)
    others = [flag for flag in taken if flag != SHORT_LOOPS and flag.split("=")[0] not in present]
    return [SHORT_LOOPS if SHORT_LOOPS in taken else ONE_KERNEL, *others]


def tried(folder: Path, jaxlib: str) -> tuple[str, ...]:
    """Return the flags of `TRIALS` that a version of jaxlib takes, as a folder has them or, once, by trial."""
    file = folder / f"flags-of-jaxlib-{jaxlib}.json"
    answers = _read(file)
    if not answers and os.access(folder, os.W_OK):
        with store.being_made(file):  # of many processes that start at once, one tries
            answers = _read(file)
            if not answers:
                answers = dict(zip(TRIALS, _takes(TRIALS), strict=True))
                # A full disk, say: the next start tries again.
                with contextlib.suppress(OSError):
                    files.write(file, json.dumps(answers, indent=1))
    return tuple(flag for flag in TRIALS if answers.get(flag) is True)


def _read(file: Path) -> dict[str, object]:
    """Return a file's answers by flag; none where it is missing, damaged or lacks a flag."""
    try:
        answers = json.loads(file.read_bytes())
    except (OSError, ValueError):
        return {}
    return answers if isinstance(answers, dict) and answers.keys() >= set(TRIALS) else {}


def _takes(flags: Sequence[str]) -> list[bool]:
    """Return for each flag whether a process in which it is set compiles a program; all are tried at once."""
    begun = [_trial(flag) for flag in flags]
    return [ended() for ended in begun]


def _trial(flag: str) -> Callable[[], bool]:
    """Begin the trial of a flag; what is returned waits for it and returns whether it went well."""
    path = os.pathsep.join(place for place in sys.path if place)  # jaxlib is found where this process finds it
    environment = {**os.environ, "XLA_FLAGS": flag, "JAX_PLATFORMS": "cpu", "PYTHONPATH": path}
    nothing = subprocess.DEVNULL
    try:
        process = subprocess.Popen(
            [sys.executable, "-c", COMPILES], env=environment, stdin=nothing, stdout=nothing, stderr=nothing
        )
    except (OSError, ValueError):  # no interpreter to start, in a program that embeds Python
        return lambda: False

    def ended() -> bool:
        try:
            return process.wait(PATIENCE) == 0
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            return False

    return ended

"""Settings of this process that are made before anything heavy is imported: of its memory, and of what XLA prints."""

import ctypes
import gc
import os

GARBAGE_THRESHOLD = 200_000  # objects; tracing a capture makes a million that live, and looking through them costs
TOP_PAD = 64 * 2**20  # bytes, a thread's whole heap at once; growing page by page makes 70 000 system calls in a load
# XLA takes a program that compiles for two minutes for a fault, and prints an alarm that asks for a report of it. What
# has failed raises an exception besides; what is fatal is still printed.
LOG_LEVEL, FATAL = "TF_CPP_MIN_LOG_LEVEL", "3"
M_TOP_PAD = -2  # glibc's malloc.h


def prepare() -> None:
    """Collect garbage rarely, let the heap grow in large pieces (with glibc alone), and keep XLA's alarms to itself
    unless the environment asks for them."""
    os.environ.setdefault(LOG_LEVEL, FATAL)
    gc.set_threshold(GARBAGE_THRESHOLD)
    try:
        ctypes.CDLL(None).mallopt(M_TOP_PAD, TOP_PAD)
    except (AttributeError, OSError, TypeError):
        # Other C libraries have no mallopt, and it is for speed alone.
        return

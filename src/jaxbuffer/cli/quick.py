"""What lets a command answer soon: settings of this process's memory, made before anything heavy is imported."""

import ctypes
import gc

GARBAGE_THRESHOLD = 200_000  # objects; tracing a capture makes a million that live, and looking through them costs
TOP_PAD = 64 * 2**20  # bytes, a thread's whole heap at once; growing page by page makes 70 000 system calls in a load
M_TOP_PAD = -2  # glibc's malloc.h


def prepare() -> None:
    """Collect garbage rarely, and let the heap grow in large pieces; without glibc only the former."""
    gc.set_threshold(GARBAGE_THRESHOLD)
    try:
        ctypes.CDLL(None).mallopt(M_TOP_PAD, TOP_PAD)
    except (AttributeError, OSError, TypeError):
        # Other C libraries have no mallopt, and it is for speed alone.
        return

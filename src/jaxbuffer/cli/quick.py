"""What lets a command answer soon: settings of this process's memory, made before anything heavy is imported."""

import ctypes
import gc

GARBAGE_THRESHOLD = 200_000  # objects; tracing a capture makes a million that live, and looking through them costs
TOP_PAD = 32 * 2**20  # bytes by which a heap grows; the usual 128 KiB make 35 000 system calls to load a program
M_TOP_PAD = -2  # glibc's malloc.h


def prepare() -> None:
    """Collect garbage rarely, and let the heap grow in large pieces; without glibc only the former."""
    gc.set_threshold(GARBAGE_THRESHOLD)
    try:
        ctypes.CDLL(None).mallopt(M_TOP_PAD, TOP_PAD)
    except (AttributeError, OSError, TypeError):
        return

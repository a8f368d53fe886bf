"""Ctrl-C, SIGTERM and SIGHUP end a command in the same way: what is done is kept, the exit code is 128 + the signal."""

import contextlib
import os
import signal
import sys
import time
from types import FrameType

PATIENCE = 1.0  # s in which a second signal counts as the first, repeated


class Ending:
    """Turns the first signal into a `KeyboardInterrupt`; one that comes clearly later ends the process on the spot."""

    def __init__(self) -> None:
        self.number = int(signal.SIGINT)
        self.first: float | None = None
        self.code: object = None  # of the exit, once there is one

    def listen(self) -> None:
        """Catch signals from now on, except those that whoever started this process had ignored, as nohup does."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self)

    def __call__(self, number: int, _: FrameType | None) -> None:
        if self.first is None:
            self.number, self.first = number, time.monotonic()
            raise KeyboardInterrupt
        # Quick repetitions must not cut short what is being saved.
        if time.monotonic() - self.first > PATIENCE:
            os._exit(128 + number)

    def without_tidying(self) -> None:
        """End the process with its exit code, without Python's freeing of every object: 0.5 to 1 s for what the system
        frees anyway.

        Registered first, so that it runs last: threads have ended by then, and the other exit functions have run.
        """
        # Without a code this is no exit of a command, and Python ends as it always does.
        if not isinstance(self.code, int):
            return
        with contextlib.suppress(OSError):
            # `os._exit` drops what is still in Python's buffers.
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(self.code)

    def leave(self) -> None:
        """End the process: an ordinary exit would trip over a compiler still at work in its thread."""
        os._exit(128 + self.number)


ENDING = Ending()

"""The command line: `jaxbuffer simulate|sensitivity|sweep|tune|report`."""

import atexit
from collections.abc import Sequence

from .signals import ENDING


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit with its code."""
    ENDING.listen()
    atexit.register(ENDING.without_tidying)
    try:
        # here, so that a signal during the imports ends the process quietly
        from .entry import main as enter

        enter(arguments)
    except SystemExit as end:
        ENDING.code = end.code
        raise
    except KeyboardInterrupt:  # while modules were being imported
        ENDING.leave()

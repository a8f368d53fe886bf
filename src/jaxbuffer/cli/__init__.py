"""The command line: `jaxbuffer simulate|sensitivity|sweep|tune|report`."""

from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit with its code."""
    from .signals import ENDING

    ENDING.listen()
    try:
        from .entry import main as enter

        enter(arguments)
    except KeyboardInterrupt:  # while modules were being imported
        ENDING.leave()

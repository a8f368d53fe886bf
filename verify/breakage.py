"""What a breakage is."""

from collections.abc import Callable
from typing import NamedTuple


class Breakage(NamedTuple):
    """What is broken, how, and the checks that are run against it."""

    name: str
    what: str
    apply: Callable[[], None]
    checks: tuple[str, ...]

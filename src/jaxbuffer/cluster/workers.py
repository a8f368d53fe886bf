"""Which workers of a cluster may compute: those that would find the same bits."""

import warnings
from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..compiling.kind import HOST, kind
from ..errors import InputError
from .connect import PATIENCE

if TYPE_CHECKING:
    from distributed import Client

Kind = Mapping[str, str]


def prepared(cache: str | None) -> dict[str, str]:
    """This process set up for computing, and what its numbers depend on.

    ``cache``: folder of compiled programs where $JAXBUFFER_CACHE names none; None in the process that asks.
    """
    import os

    if cache is not None:
        from ..compiling.backend import backend_is_up
        from ..compiling.process import configure
        from ..compiling.programs import folder

        if folder() is None:
            if backend_is_up():
                ...
            configure(cache=os.environ.get("JAXBUFFER_CACHE") or cache)
    return kind()


def differing(one: Kind, other: Kind) -> list[str]:
    """The names under which two kinds differ."""
    return [name for name in {**one, **other} if one.get(name) != other.get(name)]

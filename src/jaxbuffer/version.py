"""Which version this is."""

import functools
from importlib import metadata


@functools.cache
def version() -> str:
    """Return the installed version, as in pyproject.toml."""
    try:
        return metadata.version("jaxbuffer")
    except metadata.PackageNotFoundError:  # run from a checkout
        return "not installed"

"""Which version this is."""

import functools
from importlib import metadata


@functools.cache
def version() -> str:
    """The installed version, as in pyproject.toml."""
    try:
        return metadata.version("jaxbuffer")
    except metadata.PackageNotFoundError:  # run from a checkout
        return "not installed"

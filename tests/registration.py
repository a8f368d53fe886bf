"""Mechanisms that are known to one test, or to one file of tests, alone: others list all that there are."""

import contextlib

from jaxbuffer.mechanisms import registry


@contextlib.contextmanager
def registered(mechanism):
    """The mechanism is known within this context."""
    try:
        yield registry.register(mechanism)
    finally:  # alone: others may have been imported meanwhile, which happens once
        registry._BY_DESIGN.pop(mechanism.design)

"""The command line: `jaxbuffer simulate|sensitivity|tune`."""

from .entry import main as main

"""The command line: `jaxbuffer simulate|sensitivity|sweep|tune|report`."""

from .entry import main as main

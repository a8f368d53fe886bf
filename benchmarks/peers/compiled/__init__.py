"""Whole captures in one compiled loop, as written for speed by hand: nothing of Python between start and report."""

from .loop import dop853 as dop853
from .loop import rodas4 as rodas4

"""A latch and a buffer that fit the scenarios of a docking, in closed form."""

from .buffer import size_buffer as size_buffer
from .latch import size_latch as size_latch

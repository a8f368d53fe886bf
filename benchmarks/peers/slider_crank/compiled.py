"""Numba's ``njit`` where there is a Numba; else the functions stay plain Python, which is slow and gives the same."""

from __future__ import annotations

try:
    from numba import njit as njit
except ImportError:

    def njit(function=None, **_):
        """The function as it is."""
        return (lambda inner: inner) if function is None else function

"""The peers by name: each runs one whole capture, ``solve(peer, parameters, rtol, atol)``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType

from scipy.integrate import BDF, DOP853, LSODA, Radau

from . import scipy_peers, sundials
from .course import PeerCapture
from .parameters import Parameters

__all__ = ["PEERS", "PeerCapture", "solve"]

PEERS: Mapping[str, Callable[..., PeerCapture]] = MappingProxyType(
    {
        "SciPy DOP853": partial(scipy_peers.capture, DOP853),
        "SciPy LSODA": partial(scipy_peers.capture, LSODA, implicit=True),
        "SciPy Radau": partial(scipy_peers.capture, Radau, implicit=True),
        "SciPy BDF": partial(scipy_peers.capture, BDF, implicit=True),
        "CVODE Adams": partial(sundials.cvode, "Adams"),
        "CVODE BDF": partial(sundials.cvode, "BDF"),
        "IDA": sundials.ida,
    }
)


def solve(peer: str, parameters: Parameters, rtol: float = 1e-7, atol: float = 1e-9, **options) -> PeerCapture:
    """One capture by the ``peer`` of that name; ``options`` go to its solver as they are.

    The tolerances are scalars for positions [m, rad] and velocities [m/s, rad/s] alike.
    """
    if peer not in PEERS:
        raise ValueError(f"no peer named {peer!r}; there are {', '.join(PEERS)}")
    return PEERS[peer](parameters, rtol, atol, **options)

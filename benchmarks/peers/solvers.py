"""The peers by name: each runs one whole capture, ``solve(peer, parameters, rtol, atol)``."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from types import MappingProxyType

import numpy as np
from scipy.integrate import BDF, DOP853, LSODA, Radau

from . import compiled, scipy_peers, sundials
from .course import PeerCapture
from .parameters import Parameters, Vector
from .start import STATES

__all__ = ["ABSOLUTE", "PEERS", "PeerCapture", "solve", "tolerances"]

COMPILED_CVODE = ("Adams", "BDF") if compiled.HAS_CVODE else ()
PEERS: Mapping[str, Callable[..., PeerCapture]] = MappingProxyType(
    {
        "compiled DOP853": compiled.dop853,
        "compiled RODAS": compiled.rodas4,
        **({f"compiled CVODE {name}": partial(compiled.cvode, name) for name in COMPILED_CVODE}),
        "SciPy DOP853": partial(scipy_peers.capture, DOP853),
        "SciPy LSODA": partial(scipy_peers.capture, LSODA, implicit=True),
        "SciPy Radau": partial(scipy_peers.capture, Radau, implicit=True),
        "SciPy BDF": partial(scipy_peers.capture, BDF, implicit=True),
        "CVODE Adams": partial(sundials.cvode, "Adams"),
        "CVODE BDF": partial(sundials.cvode, "BDF"),
        "IDA": sundials.ida,
    }
)


# atol as parts of rtol, for positions [m, rad] and velocities [m/s, rad/s]. A motion has about 0.1 m and 0.1 m/s, a
# contact 1e-5 m: which of these serves a solver best differs, so that each is given its choice of them.
ABSOLUTE = ((1e-2, 1e-2), (1e-4, 1e-4), (1e-2, 1e-1), (1e-3, 1.0))


def tolerances(rtol: float, parts: tuple[float, float]) -> Vector:
    """Absolute tolerances (25,) of the state, ``parts`` of ``rtol`` for positions and for velocities."""
    atol = np.full(STATES, rtol * parts[1])
    atol[:12] = rtol * parts[0]
    return atol


def solve(peer: str, parameters: Parameters, rtol: float = 1e-7, atol: float | Vector = 1e-9, **options) -> PeerCapture:
    """One capture by the ``peer`` of that name; ``options`` go to its solver as they are.

    ``atol`` is one number for positions [m, rad] and velocities [m/s, rad/s] alike, or one for each state (25,).
    """
    if peer not in PEERS:
        raise ValueError(f"no peer named {peer!r}; there are {', '.join(PEERS)}")
    return PEERS[peer](parameters, rtol, atol, **options)

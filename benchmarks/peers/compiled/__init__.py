"""Whole captures in one compiled loop, as written for speed by hand: nothing of Python between start and report."""

from ..course import PeerCapture
from ..parameters import Parameters, Vector
from .loop import dop853 as dop853
from .loop import rodas4 as rodas4
from .sundials_library import MISSING as MISSING
from .sundials_library import functions

HAS_CVODE = functions() is not None


def cvode(method: str, parameters: Parameters, rtol: float, atol: float | Vector) -> PeerCapture:
    """One capture by CVODE's ``method``, "Adams" or "BDF", driven from compiled code; the first call compiles."""
    from .cvode import capture

    return capture(method, parameters, rtol, atol)

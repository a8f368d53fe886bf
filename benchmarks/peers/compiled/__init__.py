"""Whole captures in one compiled loop, as written for speed by hand: nothing of Python between start and report."""

from .cvode import C as _found
from .cvode import cvode as cvode
from .loop import dop853 as dop853
from .loop import rodas4 as rodas4
from .sundials_library import MISSING as MISSING

HAS_CVODE = _found is not None

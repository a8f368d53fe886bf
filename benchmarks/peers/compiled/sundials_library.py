"""SUNDIALS' C functions for compiled code: from scikit-sundae's wheel, or from the system (Debian: libsundials-dev).

Pointers are passed as whole numbers of their size, which is how numba hands them over.
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_double, c_int, c_int64, c_long, c_size_t
from ctypes.util import find_library
from importlib.util import find_spec
from pathlib import Path

MISSING = "CVODE from compiled code skipped: SUNDIALS' libraries not found"
PARTS = ("core", "nvecserial", "sunmatrixdense", "sunlinsoldense", "cvode")
SIGNATURES = {
    "SUNContext_Create": (c_int, c_int64, c_size_t),
    "SUNContext_ClearErrHandlers": (c_int, c_size_t),
    "N_VMake_Serial": (c_size_t, c_int64, c_size_t, c_size_t),
    "N_VGetArrayPointer": (POINTER(c_double), c_size_t),
    "SUNDenseMatrix": (c_size_t, c_int64, c_int64, c_size_t),
    "SUNDenseMatrix_Data": (POINTER(c_double), c_size_t),
    "SUNLinSol_Dense": (c_size_t, c_size_t, c_size_t, c_size_t),
    "CVodeCreate": (c_size_t, c_int, c_size_t),
    "CVodeInit": (c_int, c_size_t, c_size_t, c_double, c_size_t),
    "CVodeReInit": (c_int, c_size_t, c_double, c_size_t),
    "CVodeSVtolerances": (c_int, c_size_t, c_double, c_size_t),
    "CVodeSetUserData": (c_int, c_size_t, c_size_t),
    "CVodeSetLinearSolver": (c_int, c_size_t, c_size_t, c_size_t),
    "CVodeSetJacFn": (c_int, c_size_t, c_size_t),
    "CVodeRootInit": (c_int, c_size_t, c_int, c_size_t),
    "CVodeSetRootDirection": (c_int, c_size_t, c_size_t),
    "CVodeSetMaxNumSteps": (c_int, c_size_t, c_long),
    "CVodeSetInitStep": (c_int, c_size_t, c_double),
    "CVodeSetStopTime": (c_int, c_size_t, c_double),
    "CVode": (c_int, c_size_t, c_double, c_size_t, c_size_t, c_int),
    "CVodeGetRootInfo": (c_int, c_size_t, c_size_t),
    "CVodeGetNumSteps": (c_int, c_size_t, c_size_t),
    "CVodeGetNumRhsEvals": (c_int, c_size_t, c_size_t),
}


def _file(part: str) -> str | None:
    spec = find_spec("sksundae")
    if spec is not None and spec.origin is not None:
        folder = Path(spec.origin).parent.parent / "scikit_sundae.libs"
        shipped = sorted(folder.glob(f"libsundials_{part}[-.]*so*"))
        if shipped:
            return str(shipped[0])
    return find_library(f"sundials_{part}")


def functions() -> dict[str, ctypes._CFuncPtr] | None:
    """The functions by name, or None where a library is not found."""
    files = [_file(part) for part in PARTS]
    if None in files:
        return None
    libraries = [ctypes.CDLL(file) for file in files]
    table = {}
    for name, (result, *arguments) in SIGNATURES.items():
        function = next((getattr(library, name) for library in libraries if hasattr(library, name)), None)
        if function is None:
            return None
        function.restype, function.argtypes = result, arguments
        table[name] = function
    return table

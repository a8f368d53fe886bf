"""The frequencies of a probe that bends, and the design that has a given one (M108)."""

import numpy as np
from jaxtyping import Array, Float

from ...errors import InputError, check_single, check_type
from ...fields import NON_NEGATIVE, POSITIVE, replace
from .design import Design
from .parts.bending import BENDING_MODES, bending_probe

ONE = "{} is one number"


def bending_frequencies(design: Design) -> Float[Array, " modes"]:
    """Return the natural frequencies of the probe with its tip, clamped in its guide [Hz], shape (modes,), in ascending
    order (M108).

    **Arguments:** ``design``: one whose probe bends.

    **Raises:** `InputError` if it does not.

    **Example:**

    >>> import math
    >>> aluminium = jb.replace(jb.table2(), {"probe.bending_stiffness": 71.7e9 * math.pi * 0.009**4 / 4})  # N m²
    >>> [round(float(f), 1) for f in jb.bending_frequencies(aluminium)[:2]]
    [220.4, 1592.8]
    """
    check_type("design", design, Design, "jb.table2(), say")
    bar = bending_probe(design.probe)
    if bar is None:
        raise InputError("the probe does not bend: give probe.bending_stiffness [N m²]")
    return bar.modes.frequencies()


def with_bending(design: Design, frequency: float, damping_ratio: float = 0.02, modes: int = BENDING_MODES) -> Design:
    """Return the design with a probe that bends at a given first frequency (M108).

    **Arguments:** ``design``; ``frequency``: the first one, clamped in the guide, with the tip [Hz]; ``damping_ratio``:
    ζ of that mode [-], the k-th has ζ f_k/f_1; ``modes``: how many.

    **Raises:** `InputError` for values out of range.

    **Example:**

    >>> soft = jb.with_bending(jb.table2(), 50.0)
    >>> print(f"{float(soft.probe.bending_stiffness):.4g} N m², {float(jb.bending_frequencies(soft)[0]):.4g} Hz")
    19.01 N m², 50 Hz
    """
    check_single("frequency", frequency, "Hz", ONE.format("frequency"), **POSITIVE)
    check_single("damping_ratio", damping_ratio, "-", ONE.format("damping_ratio"), **NON_NEGATIVE)
    # All frequencies go with the root of the bending stiffness: those of 1 N m² tell the one that is wanted.
    unit = replace(design, {"probe.bending_stiffness": 1.0, "probe.bending_modes": modes})
    first = float(bending_frequencies(unit)[0])
    values = {
        "probe.bending_stiffness": (frequency / first) ** 2,
        # The damping ratio of a mode is β ω/2 (M108).
        "probe.bending_damping": damping_ratio / (np.pi * frequency),
    }
    return replace(unit, values)

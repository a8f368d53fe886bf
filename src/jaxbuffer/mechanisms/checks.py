"""Checks of an assembled mechanism: its parts have names of their own, and its magnitudes are numbers."""

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

import jax
import numpy as np

from .._types import Scalar
from ..errors import InputError, concrete
from .system import ContactSystem


def check_names(what: str, names: Iterable[str]) -> None:
    """Raise `InputError` where two have one name. ``what``: what they are, in the plural."""
    for name, count in Counter(names).items():
        if count > 1:
            raise InputError(f"{count} {what} are called {name!r}: give each a name of its own")


def check_magnitudes(system: ContactSystem, others: Mapping[str, Scalar | None], numbers: Any, dimensions: int) -> None:
    """Raise `InputError` for a threshold, scale or tolerance that is no number: NaN is below and above nothing, so that
    what is compared with it is decided without a word.

    **Arguments:** ``system``; ``others``: magnitudes besides its own, by name; ``numbers``: all that these come from.
    Where one of them is traced, or has more axes than so many ``dimensions``, there are no values to look at.
    """
    if any(isinstance(leaf, jax.core.Tracer) or np.ndim(leaf) > dimensions for leaf in jax.tree.leaves(numbers)):
        return
    # A threshold may be -∞, a limit ∞ and a number that nothing stands for None; NaN is wrong everywhere.
    magnitudes: dict[str, tuple[Any, bool]] = {
        **{f"roundoff of {name}": (x, True) for name, x in zip(system.observed, system.roundoff(), strict=True)},
        "scales": (system.scales(), False),
        "scale_limits": (system.scale_limits(), True),
        "typical_speed": (system.typical_speed, False),
        "energy_scale": (system.energy_scale, False),
        "momentum_scale": (system.momentum_scale, False),
        "tolerance_share": (system.tolerance_share, False),
        "invariant_change": (system.invariant_change, False),
        **{name: (value, False) for name, value in others.items()},
    }
    for name, (value, unbounded) in magnitudes.items():
        array = None if value is None else concrete(value)
        if array is not None and not np.all(~np.isnan(array) if unbounded else np.isfinite(array)):
            raise InputError(f"{name} of the assembled mechanism is {array}: give the elements finite numbers")

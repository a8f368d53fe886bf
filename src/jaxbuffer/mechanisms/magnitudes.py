"""The magnitudes that a mechanism's changes are compared with: that each of them is a number."""

from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from ..errors import InputError, concrete

if TYPE_CHECKING:  # `Assembled` checks itself by this
    from .assembled import Assembled


def check_magnitudes(assembled: "Assembled") -> None:
    """Raise `InputError` for a threshold, scale or tolerance that is no number: NaN is below and above nothing, so that
    what is compared with it is decided without a word. Traced numbers have no values to look at."""
    it = assembled
    leaves = jax.tree.leaves((it.system, it.q, it.v, it.elements, it.size, it.parts))
    if any(isinstance(leaf, jax.core.Tracer) or np.ndim(leaf) > np.ndim(it.q) for leaf in leaves):
        return
    # A threshold may be -∞, a limit ∞ and a number that nothing stands for None; NaN is wrong everywhere.
    magnitudes: dict[str, tuple[Any, bool]] = {
        **{f"negligible of {name}": (x, True) for name, x in zip(it.observed, it.negligible(), strict=True)},
        "scales": (it.scales(), False),
        "scale_limits": (it.scale_limits(), True),
        "typical_speed": (it.typical_speed, False),
        "energy_scale": (it.energy_scale, False),
        "momentum_scale": (it.momentum_scale, False),
        "tolerance_share": (it.tolerance_share, False),
        "invariant_change": (it.invariant_change, False),
        "quiet": (it.quiet, False),
    }
    for name, (value, unbounded) in magnitudes.items():
        array = None if value is None else concrete(value)
        if array is not None and not np.all(~np.isnan(array) if unbounded else np.isfinite(array)):
            raise InputError(f"{name} of the assembled mechanism is {array}: give the elements finite numbers")

"""Limits within which a mechanism's answers hold."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from ..contact.laws import BEYOND_LAW as BEYOND_LAW


class ValidityLimit(NamedTuple):
    """How near runs come to a limit.

    ``beyond``: what happens there in words, after `BEYOND_LAW` where it is the contact law's; ``share`` [-] of the
    limit, one for each run, valid up to 1 (NaN: not known).
    """

    beyond: str
    share: Float[np.ndarray, "..."]

    @property
    def passed(self) -> Bool[np.ndarray, "..."]:
        """Return which runs lie beyond the limit."""
        # NaN, which is not known, compares as not beyond it.
        return np.asarray(self.share) > 1.0

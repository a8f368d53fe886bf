"""A change between two values as a share of the first one, where that has a meaning."""

import math


def change_in_words(before: float | None, after: float | None, digits: str = "+.1f") -> str:
    """Return a change in per cent: "+12.5 %".

    A value that is not known, or a sign that changes, has no share of it: "–". Neither has what begins at zero, unless
    it stays there.
    """
    change = relative_change(before, after)
    return "–" if change is None else f"{100.0 * change:{digits}} %"


def relative_change(before: float | None, after: float | None) -> float | None:
    """Return ``after / before - 1`` [-]: 0 where both are 0, None where it has no meaning.

    It has none where a value is not known or not finite, where the first one alone is 0, and where the sign changes.
    """
    if before is None or after is None or not (math.isfinite(before) and math.isfinite(after)):
        return None
    if before == after:
        return 0.0
    if before == 0.0 or before * after < 0.0:
        return None
    change = after / before - 1.0
    return (change if before > 0.0 else -change) if math.isfinite(change) else None


def percent(share: float | None, digits: str = ".2g") -> str:
    """Return a share in per cent: "12 %"; "an unknown share" where it is not known or not finite."""
    return f"{100.0 * share:{digits}} %" if share is not None and math.isfinite(share) else "an unknown share"

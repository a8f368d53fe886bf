"""What the Lagrangian's curvature is, as far as the steps so far have shown it."""

import numpy as np
from jaxtyping import Float

DAMPING = 0.2  # Powell's: keeps the estimate positive definite


def learnt(
    curvature: Float[np.ndarray, "n n"], step: Float[np.ndarray, " n"], change: Float[np.ndarray, " n"]
) -> Float[np.ndarray, "n n"]:
    """Damped BFGS (Nocedal and Wright, procedure 18.2): ``change`` of the Lagrangian's slope over a ``step``.

    It starts from zero, which makes first steps those of the first-order model; the first update that shows positive
    curvature sets its size.
    """
    length, bend = float(step @ step), float(step @ change)
    if length == 0.0 or not np.all(np.isfinite(change)):
        return curvature
    if not np.any(curvature):
        if bend <= 0.0:
            return curvature
        curvature = (bend / length) * np.eye(len(step))
    along = curvature @ step
    expected = float(step @ along)
    if expected <= 0.0:
        return curvature
    share = 1.0 if bend >= DAMPING * expected else (1.0 - DAMPING) * expected / (expected - bend)
    change = share * change + (1.0 - share) * along
    return curvature - np.outer(along, along) / expected + np.outer(change, change) / float(step @ change)

"""What a history shows of one instant."""

from typing import NamedTuple

from jaxtyping import Array, Float

from .._types import Scalar


class Snapshot(NamedTuple):
    """One instant of a run. For each contact that has impacts ``gap`` [m], ``approach_speed`` and ``slip`` [m/s],
    ``normal`` F_n and ``friction`` F_t [N]; ``multipliers`` of the joints' rows [N, N m]; ``others``: the mechanism's
    own by name; ``acceleration``: (coordinates,) q̈ [m/s², m/s², rad/s², …]."""

    gap: Float[Array, " contacts"]
    approach_speed: Float[Array, " contacts"]
    slip: Float[Array, " contacts"]
    normal: Float[Array, " contacts"]
    friction: Float[Array, " contacts"]
    multipliers: Float[Array, " rows"]
    others: dict[str, Scalar]
    acceleration: Float[Array, " coordinates"]

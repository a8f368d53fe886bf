"""Time histories of a run: everything one would plot, at every accepted step."""

from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float

from ..fields import Portable
from ..plane import PLANE
from .energy import Energy

UNITS = {
    **{
        "time": "s",
        "position": "m, m, rad",
        "velocity": "m/s, m/s, rad/s",
        "acceleration": "m/s², m/s², rad/s²",
        "multipliers": "N, N m",
        "gap": "m",
    },
    **{"approach_speed": "m/s", "slip": "m/s", "contact_force": "N", "friction_force": "N"},
}

IN_SPACE = {
    "position": "m, m, m, rad, rad, rad",
    "velocity": "m/s, m/s, m/s, rad/s, rad/s, rad/s",
    "acceleration": "m/s², m/s², m/s², rad/s², rad/s², rad/s²",
}


class History(Portable):
    """Histories along the first axis ("steps").

    ``time`` [s]; ``position`` (steps, bodies, [x, y, angle]) [m, m, rad], ``velocity`` and ``acceleration`` against the
    ground, in space [x, y, z, rotation vector] and [x, y, z, spin]; ``multipliers`` of the joints' rows
    [N, N m]; for each contact of the mechanism that has impacts ``gap`` [m], ``approach_speed`` and ``slip`` [m/s],
    ``contact_force`` F_n and ``friction_force`` F_t [N]; ``others``: the mechanism's own by name, each an attribute too
    (units: `Mechanism.history_units`); ``energy`` [J]. ``state`` of the time stepping and the contacts that are
    ``closed`` from then on (1, else 0): what instants between the steps are found from (`run.instants`); None if they
    were not kept. Inside `jit` the arrays have their full capacity, the last state repeated.

    Derivatives are those at fixed times, so ``time`` has none, though the steps lie elsewhere for other parameters.
    """

    time: Float[Array, " steps"]
    position: Float[Array, "steps bodies positions"]
    velocity: Float[Array, "steps bodies velocities"]
    acceleration: Float[Array, "steps bodies velocities"]
    multipliers: Float[Array, "steps rows"]
    gap: Float[Array, "steps contacts"]
    approach_speed: Float[Array, "steps contacts"]
    slip: Float[Array, "steps contacts"]
    contact_force: Float[Array, "steps contacts"]
    friction_force: Float[Array, "steps contacts"]
    others: dict[str, Float[Array, " steps"]]
    energy: Energy
    state: Float[Array, "steps state"] | None = None
    closed: Float[Array, "steps all_contacts"] | None = None

    def __repr__(self) -> str:
        lines = [f"History of {np.shape(self.time)[0] if np.ndim(self.time) else 1} instants; its arrays:"]
        if not isinstance(self.time, jax.core.Tracer) and np.ndim(self.time) == 1 and np.size(self.time):
            lines[0] = lines[0].replace("; ", f" from {float(self.time[0]):g} to {float(self.time[-1]):.6g} s; ")
        arrays = {name: getattr(self, name) for name in UNITS} | self.others
        units = UNITS if np.shape(self.velocity)[-1] == PLANE.velocities else UNITS | IN_SPACE
        lines += [f"  {name} [{units.get(name, 'own unit')}], shape {np.shape(it)}" for name, it in arrays.items()]
        return "\n".join([*lines, f"  energy [J]: {', '.join(self.energy.names)}"])

    def __getattr__(self, name: str) -> Any:
        # An object without fields yet, as one that is being unpickled, would call this method for ever by
        # `self.others`.
        others = object.__getattribute__(self, "others")
        if name in others:
            return others[name]
        raise AttributeError(f"{type(self).__name__} has no {name!r}")

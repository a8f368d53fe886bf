"""The run of a slider-crank: its largest values include those at the start."""

import jax.numpy as jnp

from ..assembled import Assembled
from ..run import Run, Solved


def cranked(mechanism: Assembled, solved: Solved) -> Run:
    """What was solved; a drive's torque may be largest at the very start, where no event is."""
    open_contacts = jnp.zeros(mechanism.contact_count)
    rate = mechanism.derivative(0.0, solved.start.state, open_contacts)
    first = mechanism.observables_at(solved.start, rate, open_contacts)
    maxima = dict(solved.common["maxima"])
    for name, value in zip(mechanism.observed, first, strict=True):
        if name in maxima:
            maxima[name] = jnp.maximum(maxima[name], value * solved.known)
    return Run(**(solved.common | {"maxima": maxima}))

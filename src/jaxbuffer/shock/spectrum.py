"""The shock response spectrum of a signal, or of a body's motion (M165)."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar
from ..errors import InputError, check_plain, concrete

SAMPLES = 20  # of a period at least: a peak between two of them is then missed by 1.2 % at most
FINE = 400  # samples of the shortest period that a motion is followed with


def shock_spectrum(
    acceleration: Float[Array, " samples"],
    step: float,
    frequencies: Float[Array, " oscillators"],
    damping: Scalar = 0.05,
) -> Float[Array, " oscillators"]:
    """Return the largest absolute acceleration of oscillators on a base that moves with a signal; differentiable by it.

    Smallwood's filter: exact for a signal that is linear between its samples. The residual response is looked at for
    one period of the slowest oscillator after the signal's end.

    **Arguments:**

    - ``acceleration``: (samples,) of the base, zero before and after [m/s²].
    - ``step``: between samples [s].
    - ``frequencies``: (oscillators,) natural ones, at most a twentieth of the sampling rate [Hz].
    - ``damping``: ratio of the critical one, below 1 [-].

    **Returns:** (oscillators,) [m/s²].

    **Raises:** `InputError` for frequencies that are not positive, or too high for the samples.

    **Source:** Smallwood, An improved recursive formula for calculating shock response spectra, 1981.

    **Example:** the half-sine of the longest shock with 5 % damping.

    >>> time = jnp.linspace(0.0, 1.0, 2001)
    >>> f"{float(shock_spectrum(jnp.sin(jnp.pi * time), 1.0 / 2000.0, jnp.array([0.75]), 0.05)[0]):.4f}"
    '1.6449'
    """
    known = np.asarray(frequencies, float)
    highest = 1.0 / (SAMPLES * float(step))
    if not np.all((known > 0.0) & (known <= highest * (1.0 + 1e-9))):
        worst = known[np.argmax(np.where(known > 0.0, known, np.inf))]
        raise InputError(
            f"frequencies hold {worst:.6g} Hz; allowed: (0, {highest:.6g}] Hz, {SAMPLES} samples a period at least"
        )
    rest = int(np.ceil(1.0 / (float(known.min()) * float(step))))
    signal = jnp.pad(jnp.asarray(acceleration, float), (0, rest))
    now, once, twice, back_once, back_twice = _filter(jnp.asarray(known), step, damping)

    def advance(carry: tuple, sample: Array) -> tuple[tuple, Array]:
        x1, x2, y1, y2, largest = carry
        y = now * sample + once * x1 + twice * x2 + back_once * y1 - back_twice * y2
        return (sample, x1, y, y1, jnp.maximum(largest, jnp.abs(y))), jnp.zeros(())

    # At rest before the signal, with the residual response after it in the samples that were padded.
    zeros = jnp.zeros(known.shape)
    return jax.lax.scan(advance, (jnp.zeros(()), jnp.zeros(()), zeros, zeros, zeros), signal)[0][-1]


def spectrum_of_motion(
    time: Float[Array, " instants"],
    velocity: Float[Array, " instants"],
    frequencies: Float[Array, " oscillators"],
    damping: Scalar = 0.05,
) -> Float[Array, " oscillators"]:
    """Return the shock response spectrum of what moves with a body, from its velocity over time; differentiable by
    that.

    Instants may lie unevenly, as those of a run's history do. Between them the velocity goes in straight lines; its
    changes over even steps, 400 in the shortest period, are the acceleration. Before the first and after the last
    instant the velocity stays as it is.

    **Arguments:**

    - ``time``: (instants,) none before the one in front of it [s].
    - ``velocity``: (instants,) of the body in one direction, ``run.history.velocity[:, body, axis]`` say [m/s].
    - ``frequencies``: (oscillators,) natural ones [Hz].
    - ``damping``: ratio of the critical one, below 1 [-].

    **Returns:** (oscillators,) largest absolute accelerations [m/s²].

    **Raises:** `InputError` for frequencies that are not positive, and for times that are not such a list.

    **Example:** a body that is stopped from 2 m/s within 10 ms.

    >>> time, velocity = jnp.array([0.0, 0.01]), jnp.array([2.0, 0.0])
    >>> found = spectrum_of_motion(time, velocity, jnp.array([10.0, 50.0]), 0.0)
    >>> " ".join(f"{a:.0f}" for a in found)
    '124 400'
    """
    for name, numbers, unit in (("frequencies", frequencies, "Hz"), ("time", time, "s"), ("velocity", velocity, "m/s")):
        check_plain(name, numbers, unit)
    known, instants = np.asarray(frequencies, float), concrete(time)
    if instants is None or instants.ndim != 1 or len(instants) < 2 or not np.all(np.diff(instants) >= 0.0):
        raise InputError("time must hold two instants or more, none before the one in front of it [s]")
    if np.shape(velocity) != instants.shape:
        raise InputError(f"velocity has shape {np.shape(velocity)}, time {instants.shape}; both must have one")
    if not known.size or not np.all((known > 0.0) & np.isfinite(known)):
        raise InputError(f"frequencies = {known.tolist()} Hz are out of range; allowed: (0, inf) Hz, at least one")
    step = 1.0 / (FINE * float(known.max()))
    count = int(np.ceil((instants[-1] - instants[0]) / step)) + 1
    # Between the middles of the samples, so that each change of velocity belongs to the sample in its midst.
    edges = jnp.asarray(instants[0] + step * (np.arange(count + 1) - 0.5))
    acceleration = jnp.diff(jnp.interp(edges, instants, velocity)) / step
    return shock_spectrum(acceleration, step, frequencies, damping)


def _filter(frequencies: Array, step: float, damping: Scalar) -> tuple[Array, ...]:
    """Return the weights of the last three samples and of the last two responses."""
    angle = 2.0 * jnp.pi * frequencies * step
    decay = jnp.exp(-damping * angle)
    turn = angle * jnp.sqrt(1.0 - damping**2)
    cosine, sine = decay * jnp.cos(turn), decay * jnp.sin(turn) / turn
    return 1.0 - sine, 2.0 * (sine - cosine), decay**2 - sine, 2.0 * cosine, decay**2

"""What an undamped oscillator answers to a pulse, in closed form (M160 to M164).

Times are over the pulse's duration τ, deflections over the static one of the pulse's peak; r = τ/T is the duration over
the oscillator's natural period. Pulses are sums of steps, ramps, sines and cosines that begin one after the other, and
so are their responses.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar, Values
from ..errors import InputError, suggest

POINTS = 2048  # of the pulse at which its response is looked at before the largest is located
Response = Callable[[Array, Array], Array]  # to an excitation that begins at 0, from 2πr and the time s ≥ 0 since then


class PulsePart(NamedTuple):
    """An excitation that begins within a pulse: ``factor`` times a step, ramp, sine or cosine, from ``start`` on."""

    factor: float
    start: float
    response: Response


Pulse = tuple[PulsePart, ...]


def _step(w: Array, s: Array) -> Array:
    return 1.0 - jnp.cos(w * s)


def _ramp(w: Array, s: Array) -> Array:
    return s - jnp.sin(w * s) / w


def _sine(w: Array, s: Array) -> Array:
    """Return the response to sin πs, without the quotient that is 0/0 in resonance."""
    forced, half = jnp.pi, 0.5 * (w - jnp.pi) * s
    turned = forced * s * jnp.cos(0.5 * (w + forced) * s) * jnp.sinc(half / jnp.pi)
    return w / (w + forced) * (jnp.sin(forced * s) - turned)


def _cosine(w: Array, s: Array) -> Array:
    """Return the response to cos 2πs, without the quotient that is 0/0 in resonance."""
    forced, half = 2.0 * jnp.pi, 0.5 * (w - 2.0 * jnp.pi) * s
    return w * w / (w + forced) * s * jnp.sin(0.5 * (w + forced) * s) * jnp.sinc(half / jnp.pi)


PULSES: Mapping[str, Pulse] = MappingProxyType(
    {
        "rectangle": (PulsePart(1.0, 0.0, _step), PulsePart(-1.0, 1.0, _step)),
        "half-sine": (PulsePart(1.0, 0.0, _sine), PulsePart(1.0, 1.0, _sine)),
        "triangle": (PulsePart(2.0, 0.0, _ramp), PulsePart(-4.0, 0.5, _ramp), PulsePart(2.0, 1.0, _ramp)),
        "terminal-peak saw-tooth": (
            PulsePart(1.0, 0.0, _ramp),
            PulsePart(-1.0, 1.0, _ramp),
            PulsePart(-1.0, 1.0, _step),
        ),
        "initial-peak saw-tooth": (PulsePart(1.0, 0.0, _step), PulsePart(-1.0, 0.0, _ramp), PulsePart(1.0, 1.0, _ramp)),
        "versed sine": (
            *(PulsePart(0.5, 0.0, _step), PulsePart(-0.5, 0.0, _cosine)),
            *(PulsePart(-0.5, 1.0, _step), PulsePart(0.5, 1.0, _cosine)),
        ),
    }
)
"""The pulses by name, each with a peak of 1 and a duration of 1 (M163)."""


def response(pulse: str, ratio: Scalar, time: Values | Scalar) -> Values:
    """Return the deflection of an undamped oscillator at rest before the pulse.

    **Arguments:** ``pulse``: a name in `PULSES`; ``ratio``: r, the pulse's duration over the natural period [-];
    ``time``: over the pulse's duration, after its end too [-].

    **Returns:** the deflection over the static one of the pulse's peak [-].

    **Raises:** `InputError` for a name that is unknown.

    **Example:** half a period after a step the oscillator is twice as far as it would be at rest.

    >>> f"{float(response('rectangle', 1.0, 0.5)):.3f}"
    '2.000'
    """
    w, time = 2.0 * jnp.pi * jnp.asarray(ratio, float), jnp.asarray(time, float)
    parts = _known(pulse)
    return sum((part.factor * part.response(w, jnp.maximum(time - part.start, 0.0)) for part in parts), 0.0 * time)


def largest_response(pulse: str, ratio: Values | Scalar) -> Values:
    """Return the largest deflection in either direction, during the pulse or after it ("maximax"); differentiable.

    **Arguments:** ``pulse``: a name in `PULSES`; ``ratio``: r, the pulse's duration over the natural period, up to 100
    [-].

    **Returns:** over the static deflection of the pulse's peak [-].

    **Raises:** `InputError` for a name that is unknown.

    **Example:** a rectangle's bound of 2 is not that of other pulses.

    >>> f"{float(largest_response('half-sine', 0.809937)):.6f}"
    '1.768458'
    """
    _known(pulse)
    return jnp.vectorize(lambda r: _largest(pulse, r))(jnp.asarray(ratio, float))


def _largest(pulse: str, ratio: Float[Array, ""]) -> Float[Array, ""]:
    """Return the larger of the largest during the pulse, located by Newton's method, and the amplitude after it."""

    def deflection(time: Array) -> Array:
        return response(pulse, ratio, time)

    rate = jax.grad(deflection)
    looked_at = jnp.asarray(np.linspace(0.0, 1.0, POINTS + 1))
    time = looked_at[jnp.argmax(jnp.abs(jax.vmap(deflection)(looked_at)))]
    for _ in range(4):
        slope, curvature = rate(time), jax.grad(rate)(time)
        # Guarded: a pulse may leave the oscillator at rest, where nothing curves.
        move = jnp.where(curvature == 0.0, 0.0, slope / jnp.where(curvature == 0.0, 1.0, curvature))
        # Kept within the spacing of the points looked at: Newton's method must not leave its maximum for another.
        time = jnp.clip(time - jnp.clip(move, -1.0 / POINTS, 1.0 / POINTS), 0.0, 1.0)
    during = jnp.abs(deflection(jax.lax.stop_gradient(time)))  # where the rate is zero, moving the time changes nothing
    after = jnp.hypot(deflection(jnp.ones(())), _rate_at_the_end(pulse, ratio) / (2.0 * jnp.pi * ratio))
    return jnp.maximum(during, after)


def _rate_at_the_end(pulse: str, ratio: Float[Array, ""]) -> Float[Array, ""]:
    """Return the rate just before the pulse's end, where parts that begin there have no rate yet."""
    w = 2.0 * jnp.pi * ratio
    parts = [part for part in PULSES[pulse] if part.start < 1.0]
    return sum((part.factor * jax.grad(part.response, 1)(w, jnp.asarray(1.0 - part.start)) for part in parts), 0.0 * w)


def _known(pulse: str) -> Pulse:
    if pulse not in PULSES:
        raise InputError(f"pulse = {pulse!r} is unknown; choose one of {', '.join(PULSES)}{suggest(pulse, PULSES)}")
    return PULSES[pulse]

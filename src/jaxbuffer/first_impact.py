"""The first impact's peak force in closed form, from the effective kinetic energy just before it.

T_c⁻ = ½ m_c v², with m_c the mass that the contact normal meets through the joints and v the approach speed. Without
friction, loss and the buffer's answer the peak is Hertz's: K^{2/5} (5 T_c⁻/2)^{3/5}. Springs and dampers are slow
against an impact of a tenth of a millisecond and only add to it: no buffer lowers it, only what meets the cone does.
"""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ._types import Scalar
from .contact.laws import HystereticLaw
from .mechanisms import CaptureMechanism, Design, Scenario, check_fit
from .mechanisms.assembly import LOWER, N
from .mechanisms.probe_in_cone import Posture
from .mechanisms.stiffness import contact_directions
from .programs import kept

HERTZ_DURATION = 2.943275  # of a lossless impact, times its largest penetration over its approach speed [-]


class FirstImpact(eqx.Module):
    """What the start of a run says of its first impact, differentiable.

    ``effective_mass`` m_c [kg]; ``effective_energy`` T_c⁻ [J]; ``elastic_peak`` [N]: K^{2/5} (5 T_c⁻/2)^{3/5};
    ``predicted_peak`` [N]: the same with the law's loss, NaN for laws that are not Hertz's with hysteresis;
    ``duration`` [s] of the impact without loss.
    """

    effective_mass: Float[Array, ""]
    effective_energy: Float[Array, ""]
    elastic_peak: Float[Array, ""]
    predicted_peak: Float[Array, ""]
    duration: Float[Array, ""]


def first_impact(design: Design, scenario: Scenario | None = None) -> FirstImpact:
    """The first impact of a capture, without simulating it: a starting guess, and what no buffer goes below.

    **Raises:** `InputError` where scenario and design don't fit.
    """
    scenario = Scenario() if scenario is None else scenario
    check_fit(design, scenario)
    return _first_impact(
        jax.tree.map(lambda x: x if isinstance(x, jax.Array) else np.asarray(x, float), (design, scenario))
    )


@kept
def _first_impact(parameters: tuple[Design, Scenario]) -> FirstImpact:
    mechanism = CaptureMechanism(*parameters)
    return predict(mechanism, mechanism.first_posture()[0])


def predict(mechanism: CaptureMechanism, at: Posture) -> FirstImpact:
    """The first impact of a mechanism's run, which starts there with the tip on the lower flank."""
    closing, speed = contact_directions(mechanism, at)[:N, LOWER], mechanism.memory(at.state)[LOWER]
    mass = mechanism.system.effective_mass(at.kin, closing)
    energy = 0.5 * mass * speed**2
    law = mechanism.pair.law
    stiffness = jnp.asarray(mechanism.design.contact_stiffness)
    peak, depth = hertz_peak(stiffness, energy), (2.5 * energy / stiffness) ** 0.4
    factor = loss_factor(law.hysteresis) if isinstance(law, HystereticLaw) else jnp.full((), jnp.nan)
    return FirstImpact(mass, energy, peak, peak * factor, HERTZ_DURATION * depth / speed)


def hertz_peak(stiffness: Scalar, energy: Scalar) -> Float[Array, ""]:
    """K^{2/5} (5 T/2)^{3/5} [N]: the peak force of a Hertz contact K δ^{3/2} that takes up the energy T [J]."""
    return jnp.asarray(stiffness) ** 0.4 * (2.5 * jnp.asarray(energy)) ** 0.6


def loss_factor(hysteresis: Scalar) -> Float[Array, ""]:
    """Peak force of two free bodies under K δ^{3/2} (1 + χ̂ δ̇/δ̇⁻), over that without loss.

    With w = δ̇/δ̇⁻ the motion is δ^{5/2} = (5 m v²/2K) G(w), G = (1 - w)/χ̂ - ln[(1 + χ̂)/(1 + χ̂ w)]/χ̂²; the force is
    largest where 3 w/5 = χ̂ G, which bisection finds.
    """
    damping = jnp.maximum(jnp.asarray(hysteresis, float), 1e-4)  # below, G loses its digits and the factor is 1 - 0.4 χ̂

    def taken_up(w: Array, damping: Array) -> Array:
        return ((1.0 - w) - jnp.log((1.0 + damping) / (1.0 + damping * w)) / damping) / damping

    still = jax.lax.stop_gradient(damping)

    def halved(_: Array, bracket: tuple[Array, Array]) -> tuple[Array, Array]:
        low, high = bracket
        middle = 0.5 * (low + high)
        early = 0.6 * middle > still * taken_up(middle, still)
        return jnp.where(early, low, middle), jnp.where(early, middle, high)

    w, _ = jax.lax.fori_loop(0, 50, halved, (jnp.zeros(()), jnp.ones(())))  # the factor is stationary there
    factor = (2.0 * taken_up(w, damping)) ** 0.6 * (1.0 + damping * w)
    return jnp.where(hysteresis < 1e-4, 1.0 - 0.4 * hysteresis, factor)

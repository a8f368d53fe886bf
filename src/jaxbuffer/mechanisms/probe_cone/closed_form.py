"""The first impact's peak force in closed form, from the effective kinetic energy just before it (M79).

Without friction, loss and the buffer's answer the peak is Hertz's (M80). Springs and dampers are slow against an impact
of a tenth of a millisecond and only add to it: no buffer lowers the first peak, less effective mass does.
"""

import functools
from typing import Any, cast

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..._types import Scalar
from ...contact.laws import HystereticLaw
from ...errors import check_type
from ...fields import Curve, Part, get, paths
from ...programs.cache import stored
from ..assembled import Assembled
from ..layout import EvaluatedState
from ..registry import mechanism_of
from .assembly import LOWER
from .bodies import TIP
from .capture import FirstImpact
from .design import DockingDesign, Meeting
from .reading import flank_direction

NO_EFFECT = 1e-12  # an elasticity that is rounding: in space a roll inertia's is not quite zero
HERTZ_DURATION = 2.943275  # of a lossless impact, times its largest penetration over its approach speed [-]


AnyDesign = DockingDesign[Any]


def first_impact(design: AnyDesign, scenario: Meeting | None = None) -> FirstImpact:
    """Return the first impact of a capture, without simulating it: a starting guess, and what no buffer goes below (M79
    to M81).

    **Arguments:**

    - ``design``: in the plane or in space.
    - ``scenario`` (default: Table 2's).

    **Returns:** a `FirstImpact`.

    **Raises:** `InputError` where scenario and design don't fit.

    **Example:**

    >>> first = jb.first_impact(jb.table2(), jb.Scenario(approach_speed=0.1))
    >>> print(f"{float(first.predicted_peak):.1f} N, {float(first.elastic_peak):.1f} N without loss")
    143.1 N, 149.9 N without loss
    """
    check_type("design", design, DockingDesign, "the design first, such as jb.table2(), then the scenario")
    mechanism = mechanism_of(design)
    meeting = mechanism.scenario() if scenario is None else scenario
    mechanism.check_fit(design, meeting)
    return _first_impact(_arrays(design, cast(Meeting, meeting)))


def first_impact_elasticities(design: AnyDesign, scenario: Meeting) -> dict[str, float]:
    """Return the elasticities of the first impact's elastic peak (M80) by the numbers of a design that change it, by
    path: the change in per cent for one per cent more of a number [-]. There are none of a free start."""
    slopes = _log_peak_slopes(_arrays(design, scenario))
    elasticities = dict[str, float]()
    for path in paths(design):
        value = get(design, path)
        if value is None or isinstance(value, (str, bool, int, Curve)):
            continue
        elasticity = float(value) * float(get(slopes, path))
        if abs(elasticity) > NO_EFFECT:  # NaN compares as not above
            elasticities[path] = elasticity
    return elasticities


def _arrays(design: AnyDesign, scenario: Meeting) -> tuple[AnyDesign, Meeting]:
    return jax.tree.map(lambda x: x if isinstance(x, jax.Array) else np.asarray(x, float), (design, scenario))


def assembled(design: Part, scenario: Part) -> Assembled:
    """Return a design in a scenario, in the plane or in space as the design is."""
    return cast(Assembled, mechanism_of(design).system(design, scenario))


@functools.partial(stored, what="the first impact's closed form")
def _first_impact(parameters: tuple[AnyDesign, Meeting]) -> FirstImpact:
    mechanism = assembled(*parameters)
    return predict(mechanism, *first_flank(mechanism, mechanism.first_evaluation()[0]))


@functools.partial(stored, what="the first impact's elasticities")
def _log_peak_slopes(parameters: tuple[AnyDesign, Meeting]) -> AnyDesign:
    """Return the slopes of the logarithm of the elastic peak by the numbers of the design, in the design's form."""

    def log_peak(design: AnyDesign) -> Float[Array, ""]:
        mechanism = assembled(design, parameters[1])
        return jnp.log(predict(mechanism, *first_flank(mechanism, mechanism.first_evaluation()[0])).elastic_peak)

    return jax.grad(log_peak)(parameters[0])


def predict(mechanism: Assembled, mass: Float[Array, ""], speed: Float[Array, ""]) -> FirstImpact:
    """Return the first impact of a mechanism's run, which starts there with the tip on the lower flank.

    **Arguments:** ``mass``: that the flank meets [kg]; ``speed``: of approach [m/s].
    """
    energy = 0.5 * mass * speed**2
    law = mechanism.element(TIP).pair.law
    stiffness = jnp.asarray(mechanism.parts.design.contact_stiffness)
    peak, depth = hertz_peak(stiffness, energy), (2.5 * energy / stiffness) ** 0.4
    factor = loss_factor(law.hysteresis) if isinstance(law, HystereticLaw) else jnp.full((), jnp.nan)
    first = FirstImpact(mass, energy, peak, peak * factor, HERTZ_DURATION * depth / speed)
    if mechanism.parts.scenario.start != "free":
        return first
    return jax.tree.map(lambda number: jnp.nan * number, first)  # a free start says nothing of the first impact


def first_flank(mechanism: Assembled, at: EvaluatedState) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """Return the effective mass [kg] that the lower flank meets, the joints holding and the springs soft, and the
    contact's memory [m/s]: 1/m = A M_c⁻¹ Aᵀ, where A q̇ is the approach speed."""
    return mechanism.system.effective_mass(at.kin, flank_direction(mechanism, at)), mechanism.memory(at.state)[LOWER]


def hertz_peak(stiffness: Scalar, energy: Scalar) -> Float[Array, ""]:
    """Return the peak force of a Hertz contact that takes up an energy [N] (M80).

    **Arguments:** ``stiffness``: K [N/m^1.5]; ``energy``: T [J].
    """
    return jnp.asarray(stiffness) ** 0.4 * (2.5 * jnp.asarray(energy)) ** 0.6


def loss_factor(hysteresis: Scalar) -> Float[Array, ""]:
    """Return the peak force of two free bodies with hysteresis over that without [-] (M81).

    The equation for w, the share of the speed that is left at the peak, is solved by bisection.

    **Arguments:** ``hysteresis``: χ̂ [-].
    """
    damping = jnp.maximum(jnp.asarray(hysteresis, float), 1e-4)  # below, G loses its digits and the factor is 1 - 0.4 χ̂

    def taken_up(w: Array, damping: Array) -> Array:
        return ((1.0 - w) - jnp.log((1.0 + damping) / (1.0 + damping * w)) / damping) / damping

    # The factor is stationary at w, so that its derivative needs none of w: the bisection is left out of it.
    still = jax.lax.stop_gradient(damping)

    def halved(_: Array, bracket: tuple[Array, Array]) -> tuple[Array, Array]:
        low, high = bracket
        middle = 0.5 * (low + high)
        early = 0.6 * middle > still * taken_up(middle, still)
        return jnp.where(early, low, middle), jnp.where(early, middle, high)

    # Fifty halvings of a bracket of length one leave less than rounding.
    w, _ = jax.lax.fori_loop(0, 50, halved, (jnp.zeros(()), jnp.ones(())))  # the factor is stationary there
    factor = (2.0 * taken_up(w, damping)) ** 0.6 * (1.0 + damping * w)
    return jnp.where(hysteresis < 1e-4, 1.0 - 0.4 * hysteresis, factor)

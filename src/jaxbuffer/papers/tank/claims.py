"""What the paper's text claims, and what the model says to each."""

from typing import Any

import jax.numpy as jnp
import numpy as np

from ...shock.pressure import hertz_shear
from ...shock.pulses import largest_response
from ..claims import Claim, Rows, Value, cell, column, listed, near

PULSES = ("half-sine", "triangle", "versed sine", "rectangle")
RATIOS = (0.2, 0.3, 0.4)  # Poisson's
NODE, MULTIPLIER = range(2)  # cases of the study of contact; penalties of growing stiffness are the others
PENALTIES = slice(2, None)


def _printed_depth(ratio: Any) -> Any:
    return 2.0 / ((1.0 + ratio) * np.pi)


def _shear_depths(_: Rows) -> Any:
    """Return the depth of the largest shear by Hertz, of the contact's radius, for each of `RATIOS`."""
    depths = np.linspace(0.2, 1.0, 8001)
    return np.array([depths[int(np.argmax(np.asarray(hertz_shear(jnp.asarray(depths), nu))))] for nu in RATIOS])


def _largest_responses(_: Rows) -> Any:
    """Return the largest response over the pulse's peak with T_n < τ, for each of `PULSES`."""
    ratio = jnp.linspace(1.0, 10.0, 400)
    return np.array([float(jnp.max(largest_response(pulse, ratio))) for pulse in PULSES])


def _last_strong(_: Rows) -> Any:
    """Return the largest τ/T_n below 1 from which on down responses are below the pulse's peak, for each of
    `PULSES`."""
    ratio = jnp.linspace(0.01, 0.999, 400)
    weak = [np.asarray(largest_response(pulse, ratio)) < 1.0 for pulse in PULSES]
    return np.array([float(ratio[int(np.argmin(it)) - 1]) for it in weak])


ALONG, ACROSS = (1e3 * cell("drop", 0, name) for name in ("deflection", "sideways"))
ORDER = column("drop", "order")
NODE_DEPTH, MULTIPLIER_DEPTH = (cell("contact", case, "penetration") for case in (NODE, MULTIPLIER))
PENALTY_DEPTHS = column("contact", "penetration", PENALTIES)
EXACT = 1e-2 * PENALTY_DEPTHS.map(min)
# A defence node closes its pair alone; multipliers, which close all pairs together, are the measure of that.
IMPULSE, FORCE = ([cell("contact", case, name) for case in (NODE, MULTIPLIER)] for name in ("impulse", "peak_force"))
IMPULSE_OFF, FORCE_OFF = (abs(value[NODE] / value[MULTIPLIER] - 1.0) for value in (IMPULSE, FORCE))
PENALTY_FORCES, STEPS = column("contact", "peak_force", PENALTIES), column("contact", "steps")
SPRING_SHARES = column("height", "peak_force") / column("height", "spring_force")
PEAK_AT = column("height", "peak_time") / column("height", "contact_time")
HEIGHTS = column("height", "case")
DEPTHS, RESPONSES, LAST_STRONG = Value(_shear_depths), Value(_largest_responses), Value(_last_strong)
RATIO, PULSE = Value(lambda rows: np.array(RATIOS)), Value(lambda rows: np.array(PULSES))

CLAIMS = (
    Claim(
        "The safety of the full tank is evaluated: 348 kg from 2.04 m",
        "4, 5",
        "{}; the paper prints no result to compare with",
        (
            listed(
                "{}: {}, {:.3g} kN, top down by {:.3g} mm, plastic strain {:.2g}",
                *(column("drop", "case"), column("drop", "outcome"), 1e-3 * column("drop", "peak_force")),
                *(1e3 * column("drop", "deflection"), column("drop", "plastic_strain")),
                joint="; ",
            ),
        ),
    ),
    Claim(
        "The major deformation is along the impact",
        "4, fig. 3",
        "full: {:.3g} mm along the impact, {:.3g} mm across",
        (ALONG, ACROSS),
        (ALONG > ACROSS,),
    ),
    Claim(
        "Simulation and experiment agree at the test point",
        "4, fig. 4",
        "the curves of fig. 4 are lost and the text prints no value of either",
    ),
    Claim(
        "Failure forms come in an order of time",
        "3",
        "{}",
        (listed("{}: {}", column("drop", "case"), ORDER, joint="; "),),
        (ORDER != "none",),
    ),
    Claim(
        "The defence node satisfies the constraint exactly",
        "3.2",
        "wall in the slider by {:.2g} µm, multipliers {:.2g} µm, penalties {:.3g} mm",
        (1e6 * NODE_DEPTH, 1e6 * MULTIPLIER_DEPTH, 1e3 * PENALTY_DEPTHS),
        (NODE_DEPTH < EXACT, MULTIPLIER_DEPTH < EXACT),
    ),
    Claim(
        "The defence node computes the contact force accurately",
        "3.2",
        "impulse within 20 ms {:.5g} against {:.5g} N s by multipliers ({:.1%} apart), largest force {:.4g} against "
        "{:.4g} kN ({:.0%})",
        (*IMPULSE, IMPULSE_OFF, *(1e-3 * force for force in FORCE), FORCE_OFF),
        (IMPULSE_OFF < 0.02, FORCE_OFF < 0.02),
    ),
    Claim(
        "A penalty adds an error and affects stability",
        "3.2",
        "{:.3g} kN for a stiffness ten times as large each; steps {:.0f}",
        (1e-3 * PENALTY_FORCES, STEPS),
        (
            PENALTY_FORCES[0] < 0.9 * PENALTY_FORCES[-1],
            STEPS[-1] > STEPS[0],
        ),
    ),
    Claim(
        "From a low height a cushion is a mass on a spring",
        "3.1",
        "largest force over that of the cushion alone: {}; at {} it comes after {:.2f} of the contact, a spring's "
        "after half",
        (listed("{} {:.0%}", HEIGHTS, SPRING_SHARES), HEIGHTS[0], PEAK_AT[0]),
        (abs(SPRING_SHARES[0] - 1.0) < 0.05, abs(PEAK_AT[0] - 0.5) < 0.05),
    ),
    Claim(
        "The surface pressure is largest at half of the contact's time",
        "2.1",
        "largest force at this share of the time in contact: {}",
        (listed("{} {:.2f}", HEIGHTS, PEAK_AT),),
        (abs(PEAK_AT - 0.5) < 0.05,),
    ),
    Claim(
        "The shear is largest at the depth 2/((1 + ν)π)",
        "2.1, eq. 1",
        "Hertz (eq. 1 as printed grows with depth): {}",
        (listed("ν = {:g}: {:.3f} against {:.3f}", RATIO, DEPTHS, _printed_depth(RATIO)),),
        (near(DEPTHS, _printed_depth(RATIO)),),
    ),
    Claim(
        "With T_n < τ the response may be twice the pulse's peak",
        "3.1",
        "largest response over the pulse's peak: {}",
        (listed("{} {:.3f}", PULSE, RESPONSES),),
        (abs(RESPONSES - 2.0) < 0.01,),
    ),
    Claim(
        "With T_n > τ the response is weakened",
        "3.1",
        "below the pulse's peak only from this T_n on: {}",
        (listed("{} {:.2g} τ", PULSE, 1.0 / LAST_STRONG),),
        (LAST_STRONG > 0.95,),
    ),
)

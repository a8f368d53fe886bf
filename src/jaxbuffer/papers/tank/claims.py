"""What the paper's text claims, and what the model says to each."""

import jax.numpy as jnp
import numpy as np

from ...shock.pressure import hertz_shear
from ...shock.pulses import largest_response
from ..study import OPEN, Claims, ClaimVerdict, Rows, number, verdict

PULSES = ("half-sine", "triangle", "versed sine", "rectangle")


CLAIMS = Claims()


@CLAIMS.judge("The safety of the full tank is evaluated: 348 kg from 2.04 m", "4, 5")
def _survives(rows: Rows) -> ClaimVerdict:
    finding = "; ".join(
        f"{row['case']}: {row['outcome']}, {1e-3 * number(row, 'peak_force'):.3g} kN, top down by "
        f"{1e3 * number(row, 'deflection'):.3g} mm, plastic strain {number(row, 'plastic_strain'):.2g}"
        for row in rows["drop"]
    )
    return ClaimVerdict(f"{finding}; the paper prints no result to compare with", OPEN)


@CLAIMS.judge("The major deformation is along the impact", "4, fig. 3")
def _along(rows: Rows) -> ClaimVerdict:
    row = rows["drop"][0]
    along, across = (1e3 * number(row, name) for name in ("deflection", "sideways"))
    return ClaimVerdict(f"full: {along:.3g} mm along the impact, {across:.3g} mm across", verdict([along > across]))


@CLAIMS.judge("Simulation and experiment agree at the test point", "4, fig. 4")
def _experiment(rows: Rows) -> ClaimVerdict:
    return ClaimVerdict("the curves of fig. 4 are lost and the text prints no value of either", OPEN)


@CLAIMS.judge("Failure forms come in an order of time", "3")
def _order(rows: Rows) -> ClaimVerdict:
    finding = "; ".join(f"{row['case']}: {row['order']}" for row in rows["drop"])
    return ClaimVerdict(finding, verdict([row["order"] != "none" for row in rows["drop"]]))


@CLAIMS.judge("The defence node satisfies the constraint exactly", "3.2")
def _exact(rows: Rows) -> ClaimVerdict:
    node, multiplier, *penalties = (number(row, "penetration") for row in rows["contact"])
    soft = ", ".join(f"{1e3 * p:.3g}" for p in penalties)
    finding = f"wall in the slider by {1e6 * node:.2g} µm, multipliers {1e6 * multiplier:.2g} µm, penalties {soft} mm"
    return ClaimVerdict(finding, verdict([node < 1e-2 * min(penalties), multiplier < 1e-2 * min(penalties)]))


@CLAIMS.judge("The defence node computes the contact force accurately", "3.2")
def _force(rows: Rows) -> ClaimVerdict:
    node, multiplier = ([number(row, name) for name in ("impulse", "peak_force")] for row in rows["contact"][:2])
    # A defence node closes its pair alone; multipliers, which close all pairs together, are the measure of that.
    off = [abs(a / b - 1.0) for a, b in zip(node, multiplier, strict=True)]
    finding = (
        f"impulse within 20 ms {node[0]:.5g} against {multiplier[0]:.5g} N s by multipliers ({off[0]:.1%} apart), "
        f"largest force {1e-3 * node[1]:.4g} against {1e-3 * multiplier[1]:.4g} kN ({off[1]:.0%})"
    )
    return ClaimVerdict(finding, verdict([part < 0.02 for part in off]))


@CLAIMS.judge("A penalty adds an error and affects stability", "3.2")
def _penalty(rows: Rows) -> ClaimVerdict:
    penalties = rows["contact"][2:]
    forces = ", ".join(f"{1e-3 * number(row, 'peak_force'):.3g}" for row in penalties)
    steps = [number(row, "steps") for row in rows["contact"]]
    finding = f"{forces} kN for a stiffness ten times as large each; steps {', '.join(f'{s:.0f}' for s in steps)}"
    differs = number(penalties[0], "peak_force") < 0.9 * number(penalties[-1], "peak_force")
    return ClaimVerdict(finding, verdict([differs, steps[-1] > steps[0]]))


@CLAIMS.judge("From a low height a cushion is a mass on a spring", "3.1")
def _spring(rows: Rows) -> ClaimVerdict:
    shares = {str(row["case"]): number(row, "peak_force") / number(row, "spring_force") for row in rows["height"]}
    finding = ", ".join(f"{case} {share:.0%}" for case, share in shares.items())
    first = rows["height"][0]
    at = number(first, "peak_time") / number(first, "contact_time")
    near = abs(float(next(iter(shares.values()))) - 1.0) < 0.05
    finding += f"; at {first['case']} it comes after {at:.2f} of the contact, a spring's after half"
    return ClaimVerdict(
        f"largest force over that of the cushion alone: {finding}", verdict([near, abs(at - 0.5) < 0.05])
    )


@CLAIMS.judge("The surface pressure is largest at half of the contact's time", "2.1")
def _half(rows: Rows) -> ClaimVerdict:
    shares = [number(row, "peak_time") / number(row, "contact_time") for row in rows["height"]]
    cases = ", ".join(f"{row['case']} {share:.2f}" for row, share in zip(rows["height"], shares, strict=True))
    finding = f"largest force at this share of the time in contact: {cases}"
    return ClaimVerdict(finding, verdict([abs(share - 0.5) < 0.05 for share in shares]))


@CLAIMS.judge("The shear is largest at the depth 2/((1 + ν)π)", "2.1, eq. 1")
def _shear(rows: Rows) -> ClaimVerdict:
    depths = np.linspace(0.2, 1.0, 8001)
    depth = {nu: depths[int(np.argmax(np.asarray(hertz_shear(jnp.asarray(depths), nu))))] for nu in (0.2, 0.3, 0.4)}
    finding = ", ".join(f"ν = {nu:g}: {s:.3f} against {2.0 / ((1.0 + nu) * np.pi):.3f}" for nu, s in depth.items())
    near = [abs(s * (1.0 + nu) * np.pi / 2.0 - 1.0) < 0.03 for nu, s in depth.items()]
    return ClaimVerdict(f"Hertz (eq. 1 as printed grows with depth): {finding}", verdict(near))


@CLAIMS.judge("With T_n < τ the response may be twice the pulse's peak", "3.1")
def _twice(rows: Rows) -> ClaimVerdict:
    ratio = jnp.linspace(1.0, 10.0, 400)
    most = {pulse: float(jnp.max(largest_response(pulse, ratio))) for pulse in PULSES}
    finding = "largest response over the pulse's peak: " + ", ".join(f"{name} {x:.3f}" for name, x in most.items())
    return ClaimVerdict(finding, verdict([abs(x - 2.0) < 0.01 for x in most.values()]))


@CLAIMS.judge("With T_n > τ the response is weakened", "3.1")
def _weakened(rows: Rows) -> ClaimVerdict:
    ratio = jnp.linspace(0.01, 0.999, 400)
    below = {}
    for pulse in PULSES:
        weak = np.asarray(largest_response(pulse, ratio)) < 1.0
        below[pulse] = float(ratio[int(np.argmin(weak)) - 1])
    finding = ", ".join(f"{name} {1.0 / x:.2g} τ" for name, x in below.items())
    return ClaimVerdict(
        f"below the pulse's peak only from this T_n on: {finding}", verdict([x > 0.95 for x in below.values()])
    )

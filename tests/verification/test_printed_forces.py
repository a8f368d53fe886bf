"""The docking paper's eq. 22 and 23, as printed and as corrected (docs/model.md, slips), against its eq. 7 to 10."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer import Scenario, replace, table2
from jaxbuffer.mechanisms.probe_cone.assembly import assemble

K_A, C_A, K_T, C_T, L_0 = 500.0, 5.0, 300.0, 2.0, 0.1365  # the paper's section 7
A_S, L_C, L_P = 0.1365, 0.1365, 0.2  # Table 2's a, L_C, L_P
PRINTED, CORRECTED = "printed", "corrected"
WRONG = {6, 7, 9, 16}  # whose printed form contradicts eq. 7 to 10


def state(seed=1):
    """Positions y1 to y12 and velocities y13 to y24, the probe some 0.2 m ahead of the cylinder, all else at random."""
    random = np.random.default_rng(seed)
    q = np.concatenate([random.normal(size=3), [0.1, 0.0, 0.3], [0.3, 0.1, 0.2], random.normal(size=3)])
    return np.concatenate([q + 0.05 * random.normal(size=12), random.normal(size=12)])


def separation(q):
    """D of eq. 8 with the cylinder's centre of eq. 7 in place of the hinge."""
    return jnp.stack(
        [
            q[6] - 0.5 * L_P * jnp.cos(q[8]) - q[3] + 0.5 * L_C * jnp.cos(q[5]),
            q[7] - 0.5 * L_P * jnp.sin(q[8]) - q[4] + 0.5 * L_C * jnp.sin(q[5]),
        ]
    )


def constraints(q):
    """Eq. 7."""
    return jnp.stack(
        [
            q[0] + A_S * jnp.cos(q[2]) - q[3] - 0.5 * L_C * jnp.cos(q[5]),
            q[1] + A_S * jnp.sin(q[2]) - q[4] - 0.5 * L_C * jnp.sin(q[5]),
            q[5] - q[8],
            -jnp.sin(q[5]) * (q[6] - q[3]) + jnp.cos(q[5]) * (q[7] - q[4]),
        ]
    )


def derived(y):
    """Re_1 to Re_16 by differentiation: of V (eq. 9) by q, of P (eq. 10) by its rates, and -γ (eq. 14)."""
    q, v = jnp.asarray(y[:12]), jnp.asarray(y[12:])

    def potential(q):
        d = separation(q)
        return 0.5 * K_A * (jnp.sqrt(d @ d) - L_0) ** 2 + 0.5 * K_T * (q[5] - q[2]) ** 2

    def dissipation(v):
        rate = jax.jvp(separation, (q,), (v,))[1]
        return 0.5 * C_A * rate @ rate + 0.5 * C_T * (v[5] - v[2]) ** 2

    def constraint_rates(q):
        return jax.jvp(constraints, (q,), (v,))[1]

    curvature = jax.jvp(constraint_rates, (q,), (v,))[1]
    return np.concatenate([jax.grad(potential)(q) + jax.grad(dissipation)(v), curvature])


def written(y, form):
    """Re_1 to Re_16 as eq. 22 and 23 write them, or with the corrections."""
    y = np.concatenate([[np.nan], y])  # the paper counts from 1
    sin, cos, right = np.sin, np.cos, form == CORRECTED
    dx = 0.5 * L_C * cos(y[6]) - 0.5 * L_P * cos(y[9]) - y[4] + y[7]
    dy = 0.5 * L_C * sin(y[6]) - 0.5 * L_P * sin(y[9]) - y[5] + y[8]
    root = np.sqrt(dx**2 + dy**2)
    pull = K_A * (root - L_0)
    b = L_P * sin(y[6] - y[9]) + 2 * sin(y[6]) * (y[4] - y[7]) + 2 * cos(y[6]) * (y[8] - y[5])
    b_9 = L_C * sin(y[6] - y[9]) + 2 * sin(y[9]) * (y[4] - y[7]) + 2 * cos(y[9]) * (y[8] - y[5]) if right else b
    rate_x = 2 * y[16] - 2 * y[19] + L_C * sin(y[6]) * y[18]
    rate_y = 2 * y[17] - 2 * y[20] - L_C * cos(y[6]) * y[18]
    torque = K_T * (y[6] - y[3]) + C_T * (y[18] - y[15])
    spring_6 = 0.25 * pull * L_C * b
    across = cos(y[6]) * (y[16] - y[19])
    along = sin(y[6]) * (y[17] - y[20])
    turning = y[18] * sin(y[6]) * (y[7] - y[4]) + y[18] * cos(y[6]) * (y[5] - y[8])
    re = np.zeros(17)
    re[3] = K_T * (y[3] - y[6]) + C_T * (y[15] - y[18])
    re[4] = -pull * dx / root + 0.5 * C_A * (rate_x - L_P * sin(y[9]) * y[21])
    re[5] = -pull * dy / root + 0.5 * C_A * (rate_y + L_P * cos(y[9]) * y[21])
    re[6] = spring_6 / root + torque if right else spring_6 / (root + torque)
    re[6] += 0.25 * C_A * L_C * (
        2 * sin(y[6]) * (y[16] - y[19]) - 2 * cos(y[6]) * (y[17] - y[20]) + L_C * y[18] - L_P * cos(y[6] - y[9]) * y[21]
    )  # fmt: skip
    re[7] = pull * dx / root - 0.5 * C_A * (rate_x - L_P * (sin(y[9]) if right else cos(y[9])) * y[21])
    re[8] = pull * dy / root - 0.5 * C_A * (rate_y + L_P * cos(y[9]) * y[21])
    re[9] = -0.25 * pull * L_P * b_9 / root + 0.25 * C_A * L_P * (
        2 * sin(y[9]) * (y[19] - y[16]) + 2 * cos(y[9]) * (y[17] - y[20]) + L_P * y[21] - L_C * cos(y[6] - y[9]) * y[18]
    )  # fmt: skip
    re[13] = 0.5 * L_C * cos(y[6]) * y[18] ** 2 - A_S * cos(y[3]) * y[15] ** 2
    re[14] = 0.5 * L_C * sin(y[6]) * y[18] ** 2 - A_S * sin(y[3]) * y[15] ** 2
    re[16] = y[18] * (2 * across + 2 * along + turning) if right else y[18] * 2 * across + 2 * along + turning
    return re[1:]


@pytest.mark.parametrize("form", [PRINTED, CORRECTED])
def test_which_printed_forces_contradict_the_papers_own_energies(form):
    """Corrected, all sixteen are what eq. 7 to 10 give; printed, four are not."""
    y = state()
    off = np.abs(written(y, form) - derived(y))
    assert {k for k, error in enumerate(off, 1) if error > 1e-9} == (WRONG if form == PRINTED else set())


@pytest.mark.quick
def test_the_programs_published_forces_are_the_corrected_ones():
    """With eq. 10's damper (M24), and a tip without mass, so that the probe's centre of mass is its middle (M6)."""
    design = replace(table2(), {"buffer.damping": "published", "probe.tip_mass": 1e-14})
    mechanism = assemble(design, Scenario(), 0.0)
    system, y = mechanism.system, state()
    kin = system.kinematics(jnp.asarray(y[:12]), jnp.asarray(y[12:]))
    springs = [mechanism.element(name).force for name in ("buffer", "hinge spring")]
    loads = tuple(load for spring in springs for load in spring.loads(kin))
    own = np.concatenate([-system.generalised_force(kin, loads), -system.constraints(kin).gamma])
    np.testing.assert_allclose(own, written(y, CORRECTED), rtol=1e-11, atol=1e-10)

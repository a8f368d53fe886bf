"""A cantilever spun up about its root (Kane; Simo and Vu-Quoc 1986): geometric stiffening, and what happens without."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from jaxbuffer.multibody.flexible import Bar, cantilever_bar

TOPIC = "Spin-up of a cantilever"
BLADE = Bar(length=10.0, area=1.0, second_moment=1.4e4 / 2.8e7, density=1.2, youngs_modulus=2.8e7)
PEAKS = {1: -0.57826, 2: -0.57355, 3: -0.57444, 4: -0.57434, 6: -0.57437}  # by natural modes of the cantilever


def spin(time):
    """ω and ω̇ of θ = 6/15 (t²/2 + (15/2π)² (cos(2πt/15) - 1)) up to 15 s, then 6 rad/s."""
    if time >= 15.0:
        return 6.0, 0.0
    turn = 2.0 * np.pi / 15.0
    return 0.4 * (time - np.sin(turn * time) / turn), 0.4 * (1.0 - np.cos(turn * time))


def spun_up(body, count, end, stiffened=True):
    """The tip's lateral deflection of the first modes with the frame's motion given, as a dense solution.

    M q̈ + (K + ω² (G - M)) q = -ω̇ ∫ s φ dm with s from the root: the frame's origin moves on a circle about it.
    """
    modes = body.modes
    first = slice(0, count)
    mass, stiffness = (np.asarray(matrix)[first, first] for matrix in (modes.mass_matrix, modes.stiffness))
    geometric = np.asarray(modes.geometric)[first, first] if stiffened else 0.0
    moment = np.asarray(modes.rotation + 5.0 * modes.translation[1])[first]
    tip = np.asarray(body.end.displacement_y)[first]
    inverse = np.linalg.inv(mass)

    def rate(time, state):
        q, moving = np.split(state, 2)
        omega, turning = spin(time)
        return np.concatenate([moving, -inverse @ ((stiffness + omega**2 * (geometric - mass)) @ q + turning * moment)])

    done = solve_ivp(rate, (0.0, end), np.zeros(2 * count), "DOP853", rtol=1e-9, atol=1e-11, dense_output=True)
    return lambda time: tip @ done.sol(time)[:count]


@pytest.mark.parametrize("count", PEAKS)
def test_the_tips_largest_deflection(count, evidence):
    """With so many natural modes, out of enough fixed-interface modes that these are the cantilever's own."""
    tip = spun_up(cantilever_bar(BLADE, 12, geometric=True), count, 10.0)
    times = np.linspace(5.0, 9.0, 4001)
    found = tip(times)
    claim = "largest deflection of the tip, 1 to 6 modes"
    evidence(TOPIC, claim, abs(found.min() - PEAKS[count]), 1e-5, "an independent program", "m", f"{count} modes")
    evidence(TOPIC, "its time", abs(times[np.argmin(found)] - 6.76), 0.05, "an independent program", "s")


@pytest.mark.quick
def test_craig_and_bamptons_modes_against_geometrically_exact_elements(evidence):
    """Exudyn's 32 geometrically exact elements, whose last doubling moved the peak by 5e-4 of it: -0.57398 m."""
    tip = spun_up(cantilever_bar(BLADE, 4, geometric=True), 6, 10.0)
    found = tip(np.linspace(5.0, 9.0, 4001)).min()
    evidence(TOPIC, "peak against geometrically exact elements, relative", abs(found / -0.57398 - 1.0), 1e-3, "Exudyn")


def test_the_blade_stretches_in_the_steady_spin(evidence):
    """ρ A Ω² L³/(3 E A) at its end; the frame's axes see the origin's centripetal acceleration, too."""
    body = cantilever_bar(BLADE, 0, 6)
    modes, lateral = body.modes, body.lateral
    pull = 36.0 * np.asarray(modes.radial + 5.0 * modes.translation[0])[lateral:]
    q = np.linalg.solve(np.asarray(modes.stiffness - 36.0 * modes.mass_matrix)[lateral:, lateral:], pull)
    found = np.asarray(body.end.displacement_x)[lateral:] @ q
    evidence(
        TOPIC, "steady extension, relative", abs(found / (1.2 * 36.0 * 1000.0 / (3 * 2.8e7)) - 1.0), 1e-3, "closed form"
    )


def test_without_stiffening_it_diverges(evidence):
    """ω1 = 1.875104² √(EI/ρA)/L² = 3.798 rad/s < 6 rad/s: the linear frame is no model of this."""
    body = cantilever_bar(BLADE, 12)
    omega = 2.0 * np.pi * float(body.modes.frequencies()[0])
    closed = 1.875104068711961**2 * np.sqrt(1.4e4 / 1.2) / 100.0
    evidence(TOPIC, "first frequency at rest, relative", abs(omega / closed - 1.0), 1e-6, "closed form")
    assert np.isnan(body.modes.frequencies(6.0)[0]) and np.isfinite(body.modes.frequencies(3.0)[0])
    tip = spun_up(body, 2, 20.0, stiffened=False)
    growth = np.log(tip(16.0) / tip(15.5)) / 0.5
    evidence(
        TOPIC, "rate of the divergence, relative", abs(growth / np.sqrt(36.0 - closed**2) - 1.0), 1e-2, "√(Ω² - ω1²)"
    )

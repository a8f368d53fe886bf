"""Orders of convergence: of every stepper on a smooth phase, of all of them through contact, and of their estimates.

The contact force K δ^{3/2} has an infinite second derivative at touchdown: from there on no method keeps more than
order 5/2 in the velocities if steps are even in time; in its root they keep their own.
"""

from functools import cache

import diffrax
import numpy as np
import pytest

from hybrid.phases import impact, one_step, stepper, swing
from jaxbuffer.hybrid import Automatic, DiagonallyImplicit, ExplicitRungeKutta

TOPIC = "Orders of convergence"
REFERENCE = ExplicitRungeKutta(diffrax.Dopri8())
SOLVERS = {
    "Tsit5": (ExplicitRungeKutta(diffrax.Tsit5()), 5, (96, 192)),
    "DOP853": (ExplicitRungeKutta(), 8, (8, 16)),
    "KenCarp3": (DiagonallyImplicit(diffrax.KenCarp3()), 3, (96, 192)),
    "KenCarp4": (DiagonallyImplicit(), 4, (32, 96)),
    "KenCarp5": (DiagonallyImplicit(diffrax.KenCarp5()), 5, (48, 128)),
    "Kvaerno5": (DiagonallyImplicit(diffrax.Kvaerno5()), 5, (48, 128)),
    "Automatic": (Automatic(), 8, (8, 16)),
}
SWING, CLOSING = 0.02, 1.2e-4  # s; the second ends before the first impact's peak
# The methods between which the automatic solver, which runs take, switches are quick, and that is slow.
MARKS = {"DOP853": (), "KenCarp4": (), "Automatic": pytest.mark.slow}
each_solver = pytest.mark.parametrize(
    "name", [pytest.param(name, marks=MARKS.get(name, pytest.mark.long)) for name in SOLVERS]
)


@cache
def reference(phase, duration, steps):
    return stepper(REFERENCE, phase())(duration, steps)


def order(solver, phase, duration, counts, exact, part):
    """Observed between two numbers of steps, and the errors it is taken from."""
    advance = stepper(solver, phase())
    errors = [float(np.max(np.abs((advance(duration, n) - exact)[part]))) for n in counts]
    return np.log(errors[0] / errors[1]) / np.log(counts[1] / counts[0]), errors


@each_solver
def test_order_on_a_smooth_phase(evidence, name):
    """Order 8 is approached from below, and rounding ends it at 7.8."""
    solver, theory, counts = SOLVERS[name]
    observed, errors = order(solver, swing, SWING, counts, reference(swing, SWING, 2000), np.s_[:24])
    allowed = 0.3 if theory == 8 else 0.15
    detail = f"{observed:.2f} against {theory}, errors {errors[0]:.1e} and {errors[1]:.1e}"
    evidence(TOPIC, f"{name}: order on a smooth phase", abs(observed - theory), allowed, "its theory", detail=detail)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Tsit5", pytest.param("KenCarp5", marks=pytest.mark.slow)])
def test_order_through_a_touchdown(evidence, name):
    solver = SOLVERS[name][0]
    exact = reference(impact, CLOSING, 100_000)
    observed, errors = order(solver, impact, CLOSING, (16, 64), exact, np.s_[12:24])
    detail = f"{observed:.2f} against 5/2, errors {errors[0]:.1e} and {errors[1]:.1e} m/s"
    claim = f"{name}: order in the velocities from touchdown on, in equal steps"
    evidence(TOPIC, claim, abs(observed - 2.5), 0.15, "force ~ δ^{3/2} at touchdown", detail=detail)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Tsit5", "DOP853"])
def test_order_is_kept_in_the_root_of_time(evidence, name):
    """Steps that are even in the root of the time since touchdown see a smooth force; some gain an order on top."""
    solver, theory, *_ = SOLVERS[name]
    exact = stepper(SOLVERS["DOP853"][0], impact(), rooted=True)(CLOSING, 400)
    advance = stepper(solver, impact(), rooted=True)
    counts = (4, 8) if theory == 8 else (8, 16)
    errors = [float(np.max(np.abs((advance(CLOSING, n) - exact)[12:24]))) for n in counts]
    observed = np.log2(errors[0] / errors[1])
    detail = f"{observed:.2f} against {theory}, errors {errors[0]:.1e} and {errors[1]:.1e} m/s"
    evidence(
        TOPIC,
        f"{name}: order from touchdown on, in the root of time",
        max(0.0, theory - observed),
        0.3,
        "its theory",
        detail=detail,
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [*(pytest.param(name, marks=pytest.mark.slow) for name in ("Tsit5", "KenCarp3")), "KenCarp4"]
)
def test_error_estimate(evidence, name):
    """One order below the error, so that it overrates small errors ever more.

    KenCarp5's underrates the error of its implicit half tenfold here, hence it is no default.
    """
    solver, theory, _ = SOLVERS[name]
    phase = swing()
    mechanism, state, _ = phase
    scales, take, exact = np.asarray(mechanism.scales())[:24], one_step(solver, phase), stepper(REFERENCE, phase)

    def size(error):
        return float(np.sqrt(np.mean((np.asarray(error)[:24] / scales) ** 2)))

    steps = (1e-3, 5e-4, 2.5e-4)
    estimated, true = [], []
    for step in steps:
        end, estimate = take(state, step)
        estimated.append(size(estimate))
        true.append(size(end - exact(step, 200)))
    observed = np.log2(estimated[0] / estimated[2]) / 2
    ratios = [a / b for a, b in zip(estimated, true, strict=True)]
    claim = f"{name}: order of its error estimate"
    told = f"{observed:.2f} against {theory}; estimated over true " + ", ".join(f"{ratio:.1f}" for ratio in ratios)
    evidence(TOPIC, claim, abs(observed - theory), 0.15, "its embedded method's theory", detail=told)
    assert ratios[0] < ratios[1] < ratios[2]
    claim = f"{name}: true local error over its estimate, at the shortest of three steps"
    evidence(TOPIC, claim, 1 / ratios[2], 2.0, "a tight solve", detail=told)

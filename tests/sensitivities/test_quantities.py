"""Every quantity that can be asked for has the right derivative, events that move with the parameters included."""

import dataclasses

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.mechanisms.probe_cone.quantities import QUANTITIES
from jaxbuffer.mechanisms.quantity import IMPACT_UNITS, check_quantities, unit_of
from jaxbuffer.sensitivities.certificate import Verdict
from jaxbuffer.sensitivities.gradients import gradients
from verification.cases import CASES

PARAMETERS = PROBE_CONE.defaults.parameters

ESCAPING = CASES["random-1-12"]
CROSSING = {"lateral_miss", "lateral_miss_rate", "attitude_miss", "attitude_miss_rate"}  # at the capture plane
WITH_LATCHES = {"latch_time", "settling_time", "peak_passive_acceleration"}  # NaN without
SHOCKS = {"shock.active_1": 20.0, "shock.passive_1": 60.0}
RUNS = {
    "captured": (jb.replace(jb.table2(), SHOCKS), jb.Scenario(), 8.0, (1, 2, 14)),
    "escaped": (ESCAPING.design, ESCAPING.scenario, 8.0, (1, 3)),
    "timeout": (jb.table2(), jb.Scenario(), 0.3, (1, 5)),
    "timeout, the stroke rising": (jb.table2(), jb.Scenario(), 0.05, (1, 5)),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    "run", [pytest.param(run, marks=pytest.mark.long if run == "captured" else ()) for run in RUNS]
)
def test_derivatives_of_every_quantity_agree_with_differences_of_tight_solves(run):
    """Relative to the elasticity, or to 1e-3 where it is smaller. Measured: off by 2.5e-5 at most; the differences' own
    uncertainty, which says nothing of the gradients, is 4.7e-4 at most (peak buffer force)."""
    design, scenario, duration, impacts = RUNS[run]
    absent = WITH_LATCHES | (set() if run == "captured" else CROSSING)
    absent |= {name for name in QUANTITIES if "_shock_" in name and not PROBE_CONE.has(name, design)}
    differentiable = [name for name, it in QUANTITIES.items() if it.differentiable and name not in absent]
    names = (*differentiable, *(f"impact.{number}.{field}" for number in impacts for field in IMPACT_UNITS))
    found = jb.sensitivity(design, scenario, PARAMETERS, duration, quantities=names, rtol=1e-9, certify="thorough")
    assert found.capture.outcome.name == run.split(",")[0]
    off, uncertainty = found.certificate.by_differences, found.certificate.uncertainty
    assert np.max(uncertainty) < 6e-4
    assert np.max(off) < 1e-4
    assert found.certificate.verdict == Verdict.trusted
    moving = {name for name, row in zip(names, found.gradients, strict=True) if np.any(np.abs(row) > 1e-9)}
    fixed = "end_time" if run.startswith("timeout") else "throat_distance"
    never = {"impact.1.time", "impact.1.approach_speed", "peak_stop_force", "stop_loss"}  # Table 2 has no end stop,
    never |= {"bending", "bending_loss", "play_loss"}  # is rigid and has no play,
    never |= {"buffer_friction_loss", "rebound_loss"}  # no friction in the buffer and no rebound stop,
    never |= {"peak_latch_force", "latch_share", "latch_loss", "latch_energy", "latch_energy_share"}  # and no latches
    never |= {"peak_lockout_force", "lockout_stroke", "lockout_loss"}  # nor a lockout,
    never |= {"extension", "extension_time"} if "rising" in run else set()  # pushed in alone until then
    assert moving == set(names) - never - {fixed}


@pytest.mark.slow
def test_an_impact_that_is_not_there_is_refused():
    """Table 2 is captured in contact: its last impact has no release, and there is no twenty-fifth."""
    names = ("peak_force", "impact.24.release_time", "impact.25.time")
    found = jb.sensitivity(jb.table2(), quantities=names)
    assert found.certificate.verdicts == (Verdict.trusted, Verdict.refused, Verdict.refused)
    assert found.certificate.verdict == Verdict.refused
    assert found.certificate.reason == "impact.24.release_time or its gradient is not finite; the run has 24 impacts"


@pytest.mark.slow
def test_the_capture_margin_is_smooth_where_capture_happens_just_in_time():
    """A run that is stopped at the very moment of capture has no margin; a little earlier or later it has
    little, and the same slopes."""
    design, scenario = jb.table2(), jb.Scenario()
    values = [jb.get(design, path) for path in PARAMETERS]
    end = float(jb.simulate(design, scenario, rtol=1e-9).end_time)
    late, early = (
        gradients(PROBE_CONE, design, scenario, PARAMETERS, values, end * (1.0 + share), rtol=1e-9)
        for share in (1e-7, -1e-7)
    )
    assert [linear.run.outcome.name for linear in (late, early)] == ["captured", "timeout"]
    margins = [float(linear.run.capture_margin) for linear in (late, early)]
    assert 0.0 < margins[0] < 1e-8 and -1e-8 < margins[1] < 0.0
    np.testing.assert_allclose(late.of("capture_margin"), early.of("capture_margin"), rtol=1e-5)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("peak_froce", "quantity peak_froce is unknown; did you mean peak_force?"),
        ("impact.0.time", "impact.0.time: '0' is not an impact's number; they count from 1, as in impact.1.peak_force"),
        ("impact.one.time", "'one' is not an impact's number"),
        ("impact.2.speed", "impact.2.speed is unknown; an impact has peak_force, approach_speed, time, release_time"),
    ],
)
def test_unknown_quantities_are_refused_with_a_suggestion(name, message):
    with pytest.raises(jb.InputError) as caught:
        jb.sensitivity(jb.table2(), quantities=("stroke", name))
    assert message in str(caught.value)


def test_no_quantity_no_parameter_and_one_named_twice():
    for call, message in (
        (lambda: check_quantities(QUANTITIES, ()), "quantities is empty"),
        (lambda: check_quantities(QUANTITIES, ("stroke", "stroke")), "names stroke twice"),
        (lambda: jb.sensitivity(jb.table2(), wrt=()), "wrt is empty"),
        (lambda: jb.sensitivity(jb.table2(), certify="full"), "certify = 'full' is unknown; choose one of quick"),
        (lambda: jb.sensitivity(jb.table2(), wrt=("buffer.damping",)), "is not a number that can be differentiated"),
    ):
        with pytest.raises(jb.InputError, match=message):
            call()


def test_units():
    assert [unit_of(QUANTITIES, name) for name in ("stroke", "impact.3.release_time", "dissipated")] == ["m", "s", "J"]


def test_angles_are_shown_in_degrees():
    shown = [quantity.in_figures for quantity in QUANTITIES.values() if quantity.unit == "rad"]
    assert shown
    for unit, factor in shown:
        assert unit == "deg"
        assert factor == pytest.approx(np.degrees(1.0), rel=1e-14)


@pytest.mark.slow
def test_elasticities_of_chaotic_runs_have_exponents():
    """The tank's, whose liquid amplifies small differences, are as large as that."""
    found = jb.sensitivity(jb.BarDrop(), wrt=["bar.density"], duration=0.01, certify="none")
    large = dataclasses.replace(found, elasticities=np.full_like(found.elasticities, -2.5e90))
    assert "-2.500e+90" in str(large)
    assert f"{found.elasticities[0, 0]:+.4f}" in str(found)

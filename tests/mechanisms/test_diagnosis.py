"""Why a capture did not succeed: what is said of it follows from the conservation of momentum and energy."""

import math
import re

import equinox as eqx
import jax
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.probe_cone.diagnosis import course, turned_round
from jaxbuffer.sensitivities.result import advice
from jaxbuffer.sensitivities.sensitivity import Sensitivity

SPEED, TURNED = 0.1, 0.3  # m/s, rad


@pytest.fixture(scope="module")
def escaped():
    return jb.simulate(jb.table2(), jb.Scenario(approach_speed=SPEED, misalignment=TURNED))


@pytest.fixture(scope="module")
def seen(escaped):
    parameters = (escaped.design, escaped.scenario, escaped.stabilisation)
    return jax.tree.map(np.asarray, course(parameters, escaped._located.rows[:, 0], escaped._located.active))


def test_the_course_begins_as_the_scenario_says_and_keeps_the_common_motion(escaped, seen, evidence):
    """At the start the active side moves at v0 and the passive vehicle rests: the approach along the cone's axis is
    v0 cos θ, and the common motion has (m_A v0)²/2(m_A + m_T), at the end too."""
    design = escaped.design
    active = design.active.mass + design.buffer.cylinder_mass + design.probe.rod_mass + design.probe.tip_mass
    passive = design.passive.mass
    common = 0.5 * (active * SPEED) ** 2 / (active + passive)
    along = 0.5 * active * passive / (active + passive) * (SPEED * math.cos(TURNED)) ** 2
    begin, last = int(np.argmin(np.asarray(escaped._located.time))), int(escaped._located.count) - 1
    source = "conservation of momentum, König's theorem"
    first = float(seen.approach[begin]) / (SPEED * math.cos(TURNED)) - 1.0
    evidence("Diagnosis", "speed of approach at the first touchdown", abs(first), 1e-12, source, "-")
    evidence("Diagnosis", "energy of the approach", abs(float(seen.along[begin]) / along - 1.0), 1e-12, source, "-")
    worst = float(np.max(np.abs(seen.common[: last + 1] / common - 1.0)))
    evidence("Diagnosis", "energy of the common motion, at every event", worst, 1e-11, source, "-")


def shares_of(run):
    """Every share of the energy that the diagnosis names [%]."""
    text = "\n".join(run.diagnosis)
    energies = text[text.index("energy left") : text.index("turned round")]
    return [float(share) for share in re.findall(r"\(([\d.]+) %\)", energies)]


def test_the_energy_is_all_accounted_for(escaped):
    shares = shares_of(escaped)
    assert len(shares) >= 6 and sum(shares) == pytest.approx(100.0, abs=0.06 * len(shares))
    assert repr(escaped).endswith("--of capture_share' says it")


def test_a_miss_beside_the_cone_turns_both_vehicles_in_common():
    """Its approach is turning about the common centre too, which no buffer takes and no share counts twice."""
    run = jb.simulate(jb.table2(), jb.Scenario(start="free", offset=0.09))
    assert int(run.impact_count) == 0 and sum(shares_of(run)) == pytest.approx(100.0, abs=0.06)
    assert re.search(r"mJ more in the common turning", "\n".join(run.diagnosis))


def test_the_impact_that_turns_the_vehicles_round_is_named(escaped, seen):
    """After its next touchdown they approach each other no more."""
    turn, hits, last = turned_round(escaped, seen), escaped.impacts, int(escaped._located.count)
    times = np.asarray(hits.time)[: int(hits.count)]
    assert turn.before > 0.0 > turn.after
    assert turn.time == pytest.approx(times[turn.impact - 1]) and turn.contact == int(hits.contact[turn.impact - 1])
    later = np.asarray(escaped._located.time)[:last] >= times[turn.impact]
    assert np.all(seen.approach[:last][later] <= 0.0)


def test_a_capture_has_no_diagnosis(escaped):
    captured = jb.simulate(jb.table2(), jb.Scenario(approach_speed=SPEED))
    assert captured.outcome is jb.Outcome.captured and captured.diagnosis == []


def test_advice_is_the_margin_over_its_derivative(escaped):
    """A margin m needs the relative change -m / (p dm/dp): 0.5 of 500 at 0.002 a unit, 0.5 of 5 at 0.4; -0.5 below."""
    paths, slopes = ("buffer.k_A", "buffer.c_A", "buffer.k_T"), np.array([[0.002, 0.4, -1e-4]])
    values, margin = np.array([500.0, 5.0, 300.0]), np.array([-0.5])
    made = Sensitivity(escaped, paths, values, ("capture_share",), margin, slopes, slopes, None)
    lines = advice(made)
    assert "capture_share = -0.5 becomes positive (to first order, which is not certified)" in lines[0]
    assert lines[1].split() == ["buffer.c_A", "+25", "%", "of", "5", "N", "s/m"]
    assert lines[2].split() == ["buffer.k_A", "+50", "%", "of", "500", "N/m"]
    assert lines[3] == "  no value above zero of buffer.k_T would do, each alone"
    assert advice(eqx.tree_at(lambda s: s.quantities, made, ("stroke",))) == []

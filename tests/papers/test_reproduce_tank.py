"""`jaxbuffer reproduce tank`: the printed data, and verdicts by hand-made rows and by published numbers."""

import math

import pytest

from jaxbuffer.papers import paper_named
from jaxbuffer.papers.claims import NO, NONE, OPEN, PARTLY, YES
from jaxbuffer.papers.study import run
from jaxbuffer.papers.tank.claims import CLAIMS
from jaxbuffer.papers.tank.studies import STUDIES

BY_NAME = {study.name: study for study in STUDIES}


def claim(start):
    (found,) = [claim for claim in CLAIMS if claim.claim.startswith(start)]
    return found


def test_the_printed_values_are_studied():
    """348 kg from 2.04 m on a tank filled with liquid; three methods of contact."""
    case, *_ = BY_NAME["drop"].cases
    assert float(case.design.slider.mass) == 348.0 and float(case.scenario.height) == 2.04
    assert case.design.contents.kind == "full" and float(case.scenario.fill) == 1.0
    bare = BY_NAME["contact"].cases
    assert {case.design.support.method for case in bare} == {"defence node", "multiplier", "penalty"}
    assert all(
        case.design.cushion.kind == "none" and case.scenario == BY_NAME["drop"].cases[0].scenario for case in bare
    )


def contact(node, multiplier, penalties=(1e-3, 1e-4)):
    rows = [{"penetration": depth, "impulse": 100.0, "peak_force": force} for depth, force in (node, multiplier)]
    rows += [{"penetration": depth, "peak_force": 1.0, "steps": 10} for depth in penalties]
    return {"contact": tuple(row | {"steps": 10} for row in rows)}


@pytest.mark.parametrize(("depth", "verdict"), [(1e-9, YES), (1e-5, PARTLY), (5e-4, PARTLY)])
def test_a_constraint_is_exact_to_a_hundredth_of_the_least_penalty(depth, verdict):
    rows = contact((depth, 1.0), (1e-12, 1.0))
    assert claim("The defence node satisfies").judge(rows).verdict == verdict


@pytest.mark.parametrize(("force", "verdict"), [(101.0, YES), (120.0, PARTLY)])
def test_a_force_is_accurate_to_two_hundredths_of_the_multipliers(force, verdict):
    rows = contact((0.0, force), (0.0, 100.0))
    assert claim("The defence node computes").judge(rows).verdict == verdict


def test_a_time_of_what_did_not_happen_is_none_in_a_row():
    """JSON has no NaN."""
    part = paper_named("tank").parts[0]._replace(solve=lambda case: 1, row=lambda case, run: {"yield_time": math.nan})
    (studied,) = run(part, (STUDIES[0]._replace(cases=STUDIES[0].cases[:1]),))
    assert studied.rows[0]["yield_time"] == NONE


@pytest.mark.slow
def test_responses_to_pulses():
    """Largest ones, by pyyeti and in closed form: 1.768 of a half-sine, 2 of a rectangle alone."""
    twice = claim("With T_n < τ").judge({})
    assert twice.verdict == PARTLY and "rectangle 2.000" in twice.finding and "half-sine 1.732" in twice.finding
    assert claim("With T_n > τ").judge({}).verdict == NO


def test_the_depth_of_the_largest_shear():
    """0.48 of the radius for ν = 0.3 (Johnson); the paper's 2/((1 + ν)π) is 0.490 and falls with ν, Hertz's rises."""
    found = claim("The shear is largest").judge({})
    assert found.verdict == PARTLY and "ν = 0.3: 0.481 against 0.490" in found.finding


def test_what_the_paper_prints_nothing_of_is_left_open():
    assert claim("Simulation and experiment").judge({}).verdict == OPEN

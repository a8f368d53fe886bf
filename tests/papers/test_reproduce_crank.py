"""`jaxbuffer reproduce impact`, the slider-crank: the printed sets, times of turns, verdicts by hand-made rows."""

import math

import numpy as np
import pytest

from jaxbuffer.output.style import png
from jaxbuffer.papers import paper_named
from jaxbuffer.papers.claims import NO, PARTLY, YES
from jaxbuffer.papers.impact.crank_claims import CLAIMS
from jaxbuffer.papers.impact.crank_rows import turn_times
from jaxbuffer.papers.impact.crank_studies import BAR, STUDIES
from jaxbuffer.papers.study import run, verdicts_of

BY_NAME = {study.name: study for study in STUDIES}
PRINTED = {(0.1, 1e4, 1e7), (0.01, 1e4, 1e7), (0.2, 1e4, 1e7), (0.2, 1e5, 1e8)}  # e [-], k [N/mm^e], M0 [N mm]


def claim(start):
    (found,) = [claim for claim in CLAIMS if claim.claim.startswith(start)]
    return found


def printed(design):
    """e, k and M0 in the paper's units."""
    pin = design.piston_pin
    exponent = float(pin.exponent)
    return exponent, round(float(pin.stiffness) / 1000.0**exponent, 6), round(1e3 * float(design.drive.torque), 6)


def test_the_printed_values_are_studied():
    """Clearance 1.1 mm, c = 10 N s/mm, d = 1e-3 mm, 10 rad/s; the bending rod with e = 0.1, k = 2e4, M0 = 1e5."""
    for study in STUDIES:
        for case in study.cases:
            pin = case.design.piston_pin
            assert [float(x) for x in (pin.clearance, pin.viscous, pin.ramp_depth)] == pytest.approx(
                [1.1e-3, 1e4, 1e-6]
            )
            assert float(case.design.drive.no_load_speed) == 10.0 and float(case.scenario.crank_speed) == 0.0
    assert {printed(case.design) for case in BY_NAME["crank"].cases[:4]} == PRINTED
    assert {printed(case.design) for case in BY_NAME["crank_rod"].cases} == {(0.1, 2e4, 1e5)}
    rigid, *bent = (case.design.rod for case in BY_NAME["crank_rod"].cases)
    assert float(rigid.mass) == pytest.approx(7850.0 * 0.015**2 * 0.12) and rigid.modes == 0
    assert all(rod.modes >= 2 and float(rod.body.inertia) == float(BAR.body.inertia) for rod in bent)


def test_times_of_turns():
    """A crank at 10 rad/s after a start of 1 ms at rest; one that has not turned once."""
    time = np.linspace(0.0, 1.3, 100)
    first, second = turn_times(time, 10.0 * (time - 1e-3))
    assert (first, second) == pytest.approx((0.2 * math.pi + 1e-3, 0.4 * math.pi + 1e-3), abs=1e-12)
    assert np.isnan(turn_times(time, time)).all()


@pytest.mark.parametrize(("across", "verdict"), [((2.0, 2.0, 2.0, 2.0), YES), ((2.0, 2.0, 2.0, 0.9), PARTLY)])
def test_the_order_of_the_components(across, verdict):
    rows = tuple({"across": force, "along": 1.0} for force in across)
    assert claim("The force along y is above").judge({"crank": rows}).verdict == verdict


@pytest.mark.parametrize(("touch", "verdict"), [(1e-3, YES), (5e-3, NO)])
def test_a_jump_from_the_joint_comes_after_a_touch(touch, verdict):
    rows = ({"start_takes": 2e-3, "first_impact": touch},) * 3
    assert claim("Its jump at start-up").judge({"crank_rod": rows}).verdict == verdict


@pytest.mark.long
def test_the_studies():
    """All runs finish, a turn of every printed set takes 2π/10 s, and every statement is verdicts_of."""
    *_, part = paper_named("impact").parts
    studied = run(part)
    rows = {found.study.name: found.rows for found in studied}
    assert {row["outcome"] for found in rows.values() for row in found} == {"finished"}
    for row in rows["crank"]:
        assert float(row["second_turn"]) == pytest.approx(0.2 * math.pi, rel=1e-3)
    assert len(verdicts_of(part.claims, studied)) == len(CLAIMS)
    assert all(png(part.figure(found)).startswith(b"\x89PNG") for found in studied)

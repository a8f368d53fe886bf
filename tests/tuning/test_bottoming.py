"""A buffer at its end is no answer: tune climbs out of it and keeps from it, and says what limits the stroke."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer import InputError, Limits, Outcome, Problem, Scenario, Variable, replace, table2
from jaxbuffer.tuning.search.evaluation import Evaluator
from jaxbuffer.tuning.search.goal import Goal

SOFT = replace(table2(), {"buffer.k_A": 20.0, "buffer.c_A": 1.0})
VARIABLES = (Variable("buffer.k_A", 20.0, 2000.0), Variable("buffer.c_A", 1.0, 60.0))


def problem(design=SOFT, variables=VARIABLES, **limits):
    """The soft buffer met fast: it comes to its end."""
    return Problem(design, [Scenario(approach_speed=0.35)], variables, limits=Limits(**limits))


@pytest.mark.long
def test_a_start_at_the_buffers_end_is_infeasible_and_slopes_lead_out_of_it():
    """The slope of the share of stroke, against differences of tight solves; then the search."""
    asked = problem()
    with Evaluator(asked) as evaluator:
        start = asked.start()
        (point,) = evaluator([start])
        goal = Goal(asked, asked.objective)
        assert point.code[0] == Outcome.bottomed
        assert not goal.feasible(point)
        assert "bottomed" in goal.broken(point)[0]
        share = asked.names.index("stroke_share")
        assert point.quantities[0, share] > 1.0
        step = 1e-5
        for k in range(2):
            moves = [np.where(np.arange(2) == k, sign * step, 0.0) for sign in (2.0, 1.0)]
            inside = np.clip(start, 2.0 * step, 1.0)  # k_A and c_A start at their low bounds
            ends = evaluator([inside + move for move in moves] + [inside], rtol=1e-10, slopes=False)
            far, near, here = (end.quantities[0, share] for end in ends)
            slope = (4.0 * near - far - 3.0 * here) / (2.0 * step)
            (there,) = evaluator([inside])
            # the largest force, the first of the quantities, is not among the rest
            assert there.rest_slope[0, share - 1, k] == pytest.approx(slope, rel=2e-3)
    tuned = jb.tune(asked, iterations=20, starts=1)
    assert tuned.before.code[0] == Outcome.bottomed
    assert tuned.after.code[0] == Outcome.captured
    assert float(tuned.after.quantities[0, share]) < 1.0


def test_a_limit_beyond_the_end_limits_nothing():
    with pytest.raises(InputError) as caught:
        problem(at_most={"stroke": 0.2})
    assert "constraints.stroke = 0.2 m is out of range; allowed: (0, 0.1365] m" in str(caught.value)
    assert "buffer.max_stroke" in str(caught.value)
    longer = (*VARIABLES, Variable("buffer.free_length", 0.1, 0.25))
    assert problem(variables=longer, at_most={"stroke": 0.2}).limits.at_most["stroke"] == 0.2
    with pytest.raises(InputError, match=r"allowed: \(0, 0\.05\] m"):
        problem(replace(SOFT, {"buffer.max_stroke": 0.05}), at_most={"stroke": 0.1})


def test_the_share_of_stroke_may_be_limited_below_its_end_only():
    assert problem(at_most={"stroke_share": 0.8}).limits.at_most["stroke_share"] == 0.8
    with pytest.raises(InputError, match=r"constraints\.stroke_share = 1\.2 is out of range; allowed: \(0, 1\]"):
        problem(at_most={"stroke_share": 1.2})

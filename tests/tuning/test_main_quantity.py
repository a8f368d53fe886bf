"""What stands for a run where nothing is said: the first of a mechanism's own quantities, whatever it is called."""

import contextlib
import dataclasses

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.fields import POSITIVE, Part, number
from jaxbuffer.mechanisms.mechanism import Defaults, Mechanism
from jaxbuffer.mechanisms.quantity import CONTACT_TIME, END_TIME, PEAK_FORCE, Quantity
from jaxbuffer.tuning.problem.own_quantities import compose
from jaxbuffer.tuning.search.goal import Goal, Tangent
from jaxbuffer.tuning.search.measurement import Measurement
from jaxbuffer.tuning.search.model_step import best_step
from registration import registered

STROKE = Quantity("m", lambda run: run.maxima["stroke"], "largest stroke", "stroke", swept=True, tuned=True)
# Called as the contact force, and another quantity.
BUFFER_FORCE = Quantity("N", lambda run: run.maxima["buffer_force"], "of the buffer", "force", swept=True, tuned=True)


class Cart(Part):
    section = "cart"
    mass: float = number(2.0, "kg", **POSITIVE)
    spring: float = number(200.0, "N/m", **POSITIVE)


class Track(Part):
    cart: Cart = Cart()


class Kick(Part):
    section = "scenario"
    speed: float = number(0.5, "m/s", **POSITIVE)


VARIABLES = [jb.Variable("cart.spring", 100.0, 400.0, scale="linear")]


@pytest.fixture
def problem():
    """Makes a problem of a mechanism with some quantities, which nothing runs; it is known to one test alone."""
    with contextlib.ExitStack() as stack:

        def make(of_mechanism, **more):
            stack.enter_context(registered(Mechanism("track", Track, Kick, of_mechanism)))
            return jb.Problem(Track(), [Kick()], VARIABLES, duration=1.0, **more)

        yield make


def test_a_mechanism_has_what_it_declares_and_defaults_of_its_own(problem):
    known = problem({"stroke": STROKE}).mechanism
    assert list(known.quantities) == ["stroke"]
    assert known.defaults.mapped == known.defaults.differentiated == ("stroke",)
    assert known.parameters(Track()) == ("cart.mass", "cart.spring")
    assert Mechanism("none", Track, Kick, {}).quantities == {}
    with pytest.raises(jb.InputError, match=r"track, Defaults\.mapped\.penetration is unknown"):
        Mechanism("track", Track, Kick, {"stroke": STROKE}, defaults=Defaults(mapped=("penetration",)))


@pytest.mark.parametrize(
    ("quantities", "peak", "main"),
    [
        ({"stroke": STROKE}, None, "stroke"),
        ({"stroke": STROKE, "wall_force": PEAK_FORCE}, "wall_force", "stroke"),
        ({"peak_force": BUFFER_FORCE, "stroke": STROKE}, None, "peak_force"),
        (
            {"peak_force": PEAK_FORCE._replace(tuned=False), "contact_time": CONTACT_TIME, "end_time": END_TIME},
            None,
            "end_time",
        ),
    ],
)
def test_the_main_quantity_is_lowered(problem, quantities, peak, main):
    asked = problem(quantities)
    assert asked.peak_quantity == peak and asked.objective == jb.Objective({main: 1.0})
    assert asked.names[0] == (peak or main)
    mean = dataclasses.replace(asked, objective=jb.Objective(over="mean"))
    assert str(mean.objective) == f"{main}, mean over the cases"


def test_without_a_quantity_to_lower_that_is_said(problem):
    with pytest.raises(jb.InputError, match="track has no quantity that an objective may use"):
        problem({"stroke": STROKE._replace(tuned=False)})


def test_a_step_without_peaks_is_that_of_the_slopes(problem):
    """f = 3 + 2 x over -0.1 ≤ x ≤ 0.1 is least at the low end, by 0.2."""
    asked = problem({"stroke": STROKE})
    goal = Goal(asked, asked.objective)
    slopes = {
        "peaks_slope": np.zeros((1, 0, 1)),
        "rest_slope": np.full((1, 1, 1), 2.0),
        "margin_slope": np.zeros((1, 1)),
    }
    tangent = Tangent(np.zeros((1, 0)), np.full((1, 1), 3.0), np.ones(1), by_peak=np.zeros((1, 1)), **slopes)
    quantities, _ = tangent.after(np.array([0.1]))
    np.testing.assert_allclose(quantities, [[3.2]])
    found = best_step(goal, tangent, np.array([0.5]), 0.1, 1.0, 10.0)
    assert found.step == pytest.approx([-0.1]) and found.predicted_reduction == pytest.approx(0.2)
    np.testing.assert_allclose(found.multipliers.slope(tangent), [2.0])


def test_own_quantities_are_made_of_what_there_is(problem):
    square = jb.CustomQuantity(lambda stroke: stroke**2, "m²")
    asked = problem({"stroke": STROKE}, quantities={"square": square})
    assert asked.names == ("stroke", "square") and asked.rest == asked.names
    own = compose(asked, np.zeros((1, 0)), np.array([[3.0]]), np.array([[[2.0]]]))
    assert Measurement.lost(asked).peaks.shape == (0,)
    np.testing.assert_allclose(own.values, [[9.0]])
    np.testing.assert_allclose(own.slopes, [[[12.0]]])
    assert np.all(own.by_peak == 0.0)

"""What elements say of a run, in a mechanism that has no words of its own for them."""

import math
from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np

from jaxbuffer.contact import KelvinVoigt
from jaxbuffer.elements import Buffer, EndStop, EnergyShare, Latch, Oscillators, SpringDamper, Thrust
from jaxbuffer.elements.telling import SummaryRow
from jaxbuffer.fields import Part
from jaxbuffer.mechanisms.energy import Balance, Energy
from jaxbuffer.mechanisms.plain_summary import plain_summary
from jaxbuffer.mechanisms.quantity import Quantity
from jaxbuffer.mechanisms.view import View
from jaxbuffer.multibody import AxialSpringDamper, TorsionalSpringDamper

ARM = AxialSpringDamper(0, 1, (0.0, 0.0), (0.0, 0.0), 300.0, 4.0, free_length=0.2)
BUFFER = Buffer(ARM, name="left_arm", stroke="left_stroke")
STOP = EndStop(ARM, KelvinVoigt(1e4, 0.0), 0.05, name="left_stop")
LATCH = Latch(1, 0, (0.0, 0.0), plane=0.3, seat=(0.2, 0.0), stiffness=5e3, strength=40.0)


def run(**quantities):
    """A made-up run whose latches closed at 2 s and that was held at 5 s."""
    return SimpleNamespace(
        mechanism=SimpleNamespace(quantities=quantities),
        quantity=quantities.get,
        maxima={"left_arm_force": 12.5, "left_stroke": 0.04, "left_stop_force": 7.0, "latch_force": 31.0, "rack": 3.0},
        maximum_times={"left_stroke": 1.5},
        switch_times={"latch": 2.0},
        end_time=jnp.asarray(5.0),
        outcome=SimpleNamespace(name="held"),
        energy=SimpleNamespace(stored={"thrust": -0.3}),
        history=SimpleNamespace(others={"left_stroke": np.array([0.0, 0.04]), "latch_force": np.array([0.0, 31.0])}),
    )


def test_each_element_has_lines_with_headings_of_its_own_name():
    assert BUFFER.report.summary(run()) == [("peak left arm force", "12.5 N"), ("left stroke", "40 mm at 1.5 s")]
    assert STOP.report.summary(run()) == [("left stop", "from 50 mm on, at most 7 N")]
    assert LATCH.report.summary(run()) == [
        ("latched", "at 2 s, held 3 s later; latch force at most 31 N of 40 N strength"),
    ]
    assert Thrust(0, 2.0, 0.5).report.summary(run()) == [("thrust", "2 N for 0.5 s, which put in 0.3 J")]
    assert Oscillators((0,), (8.0,), ("rack",)).report.summary(run()) == [("shock", "rack 3 m/s² at 8 Hz")]


def test_quantities_of_the_mechanism_come_before_observables():
    """They may know more, as of a latch that never closed, or of a log without room for it."""
    ((_, text),) = LATCH.report.summary(run(latch_time=1.0, peak_latch_force=30.0))
    assert text.startswith("at 1 s") and "at most 30 N" in text
    assert LATCH.report.summary(run(latch_time=np.nan)) == []


def test_what_an_element_draws_and_has_of_the_energy():
    (stroke,), (force,) = BUFFER.report.panels(run()), LATCH.report.panels(run())
    assert stroke.title == "Left stroke" and not stroke.to_end
    np.testing.assert_allclose(stroke.curves[0].values, [0.0, 40.0])
    assert force.to_end and [level.label for level in force.levels] == ["largest, 31 N", "strength, 40 N", ""]
    assert STOP.report.shares == (EnergyShare("left stop", "in the left stop", ("left_stop", "left_stop_damper")),)


def test_an_element_without_words_says_nothing():
    said = SpringDamper(TorsionalSpringDamper(0, 1, 5.0, 0.3)).report
    assert (said.summary(run()), said.panels(run()), said.warnings(run()), said.shares) == ([], [], [], ())


def test_a_rig_s_summary_says_each_number_once_and_no_part_that_exceeds_its_whole():
    """Gravity's work makes the total less than what is lost: each sum stands beside its own parts."""
    quantities = {
        "left_stroke": Quantity("m", lambda it: it.maxima["left_stroke"], "largest stroke", "left stroke", swept=True),
        "gap": Quantity("m", lambda it: 2.5e-3, "in the unit of people", "gap"),
        "turn": Quantity("rad", lambda it: 0.5 * np.pi, "in the unit of people", "turn"),
        "speed": Quantity("m/s", lambda it: 2.0, "speed", "speed", swept=True),
        "left_stop_force": Quantity("N", lambda it: it.maxima["left_stop_force"], "at the end", "force at the end"),
    }
    told = run()
    told.mechanism = SimpleNamespace(quantities=quantities, meant=lambda value_at: [*quantities], view=View())
    told.outcome = SimpleNamespace(failed=False, reason="time is up")
    told.design = told.scenario = Part()
    told.impact_count, told.elements, told.accepted, told.attempts = 0, (BUFFER, STOP), 9, 10
    told.energy = Energy({"kinetic": 0.25, "gravity": -2.81}, {"left_arm_damper": 4.57, "left_stop": -0.0})
    told.balance = Balance(0.0, 0.0, 0.0, 0.0)
    lines = plain_summary(told).splitlines()
    assert [line for line in lines if "stroke" in line] == ["  left stroke              40 mm at 1.5 s"]
    assert [line for line in lines if " 7 N" in line] == ["  left stop                from 50 mm on, at most 7 N"]
    assert "  speed                    2 m/s" in lines
    assert "  gap                      2.5 mm" in lines and "  turn                     90 deg" in lines
    assert "  energy lost              4.57 J (left arm damper 4.57)" in lines
    assert "  energy stored at the end -2.56 J (gravity -2.81, kinetic 0.25)" in lines


def test_a_row_says_number_limit_and_time():
    """Lengths in mm, angles in degrees; rounding is 0 without a time."""
    row = SummaryRow("stroke", 0.0251, "m", limit=0.03, time=0.12, note=", end stop from 28 mm on")
    assert row.line == ("stroke", "25.1 mm of 30 mm, end stop from 28 mm on at 0.12 s")
    assert row._replace(value=1e-10, least=1e-9).text == "0 mm of 30 mm, end stop from 28 mm on"
    assert SummaryRow("", math.pi / 6, "rad").text == "30 deg" and SummaryRow("", -2.5, "N").text == "-2.5 N"

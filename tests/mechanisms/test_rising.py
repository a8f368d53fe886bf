"""What is said of a stroke and a hinge angle that still rise where the run ends."""

import dataclasses

import jax.numpy as jnp
import numpy as np

import jaxbuffer as jb
from front.made_up import made_up_capture
from jaxbuffer.mechanisms.probe_cone.law_validity import warnings


def test_the_rate_at_the_end_is_that_of_the_stroke_by_the_duration(evidence):
    """Central differences of the largest stroke by the duration, while the buffer is pushed in; 0 after its turn."""

    def run(duration):
        return jb.simulate(jb.table2(), jb.Scenario(approach_speed=0.2), duration, rtol=1e-9)

    end, step = 0.04, 1e-4
    before, here, after = (float(run(end + k * step).stroke) for k in (-1, 0, 1))
    difference = (after - before) / (2.0 * step)
    assert before < here < after
    error = abs(float(run(end).stroke_rising) / difference - 1.0)
    evidence(
        "Closed forms", "rate of the stroke at the end of a run", error, 1e-3, "central differences by the duration"
    )
    turned = run(0.35)
    assert float(turned.stroke_rising) == 0.0 and "still rising" not in str(turned)


def test_the_summary_and_the_warnings_say_so():
    rising = {"stroke_rising": jnp.asarray(0.012), "hinge_angle_rising": jnp.asarray(np.pi / 180.0)}
    capture = dataclasses.replace(made_up_capture(), **rising)
    assert "7.5 mm of 136.5 mm, still rising at the end of the run at 12 mm/s" in str(capture)
    assert "deg, still rising at the end of the run at 1 deg/s" in str(capture)
    told = warnings(capture)
    assert [line.split(" is still rising")[0] for line in told] == ["the stroke", "the hinge angle"]
    assert "where the run ends at capture" in told[0] and warnings(made_up_capture()) == []

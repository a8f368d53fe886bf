"""Mechanisms that are alike up to their size move alike: all lengths a thousandth, masses and times the same."""

import pytest

import jaxbuffer as jb
from jaxbuffer.fields import get, metadata, paths, replace

SMALLER = 1e-3
LENGTHS = {"m": 1, "m/s": 1, "N": 1, "kg m²": 2, "N m/rad": 2, "N m s/rad": 2}  # how often a unit holds a length
COMPARED = {"peak_force": 1, "peak_latch_force": 1, "peak_hinge_force": 1, "stroke": 1, "hinge_angle": 0, "end_time": 0}


def smaller(design):
    """The design with all its lengths a thousandth; Hertz's stiffness is a force over a length to the power 3/2."""
    values = {
        path: get(design, path) * SMALLER ** LENGTHS[metadata(design, path)["unit"]]
        for path in paths(design)
        if metadata(design, path).get("unit") in LENGTHS and get(design, path) is not None
    }
    return replace(design, values | {"contact.stiffness": design.contact.stiffness / SMALLER**0.5})


@pytest.mark.long
def test_a_mechanism_of_a_thousandth_the_size_and_speed_moves_as_the_large_one():
    """At 0.3 mm/s, where 10 µm/s are no small speed: with a floor of that on the memory of touchdowns the stroke was
    off by 4e-6 and the hinge force by 2.5e-7."""
    design = replace(jb.table2(), {"latch.stiffness": 2000.0, "latch.damping": 50.0, "latch.turn_stiffness": 50.0})
    design = replace(design, {"contact.stiffness": float(design.contact_stiffness)})
    starts = [jb.Scenario(start="free", offset=0.02 * s, approach_speed=0.3 * s) for s in (1.0, SMALLER)]
    large, small = (
        jb.simulate(each, start, 20.0, rtol=1e-8) for each, start in zip((design, smaller(design)), starts, strict=True)
    )
    assert (small.outcome, int(small.impact_count)) == (large.outcome, int(large.impact_count))
    for name, power in COMPARED.items():
        value = float(small.quantity(name)) / SMALLER**power
        assert value == pytest.approx(float(large.quantity(name)), rel=3e-8), name

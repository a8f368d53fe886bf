"""How far the buffer's rod goes out beyond its free position, in a docking that swings on its spring after capture."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.output.page_data import force_record

LATCH = {"latch.stiffness": 2e3, "latch.damping": 50.0}  # N/m, N s/m
DESIGN = jb.replace(jb.table2(), LATCH)


def docked(duration=20.0, design=DESIGN):
    return jb.simulate(design, jb.Scenario(), duration, rtol=1e-9, history=True)


@pytest.mark.slow
def test_the_extension_is_the_deepest_stroke_at_any_time():
    """Runs that end at other times have their strokes there as they are, located by nothing: at the time of the
    extension it is the extension, a little before and after it less."""
    run = docked()
    extension, at, history = float(run.extension), run.maximum_times["extension"], run.history
    assert 5e-4 < -np.min(history.stroke) <= extension * (1.0 + 1e-12)
    assert float(run.quantity("extension_time")) == at
    before, there, after = (-float(docked(at + shift).history.stroke[-1]) for shift in (-1e-3, 0.0, 1e-3))
    assert there == pytest.approx(extension, rel=1e-8) and max(before, after) < extension * (1.0 - 1e-9)
    assert f"{1e3 * extension:.6g} mm beyond the free length at" in repr(run)


@pytest.mark.slow
def test_the_pages_curves_reach_the_largest_values():
    """To the six digits that a page has: evenly spread times alone would miss a short latch force by parts in a
    thousand."""
    run = docked()
    curves = {chart["axis"]: chart["curves"][0]["values"] for chart in force_record({"capture": run}, "")["more"]}
    stroke = curves["stroke [mm]"]
    assert max(stroke) == pytest.approx(1e3 * float(run.stroke), rel=2e-6)
    assert min(stroke) == pytest.approx(-1e3 * float(run.extension), rel=2e-6)
    assert max(curves["latch force [N]"]) == pytest.approx(float(run.quantity("peak_latch_force")), rel=2e-6)


def test_it_is_a_quantity_like_the_others():
    """Limits and objectives take it by name, with a unit, and figures show it in mm."""
    limits = jb.Limits(at_most={"extension": "5 mm"})
    stated = jb.Problem(DESIGN, [jb.Scenario()], [jb.Variable("buffer.k_A", 1e2, 2e3)], limits=limits)
    assert stated.limits.at_most == {"extension": pytest.approx(0.005)} and "extension" in stated.mechanism.swept
    assert stated.catalogue["extension"].in_words(0.0203) == "20.3 mm"

"""`jaxbuffer reproduce impact`: the printed data, verdicts by hand-made rows, what a fixed step sees."""

import numpy as np
import pytest

from jaxbuffer.cli.entry import run as command
from jaxbuffer.output.style import png
from jaxbuffer.papers import PAPERS, paper_named
from jaxbuffer.papers.impact.bar_claims import CLAIMS
from jaxbuffer.papers.impact.bar_rows import harmonics, sampled_at
from jaxbuffer.papers.impact.bar_studies import STUDIES
from jaxbuffer.papers.study import NO, PARTLY, YES, run

BY_NAME = {study.name: study for study in STUDIES}


def claim(start):
    (found,) = [claim for claim in CLAIMS if claim.claim.startswith(start)]
    return found


def test_every_paper_says_what_the_command_needs():
    for name in PAPERS:
        paper = paper_named(name)
        assert paper.name == name and paper.studies and paper.note
        assert len({study.name for study in paper.studies}) == len(paper.studies)
        assert all(set(part.shown) <= set(part.columns) for part in paper.parts)


def test_the_printed_values_are_studied():
    """k = 48 049 N/mm^2.2, e = 2.2, d = 0.01 mm, c = 1 and 6 N s/mm, bar 240 x 4 mm, plate 300 x 100 x 6 mm, 194 mm."""
    for study in STUDIES:
        for case, damping in zip(study.cases, (0.0, 1000.0, 6000.0), strict=True):
            d = case.design
            assert float(d.impact.damping) == damping
            assert float(d.impact.stiffness) == pytest.approx(48_049.0 * 1000.0**2.2)
            assert [float(x) for x in (d.impact.exponent, d.impact.ramp_depth)] == [2.2, 1e-5]
            assert [float(x) for x in (d.bar.length, d.bar.diameter)] == [0.24, 0.004]
            assert [float(x) for x in (d.plate.length, d.plate.width, d.plate.thickness)] == [0.3, 0.1, 0.006]
    assert {float(case.scenario.height) for case in BY_NAME["drop"].cases} == {0.194}
    assert float(BY_NAME["speed"].cases[0].scenario.height) == pytest.approx(1.325**2 / (3 * 9.81))


@pytest.mark.parametrize(("springs", "verdict"), [((244.5, 5.0), PARTLY), ((300.0, 5.0), NO), ((300.0, 251.0), YES)])
def test_the_analytical_force(springs, verdict):
    rows = tuple({"spring_peak": spring, "peak_force": 840.0} for spring in springs)
    assert claim("The spring's part reaches").judge({"speed": rows}).verdict == verdict


@pytest.mark.parametrize(("six", "verdict"), [(20.0, YES), (29.9, NO)])
def test_a_displacement_is_less_if_it_is_by_a_hundredth(six, verdict):
    rows = tuple({"plate_deflection": 1e-6 * bent} for bent in (60.0, 30.0, six))
    assert claim("More damping, less").judge({"plate": rows, "bodies": rows}).verdict == verdict


def test_what_a_fixed_step_sees_of_a_triangle():
    """A triangle of 10 µs seen at 100 µs: nine of ten grids see nothing, none more than its height."""
    sampled = sampled_at(1e-4, np.array([0.0, 1e-3, 1.005e-3, 1.01e-3, 2e-3]), np.array([0.0, 0.0, 7.0, 0.0, 0.0]))
    assert np.mean(sampled > 0.0) == pytest.approx(0.1, abs=0.01)
    assert 6.5 < sampled.max() <= 7.0
    assert harmonics(np.linspace(0.0, 3e-3, 301), np.sin(np.linspace(0.0, 6.0 * np.pi, 301)).clip(0.0)) == 3


@pytest.mark.slow
def test_the_undamped_force_at_the_printed_speed():
    """244.5 N, from an independent program; the impact without weight that it solves is 0.1 % lower."""
    part, _ = paper_named("impact").parts
    (studied,) = run(part, (BY_NAME["speed"],))
    assert float(studied.rows[0]["speed"]) == pytest.approx(1.325, rel=1e-9)
    assert float(studied.rows[0]["peak_force"]) == pytest.approx(244.5, rel=1.5e-3)
    assert float(studied.rows[1]["peak_force"]) == pytest.approx(840.0, rel=1e-3)
    assert png(part.figure(studied)).startswith(b"\x89PNG")


def test_an_unknown_paper_is_refused(tmp_path, capsys):
    assert command(["reproduce", "impacts", "--output", str(tmp_path)]) == 2
    assert "choose one of docking, impact; did you mean impact?" in capsys.readouterr().err

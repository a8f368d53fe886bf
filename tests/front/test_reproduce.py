"""`jaxbuffer reproduce`: studies as the paper has them, verdicts by hand-made rows, files never overwritten."""

import math

import pytest

from jaxbuffer.cli.entry import run as command
from jaxbuffer.output.style import png
from jaxbuffer.papers.docking import CAPTURES
from jaxbuffer.papers.docking.claims import CLAIMS
from jaxbuffer.papers.docking.figures import figure
from jaxbuffer.papers.docking.studies import STUDIES
from jaxbuffer.papers.study import NO, PARTLY, YES, Claim, run

BY_NAME = {study.name: study for study in STUDIES}


def claim(start) -> Claim:
    (found,) = [claim for claim in CLAIMS if claim.claim.startswith(start)]
    return found


def row(case="", value=0.0, outcome="captured", **numbers):
    return {"case": case, "value": value, "outcome": outcome, **numbers}


def test_the_papers_values_are_studied():
    assert [math.degrees(float(case.scenario.passive_rate)) for case in BY_NAME["rate"].cases] == pytest.approx(
        [0.0, 0.05, 0.1]
    )
    assert len(BY_NAME["friction"].cases) == 5
    for name in ("speed", "rate", "misalignment"):
        welded, free = BY_NAME[name], BY_NAME[f"{name}_free"]
        assert [case.scenario for case in welded.cases] == [case.scenario for case in free.cases]
        assert all(case.design.probe.free_tip for case in free.cases)
        assert not any(case.design.probe.free_tip for case in welded.cases)
    covered = {int(f) for s in STUDIES for f in range(int(s.figures.split("-")[0]), int(s.figures.split("-")[-1]) + 1)}
    assert covered == set(range(6, 18))


@pytest.mark.parametrize(("change", "verdict"), [(0.93, YES), (1.0, NO), (0.86, NO)])
def test_seven_percent(change, verdict):
    rows = {"tip": (row(first_peak=100.0, peak_force=200.0), row(first_peak=100 * change, peak_force=200 * change))}
    assert claim("A free tip lowers the largest impact force").judge(rows).verdict == verdict


def test_only_captures_that_succeed_have_a_duration():
    times = [row("a", outcome="timeout", contact_time=0.1, capture_time=8.0)]
    times += [row(case, contact_time=t, capture_time=2 * t) for case, t in (("b", 0.5), ("c", 0.4), ("d", 0.3))]
    assert claim("The higher the approach speed").judge({"speed": tuple(times)}).verdict == YES
    times.append(row("e", contact_time=0.35, capture_time=0.5))
    assert claim("The higher the approach speed").judge({"speed": tuple(times)}).verdict == PARTLY


def test_success_at_all_values_means_all():
    rows = {"friction": (row("μ = 0.1"), row("μ = 0.5", outcome="timeout"))}
    verdict = claim("Captured at all friction").judge(rows)
    assert verdict.verdict == PARTLY and "μ = 0.5 timeout" in verdict.said


def test_existing_results_are_refused_before_anything_runs(tmp_path, capsys):
    (tmp_path / "claims.md").write_text("mine")
    assert command(["reproduce", "--output", str(tmp_path)]) == 2
    assert "--force" in capsys.readouterr().err
    assert (tmp_path / "claims.md").read_text() == "mine"


@pytest.mark.slow
def test_a_study_runs_and_draws():
    (studied,) = run(CAPTURES, (BY_NAME["motion"],))
    assert studied.rows[0]["outcome"] == "captured"
    assert studied.rows[0]["capture_time"] == pytest.approx(0.71934, abs=1e-5)
    assert png(figure(studied)).startswith(b"\x89PNG")

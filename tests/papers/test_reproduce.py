"""`jaxbuffer reproduce`: studies as the paper has them, verdicts by hand-made rows, files never overwritten."""

import math

import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run as command
from jaxbuffer.output.style import png
from jaxbuffer.papers.claims import NO, NONE, OPEN, PARTLY, YES, Claim
from jaxbuffer.papers.docking import CAPTURES, readings
from jaxbuffer.papers.docking.claims import CLAIMS
from jaxbuffer.papers.docking.figures import figure
from jaxbuffer.papers.docking.published import as_published
from jaxbuffer.papers.docking.readings import READINGS, Reading
from jaxbuffer.papers.docking.studies import STUDIES
from jaxbuffer.papers.study import Studied, Study, StudyCase, run

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
    assert verdict.verdict == PARTLY and "μ = 0.5 timeout" in verdict.finding


def slip(**numbers):
    return row(**{"peak_friction": 9.0, "bounce": 1e-4, "parting": 0.9, **numbers})


@pytest.mark.parametrize(
    ("start", "rows", "verdict"),
    [
        ("The force without a buffer", {"rigid": (row(first_peak=1000.0), row(first_peak=100.0))}, OPEN),
        ("Rolling lowers", {"tip": (slip(friction_impulse=2), slip(friction_impulse=1, peak_friction=9.5))}, PARTLY),
        ("A free tip rolls", {"tip": (row(rolling_share=0.02), row(rolling_share=0.9))}, YES),
        ("A free tip rolls", {"tip": (row(rolling_share=0.3), row(rolling_share=1.0))}, NO),
        ("A free tip rolls", {"tip": (row(rolling_share=0.05), row(rolling_share=0.05))}, PARTLY),
        ("A free tip lowers the pen", {"tip": (row(penetration=1e-5), row(penetration=0.999e-5))}, NO),
        ("The tip slides", {"rigid": (slip(outcome="escaped", bounce=0.02), slip())}, YES),
        ("The tip slides", {"rigid": (slip(bounce=8e-4), slip())}, PARTLY),
    ],
)  # fmt: skip
def test_verdicts_on_contact(start, rows, verdict):
    assert claim(start).judge(rows).verdict == verdict


def test_a_mass_grows_slowly_if_it_does_from_impact_to_impact():
    def judged(*soft):
        both = [(5.0, 4.0, NONE, NONE, NONE), soft]
        rows = [row(**{f"mass_{k}": mass for k, mass in enumerate(masses, 1)}) for masses in both]
        return claim("The buffer lets the mass").judge({"rigid": tuple(rows)})

    assert judged(0.1, 0.2, 0.3, 0.4, 0.5).verdict == YES
    assert judged(0.1, 0.2, 0.15, 0.4, 0.5).verdict == PARTLY
    assert "rigid 5, 4 kg" in judged(0.1, 0.2, 0.3, 0.4, 0.5).finding


def test_published_studies_have_the_papers_equations_and_answer_the_same_claims():
    part = as_published(CAPTURES)
    designs = [case.design for study in part.studies for case in study.cases]
    assert {(d.buffer.damping, d.contact.arms) for d in designs} == {("published", "published")}
    assert {study.name for study in part.studies} == {f"{study.name}_published" for study in STUDIES}
    seven = part.claims[[c.claim for c in CLAIMS].index("A free tip lowers the largest impact force by 7 %")]
    ours, theirs = ((row(first_peak=100.0, peak_force=100.0), row(first_peak=f, peak_force=f)) for f in (100.0, 93.0))
    assert seven.judge({"tip": ours, "tip_published": theirs}).verdict == YES


def test_readings_cover_what_the_paper_leaves_open():
    """Table 2 as it is read here is among them; each has four runs, and a row in the table."""
    assert len(set(READINGS)) == len(READINGS) == len({str(reading) for reading in READINGS})
    assert len(readings.STUDY.cases) == 4 * len(READINGS)
    first = readings.STUDY.cases[4 * READINGS.index(Reading(False, 0.015, readings.RODS[0]))]
    table2 = BY_NAME["tip"].cases[0].design
    assert float(first.design.probe.tip_mass) == pytest.approx(float(table2.probe.tip_mass), rel=1e-12)
    assert float(first.design.probe.rod_mass) == float(table2.probe.rod_mass)
    assert {r.restitution for r in READINGS} >= {0.5, 0.95} and {r.radius for r in READINGS} == {0.009, 0.015}
    assert any(r.bends for r in READINGS) and any(r.published for r in READINGS)


def test_a_reading_bears_out_what_all_four_runs_say():
    welded = row(first_peak=100.0, peak_force=100.0, end_stroke=1e-4, stroke=1e-2)
    free = row(first_peak=93.0, peak_force=93.0, end_stroke=5e-3, stroke=1e-2)
    wrong = row(first_peak=93.0, peak_force=99.0, end_stroke=5e-3, stroke=1e-2, outcome="timeout")
    rows = [welded, welded, free, free] + [welded, wrong, wrong, free] * (len(READINGS) - 1)
    made = readings.table(Studied(readings.STUDY, (), tuple(rows)))
    assert [made[0][name] for name in readings.TESTS] == ["yes"] * 3
    assert [made[1][name] for name in readings.TESTS] == ["no", "yes", "no"]
    verdicts = [claim.judge({"readings": tuple(rows)}) for claim in readings.CLAIMS]
    assert [v.verdict for v in verdicts] == [PARTLY, YES, PARTLY, PARTLY]
    assert verdicts[3].finding.startswith("in 1 of")


def test_a_paper_without_equations_of_its_own_is_refused_them(tmp_path, capsys):
    assert command(["reproduce", "impact", "--published", "--output", str(tmp_path / "new")]) == 2
    said = capsys.readouterr().err
    assert "--published: impact has no second set of equations; docking has: leave it out" in said
    assert not (tmp_path / "new").exists()


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
    assert studied.rows[0]["returns_at"] == pytest.approx(0.279, abs=1e-3)
    assert png(figure(studied)).startswith(b"\x89PNG")


@pytest.mark.slow
def test_without_friction_or_buffer_the_first_effective_mass_is_the_closed_forms():
    """M79, exact where springs and dampers are soft; Table 2's dampers add 2 %."""
    soft = {"buffer.k_A": 0.5, "buffer.c_A": 0.0, "buffer.k_T": 0.3, "buffer.c_T": 0.0, "contact.friction": 0.0}
    case = StudyCase("soft", 0.0, jb.replace(jb.table2(), soft), jb.Scenario(), {"duration": 0.01})
    (studied,) = run(CAPTURES, (Study("soft", "", "", "", "", (case,)),))
    expected = float(jb.first_impact(case.design).effective_mass)
    assert float(studied.rows[0]["mass_1"]) == pytest.approx(expected, rel=2e-3)
    assert studied.rows[0]["friction_impulse"] == 0.0

"""Campaigns in portions: the same runs as in one go, and counts of those that there was time for."""

import os
import signal

import pytest

import jaxbuffer as jb
from benchmarks import campaign as campaigns
from benchmarks import wide
from benchmarks.campaign import ANY_PARTS, STUDIES, campaign, studies_of
from benchmarks.elasticities import NUMBERS, OWN, numbers_of
from benchmarks.portions import Portion, cases


def numbered(first, count=40):
    studies = studies_of("bar drop, any parts", 4, seed=0)
    return [(case.number, case.label, case.design) for case in cases(studies, count, 0, first)]


def test_runs_from_a_number_on_are_those_of_the_whole():
    whole = numbered(0)
    numbers = [number for number, *_ in whole]
    assert numbers == sorted(set(numbers)) and len({label for _, label, _ in whole}) == len(whole)
    for first in (1, 10, 25):
        assert repr(numbered(first)) == repr([run for run in whole if run[0] >= first])


@pytest.mark.parametrize("request_to_end", [signal.SIGINT, signal.SIGTERM])
def test_a_campaign_that_is_told_to_end_finishes_its_run_and_prints_its_counts(monkeypatch, capsys, request_to_end):
    ended, before = jb.Outcome(0), signal.getsignal(request_to_end)

    def shortfalls(design, scenario, duration):
        made.append(design)
        if len(made) == 3:
            os.kill(os.getpid(), request_to_end)
        return ended, 2e-6, {"missed": ["peak_force 2e-3"]}

    made, study = [], STUDIES["docking"]()
    monkeypatch.setattr(campaigns, "_shortfalls", shortfalls)
    campaign("docking", [study], 10, 0)
    shown = capsys.readouterr().out
    following = list(cases([study], 10, 0))[3].number
    assert f"docking: 3 runs, 3 {ended.name}; stopped: go on with --first {following}\n" in shown
    assert "  missed: 3  " in shown and "  energy off by more than 1e-06: 3  " in shown
    assert signal.getsignal(request_to_end) is before
    campaign("docking", [study], 10, 0, first=following)
    assert [repr(design) for design in made] == [repr(design) for design, _ in study.drawn(10, 0)]
    assert "stopped" not in capsys.readouterr().out


def test_a_campaign_without_time_says_so():
    portion = Portion(minutes=0.0)
    assert list(portion.of(cases([STUDIES["docking"]()], 10, 0))) == []
    assert portion.stopped and portion.remark == "; stopped: go on with --first 0"


@pytest.mark.slow
def test_wide_designs_are_told_by_their_ends_and_beside_their_tight_solves(capsys):
    """The exit status is 1 where a quantity is far from a tight solve that knows it: after many impacts one may be."""
    code = wide.main(["bar drop, any parts"], runs=2, structures=1, tight=True)
    shown = capsys.readouterr().out
    assert "bar drop, any parts: 2 runs, 2 finished" in shown and "beyond a limit of the model's validity: " in shown
    assert "against rtol 1e-10, the quantity farthest off: " in shown
    assert "another outcome or number of impacts: " in shown
    assert code == int(int(shown.split("off by over 1e-05: ")[1].split()[0]) > 0)


def test_a_structure_is_differentiated_by_the_numbers_of_its_optional_parts():
    base, parts = ANY_PARTS["docking, any parts"]
    base = STUDIES[base]()
    for names in (["spring curve"], ["latch", "thrust"], ["free tip"]):
        study = base.with_parts({name: parts[name] for name in names})
        own = {path for name in names for path in (*parts[name].logarithmic, *parts[name].even)}
        numbers = numbers_of(study, base, seed=0)
        assert len(set(numbers)) == NUMBERS and len(own & set(numbers)) == min(len(own), OWN)
        for design, scenario in study.drawn(1, 0):
            jb.fields.check_numbers(design, scenario, numbers, "one")

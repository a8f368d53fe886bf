"""Evidence fails its test where it must and keeps the worst; the report sees what no breakage caught."""

import json
import subprocess
import sys

import pytest

from evidence import Evidence
from verify.breakages import BREAKAGES
from verify.report import STATE, markdown, note_state, page, uncaught
from verify.run import ROOT


def record(measured, tolerance=1e-3, claim="claim"):
    return {"topic": "topic", "claim": claim, "measured": measured, "tolerance": tolerance, "source": "source"}


@pytest.mark.parametrize("measured", [2e-3, float("nan"), -1e-9, float("inf")])
def test_what_is_above_its_tolerance_or_no_number_fails(measured):
    with pytest.raises(AssertionError, match="claim"):
        Evidence()(**record(measured))


def test_the_worst_of_a_claim_is_kept(tmp_path):
    evidence = Evidence()
    for measured in (1e-4, 5e-4, 2e-4):
        evidence(**record(measured))
    evidence(**record(0.0, 0.0, "another"))
    evidence.write(tmp_path / "a" / "evidence.json")
    first, second = json.loads((tmp_path / "a" / "evidence.json").read_text())
    assert (first["measured"], first["count"], first["test"]) == (
        5e-4,
        3,
        "tests/verify/test_evidence.py::test_the_worst_of_a_claim_is_kept",
    )
    assert (second["claim"], second["measured"]) == ("another", 0.0)


def test_the_worst_of_all_processes_is_kept():
    here, there = Evidence(), Evidence()
    here(**record(1e-4))
    there(**record(5e-4))
    there(**record(2e-4))
    there(**record(1e-5, claim="another"))
    with pytest.raises(AssertionError):
        there(**record(float("nan"), claim="failed"))
    here.add(list(there.records.values()))
    first, second, third = here.records.values()
    assert (first["measured"], first["count"]) == (5e-4, 3)
    assert (second["claim"], second["measured"], second["count"]) == ("another", 1e-5, 1)
    assert third["measured"] != third["measured"]


def test_what_fails_is_in_the_report_too():
    evidence = Evidence()
    evidence(**record(1e-4))
    with pytest.raises(AssertionError):
        evidence(**record(float("nan")))
    assert "| claim | nan | 0.001 |" in markdown(list(evidence.records.values()), None, [], {})


def test_a_breakage_nobody_noticed_and_a_check_that_cannot_fail_are_named():
    records = [
        {"name": "first", "what": "", "checks": {"a": "failed", "b": "passed"}},
        {"name": "second", "what": "", "checks": {"b": "crashed"}},
    ]
    assert uncaught(records) == ["breakage 'second' is caught by nothing", "check b catches nothing"]
    page = markdown([], None, records, {})
    assert "| second |  | **none**; crashed `b` |" in page
    assert "| `b` | **nothing** |" in page


def test_the_page_of_an_empty_folder_lists_everything_and_says_that_nothing_was_run(tmp_path):
    text = page(tmp_path)
    assert text.count("Nothing has been run for these sources") == 6  # claims, breakages, four papers
    assert all(f"| {breakage.name} | {breakage.what} |" in text for breakage in BREAKAGES)
    assert "| Captured at all approach speeds | 8, fig. 10 |" in text and "| any measurement |" in text
    assert "| `contact/test_damping.py` | Damping factors by author, for any spring. |" in text


def test_results_of_other_sources_do_not_count(tmp_path):
    (tmp_path / "evidence.json").write_text(
        json.dumps([record(1e-4) | {"unit": "", "detail": "", "test": "t", "count": 1}])
    )
    note_state(tmp_path, ["tests"])
    assert "| claim | 0.0001 | 0.001 |" in page(tmp_path)
    (tmp_path / STATE).write_text(json.dumps({"tests": "another"}))
    assert "| claim |" not in page(tmp_path)


def test_at_least_ten_breakages_each_with_a_name_of_its_own():
    assert len({breakage.name for breakage in BREAKAGES}) == len(BREAKAGES) >= 10


def test_every_check_of_a_breakage_is_there():
    """A test that was moved or renamed would notice nothing any more."""
    for check in {check for breakage in BREAKAGES for check in breakage.checks}:
        file, _, test = check.partition("::")
        path = ROOT / file
        assert path.is_file() or (not test and path.is_dir()), check
        assert not test or f"def {test.partition('[')[0]}(" in path.read_text(encoding="utf-8"), check


def test_every_breakage_replaces_what_there_is():
    """One that patches what was renamed, or whose arguments changed, crashes its checks instead of failing them."""
    done = subprocess.run([sys.executable, "-m", "verify.stale"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, ""), done.stdout + done.stderr

"""Benchmarks without the measuring: choice at equal accuracy, ratios, baseline and report on made-up figures."""

import json
import math
import re
import sys
import time
from pathlib import Path

import pytest

from benchmarks import __main__ as command
from benchmarks import baseline, docs, fresh, report, speed
from benchmarks.accuracy import Result, Setting, cheapest, errors, race, reliable
from benchmarks.figures import Check, Curve, Figure, Part, Plot, Ratio

RUN = {
    "mode": "quick",
    "date": "2025-01-02",
    "seconds": 120.0,
    "machine": {"processor": "abacus", "cores": 2, "load": 0.1, "python": "3", **dict.fromkeys(report.PACKAGES, "1")},
}


def setting(seconds, error, solver="a"):
    return Setting(solver, "rtol", {"peak": error, "end": 0.0}, seconds, lambda: time.sleep(1e-3 * seconds))


def part(ours=2.0, theirs=10.0, name="capture", key="best-peer") -> Part:
    mine = Figure("jaxbuffer", ours, "ms", {"peak": 1e-5, "end": 2e-6}, "rtol 1e-06")
    other = Figure("LSODA", theirs, "ms", {"peak": 3e-5, "end": math.inf})
    return Part(
        name,
        "One capture",
        (Ratio(f"{name}/{key}", "against the best peer", mine, other, 4.0),),
        (
            Check("peak memory", Figure("jaxbuffer", 2000.0, "MiB"), 1024.0),
            Check("rate", Figure("x", 700.0, "1/s"), 600.0, True),
        ),
        (Plot("a plot", "Work", "wall time [s]", "error [-]", (Curve("jaxbuffer", (1.0, 2.0), (1e-3, 1e-4)),), 1e-4),),
        ("a note",),
        (Figure("a turn", 7.5, "ms", setting="28 impacts"),),
    )


def test_errors_are_relative_and_infinite_between_captures_of_another_kind():
    exact = Result("captured", 24, 250.0, 0.7)
    off = errors(Result("captured", 24, 250.5, 0.7), exact)
    assert off == {"peak": pytest.approx(2e-3), "end": 0.0}
    assert set(errors(Result("escaped", 24, 250.0, 0.7), exact).values()) == {math.inf}
    assert set(errors(Result("captured", 23, 250.0, 0.7), exact).values()) == {math.inf}


def test_a_loose_setting_that_hits_the_mark_by_luck_is_not_relied_on():
    curve = [setting(4.0, 1e-6), setting(3.0, 9e-5), setting(2.0, 2e-4), setting(1.0, 1e-5)]
    assert [s.seconds for s in reliable(curve, 1e-4)] == [4.0, 3.0]
    other = [setting(3.5, 5e-5, "b"), setting(2.5, 1e-3, "b")]
    assert cheapest([curve, other], 1e-4).errors == curve[1].errors
    assert cheapest([other[1:]], 1e-4) is None


def test_what_may_be_the_quickest_runs_once_more():
    """A machine that was slow for a while must not decide."""
    runs = []

    def timed(seconds, truly, name):
        return Setting(name, "", {"peak": 0.0}, seconds, lambda: (runs.append(name), time.sleep(truly)))

    settings = [timed(1.0, 0.02, "in luck"), timed(1.5, 0.005, "unlucky"), timed(1.7, 0.0, "too slow")]
    result = cheapest([settings], 1e-4)
    assert result.solver == "unlucky" and 0.005 <= result.seconds < 0.02
    assert runs == ["in luck", "unlucky"] * 3


def test_a_race_keeps_the_best_time_and_spares_the_slow():
    runs = []
    quick = Setting("a", "", {"peak": 0.0}, 1.0, lambda: runs.append("quick"))
    slow = Setting("b", "", {"peak": 0.0}, 9.0, lambda: runs.append("slow"))
    first, second = race([quick, slow], 3)
    assert runs == ["quick"] * 3 and first.seconds < 1.0 and second.seconds == 9.0


def test_ratios_say_how_many_times_as_fast():
    assert part().ratios[0].value == 5.0 and part().ratios[0].met
    assert part(theirs=4.0).ratios[0].met is False
    rates = [Figure("x", rate, "1/s") for rate in (600.0, 50.0)]
    assert Ratio("sweep/pool", "", *rates).value == 12.0 and Ratio("sweep/pool", "", *rates).met is None
    with pytest.raises(ValueError, match="ms against 1/s"):
        _ = Ratio("x/y", "", part().ratios[0].ours, rates[0]).value
    assert [check.met for check in part().checks] == [False, True]


def test_a_ratio_that_fell_or_was_lost_is_told():
    before = {"capture/best-peer": 10.0, "capture/IDA": 5.0, "sweep/pool": 3.0}
    assert baseline.fallen({"capture/best-peer": 7.1, "capture/IDA": 50.0, "sweep/pool": 3.0, "new": 0.1}, before) == []
    assert baseline.fallen({"capture/best-peer": 6.9, "sweep/pool": 2.5}, before) == [
        "capture/best-peer: 6.90, baseline 10.00",
        "capture/IDA: not measured, baseline 5.00",
    ]
    assert baseline.due(before, ["sweep", "cold"]) == {"sweep/pool": 3.0}


def test_baselines_of_modes_and_parts_are_kept_apart(tmp_path):
    file = tmp_path / "baseline.json"
    assert baseline.load("quick", file) == {}
    baseline.store("quick", baseline.ratios([part(), part(name="gradient")]), RUN, file)
    baseline.store("full", {"capture/best-peer": 9.0}, RUN, file)
    later = RUN | {"date": "2025-03-04", "machine": RUN["machine"] | {"processor": "astrolabe"}}
    baseline.store("quick", {"gradient/best-peer": 33.333}, later, file)
    assert baseline.load("quick", file) == {"capture/best-peer": 5.0, "gradient/best-peer": 33.3}
    assert baseline.load("full", file) == {"capture/best-peer": 9.0}
    assert baseline.machine_of("quick", file) == "stored last on 2 cores of astrolabe, 2025-03-04"
    assert baseline.machine_of("full", file) == "stored last on 2 cores of abacus, 2025-01-02"


@pytest.fixture
def measured(monkeypatch, tmp_path):
    """The command with made-up parts, and a baseline of its own."""
    result = {"capture": part(), "sweep": RuntimeError("no setting is accurate enough")}

    class Stub:
        def __init__(self, name):
            self.name = name

        def measure(self, plan):
            if isinstance(result[self.name], Exception):
                raise result[self.name]
            return result[self.name]

    for name in result:
        monkeypatch.setitem(sys.modules, f"benchmarks.{name}", Stub(name))
    monkeypatch.setattr(baseline, "FILE", tmp_path / "baseline.json")
    return result


def run(tmp_path, *words):
    return command.main(["--quick", "--output", str(tmp_path / "out"), *words])


def test_the_command_notices_a_slowdown(measured, tmp_path, capsys):
    assert run(tmp_path, "--only", "capture", "--check-baseline") == 1, "nothing to compare with"
    assert run(tmp_path, "--only", "capture", "--store-baseline") == 0
    assert run(tmp_path, "--only", "capture", "--check-baseline") == 0
    measured["capture"] = part(ours=4.0)
    capsys.readouterr()
    assert run(tmp_path, "--only", "capture", "--check-baseline") == 1
    shown = capsys.readouterr().out
    assert "SLOWER capture/best-peer: 2.50, baseline 5.00" in shown and "0 of 1 ratios" in shown
    assert "stored last on" in shown, "a ratio may differ between processors"
    assert run(tmp_path, "--only", "capture") == 0, "asked not to compare"


def test_a_part_that_fails_is_told_and_leaves_the_others(measured, tmp_path, capsys):
    assert run(tmp_path, "--only", "capture,sweep") == 1
    shown = capsys.readouterr().out
    assert "failed: no setting is accurate enough" in shown and "against the best peer" in shown
    record = json.loads((tmp_path / "out" / "results.json").read_text())
    assert [len(one["ratios"]) for one in record["parts"]] == [1, 0]
    assert (tmp_path / "out" / "a-plot.png").read_bytes().startswith(b"\x89PNG")


def test_unknown_parts_are_refused(capsys):
    assert command.main(["--only", "capture,warp"]) == 2
    assert "no such part: warp; there are capture, gradient" in capsys.readouterr().err


def test_the_report_says_everything():
    text = report.markdown([part()], RUN)
    assert "| a turn | 7.5 ms | 28 impacts |" in text.splitlines()
    assert "`python -m benchmarks --quick`, 2025-01-02, 2 min on 2 cores of abacus, load average 0.1" in text
    ours, theirs = "2 ms (jaxbuffer; rtol 1e-06; peak 1.0e-05, end 2.0e-06)", "10 ms (LSODA; peak 3.0e-05, end inf)"
    assert f"| against the best peer | {ours} | {theirs} | 5 | ≥ 4 | met |" in text.splitlines()
    assert "| peak memory | 2000 MiB | ≤ 1024 MiB | MISSED |" in text.splitlines()
    assert "- a note" in text and "![Work](a-plot.png)" in text


def test_the_pages_tables_are_those_of_the_stored_results():
    stored = json.dumps(report.record([part()], RUN))
    assert "Infinity" not in stored
    text = docs.tables(stored)
    assert text.startswith("`python -m") and "### One capture" in text and "| 5 | ≥ 4 | met |" in text


def test_our_page_includes_the_tables():
    included = re.search(r"^```\{include\} (\S+)$", docs.PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert included and (docs.PAGE.parent / included[1]).resolve() == docs.TABLES and docs.TABLES.is_file()


def test_the_command_writes_the_tables(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(docs, "TABLES", tmp_path / "measured.md")
    assert docs.main(tmp_path / "none.json") == 2 and "no such file" in capsys.readouterr().err
    (tmp_path / "results.json").write_text(json.dumps(report.record([part()], RUN)))
    assert docs.main(tmp_path / "results.json") == 0
    assert "### One capture" in docs.TABLES.read_text(encoding="utf-8")


def test_fresh_processes_do_not_find_a_cache_of_ours(monkeypatch, tmp_path):
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", "warm")
    environment = fresh.environment(tmp_path)
    assert "JAX_COMPILATION_CACHE_DIR" not in environment and environment["JAXBUFFER_CACHE"] == str(tmp_path)


def test_a_long_part_takes_part_in_a_quick_run_only_where_it_is_named():
    assert "slider_crank" in speed.parts_of(None, quick=False)
    assert "slider_crank" not in speed.parts_of(None, quick=True)
    assert speed.parts_of("slider_crank", quick=True) == ["slider_crank"]


@pytest.mark.parametrize("name", command.NAMES)
def test_every_benchmark_says_what_it_takes(name, capsys):
    pytest.importorskip("numba", reason="numba is not installed: pip install 'jaxbuffer[bench]'")
    pytest.importorskip("sksundae", reason="scikit-sundae is not installed: pip install 'jaxbuffer[bench]'")
    assert command.main([name, "--help"]) == 0
    shown = capsys.readouterr().out
    assert f"python -m benchmarks {name}" in shown
    assert name != command.DEFAULT or all(other in shown for other in command.NAMES)


def test_one_module_alone_is_a_program():
    """All others with a main are told by `python -m benchmarks --help`."""
    folder = Path(command.__file__).parent
    files = {".".join(file.relative_to(folder).with_suffix("").parts): file for file in folder.rglob("*.py")}
    texts = {name: file.read_text(encoding="utf-8") for name, file in files.items()}
    assert [name for name, text in texts.items() if "if __name__" in text] == ["__main__"]
    assert {name for name, text in texts.items() if "\ndef main(" in text} == {*command.NAMES, "__main__"}


def test_a_benchmark_that_there_is_not_is_refused(capsys):
    assert command.main(["speeed"]) == 2
    assert "no benchmark is called speeed; did you mean speed?" in capsys.readouterr().err
    assert command.main(["gradients", "--cuonts", "1"]) == 2
    assert "--counts" in capsys.readouterr().err

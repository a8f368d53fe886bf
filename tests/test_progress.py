"""Progress in Python: a bar for True, nothing otherwise, and the caller's own function as it is."""

import jaxbuffer as jb
from jaxbuffer.cli.commands.progress import working
from jaxbuffer.programs.cache import Compilation, _announced
from jaxbuffer.progress import counted, reported


def test_a_sweep_counts_its_runs(capsys):
    jb.sweep(jb.BarDrop(), jb.BarDropScenario(height=[0.1, 0.15, 0.194]), 0.05, progress=True)
    shown = capsys.readouterr()
    assert shown.out == "" and "3/3" in shown.err and " drop" in shown.err


def test_an_evaluation_is_told_in_words(capsys):
    with reported(True, lambda record: f"{record['objective']:g} N") as report:
        for objective in (3.0, 2.5):
            report({"objective": objective})
    shown = capsys.readouterr()
    assert shown.out == "" and "2 evaluations in 00:00, 2.5 N" in shown.err


def test_nothing_is_shown_unasked(capsys):
    def mine(*given):
        pass

    assert counted(None, "run") is None and counted(False, "run") is None and counted(mine, "run") is mine
    for moves, shown in ((None, None), (False, None), (mine, mine)):
        with reported(moves, str) as report:
            assert report is shown
    assert capsys.readouterr() == ("", "")


def test_a_compilation_that_takes_no_time_has_no_line(capsys):
    def work():
        for what, seconds in (("a program", 0.3), ("a run", 7.0)):
            with _announced(Compilation(what, seconds)):
                pass

    working("simulating", work)
    said = ["simulating", "compiling a run, which usually takes about 7 s (first run only)…"]
    assert capsys.readouterr().err.splitlines() == said

"""The command line without the wait: results are made up, and what was asked for is remembered."""

import sys

import pytest
from made_up import made_up_capture, made_up_sensitivity, made_up_tuning

import jaxbuffer.runtime
import jaxbuffer.tuning
from jaxbuffer import Outcome


class Computed:
    """Stands in for simulate, sensitivity and tune, and remembers how they were called."""

    def __init__(self) -> None:
        self.calls = []
        self.outcome = Outcome.captured
        self.error = None

    def simulate(self, design, scenario, duration, **options):
        self._note("simulate", design=design, scenario=scenario, duration=duration, **options)
        return made_up_capture(scenario, outcome=self.outcome, design=design)

    def sensitivity(self, design, scenario, wrt, duration, **options):
        self._note("sensitivity", design=design, scenario=scenario, wrt=wrt, duration=duration, **options)
        return made_up_sensitivity(made_up_capture(scenario, outcome=self.outcome, design=design), wrt)

    def tune(self, problem, *, report, **settings):
        self._note("tune", problem=problem, **settings)
        tuned = made_up_tuning(problem)
        for record in tuned.records:
            report(record)
        return tuned

    def _note(self, command, **arguments):
        self.calls.append((command, arguments))
        if self.error is not None:
            raise self.error


@pytest.fixture
def computed(monkeypatch, tmp_path):
    """The command line with made-up results, in an empty folder."""
    stand_in = Computed()
    monkeypatch.setattr(jaxbuffer.tuning, "tune", stand_in.tune)
    for name in ("capture", "sensitivity"):  # the modules: the package shows functions under the same names
        function = "simulate" if name == "capture" else name
        monkeypatch.setattr(sys.modules[f"jaxbuffer.{name}"], function, getattr(stand_in, function))
    monkeypatch.setattr(jaxbuffer.runtime, "configure", lambda **options: stand_in.calls.append(("configure", options)))
    monkeypatch.chdir(tmp_path)
    return stand_in

"""The command line without the wait: results are made up, and what was asked for is remembered."""

import numpy as np
import pytest
from made_up import made_up_capture, made_up_sensitivity, made_up_sweep, made_up_tuning

from jaxbuffer import Outcome
from jaxbuffer.sensitivities.certificate import Verdict
from jaxbuffer.sweeps.grid import grid
from jaxbuffer.sweeps.sweep import SweepInterrupted
from jaxbuffer.sweeps.swept import Swept


class Computed:
    """Stands in for simulate, sensitivity, sweep and tune, and remembers how they were called."""

    def __init__(self) -> None:
        self.calls = []
        self.outcome = Outcome.captured
        self.verdict = Verdict.trusted
        self.error = None
        self.outcomes = {}  # of a sweep, by index; captured otherwise
        self.interrupt_after = None

    def simulate(self, design, scenario, duration, **options):
        self._note("simulate", design=design, scenario=scenario, duration=duration, **options)
        return made_up_capture(scenario, outcome=self.outcome, design=design)

    def sensitivity(self, design, scenario, wrt, duration, **options):
        self._note("sensitivity", design=design, scenario=scenario, wrt=wrt, duration=duration, **options)
        capture = made_up_capture(scenario, outcome=self.outcome, design=design)
        return made_up_sensitivity(capture, wrt, options["quantities"], verdict=self.verdict)

    def tune(self, problem, *, report, **settings):
        self._note("tune", problem=problem, **settings)
        tuned = made_up_tuning(problem)
        for record in tuned.records:
            report(record)
        return tuned

    def sweep(self, design, scenario, duration, *, over, progress, **options):
        asked = grid(over, design, scenario)
        designs, scenarios = asked.applied(design, scenario)
        self._note("sweep", design=designs, scenarios=scenarios, duration=duration, **options)
        found = made_up_sweep(designs, scenarios, self.outcomes)
        for done in range(1, len(found) + 1):
            progress(done, len(found))
            if done == self.interrupt_after:
                those = np.arange(len(found)) < done
                raise SweepInterrupted(Swept(asked, design, scenario, found, those), those)
        return Swept(asked, design, scenario, found, np.ones(len(found), bool))

    def asked(self, command):
        """The arguments of the last call of a command; a tuning's figure simulates its worst scenario after it."""
        return [arguments for name, arguments in self.calls if name == command][-1]

    def _note(self, command, **arguments):
        self.calls.append((command, arguments))
        if self.error is not None:
            raise self.error


@pytest.fixture
def computed(monkeypatch, tmp_path):
    """The command line with made-up results, in an empty folder."""
    stand_in = Computed()
    for module in ("run.simulate", "sensitivities.sensitivity", "sweeps.sweep", "tuning.tune"):
        function = module.rsplit(".", 1)[-1]
        monkeypatch.setattr(f"jaxbuffer.{module}.{function}", getattr(stand_in, function))
    monkeypatch.setattr(
        "jaxbuffer.compiling.process.configure", lambda **options: stand_in.calls.append(("configure", options))
    )
    monkeypatch.chdir(tmp_path)
    return stand_in


@pytest.fixture
def no_figures(monkeypatch):
    """Commands write small files in place of figures, for tests of what else they write."""
    monkeypatch.setattr(
        "jaxbuffer.output.style.both",
        lambda name, draw: {f"{name}.png": lambda: b"\x89PNG", f"{name}.svg": lambda: b"<svg/>"},
    )

"""What stands in for simulate, sensitivity, sweep, tune and pareto, so that the command line needs no wait."""

import contextlib
import dataclasses

import numpy as np

from jaxbuffer import Outcome
from jaxbuffer.sensitivities.certificate import Verdict
from jaxbuffer.sweeps.grid import grid
from jaxbuffer.sweeps.result import SweepInterrupted
from jaxbuffer.tuning.report.front import Front
from made_up import made_up_capture, made_up_sensitivity, made_up_sweep, made_up_tuning


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

    def tune(self, problem, keep, *, report, **settings):
        self._note("tune", problem=problem, **settings)
        tuned = made_up_tuning(problem)
        for record in tuned.records:
            report(record)
        keep(tuned)
        return tuned

    def sweep(self, design, scenario, duration, *, progress, over=None, **options):
        asked = over and grid(over, design, scenario)
        designs, scenarios = asked.applied(design, scenario) if asked else (design, scenario)
        self._note("sweep", design=designs, scenarios=scenarios, duration=duration, **options)
        found = made_up_sweep(designs, scenarios, self.outcomes)
        if asked:
            found = dataclasses.replace(found, design=design, scenarios=scenario, grid=asked)
        for done in range(1, len(found) + 1):
            progress(done, len(found))
            if done == self.interrupt_after:
                those = np.arange(len(found)) < done
                raise SweepInterrupted(found.only(those), those)
        return found

    def asked(self, command):
        """The arguments of the last call of a command; a tuning's figure simulates its worst scenario after it."""
        return [arguments for name, arguments in self.calls if name == command][-1]

    def _note(self, command, **arguments):
        self.calls.append((command, arguments))
        if self.error is not None:
            raise self.error

    def pareto(self, problem, objectives, points, **settings):
        self._note("pareto", problem=problem, objectives=objectives, points=points, **settings)
        every = tuple(made_up_tuning(problem) for _ in range(points))
        limits = np.full((points, len(objectives) - 1), np.inf)
        return Front(problem, tuple(objectives), limits, every)


def stand_in(monkeypatch):
    """Put a `Computed` in the place of what the commands compute, and of the sweep of `jb.sample`."""
    computed = Computed()
    for name in ("simulate", "sensitivity", "sweep", "tune", "pareto"):
        monkeypatch.setattr(f"jaxbuffer.cli.commands.{name}.compute", getattr(computed, name))
    monkeypatch.setattr("jaxbuffer.experiments.sample.sweep", computed.sweep)
    # Nothing compiles here, but a tuning that an earlier test has interrupted may: its threads end when they are done.
    monkeypatch.setattr("jaxbuffer.cli.commands.progress.watched", lambda watcher: contextlib.nullcontext())
    monkeypatch.setattr(
        "jaxbuffer.programs.process.configure", lambda **options: computed.calls.append(("configure", options))
    )
    return computed

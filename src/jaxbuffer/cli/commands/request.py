"""What every command does with its command line: read the study, set JAX up, and check where to write."""

import dataclasses
import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...errors import InputError, check_choice
from ...labelled.record import amounts
from ...mechanisms.cautions import cautions
from ...output.provenance import made
from ...programs import process
from ...study.config import Config
from ...study.load import load
from ...study.overrides import apply_options, apply_overrides
from ...tuning.problem.cases import Case
from ...tuning.problem.problem import Problem
from ..streams import note
from .output import Output


@dataclasses.dataclass(frozen=True)
class CommandLine:
    """One call of a command, options as typed. ``fields``: design and scenario fields by dotted path; ``words``: all
    that was typed after the program's name; ``begun``: when, of the clock `time.perf_counter` [s]."""

    fields: dict[str, str]
    words: tuple[str, ...]
    begun: float
    config: Path | None = None
    solver: str | None = None
    rtol: str | None = None
    duration: str | None = None
    output: Path | None = None
    force: bool = False
    figures: str | None = None
    as_json: bool = False

    def study(self) -> Config:
        """Return the study with everything the command line overrides."""
        study = apply_overrides(load(self.config), self.fields)
        options = given(solver=self.solver, rtol=self.rtol, duration=self.duration)
        # A duration that is typed holds for whatever a sweep makes of the design.
        usual = study.usual_duration and self.duration is None
        study = dataclasses.replace(study, options=apply_options(study.options, options), usual_duration=usual)
        process.check_ready()  # before a folder is made
        return study

    def tuning_study(self, **options: str | None) -> Config:
        """Return the study with those of the search's ``options`` that are given."""
        study = self.study()
        return dataclasses.replace(study, tuning=apply_options(study.tuning, given(**options)))

    def one_scenario(self, number: str | None) -> Config:
        """Return the study with the scenario of that number among its [[scenarios]] or those of [problem.grid], counted
        from 1; without one, its first or that of [scenario], which a line on stderr says where there are several."""
        study = self.study()
        cases = study.cases
        count = len(cases)
        if number is not None:
            if not (number.isdecimal() and 1 <= int(number) <= count):
                allowed = f"must be a whole number from 1 to {count}, as many as the study has"
                raise InputError(f"--scenario-number {number} {allowed}")
            case = cases[int(number) - 1]
            study = dataclasses.replace(study, scenario=case.scenario, design=case.of(study.design))
            study = dataclasses.replace(study, scenario_number=str(int(number)) if count > 1 else "")
        elif count > 1:
            numbers = [k for k, case in enumerate(cases, 1) if case == Case(study.scenario)]
            study = dataclasses.replace(study, scenario_number=str(numbers[0]) if numbers else "")
            place = "the first" if numbers[:1] == [1] else f"number {numbers[0]}" if numbers else ""
            which = f"{place} of {count} scenarios" if place else "[scenario]"
            label = study.mechanism.view.label(study.scenario)
            note(f"running {which}, {label}; --scenario-number N takes another, 1 to {count}")
        say_cautions(((study.design, study.scenario),), units=study.units)
        return study

    def varying(self, study: Config, paths: Collection[str], where: str) -> Config:
        """Return the study for runs that vary the numbers at some ``paths``, once it is said which others have no
        effect. **Raises:** `InputError` for a path that the command line sets, too; ``where`` its values are."""
        check_swept_once(self.fields, paths, where)
        # Not of the geometry, which is that of the study's own numbers and may be what is varied.
        say_cautions(((study.design, study.scenario),), paths, geometry=False, units=study.units)
        return study.varying(paths)

    def made(self, study: Config, resumed: bool = False) -> dict[str, Any]:
        """Return what is known by now of how the result came about, for its record."""
        options, read = study.options, None
        # A study that came through a pipe cannot be read a second time.
        if self.config is not None and self.config.is_file():
            read = self.config.read_text(encoding="utf-8", errors="replace")
        duration = options.duration if options.duration is not None else study.mechanism.duration(study.design)
        settings = {"solver": options.solver, **amounts({"rtol": "-", "duration": "s"}, (options.rtol, duration))}
        about = made(self.words, read, settings, time.perf_counter() - self.begun, resumed)
        return {**about, "units": dict(study.units)}

    def files(self, *names: str, resumable: Sequence[str] = (), resume: bool = False) -> Output:
        """Prepare files to write later; everything that can go wrong with it is found now, before computing them.

        **Arguments:** ``resumable``: files of a run that ``resume`` goes on with; it may overwrite the others.
        """
        if resume and self.output is None:
            raise InputError("--resume needs --output DIR, the folder of the run to go on with")
        return Output(self.output, names, self.force, self.figures, resumable, resume, self.as_json)


def say_cautions(*runs: Any, **options: Any) -> None:
    """Say on stderr which numbers have no effect and what the geometry rules out; see `cautions`."""
    for line in cautions(*runs, **options):
        note(line)


def tuned_problem(study: Config) -> Problem:
    """Return the study's design problem, once it is said which of the other numbers have no effect."""
    problem = study.problem()
    say_cautions(study.runs, set(problem.paths), units=study.units, corners=problem.corner_runs)
    return problem


def check_swept_once(fields: Mapping[str, Any], swept: Iterable[str], where: str) -> None:
    """Raise `InputError` for a field set on the command line that takes several values anyway, which are ``where``."""
    for path in swept:
        if path in fields:
            raise InputError(f"--{path} {fields[path]} and the values of {path} in {where} contradict; keep one")


def each_once(over: Sequence[str], typed: Callable[[str], tuple[str, Any]], instead: str) -> dict[str, Any]:
    """Return what several --over say, by field, each read by ``typed``. **Raises:** `InputError` for a field that is
    given twice, with what to do ``instead``."""
    by_field = dict[str, Any]()
    for path, values in map(typed, over):
        if path in by_field:
            raise InputError(f"--over {path} is given more than once; {instead}")
        by_field[path] = values
    return by_field


def given(**options: Any) -> dict[str, Any]:
    """Return those options that were given."""
    return {name: value for name, value in options.items() if value is not None}


def asked_for(typed: str, option: str = "trust") -> bool:
    """Return whether an option is on, a second run by default."""
    check_choice(option, typed, ("on", "off"))
    return typed == "on"

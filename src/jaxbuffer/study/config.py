"""A study: its design and scenarios, and the tables that stand beside them."""

import dataclasses
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from ..choosing.catalogue import TOTALS, PartsCatalogue
from ..choosing.criterion import objective_of_runs, then_of_runs
from ..errors import InputError
from ..fields import Part, declared, errors_in_typed_units
from ..mechanisms import mechanism_named
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.registry import mechanism_of
from ..run.request import check_pair
from ..tuning.problem.cases import Case
from ..tuning.problem.problem import Problem
from ..tuning.problem.settings import Settings
from ..tuning.problem.tolerances import Tolerance
from .fit_toml import FIT, FitTable
from .model import (
    PROBLEM,
    ROUNDINGS,
    SAMPLE,
    SCENARIO_TABLE,
    SCENARIOS,
    SWEEP,
    TOLERANCES,
    ProblemTable,
    SampleTable,
    StudyOptions,
)
from .parts_toml import PARTS, ChoiceSettings, Selection, check_no_sums
from .problem_toml import numbered_cases, read_problem
from .tables import PartTable, subtable

DEFAULT_KIND = "probe_cone"


@dataclasses.dataclass(frozen=True)
class Config:
    """A study: one design, the scenario to simulate, the scenarios to tune for (default: that one), and settings.

    ``table``: of which the `problem` is made; ``sweep``: values by path, as `grid` reads them; ``folder``: the file's
    own, where the Python files lie that it names; ``texts``: typed with a unit, by address; ``units``: those that
    numbers were typed with, by address, in which people are told them; ``given``: addresses of the fields that the
    file gives, those of [options] and [tune] among them; ``usual_duration``: whether ``options.duration`` is what is
    usual for the design, as none is given; ``scenario_number``: of ``scenario`` among several `cases`, "" elsewhere.
    """

    design: Part = dataclasses.field(default_factory=lambda: mechanism_named(DEFAULT_KIND).design())
    scenario: Part = subtable(SCENARIO_TABLE, "what is simulated", lambda: mechanism_named(DEFAULT_KIND).scenario())
    scenarios: tuple[Part, ...] = subtable(SCENARIOS, "what is tuned for: fields that differ from [scenario]", tuple)
    options: StudyOptions = subtable(PartTable(lambda names: StudyOptions()), "how", StudyOptions)
    table: ProblemTable = subtable(PROBLEM, "what jaxbuffer tune is to do", ProblemTable, key="problem")
    tuning: Settings = subtable(
        PartTable(lambda names: Settings()), "how jaxbuffer tune searches", Settings, key="tune"
    )
    sweep: Mapping[str, Any] = subtable(
        SWEEP, "what jaxbuffer sweep combines: a list, or from, to, count and scale", dict
    )
    sample: SampleTable = subtable(SAMPLE, "what jaxbuffer sample spreads runs over", SampleTable)
    parts: tuple[PartsCatalogue, ...] = subtable(PARTS, "catalogues that jaxbuffer choose chooses from", tuple)
    roundings: Mapping[str, Any] = subtable(
        ROUNDINGS, "values that can be built: an E series or a step, for jaxbuffer choose", dict
    )
    choosing: ChoiceSettings = subtable(
        PartTable(lambda names: ChoiceSettings()), "how jaxbuffer choose ranks", ChoiceSettings, key="choose"
    )
    tolerances: Mapping[str, Tolerance] = subtable(
        TOLERANCES, "how far built numbers may be from the drawn ones; tune keeps every limit in their corners", dict
    )
    fit: FitTable = subtable(FIT, "what jaxbuffer fit finds from measured tests", FitTable)
    folder: Path = Path()
    texts: Mapping[str, str] = dataclasses.field(default_factory=dict, compare=False)
    given: frozenset[str] = dataclasses.field(default=frozenset(), compare=False)
    units: Mapping[str, str] = dataclasses.field(default_factory=dict, compare=False)
    usual_duration: bool = dataclasses.field(default=False, compare=False)
    scenario_number: str = dataclasses.field(default="", compare=False)

    def __post_init__(self) -> None:
        mechanism = self.mechanism
        check_pair(mechanism, self.design, self.scenario)
        if self.options.duration is None:
            filled = dataclasses.replace(self.options, duration=mechanism.duration(self.design))
            # Frozen for everyone else: what was left out is filled in here, once.
            object.__setattr__(self, "options", filled)
            object.__setattr__(self, "usual_duration", True)
        for i, scenario in enumerate(self.scenarios, 1):
            try:
                check_pair(mechanism, self.design, scenario)
            except InputError as error:
                raise error.between(f"[[scenarios]] number {i} ({mechanism.view.label(scenario)}): ") from None
        # A tuning has one load case at least, and what reads this need not ask.
        if not self.scenarios:
            object.__setattr__(self, "scenarios", (self.scenario,))

    @property
    def mechanism(self) -> Mechanism:
        """Return the mechanism whose design it is."""
        return mechanism_of(self.design)

    @property
    def varied(self) -> set[str]:
        """Return the paths that the study's tuning, sweep or sample gives values."""
        return {*(self.table.variables or ()), *self.sweep, *(self.sample.ranges or ())}

    def varying(self, paths: Collection[str]) -> "Config":
        """Return the study for runs in which the numbers at some paths vary: its duration, unless one is given, is what
        is usual for what they make of the design."""
        if not self.usual_duration:
            return self
        duration = self.mechanism.duration(self.design, paths)
        return dataclasses.replace(self, options=dataclasses.replace(self.options, duration=duration))

    def problem(self) -> Problem:
        """Read the design problem, whose start must lie within the bounds."""
        check_no_sums("objective", self.table.objective.weights if self.table.objective else ())
        check_no_sums("then", self.table.then.objective.weights if self.table.then else ())
        if not self.parts:
            check_no_sums("constraints", self.table.constraints.at_most if self.table.constraints else ())
        # Messages say numbers in the units that they were typed with.
        with errors_in_typed_units(self.units):
            return read_problem(
                self.table,
                self.design,
                self.scenario,
                listed=self.scenarios,
                duration=self.options.duration,
                rtol=self.options.rtol,
                folder=self.folder,
                units=self.units,
                tolerances=self.tolerances,
            )

    @property
    def cases(self) -> tuple[Case, ...]:
        """Return the scenarios in their numbers' order, each with what a grid makes of the design."""
        return numbered_cases(self.table, self.scenario, self.scenarios, self.design)

    @property
    def runs(self) -> list[tuple[Part, Part]]:
        """Return the design and the scenario of each load case, in their numbers' order."""
        return [(case.of(self.design), case.scenario) for case in self.cases]

    def selection(self) -> Selection:
        """Read what parts are chosen by: without [problem.variables] nothing else is to be tuned."""
        given, then, table = self.table.objective, self.table.then, self.table
        # With some part runs may last longer: then all combinations are run for as long.
        study = self.varying([path for catalogue in self.parts for path in catalogue.paths])
        # No run has a price or a mass: the choice adds them to what the runs of a combination give.
        if self.parts:
            of_runs = None if given is None else objective_of_runs(given)
            table = dataclasses.replace(table, objective=of_runs, then=None if then is None else then_of_runs(then))
        if self.parts and table.variables is None:
            table = dataclasses.replace(table, variables={})
        limits = {} if table.constraints is None else table.constraints.at_most
        at_most = {name: bound for name, bound in limits.items() if name in TOTALS}
        return Selection(dataclasses.replace(study, table=table).problem(), given, then, at_most)


def study_tables() -> dict[str, Mapping[str, Any]]:
    """Return what is declared of the tables that stand beside a design's own, by their names in a study."""
    tables = {name: known for name, known in declared(Config).items() if "table" in known}
    return {known["key"] or name: {**known, "field": name} for name, known in tables.items()}


def sections(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the names of the parts of a mechanism's designs."""
    return tuple(f.name for f in dataclasses.fields(mechanism.design) if isinstance(f.default, Part))

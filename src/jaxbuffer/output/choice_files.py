"""The files of a choice: names, and what makes their contents."""

from typing import Any

import numpy as np

from ..choosing.alternatives import Alternative, reported
from ..choosing.choice import Choice, beyond, lines, ranking_rows, set_by
from ..labelled.record import amount, json_number, part_record
from ..study.tuned_toml import tuned_toml
from ..tuning.report.levers import levers_record
from ..tuning.search.evaluation import main_values
from ..version import version
from . import style
from .choice_figure import choice_figure
from .formats import Contents, Made, csv_text
from .matlab import design_mat
from .provenance import record_text
from .records import limits_record
from .tuned_records import built_record, case_records, scatter_record


def choice_files(choice: Choice, made: Made = None) -> Contents:
    """Return the files of `jaxbuffer choose`. ``made``: how it came about."""
    return {
        "design.toml": lambda: choice_design(choice),
        "design.mat": lambda: design_mat(choice.design),
        "choice.json": lambda: record_text(choice_record(choice), made),
        "choice.csv": lambda: csv_text(*ranking_rows(choice)),
        "choice.txt": lambda: f"{choice!r}\n",
        **style.both("choice", lambda: choice_figure(choice)),
    }


def choice_record(choice: Choice) -> dict[str, Any]:
    """Return the result: what was chosen from, the ranking with margins, and how many runs were spared."""
    criterion, problem, warnings = choice.criterion, choice.problem, beyond(choice)
    second = dict[str, Any]()
    if (then := criterion.then) is not None:
        second = {
            "then": criterion.in_words(then.objective),
            "then_unit": then.objective.unit(criterion.catalogue),
            "then_tolerance": amount(then.tolerance, "-"),
            "ceiling": json_number(choice.ceiling),
        }
    return {
        "kind": problem.mechanism.name,
        "identity": choice.identity,
        "message": choice.message,
        "feasible": choice.feasible,
        "objective": str(criterion),
        "objective_unit": criterion.objective.unit(criterion.catalogue),
        **second,
        **limits_record(problem.limits, problem.quantities),
        "limits_on_sums": {it.name: amount(it.bound, criterion.catalogue[it.name].unit) for it in criterion.limits},
        "tally": choice.tally._asdict() | {"spared": choice.tally.spared},
        # A page shows warnings in a place of their own, and would say them twice.
        "lines": [line for line in lines(choice) if line not in warnings],
        "warnings": warnings,
        **scatter_record(problem),
        "levers": levers_record(choice.levers),
        "rtol_of_check": amount(choice.tight, "-"),
        "accuracy": amount(choice.accuracy, "-"),
        "reordered": choice.reordered,
        "parts": {
            it.role: [
                {
                    "name": part.name,
                    **{path: _plain(value) for path, value in {**part.fields, **part.totals}.items()},
                }
                for part in it.parts
            ]
            for it in choice.catalogues
        },
        "ranking": [_alternative(choice, it) for it in choice.ranked],
        "nearest": None if choice.nearest is None else _alternative(choice, choice.nearest),
        "continuous_objective": None if choice.continuous is None else json_number(choice.continuous.value),
        "continuous_optimum": None if choice.optimum is None else json_number(choice.optimum.value),
        "units": dict(problem.units),
        "design": part_record(choice.design),
        "jaxbuffer": version(),
    }


def _plain(value: Any) -> Any:
    """Return a part's value as JSON has it; a curve as its points."""
    return value.points() if hasattr(value, "points") else value


def _alternative(choice: Choice, it: Alternative) -> dict[str, Any]:
    known, problem = choice.criterion.catalogue, choice.problem
    return {
        "parts": {catalogue.role: name for catalogue, name in zip(choice.catalogues, it.names, strict=True)},
        "feasible": it.feasible,
        "broken": list(it.broken),
        "objective": json_number(it.value),
        **({} if it.second is None else {"then": json_number(it.second)}),
        **{name: amount(value, known[name].unit) for name, value in it.totals.items()},
        "set_by": set_by(choice, it),
        "corners": None
        if not problem.corners
        else {"holding": choice.holding(it), "run": len(problem.corners), "searched": problem.needs_search},
        "largest_at": choice.label(it.deciding),
        "tuned": it.tuned is not None,
        "margins": [
            {
                "quantity": margin.limit.name,
                "limit": margin.limit.line(known[margin.limit.name]),
                "worst": amount(margin.value, known[margin.limit.name].unit),
                "left": amount(margin.share, "-"),
                "at": choice.label(margin.case),
            }
            for margin in it.margins
        ],
        "scenarios": [
            {"label": choice.label(k), **part_record(case.scenario), **built_record(case), **values}
            for k, (case, values) in enumerate(
                zip(problem.cases, case_records(problem, it.evaluation, reported(problem, it.evaluation)), strict=True)
            )
        ],
    }


def choice_design(choice: Choice) -> str:
    """Return the best combination as a study, with the parts' names in its first lines."""
    told, worst = [choice.message], None
    if choice.best is not None:
        told += [f"{path}: {name}" for path, name in set_by(choice, choice.best).items()]
        # `simulate` takes the one where the main quantity is largest.
        number = choice.problem.number(int(np.argmax(main_values(choice.problem, choice.best.evaluation))))
        worst = choice.problem.drawn[number - 1].scenario
    return tuned_toml(choice.design, choice.problem, "\n".join(told), worst)

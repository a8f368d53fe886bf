"""A tuned design as a study: for `simulate` and the other commands, and for `tune` to go on from."""

import dataclasses
import itertools
from collections.abc import Iterable, Mapping
from typing import Any

import tomli_w

from ..fields import Part, as_written, declared, unit, unit_at
from ..tuning.problem.cases import Case, Scatter, grid_address
from ..tuning.problem.objective import Objective, SecondObjective
from ..tuning.problem.problem import Problem
from ..tuning.problem.settings import Settings
from ..value_text import unit_text
from .design_toml import design_toml
from .model import limit_keys
from .tables import Keys

LEFT_OUT = "# of a quantity of your own, whose function is elsewhere: "


def tuned_toml(
    design: Part,
    problem: Problem,
    comment: str,
    first: Part | None = None,
    settings: Settings | None = None,
) -> str:
    """Return a tuned design with its problem, duration and tolerance: a study that `tune` goes on from.

    Numbers that were typed with a unit have it again, and all are read back as exactly those that were evaluated.

    **Arguments:** ``first``: the scenario that `simulate` takes, of the problem's (default: the first of them);
    ``settings``: of the search.
    """
    assert problem.duration is not None
    # As drawn: what tolerances make of them follows from [tolerances], which is written too.
    listed = tuple(case.scenario for case in problem.drawn)
    duration = _entry({"duration": as_written(problem.duration, "s", problem.units.get("options.duration", ""))})
    options = ["", "[options]", f"{duration}  # s", f"rtol = {float(problem.rtol)!r}"]
    sampled = _sampled(problem)
    if sampled is None:
        whole = design_toml(design, listed, comment, problem.units, first=first)
    else:  # the samples are drawn again; what scatters, or is in the grid, replaces those fields of the scenario
        whole = design_toml(design, [], comment, problem.units, first=first or listed[0])
    parts = [
        *_variables(problem),
        *_objective(problem),
        *_limits(problem),
        *(sampled or ()),
        *_tolerances(problem),
        *options,
    ]
    changed = [] if settings is None else _keys(settings, declared(Settings))
    # The design ends with a line break, so the empty line that the parts begin with is there already.
    return "\n".join([whole, *parts[1:], *(["", "[tune]", *changed] if changed else [])]) + "\n"


def _entry(values: Mapping[str, Any]) -> str:
    return tomli_w.dumps(values).rstrip()


def _variables(problem: Problem) -> list[str]:
    if not problem.variables:  # an empty table would be an error where it is read
        return []
    lines = ["", "[problem.variables]"]
    for v in problem.variables:
        symbol = unit(problem.design, v.path)
        bounds = [as_written(end, symbol, problem.units.get(v.path, "")) for end in (v.low, v.high)]
        if isinstance(bounds[0], str) != isinstance(bounds[1], str):  # one cannot be written in its unit exactly
            bounds = [float(v.low), float(v.high)]
        comment = "" if isinstance(bounds[0], str) else unit_text(symbol, "  # ")
        lines.append(f'"{v.path}" = {_list([*bounds, v.scale])}{comment}')
    return lines


def _list(values: Iterable[Any]) -> str:
    """Write a list on one line."""
    return "[" + ", ".join(f'"{value}"' if isinstance(value, str) else repr(float(value)) for value in values) + "]"


def _objective(problem: Problem) -> list[str]:
    lines = ["", "[problem.objective]", *_weights(problem, problem.objective)]
    if (then := problem.then) is not None:
        lines += [
            "",
            "[problem.then]",
            *_weights(problem, then.objective),
            *_keys(then, declared(SecondObjective), declared(SecondObjective)),
        ]
    return lines


def _weights(problem: Problem, objective: Objective) -> list[str]:
    """Write weights and options; all of them as comments where one is on a quantity of the user's own: what is left
    would be another objective."""
    lines = [f"{name} = {float(weight)!r}" for name, weight in objective.weights.items()]
    lines += _keys(objective, declared(Objective), ("over", "level") if objective.over == "cvar" else ("over",))
    own = set(objective.weights) & set(problem.quantities)
    return [f"{LEFT_OUT}{line}" for line in lines] if own else lines


def _limits(problem: Problem) -> list[str]:
    limits, mechanism = problem.limits, problem.mechanism
    stated = () if mechanism.success is None else ("require_success",)
    lines = ["", "[problem.constraints]", *_keys(limits, limit_keys(mechanism), stated)]
    for name in dict.fromkeys(limits.names):
        symbol, where = problem.catalogue[name].unit, f"problem.constraints.{name}"
        sides = {"max": limits.at_most.get(name), "min": limits.at_least.get(name)}
        typed = {side: problem.units.get(f"{where}.{side}") or problem.units.get(where, "") for side in sides}
        given = {side: as_written(it, symbol, typed[side]) for side, it in sides.items() if it is not None}
        if len({isinstance(it, str) for it in given.values()}) > 1:  # either all have a unit, or none
            given = {side: float(it) for side, it in sides.items() if it is not None}
        texts = (f'{side} = "{it}"' if isinstance(it, str) else f"{side} = {it!r}" for side, it in given.items())
        line = f"{name} = {{{', '.join(texts)}}}  # {symbol}"
        lines.append(f"{LEFT_OUT}{line}" if name in problem.quantities else line)
    return lines


def _sampled(problem: Problem) -> list[str] | None:
    """Return [problem.sample] where something is sampled, and [problem.grid] of several scenarios; None where
    [[scenarios]] say it, as the scenarios are no grid, or nothing is sampled and they do not set numbers of the
    design."""
    scatter, bases = problem.scatter, [it if isinstance(it, Case) else Case(it) for it in problem.scenarios]
    if (scatter is None and not any(base.values for base in bases)) or any(base.factors for base in bases):
        return None
    lines, fields = [] if scatter is None else _distributions(scatter), _grid(bases)
    if fields is None:
        return None
    if fields:
        lines += ["", "[problem.grid]"]
        for name, values in fields.items():
            of_design = "." in name
            typed = problem.units.get(grid_address(name), "")
            symbol = unit(problem.design if of_design else bases[0].scenario, name)
            written = [as_written(value, symbol, typed) for value in values] if symbol else values
            # Values of which some have a unit and others none are refused where they are read.
            if len({isinstance(it, str) for it in written}) > 1:
                written = values
            key = f'"{name}"' if of_design else name
            lines.append(f"{key} = {_list(written)}" if symbol else f"{key} = {_entry({'x': list(values)})[4:]}")
    return lines


def _tolerances(problem: Problem) -> list[str]:
    """Return [tolerances], none where there are none."""
    lines = ["", "[tolerances]"] if problem.tolerances else []
    for address, it in problem.tolerances.items():
        symbol = unit_at(problem.design, problem.drawn[0].scenario, address)
        typed = "%" if it.relative else problem.units.get(f"tolerances.{address}", "") or symbol
        ends = [_tolerance_end(end, "-" if it.relative else symbol, typed) for end in (it.low, it.high)]
        both = f"[{', '.join(ends)}]"
        lines.append(f'"{address}" = {ends[1] if it.low == -it.high else both}')
    return lines


def _tolerance_end(end: float, symbol: str, typed: str) -> str:
    """Return one side of a tolerance as TOML; a number alone would have no unit."""
    written = as_written(end, symbol, typed)
    if isinstance(written, str):
        return f'"{written}"'
    if typed == "%":
        return f'"{100.0 * written!r} %"'
    return repr(written) if symbol == "-" else f'"{written!r} {symbol}"'


def _distributions(scatter: Scatter) -> list[str]:
    lines = ["", "[problem.sample]", *_keys(scatter, declared(Scatter), always=declared(Scatter))]
    for table, distributions in (("scenario", scatter.fields), ("factors", scatter.factors)):
        if distributions:
            lines += ["", f"[problem.sample.{table}]"]
        for name, it in distributions.items():
            lines.append(f'"{name}" = {{{it.kind} = {_list([it.first, it.second])}}}')
    return lines


def _grid(cases: list[Case]) -> dict[str, list[Any]] | None:
    """Return the values of each field that differs between cases which are all combinations of them, and of each number
    of the design that they set; None of others."""
    names = [field.name for field in dataclasses.fields(cases[0].scenario)]
    points = [{**{name: getattr(it.scenario, name) for name in names}, **dict(it.values)} for it in cases]
    values = {name: list(dict.fromkeys(it[name] for it in points)) for name in points[0]}
    differing = {name: several for name, several in values.items() if len(several) > 1 or "." in name}
    every = {tuple(it[name] for name in differing) for it in points}
    # A grid says the same only if every combination is there, each once.
    whole = every == set(itertools.product(*differing.values())) and len(points) == len(every)
    return differing if whole else None


def _keys(owner: Any, keys: Keys, always: Iterable[str] = ()) -> list[str]:
    """Return a line for each key that has another value than its default, and for those that are ``always`` written."""
    stated, values = set(always), {name: getattr(owner, name) for name in keys}
    return [_entry({name: it}) for name, it in values.items() if name in stated or it != keys[name]["default"]]

"""A tuned design as a study: for `simulate` and the other commands, and for `tune` to go on from."""

import dataclasses
import itertools
from collections.abc import Iterable, Mapping
from typing import Any

import tomli_w

from ..fields import SCENARIO, Part, as_written, declared, unit
from ..tuning.cases import Case, Scatter
from ..tuning.objective import Objective, SecondObjective
from ..tuning.problem import Problem, Settings
from ..value_text import unit_text
from .config import design_toml
from .model import limit_keys
from .tables import Keys

LEFT_OUT = "# of a quantity of your own, whose function is elsewhere: "


def tuned_toml(
    design: Part,
    problem: Problem,
    comment: str,
    scenarios: Iterable[Part] = (),
    settings: Settings | None = None,
) -> str:
    """Return a tuned design with its problem, duration and tolerance: a study that `tune` goes on from.

    Numbers that were typed with a unit have it again, and all are read back as exactly those that were evaluated.

    **Arguments:** ``scenarios`` (default: in the problem's order): `simulate` takes the first; ``settings``: of the
    search.
    """
    assert problem.duration is not None
    listed = tuple(scenarios) or problem.scenarios_met
    duration = _entry({"duration": as_written(problem.duration, "s", problem.units.get("options.duration", ""))})
    options = ["", "[options]", f"{duration}  # s", f"rtol = {float(problem.rtol)!r}"]
    sampled = _sampled(problem)
    if sampled is None:
        whole = design_toml(design, listed, comment, problem.units)
    else:  # the samples are drawn again; what scatters, or is in the grid, replaces those fields of the scenario
        whole = design_toml(design, listed[:1], comment, problem.units, "[scenario]")
    parts = [*_variables(problem), *_objective(problem), *_limits(problem), *(sampled or ()), *options]
    changed = [] if settings is None else _keys(settings, declared(Settings))
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
    """Return [problem.sample], and [problem.grid] where it is taken at several scenarios; None where nothing scatters,
    or the scenarios are no grid."""
    scatter, bases = problem.scatter, [it if isinstance(it, Case) else Case(it) for it in problem.scenarios]
    if scatter is None or any(base.factors for base in bases):
        return None
    lines, fields = _distributions(scatter), _grid([base.scenario for base in bases])
    if fields is None:
        return None
    if fields:
        lines += ["", "[problem.grid]"]
        for name, values in fields.items():
            typed, symbol = problem.units.get(f"{SCENARIO}{name}", ""), unit(bases[0].scenario, name)
            written = [as_written(value, symbol, typed) for value in values] if symbol else values
            if len({isinstance(it, str) for it in written}) > 1:
                written = values
            lines.append(f"{name} = {_list(written)}" if symbol else _entry({name: list(values)}))
    return lines


def _distributions(scatter: Scatter) -> list[str]:
    lines = ["", "[problem.sample]", *_keys(scatter, declared(Scatter), always=declared(Scatter))]
    for table, distributions in (("scenario", scatter.fields), ("factors", scatter.factors)):
        if distributions:
            lines += ["", f"[problem.sample.{table}]"]
        for name, it in distributions.items():
            lines.append(f'"{name}" = {{{it.kind} = {_list([it.first, it.second])}}}')
    return lines


def _grid(scenarios: list[Part]) -> dict[str, list[Any]] | None:
    """Return the values of each field that differs between scenarios that are all combinations of them; None of
    others."""
    names = [field.name for field in dataclasses.fields(scenarios[0])]
    values = {name: list(dict.fromkeys(getattr(it, name) for it in scenarios)) for name in names}
    differing = {name: several for name, several in values.items() if len(several) > 1}
    every = {tuple(getattr(it, name) for name in differing) for it in scenarios}
    # A grid says the same only if every combination is there, each once.
    whole = every == set(itertools.product(*differing.values())) and len(scenarios) == len(every)
    return differing if whole else None


def _keys(owner: Any, keys: Keys, always: Iterable[str] = ()) -> list[str]:
    """Return a line for each key that has another value than its default, and for those that are ``always`` written."""
    stated, values = set(always), {name: getattr(owner, name) for name in keys}
    return [_entry({name: it}) for name, it in values.items() if name in stated or it != keys[name]["default"]]

"""What a page says of other numbers than the tuned ones: sliders, and what models of a design say there."""

import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..experiments.what_if import RUNS
from ..experiments.what_if import what_if as fit_around
from ..experiments.what_if_model import Endings, Model
from ..fields import SCENARIO
from ..files import user_path, write
from ..labelled.record import Record, amounts
from ..output.folder import BESIDE, DESIGN, RECORDS, Results
from ..output.formats import compact_json
from ..output.provenance import MADE, made, made_in_python
from ..study.load import load
from ..tuning.problem.problem import Problem
from ..value_text import percent_text
from .page import PageSection
from .records import Display, display, field_name, same

NONE = "–"
SOLVED = "solved"  # where any end will do
FINEST = 1e-4  # an error that is told: the runs themselves are no better
DOUBTFUL = 0.5  # an error from which on a model says nothing of the truth
SURE = 0.002  # an error up to which four digits are shown, and above it three


class SliderRow(NamedTuple):
    """A line of the table over all scenarios: a quantity's place among them, "most" or "least" of it, its limit or
    None, in the unit that is shown; the largest ``error`` of its good models, None without any, in words
    (``measured``), and that of all models in words (``of_all``), for where no number is shown."""

    quantity: int
    side: str
    limit: float | None
    error: float | None
    measured: str
    of_all: str


def tuned_folder(folders: Sequence[str | Path]) -> Path:
    """Return the first of some folders that has a tuned design. **Raises:** `InputError` where none has."""
    every = [user_path(folder) for folder in folders]
    for folder in every:
        if (folder / RECORDS["tuned"]).is_file() and (folder / DESIGN).is_file():
            return folder
    named = ", ".join(map(str, every))
    raise InputError(f"what if: no tuned design in {named}; jaxbuffer tune STUDY.toml --output FOLDER makes one")


def make_what_if(
    folder: Path,
    runs: int = RUNS,
    progress: Callable[[int, int], None] | None = None,
    command: Sequence[str] | None = None,
) -> Path:
    """Fit models to runs around the tuned design of a folder, and write them there.

    **Arguments:** ``runs``, ``progress``: as of `experiments.what_if`; ``command``: the words as typed, None from
    Python.

    **Returns:** the file, `what_if.json`.
    """
    begun, problem = time.perf_counter(), tuned_problem(folder)
    found = fit_around(problem, runs, progress=progress)
    settings = amounts({"rtol": "-", "duration": "s"}, (problem.rtol, problem.duration))
    how = made_in_python() if command is None else made(command, None, settings, time.perf_counter() - begun)
    write(folder / BESIDE["what_if"], compact_json(found.record() | {MADE: how}))
    return folder / BESIDE["what_if"]


def tuned_problem(folder: Path) -> Problem:
    """Return the problem of a folder's tuned design, as `jaxbuffer tune` goes on from it."""
    return load(folder / DESIGN).problem()


def what_if(results: Results) -> PageSection | None:
    """Return the section of a tuned folder in which `what_if.json` lies."""
    record, tuned = results.records.get("what_if"), results.tuned
    if record is None or tuned is None:
        return None
    now = {v["path"]: v["value"] for v in tuned["variables"]}
    # A tuning that was resumed or made anew leaves the models of the design before in its folder.
    if not same_design(record, now):
        again = f"jaxbuffer report {results.folder} --what-if makes one of this design"
        return PageSection("What if", warnings=[f"what_if.json is of another design than the tuned one; {again}."])
    return PageSection("What if", _text(record, results), what_if=data(record, results))


def same_design(record: Record, values: dict[str, Any]) -> bool:
    """Return whether models are of the design that has these values."""
    known = dict(record["variables"].items())
    return known.keys() == values.keys() and all(same(known[path], values[path]) for path in known)


def data(record: Record, results: Results) -> dict[str, Any]:
    """Return what the page's template and script need, numbers of quantities with the factor of the unit shown."""
    own = (results.tuned or Record()).get("quantities", {})
    shown = [display(results.mechanism, name, own) for name in record["quantities"]]
    rows = list(_rows(record, shown))
    models = [[None if it is None else Model.of(dict(it.items())) for it in case["models"]] for case in record["cases"]]
    shares, nominal = np.array(record["shares"]), np.array(record["nominal"])
    at = [[None if it is None else it.at(nominal, shares) for it in case] for case in models]
    ended_well = [
        Endings(case["neighbours"], case["confirmed"]).well(nominal, shares, np.array(case["succeeded"]))
        for case in record["cases"]
    ]
    return {
        "good": record["good"],
        "success": record["success"] or SOLVED,
        "sliders": [
            dict(it.items()) | {"nominal": place} for it, place in zip(record["sliders"], nominal.tolist(), strict=True)
        ],
        "shares": record["shares"],
        "quantities": [it._asdict() for it in shown],
        "rows": [
            row._asdict()
            | {"limit_text": NONE if row.limit is None else number(row.limit, 0.0)}
            | _at_nominal(row, shown[row.quantity], at, record, all(ended_well))
            for row in rows
        ],
        "cases": [
            _case(case, values, shown, record["good"], ended)
            for case, values, ended in zip(record["cases"], at, ended_well, strict=True)
        ],
    }


def _text(record: Record, results: Results) -> list[str]:
    count, name = len(record["cases"]), results.mechanism.view.run_name
    over = f"{count} scenario{'s' if count > 1 else ''}"
    if record["left_out"]:
        over += f" that decide at the tuned design; {record['left_out']} others are left out"
    lines = [
        f"Move a number to see what the design would do then, over {over}. The numbers come from models that are fitted"
        f" to {len(record['shares'])} {name}s of each scenario around the tuned design; their error is the largest of"
        f" {record['apart']} {name}s that were kept apart. A model that misses one of these by more than"
        f" {percent_text(record['good'])} shows no number. Simulate what you choose.",
        f"Held fixed: every other number of the design, and of the scenarios{_sampled(results)}.",
    ]
    if record["omitted"]:
        own = (results.tuned or Record()).get("quantities", {})
        names = " and ".join(display(results.mechanism, it, own).title for it in record["omitted"])
        lines.append(f"No number is shown of {names}: a {name}'s end jumps where it waits for one swing more.")
    # Numbers are shown although some runs did not end well: how far to trust that.
    doubtful = [case for case in record["cases"] if not all(case["succeeded"]) or case["confirmed"] < record["apart"]]
    if doubtful:
        ended = record["success"] or SOLVED
        counts = "; ".join(f"{case['succeeded'].count(False)} in {case['in_sentence']}" for case in doubtful)
        most, least = max(case["neighbours"] for case in doubtful), min(case["confirmed"] for case in doubtful)
        lines.append(
            f"Of those {len(record['shares'])}, some were not {ended}: {counts}. A number is shown only where all"
            f" {name}s around, up to {most}, were {ended}; of the {record['apart']} kept apart at least {least} lie"
            f" there, all {ended}."
        )
    return lines


def _sampled(results: Results) -> str:
    """Return which fields of the scenarios are drawn, and so have no slider, after a comma; "" where none are."""
    ranges = (results.tuned or Record()).get("sample", Record()).get("ranges", {})
    drawn = [field_name(address) for address in ranges if address.startswith(SCENARIO)]
    return f", each with the {' and '.join(drawn)} that its sample drew" if drawn else ""


def _rows(record: Record, shown: Sequence[Display]) -> Iterator[SliderRow]:
    for k, (name, it) in enumerate(zip(record["quantities"], shown, strict=True)):
        models = [case["models"][k] for case in record["cases"] if case["models"][k] is not None]
        good = [model for model in models if model["error"] <= record["good"]]
        error = max((model["error"] for model in good), default=None)
        told = tuple(_measured(some) for some in (good, models))
        high, low = record["at_most"].get(name), record["at_least"].get(name)
        if high is not None or low is None:
            yield SliderRow(k, "most", None if high is None else it.factor * high, error, *told)
        if low is not None:
            yield SliderRow(k, "least", it.factor * low, error, *told)


def _measured(models: Sequence[Record]) -> str:
    """Say what the worst of some models misses."""
    if not models:
        return NONE
    worst = max(models, key=lambda model: model["error"])
    share = max(worst["error"], FINEST)
    return f"{'below' if share == FINEST else 'at most'} {percent_text(share, '.2g')} in {worst['tested']} runs"


def _at_nominal(
    row: SliderRow, shown: Display, at: Sequence[Sequence[float | None]], record: Record, ended_well: bool
) -> dict[str, str]:
    """Return the texts of a row at the tuned design, for print and where no script runs; the script says the same."""
    models = [case["models"][row.quantity] for case in record["cases"]]
    errors = [None if model is None else model["error"] for model in models]
    values = [None if case[row.quantity] is None else shown.factor * float(case[row.quantity] or 0.0) for case in at]
    few = any(error is None for error in errors)
    none = f"no number: {'too few runs ended well' if few else 'not good to ' + percent_text(record['good'])}"
    found = deciding(row.side, values, errors, record["good"])
    if found is None or row.error is None or not ended_well:
        return {"text": none if ended_well else NONE, "none": none, "where": NONE, "room": NONE, "told": row.of_all}
    return {
        "none": none,
        "told": row.measured,
        "text": number(values[found] or 0.0, row.error),
        "where": record["cases"][found]["label"],
        "room": NONE if row.limit is None else room(row, values[found] or 0.0),
    }


def deciding(side: str, values: Sequence[float | None], errors: Sequence[float | None], good: float) -> int | None:
    """Return which scenario has the largest or the least value; None where one without a good model may have it.

    A model that misses runs by at most e puts the truth between its value over 1 + e and over 1 - e.
    """
    sign = 1.0 if side == "most" else -1.0
    known = enumerate(zip(values, errors, strict=True))
    sure = [k for k, (value, error) in known if value is not None and error is not None and error <= good]
    best = max(sure, key=lambda k: sign * (values[k] or 0.0), default=None)
    for value, error in zip(values, errors, strict=True):
        # So bad a model cannot rule its scenario out, and 1 - e below stays well above zero.
        if value is None or error is None or error >= DOUBTFUL:
            return None
        ends = [sign * value / (1.0 + error), sign * value / (1.0 - error)]
        if error > good and (best is None or max(ends) > sign * (values[best] or 0.0)):
            return None
    return best


def room(row: SliderRow, value: float) -> str:
    """Return the room to a limit, if it is more than the model's error."""
    error, limit = row.error or 0.0, row.limit or 0.0
    left = limit - value if row.side == "most" else value - limit
    if abs(left) <= error * abs(value):
        return "within the error"
    share = f" ({percent_text(left / abs(limit), '.3g')})" if limit else ""
    return f"{number(left, SURE + error)}{share}"


def number(value: float, error: float) -> str:
    """Return a number with as many digits as its error leaves: 3, or 4 where that is small."""
    digits = 4 if error <= SURE else 3
    # Without an exponent, as the page's script writes numbers.
    return np.format_float_positional(float(f"{value:.{digits}g}"), trim="-")


def _case(
    case: Record, values: Sequence[float | None], shown: Sequence[Display], good: float, ended_well: bool
) -> dict[str, Any]:
    models = [None if model is None else dict(model.items()) for model in case["models"]]
    texts = [
        NONE
        if model is None or value is None or not ended_well
        else number(it.factor * value, model["error"])
        if model["error"] <= good
        else f"not good to {percent_text(good)}"
        for model, value, it in zip(models, values, shown, strict=True)
    ]
    return {
        "label": case["label"],
        "succeeded": case["succeeded"],
        "neighbours": case["neighbours"],
        "models": models,
        "texts": texts,
    }

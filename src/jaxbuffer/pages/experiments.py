"""What a page says of many runs: a sweep with its envelope, a sample, a front of objectives."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ..fields import as_typed, ends_as_typed, get
from ..labelled.record import Record, heading
from ..mechanisms.mechanism import EndCount, Mechanism
from ..output.folder import Results
from ..value_text import degrees_text, percent_text, table_text, unit_text
from .page import Cell, PageSection, Table
from .records import by_quantity, display, ended, field_name, figure, units_of, words

OPEN = "not computed"  # of a run that an interrupted sweep has not reached
ON_FRONT = ("front", "front, not converged")
STATUS = {"front": "good", "front, not converged": "unsure", "dominated": "", "limits broken": "bad"}


def sweep(results: Results) -> PageSection | None:
    """Return what a sweep covers, how its runs ended, its maps, and where it is safe."""
    if results.sweep is None:
        return None
    sizes = (
        " × ".join(f"{count} values of {field}" for field, count in swept_fields(results).items()) or "given one by one"
    )
    outcomes = outcome_counts(results)
    record = results.records.get("sweep", Record())
    envelope = record.get("envelope")
    every, left = sum(outcomes.values()), outcomes.get(OPEN, 0)
    computed = f"{every} runs" if not left else f"{every - left} of {every} runs, the others are not computed"
    text = [f"{computed}: {sizes}{reached(results, outcomes)}."] + (
        [] if envelope is None else envelope_in_words(envelope)
    )
    figures = figure(results, "envelope", "Which runs are safe, and the largest rectangle of them")
    figures += figure(results, "sweep", "The sweep's quantities over the swept numbers")
    title, tables = "Sweep" if envelope is None else "Envelope", [_outcomes(results.mechanism, outcomes)]
    if envelope is None:
        return PageSection(title, text, figures, tables)
    between = envelope.get("between")
    # Safe only where all runs between the scenarios are known: those of an interrupted sweep may be missing.
    safe = between and not between["unsafe_runs"] and between["runs"] == between.get("total_runs", between["runs"])
    warnings = [between["words"]] if between and not safe else []
    text += [between["words"]] if between and safe else []
    return PageSection(title, text, figures, tables, warnings=[*warnings, *not_found(envelope, record["axes"])])


def reached(results: Results, counts: Mapping[str, int]) -> str:
    """Return in how many computed runs of a sweep or sample the strictest end was reached, after a comma.

    It is "" where the design can have none. ``counts``: as of `outcome_counts`.
    """
    end = strictest_count(results, counts)
    return f", {end}" if end else ""


def strictest_count(results: Results, counts: Mapping[str, int]) -> EndCount | None:
    """Return in how many computed runs of a sweep or sample the strictest end was reached that the design can have;
    None where it can have none."""
    design = results.design
    if design is None:
        return None
    axes = [
        *results.records.get("sweep", Record()).get("axes", ()),
        *results.records.get("sample", Record()).get("ranges", ()),
    ]
    moved, computed = {axis["path"] for axis in axes}, {name: n for name, n in counts.items() if name != OPEN}
    return results.mechanism.end_count(lambda path: path in moved or get(design, path), computed)


def safe_of(envelope: Record) -> str:
    """Return how many runs of an envelope are safe: "22 of 48 runs".

    Of an interrupted sweep it is "22 of 30 computed runs, of 48 asked for,".
    """
    safe, runs, done = envelope["safe_runs"], envelope["runs"], envelope.get("done", envelope["runs"])
    return f"{safe} of {runs} runs" if done == runs else f"{safe} of {done} computed runs, of {runs} asked for,"


def outcome_counts(results: Results) -> dict[str, int]:
    """Return how many runs of a sweep ended how; of a store alone, from the numbers of the outcomes."""
    assert results.sweep is not None
    if "outcome" in results.sweep:
        names, counts = np.unique(results.sweep.outcome.values.astype(str), return_counts=True)
        return dict(zip(map(str, names), map(int, counts), strict=True))
    # A store has the outcomes as numbers only: their words are in the mechanism.
    codes, counts = np.unique(results.sweep.code.values, return_counts=True)
    words = [results.mechanism.outcomes(int(code)).name if code >= 0 else OPEN for code in codes]
    return dict(zip(words, map(int, counts), strict=True))


def swept_fields(results: Results) -> dict[str, int]:
    """Return how many values each swept field has; of runs that were given one by one, nothing."""
    sizes = {} if results.sweep is None else results.sweep.sizes
    return {field_name(str(path)): count for path, count in sizes.items() if path != "run"}


def envelope_in_words(envelope: Record) -> list[str]:
    """Return how many runs are safe, and the ranges of the largest rectangle of them."""
    texts = [f"Safe means: {envelope['criterion']}. {safe_of(envelope)} are."]
    if not envelope["rectangle"]:
        return [*texts, "No run is safe, so there is no safe rectangle."]
    ranges = " by ".join(f"{field_name(part['path'])} from {_ends(part)}" for part in envelope["rectangle"])
    texts.append(
        f"Every run of the largest safe rectangle, {envelope['runs_in_rectangle']} of them, is safe: {ranges}."
        " Between the runs nothing was computed."
    )
    reasons = ", ".join(f"{reason} ({count})" for reason, count in envelope["reasons"].items())
    return [*texts, f"Why the others are not: {reasons}."] if reasons else texts


def not_found(envelope: Record, axes: Sequence[Record]) -> list[str]:
    """Return on which sides the largest safe rectangle ends where the sweep does, as a warning; none where on no
    side."""
    values = {axis["path"]: axis["values"] for axis in axes}
    sides = [
        f"{field_name(part['path'])} {where} {_end(part[end], part)}"
        for part in envelope["rectangle"]
        for end, where, last in (("low", "below", min), ("high", "above", max))
        # A rectangle that ends where the sweep does may go on beyond it.
        if part[end] == last(values[part["path"]])
    ]
    if not sides:
        return []
    return [f"The edge of what is safe was not found on the side of {', '.join(sides)}: sweep wider."]


def _end(value: float, field: Record) -> str:
    """Return a value of a swept field: in the unit that was typed, else angles in degrees."""
    number, symbol = as_typed(value, field["unit"], field.get("display_unit", ""))
    if symbol == "rad":
        return degrees_text(math.degrees(number), 3)
    return f"{table_text(number)}{unit_text(symbol)}"


def _ends(field: Record) -> str:
    """Return the range of a swept field: "0.1 to 0.2 m/s"."""
    low, high = (_end(field[end], field) for end in ("low", "high"))
    # The unit is said once, behind the high end; a degree sign belongs to each number.
    return f"{low if low.endswith('°') else low.partition(' ')[0]} to {high}"


def sample(results: Results) -> PageSection | None:
    """Return ranges, how the runs ended, whose scatter matters most, and how far a fitted surface can be trusted."""
    record = results.records.get("sample")
    if record is None:
        return None
    ranges = []
    for r in record["ranges"]:
        low, high, symbol = ends_as_typed(r["low"], r["high"], r["unit"], r.get("display_unit", ""))
        ranges.append([r["path"], symbol, table_text(low), table_text(high), r["scale"]])
    tables = [Table("Ranges", ("number", "unit", "low", "high", "spread evenly on a scale"), ranges)]
    tables.append(_outcomes(results.mechanism, record["outcomes"]))
    indices = by_quantity(sorted(record["indices"], key=lambda row: -row["total"]))
    tables += [_indices(results.mechanism, name, rows) for name, rows in indices.items()]
    if record["surfaces"]:
        tables.append(_surfaces(results.mechanism, record))
    warnings = [
        f"Do not trust the surface of {words(it['quantity'])}: it explains less than 90 % of the variance of runs it"
        " has not seen."
        for it in record["surfaces"]
        if not it["trusted"]
    ]
    counted = reached(results, record["outcomes"])
    text = [f"{record['done']} of {record['runs']} runs, {words(record['method'])}, seed {record['seed']}{counted}."]
    warnings += [
        f"The surface of {words(it['quantity'])} is fitted as if the {it['left_out'][OPEN]} runs that are not computed"
        " did not exist."
        for it in record["surfaces"]
        if it.get("left_out", {}).get(OPEN)
    ]
    figures = figure(results, "indices", "First-order and total index of each number, with intervals")
    figures += figure(results, "surface", "What a surface says of runs it has not seen, against what was computed")
    figures += figure(results, "sample", "The quantities over each sampled number")
    return PageSection("Sample", text, figures, tables, warnings=warnings)


def _indices(mechanism: Mechanism, name: str, rows: list[Record]) -> Table:
    """Return the indices of a quantity's numbers, the number that matters most first."""
    source, first = rows[0]["from"], rows[0]
    of = "of its response surface" if source != "runs" else f"of {first['rows']} of {first['requested_rows']} rows"
    caption = f"Whose scatter matters for the {display(mechanism, name).title} (Sobol' indices {of}"
    caption += f", {percent_text(first['confidence'], 'g')} intervals)"
    interval = lambda ends: f"{ends[0]:.3f} … {ends[1]:.3f}"  # noqa: E731
    cells = []
    for row in rows:
        alone, total = (f"{row[name]:.3f}" for name in ("first_order", "total"))
        intervals = [interval(row[f"{name}_interval"]) for name in ("first_order", "total")]
        cells.append([row["number"], alone, intervals[0], total, intervals[1]])
    return Table(caption, ("number", "alone", "interval", "with all others", "interval"), cells)


def _surfaces(mechanism: Mechanism, record: Record) -> Table:
    rows: list[list[str | Cell]] = []
    for surface in record["surfaces"]:
        for kind, error in surface["cross_validated"].items():
            taken = kind == surface["kind"]
            # The verdict is on the kind of surface that was taken; the others are there for comparison.
            mark = ("good" if surface["trusted"] else "bad") if taken else ""
            errors = [f"{table_text(error['rms'])}{unit_text(surface['unit'])}", percent_text(error["relative"], ".3g")]
            errors.append(percent_text(error["explained"], ".4g"))
            verdict = ("trusted" if surface["trusted"] else "not to be trusted") if taken else "not taken"
            rows.append([display(mechanism, surface["quantity"]).title, words(kind), *errors, Cell(verdict, mark)])
    caption = "Response surfaces: their errors at runs they were not fitted to (cross-validated)"
    return Table(caption, ("quantity", "kind", "error, rms", "of a value", "variance explained", "verdict"), rows)


def front(results: Results) -> PageSection | None:
    """Return the points of a front: objectives, how sure they are, and their designs."""
    record = results.records.get("front")
    if record is None:
        return None
    points = record["points"]
    on_front = sum(point["status"] in ON_FRONT for point in points)
    rows: list[list[str | Cell]] = []
    names = [name for name in points[0] if name not in ("point", "status", "converged")]
    units = points[0].units
    headings, factors = zip(*(_front_column(results, name, units.get(name, "")) for name in names), strict=True)
    for point in points:
        mark = STATUS.get(point["status"], "")
        numbers = zip((point[name] for name in names), factors, strict=True)
        values = [table_text(factor * value if isinstance(value, float) else value) for value, factor in numbers]
        rows.append([str(point["point"]), *values, Cell(point["status"], mark)])
    objectives, count = " and ".join(map(words, record["objectives"])), record["scenarios"]
    over = (
        f"{sampled}, no bound" if (sampled := record.get("samples")) else f"{count} scenario{'s' if count > 1 else ''}"
    )
    text = [
        f"{on_front} of {len(points)} points are on the front of {objectives}, the worst of {over}:"
        " none of them is better than another in every objective.",
        "Each point is a tuning of its own; its design is the file design-N.toml of that number.",
    ]
    table = Table("Points of the front", ("point", *headings, "status"), rows)
    caption = "The front; hollow: not converged; crosses: another point is better"
    return PageSection("Front", text, figure(results, "pareto", caption), [table])


def _front_column(results: Results, name: str, symbol: str) -> tuple[str, float]:
    """Return a column's heading with the unit that people are shown, and how many of those its own unit is: of an
    objective or its limit, or of a variable."""
    quantity = results.mechanism.quantities.get(name.removeprefix("worst ").removeprefix("limit of "))
    display_unit, factor = symbol, 1.0
    if quantity is not None:
        display_unit, factor = quantity.in_figures
    elif typed := units_of(results).get(name):
        factor, display_unit = as_typed(1.0, symbol, typed)
    return heading(words(name), display_unit), factor


def _outcomes(mechanism: Mechanism, counts: Mapping[str, int]) -> Table:
    rows: list[list[str | Cell]] = [
        [Cell(OPEN, "unsure") if name == OPEN else ended(mechanism, name), str(count)] for name, count in counts.items()
    ]
    return Table("How the runs ended", ("outcome", f"{mechanism.view.run_name}s"), rows)

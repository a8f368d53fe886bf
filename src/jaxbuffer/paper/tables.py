"""The studies' numbers and the judged claims as Markdown."""

from collections.abc import Sequence

from .run import COLUMNS, Row, Studied

NOTE = (
    "The paper's figures are lost and its text prints no force: its statements are all there is to compare with. "
    "Values its text leaves open are assumed, as said under each study."
)
SHOWN = ("case", "outcome", "peak_force", "first_peak", "contact_time", "capture_time", "penetration", "stroke")


def claims_table(verdicts: Sequence[dict[str, str]]) -> str:
    """Claim by claim."""
    lines = ["| the paper's text | section | the model | verdict |", "|---|---|---|---|"]
    lines += [f"| {v['claim']} | {v['section']} | {v['model']} | **{v['verdict']}** |" for v in verdicts]
    return "\n".join(lines)


def markdown(studied: Sequence[Studied], verdicts: Sequence[dict[str, str]]) -> str:
    """The whole report."""
    parts = ["# The paper's studies, run again", NOTE, "## Claims", claims_table(verdicts)]
    for found in studied:
        study = found.study
        parts.append(f"## {study.title} (fig. {study.figures})")
        if study.assumed:
            parts.append(f"Assumed: {study.assumed}.")
        parts.append(_table(found.rows))
        parts.append(f"![{study.title}]({study.name}.png)")
    return "\n\n".join(parts) + "\n"


def _table(rows: Sequence[Row]) -> str:
    heads = [f"{name.replace('_', ' ')} [{unit}]" if (unit := COLUMNS[name]) else name for name in SHOWN]
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for row in rows:
        cells = [v if isinstance(v := row[name], str) else f"{v:.5g}" for name in SHOWN]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)

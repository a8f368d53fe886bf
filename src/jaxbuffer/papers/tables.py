"""A paper's numbers and verdicts on its claims as Markdown."""

from collections.abc import Sequence

from .study import Paper, Studied

NAMED = {"study": "", "case": "", "value": ""}  # what every row begins with, without units


def claims_table(verdicts: Sequence[dict[str, str]]) -> str:
    """Write a table of verdicts, claim by claim."""
    lines = ["| the paper's text | section | the model | verdict |", "|---|---|---|---|"]
    lines += [f"| {v['claim']} | {v['section']} | {v['model']} | **{v['verdict']}** |" for v in verdicts]
    return "\n".join(lines)


def markdown(paper: Paper, studied: Sequence[Studied], verdicts: Sequence[dict[str, str]]) -> str:
    """Write the whole report."""
    parts = ["# The paper's studies, run again", f"*{paper.title}*", paper.note, "## Claims", claims_table(verdicts)]
    for each in studied:
        study = each.study
        parts.append(f"## {study.title} (fig. {study.figures})")
        if study.assumed:
            parts.append(f"Assumed: {study.assumed}.")
        parts.append(_table(paper, each))
        parts.append(f"![{study.title}]({study.name}.png)")
    return "\n\n".join(parts) + "\n"


def _table(paper: Paper, results: Studied) -> str:
    part = paper.part_of(results.study)
    if part.table is not None:
        own = part.table(results)
        heads, rows, digits = list(own[0]), [list(row.values()) for row in own], ".4g"
    else:
        units = {"case": "", **part.columns}
        shown = ("case", *part.shown)
        heads = [f"{name.replace('_', ' ')} [{unit}]" if (unit := units[name]) else name for name in shown]
        rows, digits = [[row[name] for name in shown] for row in results.rows], ".5g"
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    # What a run does not have is a word, `NONE`.
    lines += [f"| {' | '.join(v if isinstance(v, str) else f'{v:{digits}}' for v in row)} |" for row in rows]
    return "\n".join(lines)

"""Make the page of what is verified (docs/generated/verified.md) from what the runs left."""

import ast
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from jaxbuffer.pages.verification import sources
from jaxbuffer.papers import PAPERS, paper_named

from .breakages import BREAKAGES
from .gaps import GAPS
from .run import CLAIMING, ROOT

HEAD = """# What was measured

The build of these pages and `make verify` write this page; [What is verified](../verification.md) says how to read it.
Measured is the worst error over all cases of a claim, which must not exceed the tolerance. It is relative unless a unit
is given."""
NOT_RUN = (
    "**Nothing has been run for these sources.** `make verify` runs it all; `python -m verify --only {part}` this part."
)
STATE = "state.json"
Record = dict[str, Any]


def note_state(folder: Path, parts: Iterable[str]) -> None:
    """Note in ``folder`` that its results of ``parts`` belong to the present sources."""
    (folder / STATE).write_text(json.dumps(_read(folder / STATE, {}) | dict.fromkeys(parts, sources()), indent=1))


def page(folder: Path) -> str:
    """Return the page of the results in ``folder``; parts that were run with other sources count as not run."""
    state, now = _read(folder / STATE, {}), sources()
    current = {part for part, digest in state.items() if digest == now}
    claims = {paper: _read(folder / paper / "studies.json", {"claims": []})["claims"] for paper in PAPERS}
    return markdown(
        _read(folder / "evidence.json", []) if "tests" in current else [],
        folder / "tests.xml" if "tests" in current else None,
        _read(folder / "breakages.json", []) if "breakages" in current else [],
        claims if "paper" in current else dict.fromkeys(PAPERS, ()),
    )


def _read(path: Path, otherwise: Any) -> Any:
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else otherwise


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [" | ".join(heads), " | ".join("---" for _ in heads), *(" | ".join(row) for row in rows)]
    return "\n".join(f"| {line} |" for line in lines)


def markdown(
    evidence: Sequence[Record], tests: Path | None, breakages: Sequence[Record], claims: Mapping[str, Sequence[Record]]
) -> str:
    """Return the whole page; of a part that was not run it lists what would be run."""
    parts = [HEAD]
    if not evidence:
        parts += ["## Claims", NOT_RUN.format(part="tests")]
    for topic in dict.fromkeys(record["topic"] for record in evidence):
        parts += [f"## {topic}", claims_of(evidence, topic)]
    parts += ["## Deliberate breakages", *([broken(breakages)] if breakages else planned())]
    for paper, said in claims.items():
        parts += [f"## The {paper} paper's claims", *([verdict_line(said)] if said else statements(paper))]
    parts += ["## Where no evidence exists", table(("of", "why"), GAPS)]
    parts += ["## All tests behind this page", modules(tests if tests is not None and tests.exists() else None)]
    return "\n\n".join(parts) + "\n"


def claims_of(evidence: Sequence[Record], topic: str) -> str:
    """One topic's claims."""
    rows = []
    for r in (record for record in evidence if record["topic"] == topic):
        unit = f" {r['unit']}" if r["unit"] else ""
        detail = f"; {r['detail']}" if r["detail"] else ""
        measured, tolerance = (f"{abs(r[name]):.2g}{unit}" for name in ("measured", "tolerance"))
        cases = f"{r['count']} cases" if r["count"] > 1 else "1 case"
        rows.append((r["claim"], measured, tolerance, f"{r['source']} ({cases}{detail})", f"`{_short(r['test'])}`"))
    return table(("claim", "measured", "tolerance", "against", "test"), rows)


def broken(records: Sequence[Record]) -> str:
    """Each breakage and what its checks made of it, then each check and what it caught."""
    rows, catches = [], {}
    for record in records:
        said: dict[str, list[str]] = {}
        for check, answer in record["checks"].items():
            said.setdefault(answer, []).append(f"`{_short(check)}`")
            if answer == "failed":
                catches.setdefault(check, []).append(record["name"])
        caught, missed = ", ".join(said.get("failed", [])) or "**none**", []
        for answer, words in (("passed", "not by"), ("crashed", "crashed"), ("not run", "not run")):
            if answer in said:
                missed.append(f"{words} {', '.join(said[answer])}")
        rows.append((record["name"], record["what"], "; ".join([caught, *missed])))
    order = dict.fromkeys(check for record in records for check in record["checks"])
    back = [(f"`{_short(check)}`", ", ".join(catches.get(check, [])) or "**nothing**") for check in order]
    first = table(("broken", "how", "caught by"), rows)
    return f"{first}\n\nAnd the other way round, so that no check is one that cannot fail:\n\n" + table(
        ("check", "fails when broken"), back
    )


def planned() -> list[str]:
    """Return that no breakage was run, and a table of all of them with the checks that must notice each."""
    rows = [(b.name, b.what, ", ".join(f"`{_short(check)}`" for check in b.checks)) for b in BREAKAGES]
    return [NOT_RUN.format(part="breakages"), table(("broken", "how", "to be caught by"), rows)]


def statements(paper: str) -> list[str]:
    """Return that a paper's studies were not run, and a table of its claims."""
    claims = [claim for part in paper_named(paper).parts for claim in part.claims]
    return [
        NOT_RUN.format(part="paper"),
        table(("the paper's text", "section"), [(claim.claim, claim.where) for claim in claims]),
    ]


def uncaught(records: Sequence[Record]) -> list[str]:
    """Breakages that no check noticed, and checks that noticed none."""
    missed = [f"breakage {r['name']!r} is caught by nothing" for r in records if "failed" not in r["checks"].values()]
    failing = {check for r in records for check, answer in r["checks"].items() if answer == "failed"}
    listed = {check for r in records for check in r["checks"]}
    return missed + [f"check {check} catches nothing" for check in sorted(listed - failing)]


def verdict_line(claims: Sequence[Record]) -> str:
    """A paper's claims as `jaxbuffer reproduce` judges them."""
    rows = [(c["claim"], c["section"], c["model"], f"**{c['verdict']}**") for c in claims]
    return table(("the paper's text", "section", "the model", "verdict"), rows)


def modules(tests: Path | None) -> str:
    """Return a table of the test modules, each with its first line and, if it was run, its passed tests."""
    counts: dict[str, list[int]] = {}
    if tests is None:
        paths = sorted(path for folder in CLAIMING for path in (ROOT / folder).rglob("test_*.py"))
        return table(("tests", "what they check"), [_module(path.relative_to(ROOT).as_posix()) for path in paths])
    for case in ElementTree.parse(tests).iter("testcase"):
        name = (case.get("classname") or case.get("name", "")).replace(".", "/") + ".py"  # a module that was skipped
        passed = counts.setdefault(name, [0, 0])
        passed[0] += 1
        passed[1] += case.find("failure") is None and case.find("error") is None and case.find("skipped") is None
    rows = [(*_module(name), f"{passed} of {total}") for name, (total, passed) in sorted(counts.items())]
    return table(("tests", "what they check", "passed"), rows)


def _module(name: str) -> tuple[str, str]:
    """Return a test module's name and the first line of its docstring."""
    said = ast.get_docstring(ast.parse((ROOT / name).read_text(encoding="utf-8"))) or ""
    return f"`{_short(name)}`", said.split("\n")[0]


def _short(node: str) -> str:
    return node.removeprefix("tests/")

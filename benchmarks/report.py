"""From what the parts found to results.json, results.md and a table on the terminal."""

from __future__ import annotations

import json
import math
import os
import platform
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from .figures import Check, Figure, Part, Ratio

PACKAGES = ("jax", "jaxlib", "numba", "scipy", "scikit-sundae", "numpy")
HEADINGS = ("what", "jaxbuffer", "other", "ratio", "target", "met")
CHECK_HEADINGS = ("what", "measured", "bound", "met")
FIGURE_HEADINGS = ("what", "measured", "of")


def machine() -> dict[str, Any]:
    """Processor, cores and versions."""
    names = [line.split(":", 1)[1].strip() for line in _cpuinfo() if line.startswith("model name")]
    return {
        "processor": names[0] if names else platform.processor() or platform.machine(),
        "cores": len(os.sched_getaffinity(0)),
        "load": round(os.getloadavg()[0], 1),  # processes that ran when this was asked: others only add to times
        "python": platform.python_version(),
        **{name: _version(name) for name in PACKAGES},
    }


def _cpuinfo() -> list[str]:
    file = Path("/proc/cpuinfo")
    return file.read_text().splitlines() if file.exists() else []


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"


def about(mode: str) -> dict[str, Any]:
    """What a run is told apart by; ask before it starts, for the load that it found."""
    return {"mode": mode, "date": time.strftime("%Y-%m-%d"), "machine": machine()}


def record(parts: Sequence[Part], run: Mapping[str, Any]) -> dict[str, Any]:
    """Everything, for results.json; what is not finite becomes null."""
    return _finite(
        {
            **run,
            "parts": [
                asdict(part)
                | {
                    "ratios": [asdict(ratio) | {"value": ratio.value, "met": ratio.met} for ratio in part.ratios],
                    "checks": [asdict(check) | {"met": check.met} for check in part.checks],
                }
                for part in parts
            ],
        }
    )


def restored(record: Mapping[str, Any]) -> list[Part]:
    """The parts of a `record`, plots left out."""

    def figure(of: Mapping[str, Any]) -> Figure:
        off = {name: math.inf if value is None else value for name, value in of["errors"].items()}
        return Figure(of["label"], of["value"], of["unit"], off, of["setting"])

    return [
        Part(
            part["name"],
            part["title"],
            tuple(
                Ratio(of["key"], of["what"], figure(of["ours"]), figure(of["theirs"]), of["target"])
                for of in part["ratios"]
            ),
            tuple(Check(of["what"], figure(of["figure"]), of["bound"], of["at_least"]) for of in part["checks"]),
            notes=tuple(part["notes"]),
            figures=tuple(figure(of) for of in part.get("figures", ())),  # results of before had none
        )
        for part in record["parts"]
    ]


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def number(value: float, unit: str) -> str:
    """Three digits and a unit."""
    text = f"{value:.3g}" if 1e-3 <= abs(value) < 1e3 else f"{value:.0f}" if abs(value) >= 1e3 else f"{value:.2e}"
    return f"{text} {unit}".strip()


def mark(met: bool | None) -> str:
    """Whether a target is met, in a word."""
    return "" if met is None else "met" if met else "MISSED"


def accuracy(figure: Figure) -> str:
    """The errors, or the largest of many."""
    if len(figure.errors) > 2:
        return f"largest error {max(figure.errors.values()):.1e}"
    return ", ".join(f"{name} {value:.1e}" for name, value in figure.errors.items())


def _cell(figure: Figure) -> str:
    behind = "; ".join(filter(None, (figure.label, figure.setting, accuracy(figure))))
    return f"{number(figure.value, figure.unit)} ({behind})"


def ratio_row(ratio: Ratio) -> tuple[str, ...]:
    """Cells under HEADINGS."""
    target = "" if ratio.target is None else f"≥ {ratio.target:g}"
    value = number(ratio.value, "")
    return ratio.what, _cell(ratio.ours), _cell(ratio.theirs), value, target, mark(ratio.met)


def check_row(check: Check) -> tuple[str, ...]:
    """Cells under CHECK_HEADINGS."""
    bound = f"{'≥' if check.at_least else '≤'} {number(check.bound, check.figure.unit)}"
    return check.what, number(check.figure.value, check.figure.unit), bound, mark(check.met)


def figure_row(figure: Figure) -> tuple[str, ...]:
    """Cells under FIGURE_HEADINGS."""
    return figure.label, number(figure.value, figure.unit), figure.setting


def markdown(parts: Sequence[Part], run: Mapping[str, Any]) -> str:
    """results.md."""
    machine = run["machine"]
    versions = ", ".join(f"{name} {machine[name]}" for name in ("python", *PACKAGES))
    lines = [
        "# Results",
        "",
        f"`python -m benchmarks{' --quick' if run['mode'] == 'quick' else ''}`, {run['date']}, "
        f"{run['seconds'] / 60:.0f} min on {machine['cores']} cores of {machine['processor']}, "
        f"load average {machine['load']} at the start; {versions}.",
        "Times are the best of several warm runs. A ratio above 1 means that jaxbuffer is quicker.",
    ]
    for part in parts:
        lines += ["", f"## {part.title}"]
        if part.ratios:
            lines += ["", *_table(HEADINGS, [ratio_row(ratio) for ratio in part.ratios])]
        if part.checks:
            lines += ["", *_table(CHECK_HEADINGS, [check_row(check) for check in part.checks])]
        if part.figures:
            lines += ["", *_table(FIGURE_HEADINGS, [figure_row(figure) for figure in part.figures])]
        if part.notes:
            lines += ["", *(f"- {note}" for note in part.notes)]
        if part.plots:
            lines += ["", *(f"![{plot.title}]({plot.name.replace(' ', '-')}.png)" for plot in part.plots)]
    return "\n".join(lines) + "\n"


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    for cells in (headings, ["---"] * len(headings), *rows):
        yield "| " + " | ".join(cells) + " |"


def write(parts: Sequence[Part], run: Mapping[str, Any], folder: Path) -> list[Path]:
    """All files in ``folder``."""
    from .plots import draw_all

    folder.mkdir(parents=True, exist_ok=True)
    numbers, text = folder / "results.json", folder / "results.md"
    numbers.write_text(json.dumps(record(parts, run), indent=1) + "\n")
    text.write_text(markdown(parts, run))
    return [numbers, text, *(file for part in parts for file in draw_all(part, folder))]


def show(parts: Sequence[Part], console: Console) -> None:
    """The summary on the terminal."""
    table = Table(title="jaxbuffer and its peers")
    for heading in HEADINGS:
        table.add_column(heading, justify="right" if heading in {"ratio", "target"} else "left")
    for part in parts:
        table.add_section()
        for ratio in part.ratios:
            table.add_row(f"{part.name}: {ratio.what}", *_short(ratio.ours, ratio.theirs), *ratio_row(ratio)[3:])
        for check in part.checks:
            what, value, bound, met = check_row(check)
            table.add_row(f"{part.name}: {what.replace('`', '')}", value, "", "", bound, met)
        for figure in part.figures:
            what, value, of = figure_row(figure)
            table.add_row(f"{part.name}: {what}", ", ".join(filter(None, (value, of))), "", "", "", "")
    console.print(table)
    for note in (note for part in parts for note in part.notes):
        console.print(f"- {note}", highlight=False)


def _short(*figures: Figure) -> list[str]:
    return [", ".join(filter(None, (number(figure.value, figure.unit), accuracy(figure)))) for figure in figures]

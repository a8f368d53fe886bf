"""A stored baseline of ratios: a slowdown shows as a fallen ratio to a peer of the same run, whatever the machine."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

from .figures import Part

FILE = Path(__file__).with_name("baseline.json")
ALLOWED = 0.3  # [-] part of a ratio that may be lost: quick runs on a shared machine scatter by half of that


def ratios(parts: Iterable[Part]) -> dict[str, float]:
    """All ratios [-] of a run by key."""
    return {ratio.key: ratio.value for part in parts for ratio in part.ratios}


def due(before: Mapping[str, float], ran: Collection[str]) -> dict[str, float]:
    """The baseline of the parts that ``ran``: a ratio of theirs that is missing now was lost."""
    return {key: value for key, value in before.items() if key.split("/")[0] in ran}


def fallen(now: Mapping[str, float], before: Mapping[str, float], allowed: float = ALLOWED) -> list[str]:
    """A line for each ratio that is missing or below its baseline by more than ``allowed`` of it."""
    return [
        f"{key}: {f'{now[key]:.2f}' if key in now else 'not measured'}, baseline {value:.2f}"
        for key, value in before.items()
        if now.get(key, 0.0) < (1.0 - allowed) * value
    ]


def load(mode: str, file: Path | None = None) -> dict[str, float]:
    """The ratios of a baseline of ``mode``, "quick" or "full"; empty where there is none. ``file``: default `FILE`."""
    return _stored(file).get(mode, {}).get("ratios", {})


def machine_of(mode: str, file: Path | None = None) -> str:
    """On which machine a baseline was stored last, and when: a ratio may differ between processors."""
    last = _stored(file).get(mode)
    return f"stored last on {last['cores']} cores of {last['processor']}, {last['date']}" if last else "none stored"


def store(mode: str, now: Mapping[str, float], about: Mapping[str, Any], file: Path | None = None) -> None:
    """Put the ratios in place of their baselines, with what `report.about` says of the run; other ratios stay."""
    ratios = {**load(mode, file), **{key: float(f"{value:.3g}") for key, value in now.items()}}
    machine = about["machine"]
    last = {"processor": machine["processor"], "cores": machine["cores"], "date": about["date"], "ratios": ratios}
    (file or FILE).write_text(json.dumps({**_stored(file), mode: last}, indent=1, sort_keys=True) + "\n")


def _stored(file: Path | None) -> dict[str, Any]:
    file = file or FILE
    return json.loads(file.read_text()) if file.exists() else {}

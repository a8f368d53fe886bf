"""Which files belong to one result, so that none of an earlier result stays beside a new one and is taken for its."""

import fnmatch
import json
from collections.abc import Collection
from pathlib import Path
from typing import NamedTuple

from ..files import naming
from ..mechanisms import all_mechanisms


class Group(NamedTuple):
    """The files of one kind of result: a new one has one of the ``main`` files at least; ``others``: what it may have
    besides, as patterns."""

    main: tuple[str, ...]
    others: tuple[str, ...]


FIGURES = ("png", "svg")
BEFORE = "evaluation,"  # how history.csv of a tuning begins


def groups() -> dict[str, Group]:
    """Return every kind of result that has files which some results of the kind have and others have not."""
    runs = [mechanism.view.run_name for mechanism in all_mechanisms()]
    of_runs = ("force.json", "history.csv", "motion.json", "fields*.vtu", *_figures("motion", "fields", *runs))
    of_runs += tuple(f"{name}.{kind}" for name in runs for kind in ("txt", "nc", "mat"))
    return {
        "run": Group(tuple(f"{name}.json" for name in runs), of_runs),
        "sweep": Group(("sweep.json",), ("sweep.csv", "sweep.txt", "sweep.nc", *_figures("sweep", "envelope"))),
        "sample": Group(
            ("sample.json",),
            (
                *(f"sample.{kind}" for kind in ("csv", "txt", "nc")),
                "indices.csv",
                "surface.csv",
                *_figures("sample", "indices", "surface"),
            ),
        ),
        "tuned": Group(
            ("tuned.json", "design.toml"), ("history.csv", "force.json", "tune.txt", "design.mat", *_figures("tune"))
        ),
        "fit": Group(("fit.json",), ("design.toml", "fit.csv", "fit.txt", *_figures("fit"))),
        "size": Group(("size.json",), ("design.toml", "size.txt", *_figures("size"))),
        "front": Group(("pareto.json",), ("design-[0-9]*.toml", "pareto.csv", "pareto.txt", *_figures("pareto"))),
        "choice": Group(("choice.json",), ("choice.csv", "choice.txt", "design.mat", *_figures("choice"))),
    }


def _figures(*names: str) -> tuple[str, ...]:
    return tuple(f"{name}.{ending}" for name in names for ending in FIGURES)


def stale(folder: Path, names: Collection[str]) -> list[Path]:
    """Return the files in a folder that are of an earlier result than the new one whose files have these ``names``."""
    if not folder.is_dir():
        return []
    there = [path for path in sorted(folder.iterdir()) if path.name not in names and path.is_file()]
    files = list[Path]()
    if not there:  # the usual case, and the kinds of results are those of all mechanisms, which take long to import
        return files
    for kind, group in groups().items():
        # A result of another kind may lie in the same folder, and stays.
        if not set(group.main) & set(names):
            continue
        patterns = (*group.main, *group.others)
        files += [
            path
            for path in there
            if any(fnmatch.fnmatchcase(path.name, pattern) for pattern in patterns) and _is_of(kind, path)
        ]
    return files


def remove_stale(folder: Path, names: Collection[str]) -> None:
    """Remove these files. **Raises:** an `OSError` that names the one that cannot be removed."""
    for path in stale(folder, names):
        with naming(path):
            path.unlink(missing_ok=True)


def _is_of(kind: str, path: Path) -> bool:
    """Return whether a file is of this kind of result: runs and tunings both have a force.json and a history.csv."""
    # The names of all other files say which kind they are of.
    if kind not in ("run", "tuned") or path.name not in ("force.json", "history.csv"):
        return True
    try:
        text = path.read_text(encoding="utf-8")
        if path.suffix == ".csv":
            tuned = text.startswith(BEFORE)
        else:
            curves = [curve["name"] for curve in json.loads(text)["curves"]]
            # There are none where a tuning's worst scenario could not be run again.
            tuned = "after" in curves or not curves
    except (OSError, ValueError, KeyError, TypeError):
        tuned = False
    return (kind == "tuned") == tuned

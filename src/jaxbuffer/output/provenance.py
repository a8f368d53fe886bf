"""How a result came about: command, study, settings, versions, time and machine."""

import os
import platform
import shlex
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

from ..files import home
from ..labelled.record import amount
from ..version import version
from .formats import Made, json_text

MADE = "made"  # a record's key for it
CPUINFO = Path("/proc/cpuinfo")


def made(
    command: Sequence[str], study: str | None, settings: Mapping[str, Any], seconds: float, resumed: bool = False
) -> dict[str, Any]:
    """Return everything that another person needs to compute a result again, and to judge where numbers differ.

    Two runs of the same command differ in nothing else than this part of their records.

    **Arguments:**

    - ``command``: the words as typed, without the program's name; the home folder becomes "~", which names no user.
    - ``study``: the text of the study (TOML), None where there was none.
    - ``settings``: of the solver, numbers with their units (`amount`).
    - ``seconds``: from the command's start to the result [s], compilation included.
    - ``resumed``: whether the command went on with an earlier run, whose time is not in ``seconds``.

    **Example:**

    >>> from jaxbuffer.labelled.record import amount
    >>> from jaxbuffer.output.provenance import made
    >>> told = made(["simulate", "--buffer.k_A", "800"], None, {"rtol": amount(1e-6, "-")}, 2.5)
    >>> told["command"], told["wall_time"]
    ('jaxbuffer simulate --buffer.k_A 800', {'value': 2.5, 'unit': 's'})
    """
    return {
        "command": " ".join(["jaxbuffer", *map(_quoted, command)]),
        "study": study,
        "settings": dict(settings),
        "wall_time": amount(round(seconds, 3), "s"),
        "resumed": resumed,
        **_here(),
    }


def _quoted(word: str) -> str:
    """Return a word as a shell takes it, a path in the home folder, also behind an option's "=", with "~"."""
    own = home()
    if own is None or not own.is_absolute() or own == Path(own.anchor):  # what is in "/" names no user
        return shlex.quote(word)
    # An option's value may be a path, too: --output=/home/me/results.
    option, equals, path = word.partition("=") if word.startswith("-") else ("", "", word)
    inside = path.removeprefix(str(own))
    if inside == path or inside[:1] not in ("", "/"):  # /home/me is no folder above /home/menu
        return shlex.quote(word)
    return f"{shlex.quote(option) if option else ''}{equals}~{'/' if inside else ''}" + (
        shlex.quote(inside[1:]) if inside[1:] else ""
    )


def made_in_python() -> dict[str, Any]:
    """Return what is known of a result that is saved from Python: when, by which versions, on which machine."""
    return {"command": "in Python", "study": None, **_here()}


def _here() -> dict[str, Any]:
    system = f"{platform.system()} {platform.release()}, {platform.machine()}"
    return {
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "versions": {"jaxbuffer": version(), "Python": platform.python_version(), "JAX": metadata.version("jax")},
        "machine": {"processor": processor(), "cores": os.cpu_count(), "system": system},
    }


def processor() -> str:
    """Return the processor's name as the system tells it, its architecture where it tells none."""
    # On Linux `platform.processor` tells the architecture at most.
    lines = CPUINFO.read_text(errors="replace").splitlines() if CPUINFO.is_file() else []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, "") or platform.processor() or platform.machine() or "unknown"


def record_text(record: Mapping[str, Any], made: Made) -> str:
    """Return a record with how it came about at its end, where that is known, as text."""
    return json_text(record if made is None else {**record, MADE: made})

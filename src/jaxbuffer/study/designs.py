"""Designs as files: `load_design` and `save_design`, exact to the last bit."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..errors import InputError, check_single
from ..fields import Part, get, paths, point_paths, unit
from ..files import user_path, write
from ..mechanisms.registry import mechanism_of
from ..run.request import check_pair
from .design_toml import design_toml
from .load import load


def load_design(toml: str | Path) -> tuple[Any, tuple[Any, ...]]:
    """Load the design and the scenarios of a TOML file: a study, or what `save_design` or a tuning wrote.

    **Arguments:**

    - ``toml``: the file.

    **Returns:** the design, and the scenarios of its [[scenarios]]; where it has none, that of [scenario], by default
    the mechanism's own.

    **Raises:** `InputError` for a file that is not there or says something wrong, naming file and field.

    **Example:**

    >>> import tempfile, pathlib
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder) / "drop.toml"
    ...     _ = file.write_text('kind = "bar_drop"')
    ...     design, scenarios = jb.load_design(file)
    >>> type(design).__name__, len(scenarios)
    ('BarDrop', 1)
    """
    study = load(toml)
    return study.design, study.scenarios


def save_design(
    path: str | Path, design: Part, scenarios: Iterable[Part] = (), comment: str = "", *, overwrite: bool = False
) -> None:
    """Write a design, and scenarios if there are any, as TOML that `load_design` and all commands read.

    **Arguments:**

    - ``path``: of the file.
    - ``design``: of any mechanism, with single numbers.
    - ``scenarios``: of the same mechanism.
    - ``comment``: lines at the top of the file.
    - ``overwrite``: whether to replace a file that is there.

    **Raises:** `InputError` for a file that is there, for arrays, and for scenarios of another mechanism.

    **Example:**

    >>> import tempfile, pathlib
    >>> design, scenario = jb.replace(jb.table2(), {"buffer.k_A": 800.0}), jb.Scenario(approach_speed=0.2)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder) / "stiff.toml"
    ...     jb.save_design(file, design, [scenario], comment="a stiffer buffer")
    ...     jb.load_design(file) == (design, (scenario,))
    True
    """
    mechanism, listed = mechanism_of(design), tuple(scenarios)
    for scenario in listed:
        check_pair(mechanism, design, scenario)
    for part in (design, *listed):
        # An array is many designs at once, for which a file has no room.
        for name in (*paths(part), *point_paths(part)):
            if unit(part, name) and get(part, name) is not None:
                check_single(name, get(part, name), unit(part, name), "save each design to a file of its own")
    try:
        write(user_path(path), design_toml(design, listed, comment), overwrite)
    except FileExistsError:
        raise InputError(f"{path} exists; overwrite=True replaces it") from None

"""How a run is done: quick or full, and how it tells what it is doing."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import TypeVar

from rich.console import Console
from rich.progress import Progress

from .peers.reference import Reference, load

T = TypeVar("T")

ROOT = Path(__file__).resolve().parent.parent
REFERENCES = ROOT / "tests" / "verification" / "captures.json"
QUICK_PEERS = ("compiled DOP853", "compiled RODAS", "SciPy LSODA", "CVODE Adams")  # the quickest of either kind


def of_tests(name: str) -> ModuleType:
    """Return a module of the tests, which are no package."""
    sys.path.append(str(ROOT / "tests"))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.pop()


@dataclass(frozen=True)
class Plan:
    """The choices of a run; parts ask it rather than count for themselves."""

    quick: bool = False
    console: Console = field(default_factory=lambda: Console(stderr=True))

    @property
    def peers(self) -> tuple[str, ...]:
        """Names of the peers that run."""
        from .peers.solvers import PEERS

        return QUICK_PEERS if self.quick else tuple(PEERS)

    @property
    def repeats(self) -> int:
        """Runs of which the best is taken, where figures are compared."""
        return 5 if self.quick else 10

    @cached_property
    def table2(self) -> Reference:
        """The exact reference of the Table-2 capture."""
        return next(reference for reference in load(REFERENCES) if reference.name == "table2")

    def track(self, items: Iterable[T], doing: str) -> Iterator[T]:
        """The ``items``, with a progress bar, or one line where nobody watches."""
        known = list(items)
        if not self.console.is_terminal:
            self.console.print(f"{doing} …")
            yield from known
            return
        with Progress(console=self.console, transient=True) as progress:
            yield from progress.track(known, description=doing)

"""Where and how the runs of a choice are computed and kept."""

import contextlib
import dataclasses
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from ..errors import InputError, check_whole
from ..files import Lock, user_path
from ..hybrid import Diffrax, Solver, solver_named
from ..programs.process import check_ready
from ..run.stepper import stepper_of
from ..tuning.problem.problem import Problem
from ..tuning.search.evaluation import FINEST_OF_DIFFRAX
from ..tuning.search.store import LOG, Record
from .store import FOLDER

OPTIMUM, TUNED = "choose.optimum", "choose.tuned"  # folders of tunings
QUICK = {"starts": 8, "rounds": 2}  # settings of tunings beside a choice where none are given


@dataclasses.dataclass(frozen=True)
class Means:
    """Where and how runs are computed: as the arguments of `choose`; ``settings``: of tunings."""

    folder: str | Path | None = None
    resume: bool = False
    workers: int | None = None
    executor: Executor | None = None
    solver: Solver | str | None = None
    progress: Callable[[int, int], None] | None = None
    report: Callable[[Record], None] | None = None
    settings: Mapping[str, Any] = dataclasses.field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.resume and self.folder is None:
            raise InputError("resume needs the folder of the choice to go on with")
        # A choice of roundings tunes first, so that an interrupted one may have begun nothing but that.
        if self.resume and self.path is not None and not any((self.path / it).exists() for it in (FOLDER, OPTIMUM)):
            raise InputError(f"{self.path}: there is no choice to resume; leave out --resume to begin one")
        if self.workers is not None:
            check_whole("workers", self.workers, 1)
        check_ready()

    @property
    def path(self) -> Path | None:
        """Return the folder, None where nothing is kept."""
        return None if self.folder is None else user_path(self.folder)

    def tuning(self, name: str) -> dict[str, Any]:
        """Return the keywords of a tuning in a folder of its own."""
        folder = None if self.path is None else self.path / name
        shared = {"workers": self.workers, "executor": self.executor, "solver": self.solver, "report": self.report}
        resume = self.resume and folder is not None and (folder / LOG).exists()
        return {**(self.settings or QUICK), **shared, "folder": folder, "resume": resume, "save": False}

    def tight(self, problem: Problem) -> float:
        """Return the relative error of the runs that a result is told from [-], as of a tuning."""
        usual = stepper_of(problem.mechanism).tight
        smooth = isinstance(solver_named(self.solver), Diffrax)
        return max(usual, FINEST_OF_DIFFRAX) if smooth else usual

    @contextlib.contextmanager
    def locked(self) -> Iterator[None]:
        """Let the folder be this choice's own until the end of the block."""
        if self.path is None:
            yield
            return
        lock = Lock(self.path)
        try:
            yield
        finally:
            lock.release()

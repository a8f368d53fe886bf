"""(a) Table 2, worst case over approach speeds."""

from concurrent.futures import Executor
from pathlib import Path

from .study import config, tuned


def main(folder: Path, resume: bool = False, executor: Executor | None = None) -> None:
    """One tuning; its figure says it all."""
    tuned(config("speeds"), folder, resume, executor)

"""(e) A design that stays good when the built mechanism differs from the drawn one by up to 10 %."""

from concurrent.futures import Executor
from pathlib import Path

from .study import config, tuned


def main(folder: Path, resume: bool = False, executor: Executor | None = None) -> None:
    """One tuning; its figure says it all."""
    tuned(config("robust"), folder, resume, executor)

"""(i) The tank paper's load on a full tank: the lightest sides and the cushion that survive it."""

from concurrent.futures import Executor
from pathlib import Path

from .study import config, tuned


def main(folder: Path, resume: bool = False, executor: Executor | None = None) -> None:
    """One tuning; its figure says it all."""
    tuned(config("full_tank"), folder, resume, executor)

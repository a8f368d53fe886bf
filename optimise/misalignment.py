"""(b) Misalignment of the vehicles and rotation of the passive one."""

from pathlib import Path
from typing import Any

from .study import config, tuned


def main(folder: Path, resume: bool = False, client: Any = None) -> None:
    """One tuning; its figure says it all."""
    tuned(config("misalignment"), folder, resume, client)

"""(a) Table 2, worst case over approach speeds."""

from pathlib import Path
from typing import Any

from .study import config, tuned


def main(folder: Path, resume: bool = False, client: Any = None) -> None:
    """One tuning; its figure says it all."""
    tuned(config("speeds"), folder, resume, client)

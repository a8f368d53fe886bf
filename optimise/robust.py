"""(e) A design that stays good when the built mechanism differs from the drawn one by up to 10 %."""

from pathlib import Path
from typing import Any

from .study import config, tuned


def main(folder: Path, resume: bool = False, client: Any = None) -> None:
    """One tuning; its figure says it all."""
    tuned(config("robust"), folder, resume, client)

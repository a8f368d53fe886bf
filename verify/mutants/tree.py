"""A copy of the repository in which one file at a time holds a fault."""

import os
import shutil
from pathlib import Path

from .changes import Mutant

NEEDED = ("src", "tests", "benchmarks", "verify", "optimise", "docs", "pyproject.toml", "constraints.txt", "README.md",
          "CHANGELOG.md")  # fmt: skip


def copied(root: Path, tree: Path) -> Path:
    """A fresh copy of what the tests need."""
    shutil.rmtree(tree, ignore_errors=True)
    tree.mkdir(parents=True)
    for name in NEEDED:
        if (root / name).is_dir():
            shutil.copytree(root / name, tree / name, ignore=shutil.ignore_patterns("__pycache__", "_build"))
        else:
            shutil.copy2(root / name, tree / name)
    return tree


class Broken:
    """The copy with a fault in it, for as long as the context lasts.

    Python takes a file's compiled form for current by its time in whole seconds and its size, so each fault has a time
    of its own.
    """

    turn = 0

    def __init__(self, tree: Path, mutant: Mutant) -> None:
        self.file, self.mutant = tree / "src" / "jaxbuffer" / mutant.path, mutant

    def __enter__(self) -> None:
        self.sound, self.time = self.file.read_bytes(), self.file.stat().st_mtime
        it = self.mutant
        assert self.sound[it.start : it.end].decode() == it.old, f"{self.file} is not what it was"
        self.file.write_bytes(self.sound[: it.start] + it.new.encode() + self.sound[it.end :])
        Broken.turn += 1
        os.utime(self.file, (self.time - 10.0 * Broken.turn,) * 2)

    def __exit__(self, *_: object) -> None:
        self.file.write_bytes(self.sound)
        os.utime(self.file, (self.time, self.time))

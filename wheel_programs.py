"""A step of building the wheel: the default mechanism's programs, traced and exported, go into it.

The first `simulate`, `sensitivity` or `sweep` on a machine then compiles at once. A program is used only with the
versions of Python and of the packages that it was exported with, so it is exported only where these are installed
beside the build tool (`python -m build --no-isolation`); any other wheel has none, and neither has an editable install.
"""

import importlib.util
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

COMMANDS = (
    "sensitivity",  # simulates as well
    "simulate --output results",  # with the history of its steps
    "sweep --over scenario.approach_speed=0.1:0.2:2",
)
SHIP = "import sys, pathlib; from jaxbuffer.programs import store; store.ship(*map(pathlib.Path, sys.argv[1:]))"
SETTINGS = ("JAX", "XLA")  # what names of settings in the environment begin with, which make other programs


class Programs(BuildHookInterface):
    """Exports programs into a folder that the wheel takes in."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "editable" or importlib.util.find_spec("jax") is None:
            return
        self.work = tempfile.TemporaryDirectory()
        cache, shipped = Path(self.work.name, "cache"), Path(self.work.name, "shipped")
        inherited = {name: value for name, value in os.environ.items() if not name.startswith(SETTINGS)}
        environment = inherited | {
            "PYTHONPATH": str(Path(self.root, "src")),
            "JAXBUFFER_CACHE": str(cache),
            "JAXBUFFER_EXPORT": "1",
        }

        def python(*arguments: str) -> None:
            command = [sys.executable, *arguments]
            subprocess.run(command, env=environment, cwd=self.work.name, check=True, stdout=subprocess.DEVNULL)

        for command in COMMANDS:
            python("-m", "jaxbuffer", *command.split())
        python("-c", SHIP, str(cache), str(shipped))
        build_data["force_include"][str(shipped)] = "jaxbuffer/programs/shipped"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        if hasattr(self, "work"):
            self.work.cleanup()

"""Every command of quickstart and guides runs."""

import os
import subprocess
import sys

import pytest

from pages import GUIDES, commands


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in GUIDES if commands(page)], ids=lambda page: page.name)
def test_commands_of_a_guide_run(page, tmp_path):
    folder = tmp_path / "bin"
    folder.mkdir()
    for name, words in (("jaxbuffer", " -m jaxbuffer"), ("python", "")):
        script = folder / name
        script.write_text(f'#!/bin/sh\nexec "{sys.executable}"{words} "$@"\n')
        script.chmod(0o755)
    names = os.environ | {"PATH": f"{folder}:{os.environ['PATH']}"}
    command = ["bash", "-e", "-u", "-o", "pipefail", "-c", commands(page)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False, env=names)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]

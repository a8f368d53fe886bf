"""Every command of quickstart and guides runs.

A shell reads them, and hands each `jaxbuffer …` to this process, which has JAX and the programs of the commands before.
"""

import contextlib
import io
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Client, Listener
from unittest.mock import patch

import pytest

from documents.examples import GUIDES, commands
from jaxbuffer.cli.entry import run

# for `make test-long`
LONG = (
    "quickstart",
    "clusters",
    "laws",
    "gradients",
    "tuning",
    "robust",
    "tank_drop",
    "data_sheet",
    "choose",
    "control_loop",
)

# `jaxbuffer` for the shell: sends where it is and its words, prints what comes back and ends with the command's code
SENDER = """
import os, sys
from multiprocessing.connection import Client

with Client({address!r}) as command:
    command.send((os.getcwd(), dict(os.environ), sys.argv[1:]))
    code, shown, errors = command.recv()
sys.stdout.write(shown)
sys.stderr.write(errors)
sys.exit(code)
"""


def answer(place, environment, words):
    """Exit code, standard output and standard error of a command of ours, run in this process."""
    shown, errors = io.StringIO(), io.StringIO()
    with (
        contextlib.chdir(place),
        patch.dict(os.environ, environment, clear=True),
        contextlib.redirect_stdout(shown),
        contextlib.redirect_stderr(errors),
    ):
        code = run(words)
    return code, shown.getvalue(), errors.getvalue()


def run_by_shell(text, folder, listener):
    """Let a shell run a text, and end what listens for its commands."""
    programs = folder / "bin"
    programs.mkdir()
    sender = programs / "sender.py"
    sender.write_text(SENDER.format(address=listener.address))
    for name, words in (("jaxbuffer", f' -IS "{sender}"'), ("python", "")):
        script = programs / name
        script.write_text(f'#!/bin/sh\nexec "{sys.executable}"{words} "$@"\n')
        script.chmod(0o755)
    names = os.environ | {"PATH": f"{programs}:{os.environ['PATH']}", "PYTHONIOENCODING": "utf-8"}
    words = ["bash", "-e", "-u", "-o", "pipefail", "-c", text]
    try:
        return subprocess.run(words, capture_output=True, text=True, cwd=folder, check=False, env=names)
    finally:
        with Client(listener.address) as last:
            last.send(None)


def run_here(text, folder):
    """What a shell's text ended with and printed; this process answers its commands of ours, one after the other."""
    with Listener() as listener, ThreadPoolExecutor(1) as thread:
        shell = thread.submit(run_by_shell, text, folder, listener)
        while True:
            with listener.accept() as connection:
                if (command := connection.recv()) is None:
                    return shell.result()
                connection.send(answer(*command))


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=pytest.mark.long if page.stem in LONG else ()) for page in GUIDES if commands(page)],
    ids=lambda page: page.name,
)
def test_commands_of_a_guide_run(page, tmp_path):
    done = run_here(commands(page), tmp_path)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]


def test_a_command_that_fails_ends_the_shell_with_its_code(tmp_path):
    text = (
        "mkdir sub && cd sub\njaxbuffer fields bar_drop | grep -c height\njaxbuffer simulate none.toml\necho not here"
    )
    done = run_here(text, tmp_path)
    assert done.returncode == 2 and int(done.stdout) > 0 and "none.toml" in done.stderr

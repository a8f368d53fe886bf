"""Every Python example of README and docs runs."""

import subprocess
import sys

import pytest

from pages import PAGES, blocks


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_examples_of_a_page_run(page, tmp_path, programs):
    kept = f"import jaxbuffer\njaxbuffer.configure(cache={str(programs)!r})\n"
    command = [sys.executable, "-W", "error", "-c", kept + blocks(page)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr[-2000:]

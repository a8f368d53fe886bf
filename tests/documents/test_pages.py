"""Every Python example of README and docs runs.

The README's runs as a reader would run it, in a process of its own; the others in this one, as a module each.
"""

import subprocess
import sys
from types import ModuleType

import pytest

from documents.examples import PAGES, ROOT, blocks
from jaxbuffer.contact.laws.registry import _all as laws
from jaxbuffer.mechanisms import all_mechanisms, registry

README = ROOT / "README.md"
# Pages for `make test-long`.
LONG = ("diffrax", "docking3d", "gradients", "mechanisms", "ring", "slider_crank", "structures", "tank_drop", "tuning")


@pytest.mark.slow
def test_examples_of_the_readme_run_in_a_process_of_their_own(tmp_path, programs):
    prologue = f"import jaxbuffer\njaxbuffer.configure(cache={str(programs)!r})\n"
    command = [sys.executable, "-W", "error", "-c", prologue + blocks(README)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.fixture
def module(tmp_path, monkeypatch):
    """An empty module in an empty folder; mechanisms and laws that it registers are gone after it."""
    monkeypatch.chdir(tmp_path)
    all_mechanisms()  # registers those of the package, which stay
    monkeypatch.setattr(registry, "_BY_DESIGN", dict(registry._BY_DESIGN))
    before = dict(laws)
    made = ModuleType("example")
    monkeypatch.setitem(sys.modules, made.__name__, made)
    yield made
    laws.clear()
    laws.update(before)


@pytest.mark.slow
@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=pytest.mark.long if page.stem in LONG else ()) for page in PAGES if page != README],
    ids=lambda page: page.name,
)
def test_examples_of_a_page_run(page, module):
    exec(compile(blocks(page), str(page), "exec"), vars(module))

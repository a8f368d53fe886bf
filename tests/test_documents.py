"""Every example of the documents runs: Python of README, docs and docstrings, commands of the guides."""

import doctest
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import jaxbuffer
from jaxbuffer.contact.laws import _all as laws

ROOT = Path(__file__).resolve().parents[1]
HEADING = "**Example:**"
COMPILES = re.compile(r"\.(simulate|sensitivity|sweep|sample|tune|pareto|diffeqsolve)\(")
PARSER = doctest.DocTestParser()


def blocks(page: Path) -> str:
    """A page's Python examples, one after the other."""
    return "\n".join(re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL))


def commands(page: Path) -> str:
    """A page's shell examples, one after the other, but for those that a comment above marks as not run."""
    parts = re.findall(r"(<!-- not run.*?-->\n)?```bash\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    return "\n".join(text for comment, text in parts if not comment)


DOCS = ROOT / "docs"
GUIDES = [DOCS / "quickstart.md", *sorted((DOCS / "howto").glob("*.md"))]
PAGES = [page for page in (ROOT / "README.md", *sorted(DOCS.glob("*.md")), *GUIDES[1:]) if blocks(page)]


def docstring(name: str) -> str:
    """Of a public name itself: a class inherits none."""
    return getattr(jaxbuffer, name).__doc__ or ""


def that_compile(name: str):
    """The name, marked as slow where its example solves something."""
    slow = COMPILES.search("".join(example.source for example in PARSER.get_examples(docstring(name))))
    return pytest.param(name, marks=pytest.mark.slow if slow else ())


def run(text: str, name: str, names: dict) -> dict:
    """Run the examples of a docstring with some ``names`` defined; all names after it. Fails as `doctest` does."""
    test = PARSER.get_doctest(text, names, name, None, None)
    said: list[str] = []
    doctest.DocTestRunner(verbose=False).run(test, out=said.append, clear_globs=False)
    assert not said, "".join(said)
    return test.globs


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """The names that the package's own example defines, in an empty folder; laws that are registered go again."""
    monkeypatch.chdir(tmp_path)
    before = dict(laws)
    yield run(jaxbuffer.__doc__, "jaxbuffer", {"__name__": "example"})
    laws.clear()
    laws.update(before)


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_examples_of_a_page_run(page, tmp_path, programs):
    kept = f"import jaxbuffer\njaxbuffer.configure(cache={str(programs)!r})\n"
    command = [sys.executable, "-W", "error", "-c", kept + blocks(page)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in GUIDES if commands(page)], ids=lambda page: page.name)
def test_commands_of_a_guide_run(page, tmp_path, programs):
    folder = tmp_path / "bin"
    folder.mkdir()
    for name, words in (("jaxbuffer", " -m jaxbuffer"), ("python", "")):
        script = folder / name
        script.write_text(f'#!/bin/sh\nexec "{sys.executable}"{words} "$@"\n')
        script.chmod(0o755)
    names = os.environ | {"PATH": f"{folder}:{os.environ['PATH']}", "JAXBUFFER_CACHE": str(programs)}
    command = ["bash", "-e", "-u", "-o", "pipefail", "-c", commands(page)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False, env=names)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]


def test_the_reference_has_every_public_name_once():
    entries = [
        name
        for page in (DOCS / "api").glob("*.md")
        for name in re.findall(r"^\.\. auto\w+:: jaxbuffer\.(\w+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    ]
    assert sorted(entries) == sorted(jaxbuffer.__all__)


@pytest.mark.parametrize("file", sorted(DOCS.glob("notebook/*.ipynb")), ids=lambda file: file.name)
def test_a_notebook_is_kept_without_outputs(file):  # `make docs` runs it
    code = [cell for cell in json.loads(file.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
    assert code and not any(cell["outputs"] or cell["execution_count"] for cell in code)


@pytest.mark.parametrize("name", jaxbuffer.__all__)
def test_a_public_name_has_one_example_at_the_end_of_its_docstring(name):
    text = docstring(name)
    assert text.count(HEADING) == 1, f"give jaxbuffer.{name} an example, under {HEADING} at the end of its docstring"
    body, example = text.split(HEADING)
    assert not PARSER.get_examples(body), f"jaxbuffer.{name} has an example outside of {HEADING}"
    examples = PARSER.get_examples(example)
    assert examples and any(e.want for e in examples), f"the example of jaxbuffer.{name} shows no result"
    assert not any(e.options.get(doctest.SKIP) for e in examples), f"the example of jaxbuffer.{name} is not run"


@pytest.mark.parametrize("name", [that_compile(name) for name in jaxbuffer.__all__])
def test_the_example_of_a_public_name_runs(name, begun):
    run(docstring(name), f"jaxbuffer.{name}", begun)


def test_the_new_mechanism_of_the_example_is_short():
    code = [line for line in blocks(ROOT / "docs" / "mechanisms.md").splitlines() if line.strip()]
    assert len(code) < 80

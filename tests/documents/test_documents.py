"""Examples in docstrings run, and the reference and the notebook are whole."""

import doctest
import json
import re

import pytest

import jaxbuffer
from documents.examples import DOCS, ROOT, blocks
from jaxbuffer.contact.laws.registry import _all as laws
from jaxbuffer.study.load import load

HEADING = "**Example:**"
COMPILES = re.compile(
    r"\.(simulate|sensitivity|sweep|sample|tune|pareto|choose|buildable|diffeqsolve|step|observe|size|what_if)\("
)
LONG = ("Certificate", "published_slider_crank")  # whose examples are for `make test-long`
PARSER = doctest.DocTestParser()


def docstring(name: str) -> str:
    """Of a public name itself: a class inherits none."""
    return getattr(jaxbuffer, name).__doc__ or ""


def that_compile(name: str):
    """The name, marked as slow where its example solves something and as long where that takes long."""
    slow = COMPILES.search("".join(example.source for example in PARSER.get_examples(docstring(name))))
    return pytest.param(name, marks=pytest.mark.long if name in LONG else pytest.mark.slow if slow else ())


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
    monkeypatch.setattr("jaxbuffer.output.animation.EVEN", 2)  # frames: a short film
    before = dict(laws)
    yield run(jaxbuffer.__doc__, "jaxbuffer", {"__name__": "example"})
    laws.clear()
    laws.update(before)


def test_the_reference_has_every_public_name_once():
    entries = [
        name
        for page in (DOCS / "api").glob("*.md")
        for name in re.findall(r"^\.\. auto\w+:: jaxbuffer\.(\w+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    ]
    assert sorted(entries) == sorted(jaxbuffer.__all__)


NUMBERED = re.compile(r"--scenario-number (\d+).*# of the grid: the (\w+) approach")


@pytest.mark.parametrize("name", ["hold_20_kg", "hold_8_t"])
def test_a_scenario_number_of_a_guide_is_that_of_its_study(name, tmp_path):
    page = (DOCS / "howto" / f"{name}.md").read_text(encoding="utf-8")
    study = tmp_path / "study.toml"
    study.write_text(re.search(r"<<'END'\n(.*?)^END$", page, re.DOTALL | re.MULTILINE).group(1))
    speeds = [case.scenario.approach_speed for case in load(study).cases]
    ((number, which),) = NUMBERED.findall(page)
    assert speeds[int(number) - 1] == {"slow": min, "fast": max}[which](speeds) and min(speeds) < max(speeds)


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

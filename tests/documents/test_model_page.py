"""The page of equations, docs/model.md, and what the source cites of it."""

import re
from pathlib import Path

import pytest

from jaxbuffer import Scenario, table2
from jaxbuffer.fields import addresses

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "model.md").read_text()
SOURCES = sorted((ROOT / "src").rglob("*.py"))
NUMBERED = re.compile(r"^\*\*\(M(\d+)\)\*\*", re.MULTILINE)
CITED = re.compile(r"\bM(\d+)\b")
NUMBERS = [int(number) for number in NUMBERED.findall(PAGE)]


def test_numbers_ascend_and_are_unique():
    assert NUMBERS, "the page has no numbered equation"
    assert sorted(set(NUMBERS)) == NUMBERS


def test_each_number_stands_over_one_equation_and_names_its_source():
    entries = NUMBERED.split(PAGE)[1:]
    for number, text in zip(entries[0::2], entries[1::2], strict=True):
        introduction, _, rest = text.partition("```math\n")
        assert rest, f"M{number} has no equation"
        assert re.search(r"Source:\s", introduction), f"M{number} names no source"
        assert rest.partition("```")[0].strip(), f"M{number} has an empty equation"
        assert "```math" not in rest, f"M{number} has two equations"


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT / "src")))
def test_what_a_file_cites_exists(path):
    text = path.read_text()
    unknown = sorted({int(number) for number in CITED.findall(text)} - set(NUMBERS))
    assert not unknown, f"cites M{unknown}, which docs/model.md does not have"
    assert "the model's section" not in text, "cites a section of the model: docs/model.md has numbers"


def test_the_page_cites_only_what_it_has():
    assert {int(number) for number in CITED.findall(PAGE)} <= set(NUMBERS)


def test_the_source_cites_the_page():
    """Without this the tests above would pass on a source that cites nothing."""
    cited = {int(number) for path in SOURCES for number in CITED.findall(path.read_text())}
    assert len(cited) > len(NUMBERS) / 2


def test_inline_maths_survives_markdown():
    """GitHub takes a backslash before punctuation as Markdown's own, and ends a formula at the paragraph's end."""
    text = re.sub(r"```.*?```|`[^`\n]*`", "", PAGE, flags=re.DOTALL)
    for paragraph in text.split("\n\n"):
        assert paragraph.count("$") % 2 == 0, paragraph
        for formula in re.findall(r"\$([^$]*)\$", paragraph):
            assert not re.search(r"\\[^A-Za-z]|\n", formula), formula
            assert formula.count("{") == formula.count("}"), formula


def test_every_field_has_its_row():
    """Of design and scenario, in the table of symbols."""
    table = PAGE.partition("## Symbols and fields")[2]
    named = {name for row in table.splitlines() if row.startswith("|") for name in re.findall(r"`([^`]+)`", row)}
    assert set(addresses(table2(), Scenario())) <= named

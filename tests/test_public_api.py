"""The public names and their signatures are those of tests/public_api.txt."""

import difflib

import public_api

HOW = (
    "The public interface changed. If that is meant: keep old names working by jaxbuffer.deprecation until the next "
    "major release, name the change in CHANGELOG.md, and write the table anew by "
    "`PYTHONPATH=src python tests/public_api.py`.\n"
)


def test_the_public_interface_is_that_of_the_table():
    table = public_api.TABLE.read_text(encoding="utf-8").splitlines()
    changes = list(difflib.unified_diff(table, list(public_api.lines()), "the table", "the package", lineterm="", n=0))
    assert not changes, HOW + "\n".join(changes)


def test_the_table_says_names_parameters_members_and_fields():
    table = public_api.TABLE.read_text(encoding="utf-8")
    assert "\ntable2() -> Design\n" in table
    assert "\nclass Variable(path: str, low: float, high: float, scale: str = 'log')\n" in table
    assert "\nclass Outcome: " in table and "\n    field buffer.k_A\n" in table and "\n    to_dataframe(self)" in table
    assert " at 0x" not in table and "/" not in table

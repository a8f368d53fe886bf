"""What a field declares of itself is what the docstring of its part says."""

import pytest

import jaxbuffer as jb
from jaxbuffer.fields import NON_NEGATIVE, POSITIVE, Part, choice, flag, number


class Clamp(Part):
    """A clamp.

    **Example:** none.
    """

    section = "clamp"
    force: float = number(1.0, "N", **POSITIVE, doc="force with which it holds")
    share: float = number(0.5, "-", low=0.0, high=1.0, high_open=True, doc="share of its way")
    kind: str = choice("soft", "soft", "hard", doc="how it is made")
    mode: str = choice("in", "in", "out", doc="in: inwards; out: outwards")
    locked: bool = flag(False, doc="whether it is locked")
    unsaid: float = number(0.0, "m", **NON_NEGATIVE)


def test_each_field_has_a_line_with_its_meaning_unit_and_range():
    assert Clamp.__doc__ == (
        "A clamp.\n\n"
        "- ``force``: force with which it holds [N] (above 0).\n"
        "- ``share``: share of its way [-] (at least 0, below 1).\n"
        "- ``kind``: how it is made (one of soft, hard).\n"
        "- ``mode``: in: inwards; out: outwards.\n"
        "- ``locked``: whether it is locked.\n\n"
        "**Example:** none."
    )


@pytest.mark.parametrize("part", [type(jb.table2().probe), type(jb.table2().latch), jb.BarDropScenario], ids=str)
def test_the_programs_parts_list_every_field_once(part):
    for name in part.__annotations__:
        if name != "section":
            assert part.__doc__.count(f"- ``{name}``: ") == 1, name

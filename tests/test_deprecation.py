"""Names of earlier releases work and warn; what they were is named by none today."""

import re

import pytest

import jaxbuffer as jb
from jaxbuffer import deprecation
from jaxbuffer.deprecation import Renamed, by_former_name, renamed_keywords

LENGTH = Renamed("stroke", since="1.1", removed="2.0")
WARNING = "is deprecated since jaxbuffer 1.1 and goes in 2.0: use stroke"


@renamed_keywords(length=LENGTH)
def energy(stroke, stiffness=500.0):
    return 0.5 * stiffness * stroke**2


def test_an_old_keyword_is_passed_on_and_warned_of_where_the_user_wrote_it():
    with pytest.warns(FutureWarning, match=f"^length of energy {WARNING}$") as caught:
        assert energy(length=0.02) == energy(0.02) == energy(stroke=0.02)
    assert len(caught) == 1 and caught[0].filename == __file__


def test_an_old_and_a_new_keyword_at_once_are_refused():
    with pytest.warns(FutureWarning), pytest.raises(TypeError, match="both length and stroke"):
        energy(length=0.02, stroke=0.02)


def test_an_old_public_name_is_the_new_one(monkeypatch):
    renamed = {"table_two": Renamed("table2", since="1.1", removed="2.0")}
    monkeypatch.setattr("jaxbuffer.deprecation.by_former_name", lambda name: by_former_name(name, renamed))
    with pytest.warns(FutureWarning, match=r"^jaxbuffer\.table_two .* use table2$"):
        assert jb.table_two is jb.table2
    with pytest.raises(AttributeError):
        jb.table_three  # noqa: B018


def test_every_old_name_leads_to_one_that_is_there_and_goes_in_a_later_major_release():
    for old, it in deprecation.NAMES.items():
        assert old not in jb.__all__ and it.new in jb.__all__
        assert re.fullmatch(r"\d+\.0", it.removed) and int(it.removed[:-2]) > int(it.since.split(".")[0])

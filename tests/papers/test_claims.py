"""Claims as tables: numbers of rows, the sentence that says them, the parts that must hold."""

import numpy as np
import pytest

from jaxbuffer.papers import PAPERS, paper_named
from jaxbuffer.papers.claims import NO, OPEN, PARTLY, YES, Claim, cell, column, either, joined, listed, near

ROWS = {
    "drop": ({"case": "slow", "force": 200.0, "touches": 1}, {"case": "fast", "force": 412.0, "touches": 3}),
    "drop_published": ({"case": "slow", "force": 100.0, "touches": 1}, {"case": "fast", "force": 90.0, "touches": 1}),
}
FORCE, TOUCHES = column("drop", "force"), column("drop", "touches")


@pytest.mark.parametrize(
    ("holds", "verdict"),
    [
        ((), OPEN),
        ((FORCE[1] > FORCE[0],), YES),
        ((near(FORCE, (200.0, 433.0)),), PARTLY),
        ((near(FORCE, 500.0), False), NO),
        ((either((near(FORCE[0], 500.0), near(FORCE[1], 410.0))),), YES),
        ((~near(cell("drop", 0, "force"), 199.0), column("drop", "case") == "slow"), PARTLY),
    ],
)
def test_a_claim_holds_if_all_of_its_parts_do_in_every_case(holds, verdict):
    assert Claim("", "", "", (), holds).judge(ROWS).verdict == verdict


def test_a_sentence_has_a_place_for_each_value_and_lists_those_of_several_cases():
    values = (1e-3 * FORCE, TOUCHES, listed("{} {:.0f}", column("drop", "case"), np.maximum(FORCE, 300.0), joint="; "))
    finding = Claim("", "", "{:.2f} kN, {} touches: {}", values).judge(ROWS).finding
    assert finding == "0.20, 0.41 kN, 1, 3 touches: slow 300; fast 412"


def test_cases_are_taken_by_slice_place_or_test():
    taken = (
        column("drop", "force", slice(1, None)),
        column("drop", "force", (1, 0)),
        column("drop", "force", lambda row: row["case"] == "fast"),
    )
    assert [list(value.of(ROWS)) for value in taken] == [[412.0], [412.0, 200.0], [412.0]]
    assert list(joined(*taken[:2], TOUCHES[0]).of(ROWS)) == [412.0, 412.0, 200.0, 1.0]


def test_the_same_claim_reads_other_studies():
    rising = Claim("", "", "{:.0f} N", (FORCE,), (FORCE[1] > FORCE[0],))
    assert rising.judge(ROWS) == ("200, 412 N", YES)
    assert rising._replace(suffix="_published").judge(ROWS) == ("100, 90 N", NO)


def test_every_sentence_has_as_many_places_as_values():
    for name in PAPERS:
        for part in (*paper_named(name).parts, *paper_named(name).published):
            for claim in part.claims:
                assert claim.finding.count("{") == len(claim.values), claim.claim

"""The drop onto the empty tank in felupe: another program's elements, masses, contact and steps."""

import pytest

pytest.importorskip("felupe", reason="felupe is not installed: pip install 'jaxbuffer[verify]'")

from verification.second_opinion.dropped_tank import (
    DURATION,
    NOTICED,
    SCENARIO,
    Dropped,
    altered,
    case,
    deviations,
    dropped,
    extrapolated,
)
from verification.second_opinion.felupe_drop import dropped as dropped_by_felupe

BOUND = 1e-3


@pytest.fixture(scope="module")
def found():
    """Ours on two meshes, and theirs: of elements across, and of steps, one has more, then the other."""
    theirs = [dropped_by_felupe(case(1), SCENARIO, DURATION, *given) for given in ((2, 1000), (3, 500))]
    return [dropped(fine) for fine in (2, 4)], theirs


@pytest.mark.slow
@pytest.mark.parametrize("name", Dropped._fields)
def test_two_meshes_converge_to_felupes_drop(found, name):
    ours, theirs = found
    coarse, fine = (abs(getattr(deviations(one, theirs[1]), name)) for one in ours)
    assert abs(getattr(deviations(*theirs), name)) < 0.6 * BOUND
    assert coarse < 6e-3 and fine < 2.5e-3
    assert abs(getattr(deviations(extrapolated(*ours), theirs[1]), name)) < BOUND


@pytest.mark.slow
def test_two_per_cent_of_any_property_would_be_noticed():
    as_it_is = dropped(1)
    for name in NOTICED:
        moved = deviations(dropped(1, altered(name)), as_it_is)
        assert max(map(abs, moved)) > 2.5 * BOUND, name

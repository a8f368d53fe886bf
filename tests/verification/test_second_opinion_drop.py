"""Drops onto the tank, empty, with liquid, with plates and until the wall yields, in felupe: another program's
elements, masses and steps."""

import pytest

pytest.importorskip("felupe", reason="felupe is not installed: pip install 'jaxbuffer[verify]'")

from verification.second_opinion.dropped_tank import (
    DRY,
    FLOWING,
    NOTICED,
    WET,
    altered,
    apart,
    deviations,
    dropped,
    extrapolated,
)
from verification.second_opinion.felupe_drop import dropped as dropped_by_felupe

BOUND = 1e-3
WITHIN = {  # of the finer mesh
    "liquid": {
        "force": 5e-3,
        "travel": 2e-3,
        "deflection": 4e-3,
        "impulse": 2e-3,
        "speed": 2e-3,
        "energy": 2.5e-2,
        "pressed": 2.5e-2,
    },
    "plates": {"force": 2e-3, "travel": 1e-3, "deflection": 1.5e-2, "impulse": 2.5e-3, "speed": 3e-3},
    "yielding": {
        "force": 6e-3,
        "travel": 1.2e-2,
        "deflection": 8e-3,
        "impulse": 2e-3,
        "speed": 6e-3,
        "plastic_work": 6e-3,
    },
}
TOPIC, SOURCE = "Drop onto a tank", "felupe"


@pytest.fixture(scope="module")
def found():
    """Of the empty tank, ours on two meshes, and theirs: of elements across, and of steps, one has more, then the
    other."""
    theirs = [dropped_by_felupe("empty", *given) for given in ((2, 1000), (3, 500))]
    return [dropped(fine) for fine in (2, 4)], theirs


@pytest.mark.slow
@pytest.mark.parametrize("name", DRY)
def test_two_meshes_converge_to_felupes_drop(found, evidence, name):
    ours, theirs = found
    coarse, fine = (abs(deviations(one, theirs[1])[name]) for one in ours)
    assert abs(deviations(*theirs)[name]) < 0.6 * BOUND
    assert coarse < 6e-3 and fine < 2.5e-3
    off = abs(deviations(extrapolated(*ours), theirs[1])[name])
    evidence(TOPIC, f"empty tank, {name}, extrapolated", off, BOUND, SOURCE)


@pytest.mark.slow
def test_liquid_and_wall_move_together_as_felupes_do(evidence):
    """Theirs is implicit, of second order along elements, and follows a potential in place of the pressure; "pressed"
    is the pressure in the middle of the bottom over time, integrated."""
    ours, theirs = dropped(2, "liquid"), dropped_by_felupe("liquid", 2, 150)
    off = {name: abs(value) for name, value in deviations(ours, theirs, WET).items()} | {"pressed": apart(ours, theirs)}
    for name, within in WITHIN["liquid"].items():
        evidence(TOPIC, f"tank with liquid, {name}", off[name], within, SOURCE)


@pytest.mark.slow
def test_plates_in_motion_are_felupes(evidence):
    """Joints have no fillet: the deflection, which they decide, converges most slowly."""
    theirs = dropped_by_felupe("plates", 2, 150)
    coarse, fine = ({k: abs(v) for k, v in deviations(dropped(n, "plates"), theirs).items()} for n in (1, 2))
    assert coarse["deflection"] > 2.5 * fine["deflection"] and coarse["speed"] > 2.5 * fine["speed"]
    for name, within in WITHIN["plates"].items():
        evidence(TOPIC, f"tank with plates, {name}", fine[name], within, SOURCE)


@pytest.mark.slow
def test_a_wall_that_yields_flows_as_felupes_does(evidence):
    """Small strains, since felupe's flow is for these; one element across the wall is too stiff."""
    theirs = dropped_by_felupe("yielding", 2, 500)
    coarse, fine = (deviations(dropped(n, "yielding"), theirs, FLOWING) for n in (1, 2))
    assert all(abs(coarse[name]) > 4.0 * abs(fine[name]) for name in ("deflection", "plastic_work"))
    for name, within in WITHIN["yielding"].items():
        evidence(TOPIC, f"tank that yields, {name}", abs(fine[name]), within, SOURCE)


@pytest.mark.slow
def test_two_per_cent_of_any_property_would_be_noticed():
    as_it_is = dropped(1)
    for name in NOTICED["empty"]:
        moved = deviations(dropped(1, changed=altered("empty", name)), as_it_is)
        assert max(map(abs, moved.values())) > 2.5 * BOUND, name


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "figure"), [("liquid", "pressed"), ("plates", "deflection"), ("yielding", "plastic_work")]
)
def test_five_per_cent_of_density_of_liquid_place_of_plates_and_yield_stress_would_be_noticed(name, figure):
    (field,), as_it_is = NOTICED[name], dropped(1, name)
    other = dropped(1, name, altered(name, field, 0.05))
    off = apart(other, as_it_is) if figure == "pressed" else abs(deviations(other, as_it_is, [figure])[figure])
    assert off > 1.5 * WITHIN[name][figure]

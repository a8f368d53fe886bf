"""A plate that yields round a hole, in felupe: another program's elements, return mapping and tangent."""

import pytest

pytest.importorskip("felupe", reason="felupe is not installed: pip install 'jaxbuffer[verify]'")

from verification.second_opinion.pulled_plate import HARDENING, Pulled, deviations, pulled, pulled_by_felupe

BOUND = {"force": 4e-3, "narrowed": 5e-3, "work": 1e-3}
TOPIC = "Finite elements, liquid and contact"


@pytest.fixture(scope="module")
def found():
    """Ours on two meshes, and theirs."""
    return pulled(8), pulled(16), pulled_by_felupe(12)


@pytest.mark.slow
@pytest.mark.parametrize("name", Pulled._fields)
def test_a_plate_with_a_hole_yields_there_and_back_as_felupes_does(found, evidence, name):
    coarse, fine = (getattr(deviations(one, found[-1]), name) for one in found[:2])
    assert coarse > 2.5 * fine, "meshes converge"
    claim = f"a plate that yields round a hole, there and back: {name}"
    evidence(TOPIC, claim, fine, BOUND[name], "felupe's material of isotropic hardening")


@pytest.mark.slow
def test_five_per_cent_of_hardening_would_be_noticed(found):
    off = deviations(pulled(8, 1.05 * HARDENING), found[0])
    assert off.force > 1.5 * BOUND["force"]

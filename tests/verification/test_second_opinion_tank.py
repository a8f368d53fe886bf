"""The tank's wall in felupe: another program's elements, mesh and geometry, under large displacements."""

import pytest

pytest.importorskip("felupe", reason="felupe is not installed: pip install 'jaxbuffer[verify]'")

from verification.second_opinion.bent_tank import Bent, bent, empty_tank
from verification.second_opinion.felupe_tank import bent as bent_by_felupe

LOADS = (50.0, 1000.0)  # N/m²: the top comes down by 2 mm and by 45 mm, of a wall of 5 mm
YOUNG = 1e9  # Pa


@pytest.fixture(scope="module")
def found():
    """By load, ours on three meshes and theirs on two."""
    ours = [bent(empty_tank(fine), LOADS) for fine in (1, 2, 4)]
    theirs = [[bent_by_felupe(empty_tank(1), load, fine) for load in LOADS] for fine in (3, 4)]
    return {load: ([mesh[k] for mesh in ours], [mesh[k] for mesh in theirs]) for k, load in enumerate(LOADS)}


@pytest.mark.slow
@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("name", Bent._fields)
def test_three_meshes_converge_to_felupes(found, load, name):
    """The error is of second order in the mesh, so that two meshes give a better value together. Stresses differ by as
    much as the wall strains, since felupe's law is neo-Hookean and ours is linear in the logarithmic strain."""
    ours, theirs = found[load]
    coarse, middle, fine = (getattr(one, name) / getattr(theirs[-1], name) - 1.0 for one in ours)
    assert abs(getattr(theirs[0], name) / getattr(theirs[1], name) - 1.0) < 6e-4
    assert abs(coarse) < 0.06 and abs(middle) < 0.008 and abs(fine) < 0.0025
    strain = theirs[-1].stress / YOUNG if name == "stress" else 0.0
    assert abs((4.0 * fine - middle) / 3.0) < 1e-3 + strain

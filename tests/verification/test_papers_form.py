"""The docking paper's own form D(y) y' = F(y), its eq. 15 to 17, by IDA: the joints' multipliers are unknowns of their
own, and a solver of backward differences, as the paper's ode15s is, takes the system whole."""

import pytest

pytest.importorskip("numba", reason="numba is not installed: pip install 'jaxbuffer[bench]'")
pytest.importorskip("sksundae", reason="scikit-sundae is not installed: pip install 'jaxbuffer[bench]'")

from benchmarks.accuracy import TARGET, errors
from benchmarks.peers.reference import load
from benchmarks.peers.solvers import solve
from benchmarks.plan import REFERENCES

CASES = {case.name: case for case in load(REFERENCES)}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["table2", "table2-rolling"])
def test_backward_differences_on_the_papers_own_form(name, evidence):
    case = CASES[name]
    found = solve("IDA", case.parameters, 1e-7, 1e-9)
    assert (found.outcome, found.impacts) == (case.outcome, case.impacts)
    assert found.peak_time == pytest.approx(case.peak_time, abs=1e-6)
    for quantity, error in errors(found, case).items():
        claim = f"{quantity.replace('_', ' ')} by IDA on D(y) y' = F(y)"
        evidence("Whole captures", claim, error, TARGET, "captures of an independent solver at rtol 1e-10", detail=name)

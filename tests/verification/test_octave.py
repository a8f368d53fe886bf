"""GNU Octave's ode15s on the docking paper's own form D(y) y' = F(y), its eq. 15 to 17, where Octave is installed."""

import shutil

import pytest

if not any(map(shutil.which, ("octave-cli", "octave"))):
    pytest.skip("no Octave on the path (apt install octave): ode15s was not run", allow_module_level=True)
pytest.importorskip("numba", reason="numba is not installed: pip install 'jaxbuffer[bench]'")

from benchmarks.accuracy import TARGET, errors
from benchmarks.capture import OCTAVE_SETTINGS
from benchmarks.peers import octave
from benchmarks.peers.reference import load
from benchmarks.plan import REFERENCES


@pytest.mark.slow
def test_ode15s_on_the_papers_own_form(evidence):
    """Table 2, with the multipliers as rates of unknowns of their own: 28 unknowns, as in the paper."""
    case = load(REFERENCES)[0]
    found = octave.capture(case.parameters, *OCTAVE_SETTINGS[0], runs=1).capture
    assert found.outcome == case.outcome
    for name, error in errors(found, case).items():
        claim = f"{name.replace('_', ' ')} by Octave's ode15s on D(y) y' = F(y)"
        evidence("Whole captures", claim, error, TARGET, "captures of an independent solver at rtol 1e-10")

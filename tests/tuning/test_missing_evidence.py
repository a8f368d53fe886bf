"""Nothing that is computed after a search may lose what it has found."""

from types import SimpleNamespace

import numpy as np
import pytest

from jaxbuffer import InputError, Outcome, Problem, Scenario, Variable, load, table2
from jaxbuffer.tuning import tune as module
from jaxbuffer.tuning.search import checks
from jaxbuffer.tuning.search.checks import lower_bound
from jaxbuffer.tuning.search.measurement import Measurement
from jaxbuffer.tuning.tune import tune
from tuning.analytic import Functions, problem

PARTS = {
    "lower_bound": "the lower bound of the peak force",
    "run_corners": "the design in the corners of what scatters",
}


@pytest.fixture
def functions(monkeypatch):
    stated = problem([1.0, 1.0], [3.0, 3.0], [2.0, 2.0])
    made = Functions(stated, [[lambda x: (x[0] - 1.5) ** 2 + (x[1] - 2.5) ** 2 + 20.0]])
    monkeypatch.setattr(module, "Evaluator", lambda *_: made)
    for name in PARTS:
        monkeypatch.setattr(f"jaxbuffer.tuning.assessment.{name}", lambda *_: None)
    return made


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("error", [InputError("duration = 0 s is out of range"), RuntimeError(""), ValueError("a\nb")])
def test_evidence_that_fails_loses_no_design(functions, monkeypatch, tmp_path, part, error):
    """The design is in the folder before the evidence is computed; the result says which part is missing, and why."""
    texts = []

    def fails(*_):
        texts.extend(path.read_text() for path in tmp_path.glob("design.toml"))
        raise error

    monkeypatch.setattr(f"jaxbuffer.tuning.assessment.{part}", fails)
    tuned = tune(functions.problem, starts=2, folder=tmp_path)
    assert texts == [(tmp_path / "design.toml").read_text()]
    why = (str(error) or "RuntimeError").splitlines()[0]
    line = f"missing: {PARTS[part]}, which could not be computed: {why}"
    assert tuned.missing == (line,) and tuned.feasible
    assert line in load(tmp_path).tuned["outside_validity"] and line in " ".join(repr(tuned).split())
    # A resumed run computes what is missing.
    monkeypatch.setattr(f"jaxbuffer.tuning.assessment.{part}", lambda *_: None)
    resumed = tune(functions.problem, starts=2, folder=tmp_path, resume=True)
    assert resumed.missing == () and resumed.objective == tuned.objective


def test_a_run_that_ends_where_it_starts_has_a_lower_bound_of_nothing(monkeypatch):
    """A free start that has left the cone at once ends at 0 s and touches nothing: no run can have that duration."""
    stated = Problem(table2(), [Scenario(start="free")], [Variable("buffer.k_A", 100.0, 2000.0)], duration=1.0)
    gone = SimpleNamespace(outcome=Outcome.escaped, end_time=0.0, impact_count=0)
    nothing = Measurement.lost(stated)._replace(
        code=int(Outcome.escaped), peaks=np.zeros(24), slots=np.arange(24), peaks_slope=np.zeros((24, 1))
    )

    def measured(*_, duration, **options):
        assert duration > 0.0
        return nothing

    monkeypatch.setattr(checks, "simulate", lambda *_, **options: gone)
    monkeypatch.setattr(checks, "measure", measured)
    bound = lower_bound(stated, stated.start())
    assert np.all(bound.simulated == 0.0) and bound.lowest == 0.0

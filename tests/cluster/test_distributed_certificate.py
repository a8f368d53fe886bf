"""A certificate over a scheduler: its solves are tasks, and it is the one that threads make."""

from types import SimpleNamespace

import jax
import numpy as np
import pytest

import jaxbuffer as jb
from in_short import often
from jaxbuffer import InputError
from jaxbuffer.cluster.connect import connected
from jaxbuffer.hybrid.rungekutta.solvers import Automatic
from jaxbuffer.sensitivities.differences import FIRST
from jaxbuffer.sensitivities.gradients import Gradients
from made_up import made_up_capture

PATHS, TRUE = ("buffer.k_A", "buffer.c_A", "probe.tip_mass"), np.array([0.3, -0.05, 0.2])
START = np.array([jb.get(jb.table2(), path) for path in PATHS])


@pytest.fixture(scope="module")
def executor():
    """Two threads of this process."""
    with connected("local", 2) as client:
        yield client.get_executor()


def force(design):
    """A peak that is a product of powers: its elasticities are the exponents."""
    now = np.array([float(jb.get(design, path)) for path in PATHS])
    return 250.0 * float(np.prod((now / START) ** TRUE))


def on_a_worker():
    from distributed import get_worker

    try:
        return bool(get_worker())
    except ValueError:
        return False


@pytest.fixture
def solved(monkeypatch):
    """Solves without the wait: ``told`` what each was and whether it was a task; the elasticities ``claimed``."""
    found = SimpleNamespace(told=[], claimed=TRUE)

    def simulate(design, scenario, duration, rtol, solver):
        found.told.append(("tight", on_a_worker()))
        return made_up_capture(peak=force(design), design=design)

    def gradients(mechanism, design, scenario, paths, values, duration, *, rtol, solver, names):
        found.told.append((rtol, on_a_worker()))
        run = made_up_capture(peak=force(design), design=design)
        rows = np.zeros((len(run.mechanism.quantities), len(paths)))
        rows[list(run.mechanism.quantities).index("peak_force")] = found.claimed * float(run.peak_force) / values
        return Gradients(run, rows[:, 0], rows, {"peak_force": np.zeros((3, len(paths)))})

    monkeypatch.setattr("jaxbuffer.sensitivities.evidence.simulate", simulate)
    monkeypatch.setattr("jaxbuffer.sensitivities.sensitivity.gradients", gradients)
    return found


def asked(executor, **options):
    return jb.sensitivity(jb.table2(), wrt=PATHS, quantities=["peak_force"], executor=executor, **options)


def same(one, other):
    leaves, others = jax.tree.leaves(one), jax.tree.leaves(other)
    return len(leaves) == len(others) and all(
        np.array_equal(a, b) if np.asarray(a).dtype.kind in "OU" else np.array_equal(a, b, equal_nan=True)
        for a, b in zip(leaves, others, strict=True)
    )


@pytest.mark.parametrize(
    ("certify", "tight"), [("quick", 2 * FIRST), ("thorough", 2 * FIRST * len(PATHS)), ("none", 0)]
)
def test_every_solve_is_a_task_and_the_result_is_the_same(executor, solved, certify, tight):
    found = asked(executor, certify=certify)
    tolerances = [1e-6] if certify == "none" else [1e-7, 1e-6]
    assert all(task for _, task in solved.told)
    assert sorted(what for what, _ in solved.told if what != "tight") == pytest.approx(tolerances)
    assert [what for what, _ in solved.told].count("tight") == tight
    np.testing.assert_allclose(found.elasticities, [TRUE], rtol=1e-12)
    solved.told.clear()
    here = asked(None, certify=certify)
    assert not any(task for _, task in solved.told) and same(here, found)
    if certify != "none":
        assert found.certificate.verdict is jb.Verdict.trusted and found.certificate.solves == tight


def test_a_wrong_slope_is_found_by_workers_too(executor, solved):
    """By 10 % in one of three elasticities."""
    solved.claimed = TRUE * [1.1, 1.0, 1.0]
    found = asked(executor, certify="thorough")
    assert found.certificate.verdict is jb.Verdict.check
    np.testing.assert_allclose(found.certificate.error, [[0.1 / 1.1, 0.0, 0.0]], atol=1e-5)


def test_what_can_not_be_asked_of_an_executor(executor, solved):
    with pytest.raises(InputError, match="cannot be sent to another process; name one of automatic"):
        asked(executor, solver=Automatic(worth=3.0))
    with pytest.raises(InputError, match=r"executor = 'local' is no concurrent\.futures\.Executor, as in"):
        asked("local")
    assert asked(None, solver=Automatic(worth=3.0), certify="none").certificate is None
    assert len(solved.told) == 1


def test_what_a_worker_refuses_is_said_as_here(executor, solved, monkeypatch):
    def bad(*arguments, **options):
        raise InputError("k_A and c_A don't go together")

    monkeypatch.setattr("jaxbuffer.sensitivities.evidence.simulate", bad)
    with pytest.raises(InputError, match="don't go together"):
        asked(executor)


@pytest.mark.slow
@pytest.mark.parametrize("where", often(["local", "processes"], "processes"))
def test_the_real_one_has_the_same_bits(where):
    asked = jb.BarDrop(), jb.BarDropScenario(height=0.1), ["impact.stiffness", "scenario.height"], 0.16
    here = jb.sensitivity(*asked, certify="thorough")
    with connected(where, 2) as client:
        there = jb.sensitivity(*asked, certify="thorough", executor=client.get_executor())
    assert here.certificate.solves >= 2 * 2 * FIRST and same(here, there)

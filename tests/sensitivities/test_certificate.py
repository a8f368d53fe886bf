"""Verdicts from evidence: what is trusted, what must be checked, what is refused, and the peaks' report."""

import numpy as np
import pytest

import jaxbuffer as jb
import jaxbuffer.sensitivities.sensitivity as module
from jaxbuffer import Outcome
from jaxbuffer.mechanisms.impacts import Impacts
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.sensitivities.certificate import FLOOR, HOPELESS, KINK, TRUSTED, Peaks, Verdict, judge, peak_report
from jaxbuffer.sensitivities.evidence import Evidence, TightSolve, course_of, each, together
from made_up import made_up_capture

PATHS = ("buffer.k_A", "buffer.c_A", "probe.tip_mass")
NAMES = ("peak_force", "stroke")
ELASTICITIES = np.array([[0.3, -0.05, 0.002], [-0.8, 0.1, 0.0]])
FAR = Peaks(250.0, 0.02, 1, 0, 2, 200.0, 0.2, "buffer.k_A", -0.4)
NEAR = Peaks(250.0, 0.02, 1, 0, 2, 249.9, 4e-4, "buffer.k_A", -2e-3)


class Solves:
    """Stands in for tight solves: powers of the parameters, with their true elasticities."""

    def __init__(self, truth=ELASTICITIES):
        self.truth, self.known = truth, {}

    def inside(self, direction, move):
        return True

    def after(self, moves):
        return [self.known.setdefault((move[0].tobytes(), move[1]), self.moved(*move)) for move in moves]

    def moved(self, direction, move):
        return np.exp(self.truth @ np.log1p(move * direction))


def certified(claimed, gather=together, changes=0.0, peaks=FAR, truth=ELASTICITIES, capture=None):
    evidence = gather(Solves(truth), claimed, np.ones(2), np.full(claimed.shape, changes))
    return judge(capture or made_up_capture(), NAMES, PATHS, claimed, evidence, peaks)


@pytest.mark.parametrize("gather", [together, each])
def test_right_gradients_are_trusted(gather):
    certificate = certified(ELASTICITIES, gather)
    assert certificate.verdict == Verdict.trusted and certificate.verdicts == (Verdict.trusted,) * 2
    assert np.all(certificate.error < TRUSTED)
    assert certificate.reason.startswith("two tolerances and differences of tight solves agree within")


@pytest.mark.parametrize("gather", [together, each])
@pytest.mark.parametrize("parameter", range(3))
def test_one_elasticity_off_by_a_per_cent_is_found_by_either_kind(gather, parameter):
    claimed = ELASTICITIES.copy()
    claimed[0, parameter] *= 1.01
    certificate = certified(claimed, gather)
    assert certificate.verdicts == (Verdict.check, Verdict.trusted)
    whose = "an elasticity of peak_force" if gather is together else f"peak_force by {PATHS[parameter]}"
    assert certificate.reason.startswith(f"{whose} may be off by") and certificate.reason.endswith(
        "by differences of tight solves"
    )
    assert certificate.error[0, parameter] > 0.9e-2


@pytest.mark.parametrize("quantity", range(2))
@pytest.mark.parametrize("parameter", range(3))
def test_no_quantity_is_diluted_by_one_that_others_change(quantity, parameter):
    """The first parameter alone changes the one quantity much, the last alone the other: no direction suits both."""
    truth = np.array([[1.0, 0.02, 0.01], [0.01, 0.02, 1.0]])
    claimed = truth.copy()
    claimed[quantity, parameter] *= 1.01
    certificate = certified(claimed, truth=truth)
    assert certificate.verdicts[quantity] == Verdict.check and certificate.verdicts[1 - quantity] == Verdict.trusted
    assert certificate.error[quantity, parameter] > 0.9e-2
    assert certified(truth, truth=truth).verdict == Verdict.trusted


@pytest.mark.parametrize("gather", [together, each])
def test_a_wrong_sign_is_refused(gather):
    certificate = certified(ELASTICITIES * np.array([[1.0, -1.0, 1.0], [1.0, 1.0, 1.0]]), gather)
    assert certificate.verdicts[0] == Verdict.refused and np.max(certificate.error[0]) > HOPELESS


def test_gradients_that_change_with_the_tolerance_must_be_checked():
    certificate = certified(ELASTICITIES, changes=1e-4)
    assert certificate.verdict == Verdict.check
    assert certificate.reason == "peak_force by probe.tip_mass may be off by 5 %, by its change with the tolerance"


@pytest.mark.parametrize(("share", "verdict"), [(0.48, Verdict.check), (0.52, Verdict.refused)])
def test_from_half_of_an_elasticity_on_it_is_refused(share, verdict):
    assert certified(ELASTICITIES, changes=share * 0.002).verdicts[0] == verdict


def test_a_kink_nearby_must_be_checked_and_says_which_impact():
    certificate = certified(ELASTICITIES, peaks=NEAR)
    assert certificate.verdicts == (Verdict.check, Verdict.trusted) and abs(NEAR.swap_change) < KINK
    assert certificate.reason == (
        "peak_force has a kink nearby: impact 3 comes within 0.04 % of the peak, "
        "and -0.2 % of buffer.k_A would swap them"
    )


def test_a_function_with_a_kink_at_the_steps_is_not_trusted():
    class Bent(Solves):
        def moved(self, direction, move):
            return super().moved(direction, move) + 0.3 * max(move, 0.0)

    evidence = each(Bent(), ELASTICITIES, np.ones(2), np.zeros(ELASTICITIES.shape))
    assert judge(made_up_capture(), NAMES, PATHS, ELASTICITIES, evidence, FAR).verdict > Verdict.trusted


def test_without_differences_nothing_is_trusted():
    class Hemmed(Solves):
        def inside(self, direction, move):
            return False

    evidence = each(Hemmed(), ELASTICITIES, np.ones(2), np.zeros(ELASTICITIES.shape))
    certificate = judge(made_up_capture(), NAMES, PATHS, ELASTICITIES, evidence, FAR)
    assert certificate.verdict == Verdict.check and "no differences could be taken" in certificate.reason


def test_what_is_not_finite_is_refused():
    claimed = ELASTICITIES.copy()
    claimed[1, 2] = np.nan
    certificate = certified(claimed)
    assert certificate.verdicts == (Verdict.trusted, Verdict.refused)
    assert certificate.reason == "stroke or its gradient is not finite; the run has 1 impacts"


def test_a_failed_capture_is_refused_with_its_reason():
    capture = made_up_capture(outcome=Outcome.failed_step_size)
    certificate = judge(capture, NAMES, PATHS, np.full((2, 3), np.nan), None, None)
    assert certificate.verdict == Verdict.refused and certificate.reason == Outcome.failed_step_size.reason
    assert peak_report(capture, np.zeros((3, 3)), PATHS) is None


def test_the_peaks_report():
    """Impact 2 leads impact 1 by 4 %; k_A raises the one and lowers the other, so that 2 % less of it swaps them."""
    hits = Impacts(*(np.array([0.01, 0.02, 0.0]), np.array([0, 1, -1]), np.zeros(3), np.array([240.0, 250.0, 0.0])),
                   np.zeros(3), np.asarray(2))  # fmt: skip
    capture = made_up_capture()
    object.__setattr__(capture, "impacts", hits)
    object.__setattr__(capture, "peak_impact", np.asarray(1))
    slopes = np.array([[-240.0, 0.0, 24.0], [250.0, 0.0, 25.0], [0.0, 0.0, 0.0]])
    peaks = peak_report(capture, slopes, PATHS)
    assert (peaks.impact, peaks.contact, peaks.runner_up_impact, peaks.runner_up_force) == (1, 1, 0, 240.0)
    assert peaks.margin == pytest.approx(0.04)
    assert peaks.swap_path == "buffer.k_A" and peaks.swap_change == pytest.approx(np.sqrt(0.96) - 1.0)


def test_a_single_impact_has_no_runner_up():
    peaks = peak_report(made_up_capture(), np.ones((3, 3)), PATHS)
    assert (peaks.runner_up_impact, peaks.margin, peaks.swap_change) == (-1, 1.0, np.inf)


@pytest.mark.parametrize(("rtol", "other"), [(1e-6, 1e-7), (5e-13, 5e-12)])
def test_a_change_with_the_tolerance_is_taken_as_an_elasticity(monkeypatch, rtol, other):
    """Of slopes in units of quantity over parameter: times the parameter, over the quantity."""
    run, paths, names = made_up_capture(), ("buffer.k_A", "probe.rod_mass"), ("peak_force", "stroke")
    at = np.array([jb.get(jb.table2(), path) for path in paths])
    results = np.array([float(run.peak_force), float(run.stroke)])
    slopes, calls = np.array([[0.2, 3.0], [-1e-5, 2e-3]]), []
    apart = np.array([[1e-3, 2e-3], [4e-3, 8e-3]])  # of each elasticity's unit: d ln quantity / d ln parameter

    class Solved:
        def __init__(self, tolerance):
            calls.append(tolerance)
            self.run, self.by_impact = run, {"peak_force": np.zeros((3, 2))}
            self.slopes = slopes if tolerance == rtol else slopes + apart * results[:, None] / at

        def of(self, name):
            return self.slopes[names.index(name)]

    def gathered(tight, claimed, sizes, changes):
        np.testing.assert_allclose(claimed, slopes * at / results[:, None], rtol=1e-13)
        np.testing.assert_allclose(sizes, results, rtol=1e-15)
        return Evidence(changes, 0.0 * changes, 0.0 * changes, 0, False)

    monkeypatch.setattr(module, "gradients", lambda *_, rtol, solver, names: Solved(rtol))
    monkeypatch.setattr(module, "together", gathered)
    sensitivity = jb.sensitivity(jb.table2(), wrt=paths, quantities=names, rtol=rtol)
    np.testing.assert_allclose(sorted(calls), sorted([rtol, other]), rtol=1e-12)
    size = np.maximum(np.abs(sensitivity.elasticities), FLOOR)
    np.testing.assert_allclose(sensitivity.certificate.by_tolerance * size, apart, rtol=1e-10)


@pytest.mark.long
def test_a_parameter_at_its_bound_is_differenced_from_one_side():
    """Without an axial damper only more of it is possible."""
    design = jb.replace(jb.table2(), {"buffer.c_A": 0.0})
    sensitivity = jb.sensitivity(design, certify="thorough", quantities=("peak_force", "stroke"))
    assert sensitivity.certificate.verdict == Verdict.trusted
    assert np.all(np.isfinite(sensitivity.certificate.error)) and np.all(np.abs(sensitivity.gradients[:, 1]) > 1e-5)


def test_a_flank_touched_and_left_at_once_is_no_landmark():
    """Solves at two tolerances may find different numbers of impacts without force; the rest are the same ones."""

    def capture(flanks, forces):
        count = len(flanks)
        times = np.linspace(0.0, 0.1, count)
        hits = Impacts(times, np.array(flanks), np.zeros(count), np.array(forces), times, np.asarray(count))
        made = made_up_capture(peak=max(forces))
        object.__setattr__(made, "impacts", hits)
        return made

    run = capture([0, 1, 1, 0], [200.0, 1e-9, 250.0, 10.0])
    tight = TightSolve(PROBE_CONE, jb.table2(), jb.Scenario(), PATHS, NAMES, 8.0, None, int(run.code), course_of(run))
    assert tight.values_of(capture([0, 1, 0], [200.0, 251.0, 260.0]))[0] == 251.0
    assert np.isnan(tight.values_of(capture([0, 0, 1], [200.0, 20.0, 251.0]))[0])

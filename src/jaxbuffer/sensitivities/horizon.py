"""How many impacts of a run can be foretold: small differences grow from one to the next."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..errors import InputError
from ..mechanisms.run import Run
from ..run.simulate import simulate

TIGHT = 1e-9
CHANGE = 1e-3


class Horizon(NamedTuple):
    """``trusted``: how many impacts come before the first whose peak force changes by more than ``change`` [-] at the
    tolerance ``rtol``; ``impacts``: how many the run has; ``changes`` [-] of each that both solves have."""

    trusted: int
    impacts: int
    change: float
    rtol: float
    changes: Float[np.ndarray, " impacts"]

    def __str__(self) -> str:
        against = f"against rtol {self.rtol:g} their peak forces change by at most {self.change:g}"
        if self.trusted == self.impacts:
            return f"all {self.impacts} impacts can be trusted one by one: {against}"
        return f"the first {self.trusted} of {self.impacts} impacts can be trusted one by one: {against}"


def horizon(run: Run, rtol: float = TIGHT, change: float = CHANGE) -> Horizon:
    """Count the impacts of a run that can be trusted one by one: it is solved again more tightly, and they are
    compared.

    Of what comes after them only statistics mean something. The other solve uses the program that is compiled already.

    **Arguments:** ``run``: one at default settings but for tolerance, history and room for events; ``rtol`` of the
    other solve, at most a hundredth of the run's own; ``change`` of a peak force that is allowed [-].

    **Raises:** `InputError` for a failed run, a batch or a traced one.

    **Example:**

    >>> run = jb.simulate(jb.SliderCrank(), jb.SliderCrankScenario())
    >>> print(jb.horizon(run))
    the first 25 of 28 impacts can be trusted one by one: against rtol 1e-09 their peak forces change by at most 0.001
    """
    if run._many or run.outcome.failed:
        raise InputError("run: a horizon needs one run that did not fail")
    tight = simulate(
        run.design,
        run.scenario,
        float(run.end_time),
        rtol=rtol,
        history=run.history is not None,
        max_events=run._located.room,
        stabilisation=float(run.stabilisation),
    )
    ours, theirs = (_peaks(each) for each in (run, tight))
    count = min(len(ours[0]), len(theirs[0]))
    contact, force = ((a[:count], b[:count]) for a, b in zip(ours, theirs, strict=True))
    with np.errstate(divide="ignore", invalid="ignore"):
        # Impacts of different contacts are not the same impacts: nothing from there on can be compared.
        changes = np.where(contact[0] == contact[1], np.abs(force[0] / force[1] - 1.0), np.inf)
    # Written so that NaN counts as beyond.
    beyond = np.flatnonzero(~(changes <= change))
    return Horizon(int(beyond[0]) if beyond.size else count, len(ours[0]), change, rtol, changes)


def _peaks(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Return the contact and peak force [N] of each impact."""
    count = int(run.impacts.count)
    return np.asarray(run.impacts.contact)[:count], np.asarray(run.impacts.peak_force)[:count]

"""Throughput of a sweep over scenarios: the product's batch on this machine beside a pool of two processes of a peer.

Equal accuracy over a sweep: nine captures in ten within the target, on a sample whose exact values two peers at tight
tolerances agree on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from . import fresh, grid, ours
from .accuracy import RTOLS, TARGET, Numbers, Result, Setting, cheapest, errors, measured
from .figures import Check, Figure, Part, Ratio
from .peers.parameters import Parameters
from .peers.solvers import ABSOLUTE, solve, tolerances
from .plan import Plan

TIMES = 10.0  # [-] targets: times the rate of the pool of the best peer,
RATE = 600.0  # [1/s] captures,
MEMORY = 1024.0  # [MiB]
MOST = 0.9  # [-] part of the sample that must be within the target
AGREE = 1e-6  # [-] relative difference of two tight peers, above which a capture is too ill-conditioned to judge by
PEERS = ("compiled DOP853", "compiled RODAS", "compiled CVODE Adams", "compiled CVODE BDF")
SWEEP_RTOLS = RTOLS[2:]


class Chosen(NamedTuple):
    """The settings of both sides at equal accuracy."""

    own: Setting
    theirs: Setting
    sample: int  # captures judged by


def exact_sample(plan: Plan) -> tuple[list[Parameters], list[Result]]:
    """The sample's captures, without the ill-conditioned, and their exact values."""
    cases, values = [], []
    for case in plan.track(grid.parameters(16 if plan.quick else 40), "sweep, exact values of the sample"):
        first, second = (solve(peer, case, 1e-11, 1e-14) for peer in ("SciPy DOP853", "SciPy LSODA"))
        if max(errors(first, second).values()) <= AGREE:
            cases.append(case)
            values.append(Result(first.outcome, first.impacts, first.peak_force, first.end_time))
    return cases, values


def most(numbers: Sequence[Numbers], exact: Sequence[Result]) -> dict[str, float]:
    """The errors [-] that nine captures in ten don't exceed."""
    off = [errors(one, other) for one, other in zip(numbers, exact, strict=True)]
    return {name: float(np.quantile([one[name] for one in off], MOST, method="higher")) for name in ("peak", "end")}


def own_curve(cases: Sequence[Parameters], exact: Sequence[Result], plan: Plan) -> list[Setting]:
    """The product's settings on the sample."""
    scenarios = grid.own_scenarios(cases)

    def run(rtol: float) -> list[Result]:
        batch = ours.sweep(scenarios, rtol)
        return [ours.result(batch, place) for place in range(len(cases))]

    run(SWEEP_RTOLS[-1])  # compiles
    judge = partial(most, exact=exact)
    return [
        measured(f"{ours.NAME}, sweep", f"rtol {rtol:.0e}", partial(run, rtol), judge, rtol=rtol)
        for rtol in plan.track(SWEEP_RTOLS, "sweep, accuracy of jaxbuffer")
    ]


def peer_curve(
    peer: str, parts: tuple[float, float], cases: Sequence[Parameters], exact: Sequence[Result]
) -> Iterator[Setting]:
    """A peer's settings on the sample, up to the first that is not accurate."""

    def run(rtol: float) -> list[Numbers]:
        atol = tolerances(rtol, parts)
        return [solve(peer, case, rtol, atol) for case in cases]

    solve(peer, cases[0], 1e-5, 1e-7)  # compiles
    judge = partial(most, exact=exact)
    for rtol in SWEEP_RTOLS:
        label = f"rtol {rtol:.0e}, atol {parts[0]:g} and {parts[1]:g} of it"
        setting = measured(peer, label, partial(run, rtol), judge, peer=peer, rtol=rtol, parts=parts)
        yield setting
        if setting.error > TARGET:
            return


@cache
def chosen(plan: Plan) -> Chosen:
    """Find the settings on the sample; times count there only to choose among a side's own."""
    cases, exact = exact_sample(plan)
    own = cheapest([own_curve(cases, exact, plan)], TARGET)
    jobs = [(peer, parts) for peer in PEERS if peer in plan.peers for parts in ABSOLUTE[:: 2 if plan.quick else 1]]
    tracked = plan.track(jobs, "sweep, accuracy of the peers")
    theirs = cheapest([list(peer_curve(peer, parts, cases, exact)) for peer, parts in tracked], TARGET)
    if own is None or theirs is None:
        raise RuntimeError(f"no setting of {'a peer' if own else 'the product'} is accurate enough in a sweep")
    return Chosen(own, theirs, len(cases))


def measure(plan: Plan) -> Part:
    """Both sides, each in a fresh process."""
    pick = chosen(plan)
    count, peers_count = (200, 200) if plan.quick else (grid.SIZE, 1000)
    for side in plan.track(("product", "pool"), f"sweep, {count} captures"):
        if side == "product":
            mine = fresh.measured("sweep", captures=count, **pick.own.choice)
        else:
            theirs = fresh.measured("pool", captures=peers_count, **pick.theirs.choice)
    own = Figure("jaxbuffer, sweep", count / mine["seconds"], "1/s", pick.own.errors, pick.own.tolerances)
    pool = f"{pick.theirs.solver}, 2 processes"
    peer = Figure(pool, peers_count / theirs["seconds"], "1/s", pick.theirs.errors, pick.theirs.tolerances)
    ratio = Ratio("sweep/pool", "rate against a two-process pool of the best peer", own, peer, TIMES)
    checks = (
        Check(f"rate of {count} captures", own, RATE, at_least=True),
        Check(f"peak memory of {count} captures", Figure("jaxbuffer", mine["mebibytes"], "MiB"), MEMORY),
    )
    notes = (
        f"{MOST:.0%} of {pick.sample} sampled captures are within {TARGET:g}; the errors are those they don't exceed",
        f"the peer's rate is that of {peers_count} captures drawn from the same grid",
        f"first chunk, compilation included: {mine['first']:.1f} s; the pool needed {theirs['mebibytes']:.0f} MiB",
    )
    title = f"Sweep over approach speed, misalignment and offset, {count} captures"
    return Part("sweep", title, (ratio,), checks, notes=notes)

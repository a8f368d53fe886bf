"""Value and gradient of the peak force in five parameters: the product's derivative, the peers' differences."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from . import ours
from .accuracy import Setting, cheapest, measured, race
from .figures import Curve, Part, Plot, Ratio, milliseconds
from .peers.differences import search
from .peers.solvers import ABSOLUTE, solve
from .plan import Plan

TARGET = 1e-3  # [-] relative error of each of the five elasticities
TIMES = 15.0  # [-] target: times as fast as the quickest peer's differences
# Those that are driven from Python cost several times as much a capture.
PEERS = ("compiled DOP853", "compiled RODAS", "compiled CVODE Adams", "compiled CVODE BDF")


def own_curve(plan: Plan) -> list[Setting]:
    """The product's settings; the first call, which compiles, is not among them."""
    exact = plan.table2.elasticity

    def errors(numbers: Mapping[str, float]) -> dict[str, float]:
        return {name: abs(value / exact[name] - 1.0) for name, value in numbers.items()}

    ours.elasticities(ours.RTOLS[-1])
    return [
        measured(f"{ours.NAME}, derivative", f"rtol {rtol:.0e}", partial(ours.elasticities, rtol), errors, 2)
        for rtol in plan.track(ours.RTOLS, "gradient, jaxbuffer")
    ]


def peer_curves(plan: Plan) -> list[list[Setting]]:
    """What the peers' users would end up with."""
    parameters, exact = plan.table2.parameters, plan.table2.elasticity
    peers = [peer for peer in PEERS if peer in plan.peers]
    jobs = [(peer, parts) for peer in peers for parts in (ABSOLUTE[:1] if plan.quick else ABSOLUTE)]
    steps = {"steps": (1e-2, 3e-3)} if plan.quick else {}
    curves = []
    for peer, parts in plan.track(jobs, "gradient, peers' differences"):
        solve(peer, parameters, 1e-5, 1e-7)  # compiles
        curves.append(list(search(peer, parameters, exact, TARGET, parts, **steps)))
    return curves


def measure(plan: Plan) -> Part:
    """Search and compare."""
    mine, theirs = own_curve(plan), peer_curves(plan)
    pair = [cheapest([mine], TARGET), cheapest(theirs, TARGET)]
    ratios, notes = (), []
    if all(pair):
        own, peer = (milliseconds(setting) for setting in race(pair, 3 if plan.quick else 5))
        ratios = (Ratio("gradient/best-peer", "against the best peer's central differences", own, peer, TIMES),)
    else:
        notes.append(f"no setting within {TARGET:g} for " + ("the product" if pair[0] is None else "a peer"))
    curves = [
        Curve(curve[0].solver, tuple(s.seconds for s in curve), tuple(s.error for s in curve))
        for curve in (mine, *theirs)
        if curve
    ]
    plot = Plot(
        "gradient", "Value and five elasticities", "wall time [s]", "largest relative error [-]", tuple(curves), TARGET
    )
    title = f"Value and gradient in five parameters, each elasticity within {TARGET:g}"
    return Part("gradient", title, ratios, plots=(plot,), notes=tuple(notes))

"""One Table-2 capture: work-precision curves of the product and its peers, and the quickest at equal accuracy."""

from __future__ import annotations

from . import ours
from .accuracy import TARGET, Setting, cheapest, race
from .figures import Part, Plot, Ratio, milliseconds, precision_plot
from .peers import compiled
from .peers.timing import curves
from .plan import Plan

BEST_PEER = 4.0  # [-] targets: times as fast as the quickest of all peers, the compiled loops among them,
EXPLICIT = 0.5  # and not half as slow as the explicit method


def own_curves(plan: Plan) -> dict[str, list[Setting]]:
    """The product's curves by solver."""
    from jaxbuffer import table2

    names = ("default", "explicit") if plan.quick else tuple(ours.SOLVERS)
    return {
        name: list(ours.curve(name, table2(), plan.table2, plan.repeats))
        for name in plan.track(names, "Table-2 capture, jaxbuffer")
    }


def plots(curves_of: list[list[Setting]]) -> tuple[Plot, ...]:
    """Errors of peak force and end time over wall time."""
    return tuple(
        precision_plot(f"capture-{error}", f"One Table-2 capture, {name}", curves_of, error, TARGET)
        for error, name in (("peak", "peak force"), ("end", "end time"))
    )


def measure(plan: Plan) -> Part:
    """Run everybody."""
    mine = own_curves(plan)
    theirs = {
        peer: curves(peer, plan.table2.parameters, plan.table2, plan.repeats if plan.quick else 2)
        for peer in plan.track(plan.peers, "Table-2 capture, peers")
    }
    best = {name: cheapest([curve], TARGET) for name, curve in mine.items()}
    best |= {peer: cheapest(of_peer, TARGET) for peer, of_peer in theirs.items()}
    notes = [
        f"{name}: no setting within {TARGET:g} can be relied on" for name, choice in best.items() if choice is None
    ]
    if not compiled.HAS_CVODE:
        notes.append(compiled.MISSING)
    names = [name for name, choice in best.items() if choice is not None]
    timed = dict(zip(names, race([best[name] for name in names], plan.repeats), strict=True))
    ratios = []
    if "default" in timed:
        own = milliseconds(timed["default"])
        peers = sorted((timed[peer] for peer in theirs if peer in timed), key=lambda setting: setting.seconds)
        if peers:
            best_peer = milliseconds(peers[0])
            ratios.append(Ratio("capture/best-peer", "against the best peer", own, best_peer, BEST_PEER))
        # the best by its own name too: which one that is may change from run to run
        ratios += [Ratio(f"capture/{peer.solver}", f"against {peer.solver}", own, milliseconds(peer)) for peer in peers]
        for solver in ("implicit", "explicit"):
            if solver in timed:
                target = EXPLICIT if solver == "explicit" else None
                figure = milliseconds(timed[solver])
                ratios.append(Ratio(f"capture/{solver}", f"default against {solver}", own, figure, target))
    drawn = [*mine.values(), *(curve for of_peer in theirs.values() for curve in of_peer)]
    title = f"One Table-2 capture, peak force and end time within {TARGET:g}"
    return Part("capture", title, tuple(ratios), plots=plots(drawn), notes=tuple(notes))

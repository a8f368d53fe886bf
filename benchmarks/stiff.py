"""Stiff problems: the product's default against its explicit method, and against the peers at equal accuracy."""

from __future__ import annotations

from dataclasses import replace

from jaxbuffer import Design, table2
from jaxbuffer import replace as with_values

from . import ours
from .accuracy import RTOLS, TARGET, Setting, cheapest, errors, race
from .figures import Figure, Part, Plot, Ratio, milliseconds, precision_plot
from .peers.parameters import Parameters
from .peers.solvers import solve
from .peers.timing import curves
from .plan import Plan

TIMES = 10.0  # [-] target: times as fast as the explicit method
PEERS = (
    "compiled RODAS",
    "compiled CVODE Adams",
    "compiled CVODE BDF",
    "SciPy LSODA",
    "SciPy Radau",
    "CVODE Adams",
    "CVODE BDF",
    "IDA",
)
TIGHT = (1e-11, 1e-13)  # rtol, atol of the exact solution, and the peers that must agree on it
JUDGES = ("CVODE BDF", "SciPy LSODA")
AGREE = 1e-6  # [-]
EXPLICIT_RTOLS = RTOLS[4::2]  # stability limits the explicit method's steps, whatever the tolerance

STIFF_PROBE = {"k_A": 1e8, "c_A": 1e4, "k_T": 1e6, "c_T": 1e2}  # [N/m, N s/m, N m/rad, N m s/rad]
STICKING = 1e-5  # [m/s] slip speed below which the tip all but sticks
PROBLEMS: dict[str, tuple[Design, Parameters]] = {
    "rigid probe": (
        with_values(table2(), {f"buffer.{name}": value for name, value in STIFF_PROBE.items()}),
        replace(Parameters(), **STIFF_PROBE),
    ),
    "free tip sticking": (
        with_values(table2(), {"probe.free_tip": True, "contact.slip_speed": STICKING}),
        Parameters(rolling=True, slip_speed=STICKING),
    ),
}


def explicit(design: Design, exact: ours.Result) -> tuple[Figure, str]:
    """Time of the explicit method and how it came about; where it gives up, the time until then: a lower bound."""
    tried: list[Setting] = []
    for setting in ours.curve("explicit", design, exact, 1, EXPLICIT_RTOLS):
        tried.append(setting)
        if setting.error == float("inf"):
            break
    choice = cheapest([tried], TARGET)
    if choice is not None:
        return milliseconds(choice), "against explicit"
    return milliseconds(
        tried[-1], f"{ours.NAME}, explicit, without result"
    ), "against explicit, which gives up: at least"


def problem(plan: Plan, name: str) -> Part:
    """One problem."""
    design, parameters = PROBLEMS[name]
    solutions = [solve(peer, parameters, *TIGHT) for peer in JUDGES]
    apart = max(errors(*solutions).values())
    exact = ours.Result(*(getattr(solutions[0], field) for field in ("outcome", "impacts", "peak_force", "end_time")))
    mine = list(ours.curve("default", design, exact, 2))
    peers = [peer for peer in PEERS if peer in plan.peers]
    theirs = {peer: curves(peer, parameters, exact) for peer in plan.track(peers, f"{name}, peers")}
    own = cheapest([mine], TARGET)
    notes = [f"{name}: {' and '.join(JUDGES)} at rtol {TIGHT[0]:g} differ by {apart:.0e}"]
    key = name.replace(" ", "-")
    ratios = []
    if own is None or apart > AGREE:
        notes.append(f"{name}: " + ("no exact solution" if own else f"the product is nowhere within {TARGET:g}"))
    else:
        best = [choice for of_peer in theirs.values() if (choice := cheapest(of_peer, TARGET)) is not None]
        own, *best = race([own, *best], plan.repeats)
        figure, how = explicit(design, exact)
        ratios.append(Ratio(f"stiff/{key}/explicit", f"{name}, {how}", milliseconds(own), figure, TIMES))
        for peer in sorted(best, key=lambda setting: setting.seconds):
            what = f"{name}, against {peer.solver}"
            ratios.append(Ratio(f"stiff/{key}/{peer.solver}", what, milliseconds(own), milliseconds(peer)))
    drawn = [mine, *(curve for of_peer in theirs.values() for curve in of_peer)]
    plot: Plot = precision_plot(f"stiff-{key}", f"Stiff: {name}", drawn, "peak", TARGET)
    return Part("stiff", name, tuple(ratios), plots=(plot,), notes=tuple(notes))


def measure(plan: Plan) -> Part:
    """All problems; the free tip compiles anew and is left out of a quick run."""
    names = list(PROBLEMS)[:1] if plan.quick else list(PROBLEMS)
    parts = [problem(plan, name) for name in names]
    return Part(
        "stiff",
        f"Stiff problems, peak force and end time within {TARGET:g}",
        tuple(ratio for part in parts for ratio in part.ratios),
        plots=tuple(plot for part in parts for plot in part.plots),
        notes=tuple(note for part in parts for note in part.notes),
    )

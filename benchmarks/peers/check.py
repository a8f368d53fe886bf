"""Are the peers right?  ``python -m benchmarks peers.check`` runs every reference capture at tight tolerances.

Ends with status 1 where a peer is wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import typer

from ..accuracy import best_of, errors
from ..names import chosen
from ..plan import REFERENCES
from .reference import Reference, load
from .solvers import PEERS, solve

ACCURATE = 1e-5  # [-] relative error of the peak force that a peer may have at tight tolerances


def check_accuracy(cases: Sequence[Reference], peers: Sequence[str], rtol: float, atol: float) -> bool:
    """Print a line for each peer and capture; whether all of them are right."""
    right = True
    print(f"rtol {rtol:g}, atol {atol:g}")
    print(f"{'peer':22}{'capture':16}{'peak error':>12}{'end error':>12}{'impacts':>9}{'ms':>9}")
    for peer in peers:
        solve(peer, cases[0].parameters, 1e-4, 1e-6)  # compiles
        for case in cases:
            capture, seconds = best_of(1, lambda: solve(peer, case.parameters, rtol, atol))  # noqa: B023
            off = errors(capture, case)
            fine = off["peak"] <= ACCURATE
            right = right and fine
            mark = "" if fine else f"  WRONG: {capture.outcome}, {case.outcome} after {case.impacts} expected"
            print(
                f"{peer:22}{case.name:16}{off['peak']:12.1e}{off['end']:12.1e}{capture.impacts:9}"
                f"{1e3 * seconds:9.1f}{mark}",
                flush=True,
            )
    return right


def main(
    peer: Annotated[list[str] | None, typer.Option(help=f"only this one (may be repeated): {', '.join(PEERS)}")] = None,
    rtol: float = 1e-9,
    atol: float = 1e-12,
) -> int:
    """Run the check; the exit status."""
    return 0 if check_accuracy(load(REFERENCES), chosen(peer, PEERS, "peer"), rtol, atol) else 1

"""Are the peers right, and how fast are they?  ``python -m benchmarks.peers.check REFERENCE.json [--octave]``.

First every peer runs every reference capture at tight tolerances; then each is loosened on the first one (Table 2) as
far as its peak force and end time stay within 1e-4. Ends with status 1 where a peer is wrong.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from . import octave
from .reference import Reference, load
from .solvers import PEERS, solve
from .timing import best_of, reliable

ACCURATE = 1e-5  # [-] relative error of the peak force that a peer may have at tight tolerances
LOOSE = 1e-4  # [-] relative error of peak force and end time at the tolerances that are compared
OCTAVE_SETTINGS = ((1e-7, 1e-9), (1e-8, 1e-10))  # looser ones chatter for minutes


def check_accuracy(cases: Sequence[Reference], peers: Sequence[str], rtol: float, atol: float) -> bool:
    """Print a line for each peer and capture; whether all of them are right."""
    right = True
    print(f"rtol {rtol:g}, atol {atol:g}")
    print(f"{'peer':14}{'capture':16}{'peak error':>12}{'end error':>12}{'impacts':>9}{'ms':>9}")
    for peer in peers:
        solve(peer, cases[0].parameters, 1e-4, 1e-6)  # compiles
        for case in cases:
            capture, seconds = best_of(1, lambda: solve(peer, case.parameters, rtol, atol))  # noqa: B023
            peak, end = case.errors(capture)
            fine = case.alike(capture) and peak <= ACCURATE
            right = right and fine
            mark = "" if fine else f"  WRONG: {capture.outcome}, {case.outcome} after {case.impacts} expected"
            print(
                f"{peer:14}{case.name:16}{peak:12.1e}{end:12.1e}{capture.impacts:9}{1e3 * seconds:9.1f}{mark}",
                flush=True,
            )
    return right


def print_speed(case: Reference, peers: Sequence[str], repeats: int) -> None:
    """Print the loosest reliable setting of each peer, and the quickest where it is another."""
    print(f"\n{case.name}: settings from which on all tighter ones are within {LOOSE:g} in peak and end")
    print(f"{'peer':14}{'':10}{'rtol':>9}{'atol':>9}{'peak error':>12}{'end error':>12}{'ms':>9}")
    for peer in peers:
        settings = list(reliable(peer, case, LOOSE, repeats))
        if not settings:
            print(f"{peer:14}none")
            continue
        loosest = max(settings, key=lambda setting: (setting.rtol, setting.atol))
        quickest = min(settings, key=lambda setting: setting.seconds)
        for label, found in (("loosest", loosest), ("quickest", quickest)):
            print(
                f"{peer:14}{label:10}{found.rtol:9.1e}{found.atol:9.1e}{found.peak_error:12.1e}{found.end_error:12.1e}"
                f"{1e3 * found.seconds:9.1f}",
                flush=True,
            )


def print_octave(case: Reference) -> None:
    """Print Octave's errors and times, or why there are none."""
    for rtol, atol in OCTAVE_SETTINGS:
        try:
            found = octave.capture(case.parameters, rtol, atol)
        except octave.OctaveError as error:
            print(f"Octave ode15s failed: {error}")
            continue
        if isinstance(found, str):
            print(f"Octave ode15s {found}")
            return
        peak, end = case.errors(found.capture)
        print(
            f"{'Octave ode15s':24}{rtol:9.1e}{atol:9.1e}{peak:12.1e}{end:12.1e}{1e3 * found.seconds:9.1f}", flush=True
        )


def main() -> int:
    """Run the check; the exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.peers.check", description=__doc__.splitlines()[0])
    parser.add_argument("reference", type=Path, help="JSON file of the reference captures")
    parser.add_argument("--peer", action="append", choices=list(PEERS), help="only this one (may be repeated)")
    parser.add_argument("--rtol", type=float, default=1e-9, help="relative tolerance of the accuracy table")
    parser.add_argument("--atol", type=float, default=1e-12, help="absolute tolerance of the accuracy table")
    parser.add_argument("--repeats", type=int, default=5, help="runs of which the best is taken")
    parser.add_argument("--octave", action="store_true", help="run Octave's ode15s too (a minute)")
    options = parser.parse_args()
    cases = load(options.reference)
    peers = options.peer or list(PEERS)
    right = check_accuracy(cases, peers, options.rtol, options.atol)
    print_speed(cases[0], peers, options.repeats)
    if options.octave:
        print_octave(cases[0])
    return 0 if right else 1


if __name__ == "__main__":
    sys.exit(main())

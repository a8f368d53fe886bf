"""How long a peer takes at which accuracy: its work-precision curves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

from ..accuracy import RTOLS, Numbers, Setting, errors, measured
from .parameters import Parameters
from .solvers import ABSOLUTE, solve, tolerances

USELESS = 1e-2  # [-] a curve ends at the first setting whose error is larger


def curve(
    peer: str,
    parameters: Parameters,
    exact: Numbers,
    parts: tuple[float, float],
    repeats: int = 1,
    rtols: Sequence[float] = RTOLS,
) -> Iterator[Setting]:
    """Settings of a ``peer`` from tight to loose, with atol as ``parts`` of rtol in positions and velocities."""
    for rtol in rtols:
        run = partial(solve, peer, parameters, rtol, tolerances(rtol, parts))
        label = f"rtol {rtol:.0e}, atol {parts[0]:g} and {parts[1]:g} of it"
        setting = measured(peer, label, run, partial(errors, exact=exact), repeats)
        yield setting
        if setting.error > USELESS:
            return


def curves(peer: str, parameters: Parameters, exact: Numbers, repeats: int = 1) -> list[list[Setting]]:
    """A curve for each kind of absolute tolerance; the first run of the peer, which compiles, is not among them."""
    solve(peer, parameters, 1e-5, 1e-7)
    return [list(curve(peer, parameters, exact, parts, repeats)) for parts in ABSOLUTE]

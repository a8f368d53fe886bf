"""What the paper's abstract, note and appendix say, and what three mechanisms say to each."""

import numpy as np

from ..claims import Claim, Value, cell, column, joined

ORDERS = 0.95  # rank correlation from which on the peaks are in the order of the energies
SAME = 1e-6  # relative: an energy that does not depend on the contact
SPREAD = 0.1  # rms of ln F at one energy from which on contact parameters matter
MECHANISMS = ("cone", "bar", "crank")
ELASTIC, ALIKE, RANDOM = range(3)  # the cases


def _each(form: str) -> str:
    return ", ".join(f"{name} {{:{form}}}" for name in MECHANISMS)


def _values(name: str, case: int) -> tuple[Value, ...]:
    return tuple(cell(mechanism, case, name) for mechanism in MECHANISMS)


def _ordered(claim: str, case: int, name: str) -> Claim:
    """Claim that the peaks of a case are in the order of the energies, in each mechanism."""
    ranks, speeds = _values(name, case), _values("rank_speed", case) if name == "rank_first" else ()
    finding = f"rank correlation {_each('.4f')}"
    if speeds:
        finding += f" (of the approach speed alone {_each('.2f')})"
    return Claim(
        f"T_c⁻ characterises the intensity of the impact force: {claim}",
        "abstract",
        finding,
        (*ranks, *speeds),
        tuple(rank >= ORDERS for rank in ranks),
    )


# How far friction and loss change the mean energy at the most, relative.
CHANGES = tuple(
    column(mechanism, "mean_energy").map(lambda means: np.max(np.abs(means[1:] / means[0] - 1.0)))
    for mechanism in MECHANISMS
)
SCATTER = _values("scatter", RANDOM)

CLAIMS = (
    _ordered("no friction, no loss", ELASTIC, "rank_first"),
    _ordered("friction and loss, alike in all", ALIKE, "rank_first"),
    _ordered("friction and loss at random", RANDOM, "rank_first"),
    _ordered("later impacts as well, no friction, no loss", ELASTIC, "rank_all"),
    _ordered("later impacts as well, friction and loss", ALIKE, "rank_all"),
    Claim(
        "It depends only on mechanical parameters and configuration",
        "abstract",
        f"friction and loss change the mean by {_each('.0e')}; but it grows with the speeds squared",
        CHANGES,
        # No more than in part: an energy that depends on no contact still depends on the speeds, which the text leaves
        # out.
        (joined(*CHANGES).map(max) < SAME, False),
    ),
    Claim(
        "A force's accurate prediction takes the contact's parameters, case by case",
        "abstract",
        f"rms of ln F at one T_c⁻: {_each('.3f')}; contact at random {_each('.3f')}",
        (*_values("scatter", ELASTIC), *SCATTER),
        tuple(value > SPREAD for value in SCATTER),
    ),
    Claim(
        "The contact points' relative velocity is zero at the very beginning",
        "note 1",
        "our bodies' points close fastest at touchdown and stop at the end of compression, a quantity of each impact; "
        "the surfaces' own deformation, which the note speaks of, is no part of these models",
    ),
    Claim("Experiments confirm the indicator", "abstract", "the text at hand has no data of the experiments"),
)

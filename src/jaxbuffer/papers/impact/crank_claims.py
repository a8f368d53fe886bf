"""What the paper's section 3 says of the slider-crank, and what the model says to each."""

import numpy as np

from ..claims import Cases, Claim, Value, cell, column, either, joined, listed, near

LOWEST, MIDDLE, HIGHEST, STIFF, STIFF_ONLY = range(5)  # the rigid cases: e = 0.01, 0.1, 0.2, and 0.2 with k = 1e5
PRINTED = slice(STIFF_ONLY)  # the last set is ours
BENDING = slice(1, None)  # the first case is the rigid rod
COMPONENTS = ("across", "along")


def _swing(study: str, cases: Cases = slice(None)) -> Value:
    """Return the largest size of the torque after the start [N m]."""
    return np.maximum(abs(column(study, "least_torque", cases)), abs(column(study, "largest_torque", cases)))


def _torque_is(claim: str, where: str, case: int, *printed: float) -> Claim:
    """Compare printed torques [N m], of either sign, with the least and the largest one after the start."""
    ends = tuple(cell("crank", case, name) for name in ("least_torque", "largest_torque"))
    return Claim(
        claim,
        where,
        "{:.4g} to {:.4g} N m; cannot be compared, as no geometry is printed",
        ends,
        tuple(either(near(abs(end), value) for end in ends) for value in printed),
    )


def _forces_are(claim: str, where: str, case: int, *printed: float) -> Claim:
    """Compare the printed components [N] with the largest ones."""
    forces = tuple(cell("crank", case, name) for name in COMPONENTS)
    parts = tuple(near(force, value) for force, value in zip(forces, printed, strict=True))
    return Claim(claim, where, "{:.5g} N across, {:.5g} N along", forces, parts)


def _exponent_raises(claim: str, where: str, first: int, second: int) -> Claim:
    """Claim that both components are larger in the second case."""
    pairs = tuple(column("crank", name, (first, second)) for name in COMPONENTS)
    return Claim(
        claim,
        where,
        "across {:.4g} N, along {:.4g} N: for depths below 1 mm, here {:.2g} µm at most, δ^e falls as e grows",
        (*pairs, 1e6 * column("crank", "depth").map(max)),
        tuple(pair[1] > pair[0] for pair in pairs),
    )


def _bending_lowers(claim: str, study: str) -> Claim:
    """Claim that a rod that bends lowers torque and both components, in every number of modes."""
    values = (*(column(study, name) for name in COMPONENTS), _swing(study))
    return Claim(
        claim,
        "3.1, 4",
        "across {:.4g} N; along {:.4g} N; torque {:.3g} N m; impacts {:.4g}: rigid, 2 and 4 modes",
        (*values, column(study, "impacts")),
        tuple(value.map(lambda each: each[1:] < each[0]) for value in values),
    )


TURNS, BENT_TURNS = (
    joined(*(column(study, name, cases) for name in ("first_turn", "second_turn")))
    for study, cases in (("crank", slice(None)), ("crank_cycles", BENDING))
)
ACROSS, ALONG, ACROSS_LATER, AT_START, LATER, START_TAKES = (
    column("crank", name, PRINTED)
    for name in (*COMPONENTS, "across_second_turn", "torque_at_start", "largest_torque", "start_takes")
)
SMALL_TORQUE, LARGE_TORQUE = (cell("crank", case, "second_turn") for case in (STIFF_ONLY, STIFF))
BENT_SWING = _swing("crank_rod")
ROD_START_TAKES, ROD_TOUCHES = (column("crank_rod", name) for name in ("start_takes", "first_impact"))
FIRST_SWING, SECOND_SWING = (
    column("crank_cycles", name, BENDING) for name in ("swing_first_turn", "swing_second_turn")
)

CLAIMS = (
    Claim(
        "Torque and forces repeat at an interval of 0.63 s",
        "3.1, fig. 30",
        "{:.4f} to {:.4f} s a turn in all printed sets: 2π/ω0, whatever the contact",
        (TURNS.map(min), TURNS.map(max)),
        (near(TURNS, 0.63),),
    ),
    Claim(
        "The mechanism runs in correct cycles after the start",
        "3.1",
        "the turns repeat in time; the largest force across, overall and in the second turn, does not: {}",
        (listed("{:.4g} and {:.4g} N", ACROSS, ACROSS_LATER),),
        # That the turns repeat in time is a part of the claim, which the one above shows to hold.
        (True, near(ACROSS_LATER, ACROSS)),
    ),
    Claim(
        "The torque is largest at start-up",
        "3.1, fig. 30-33",
        "M₀ at rest by its formula, {:.4g} N m; later {:.4g} N m",
        (AT_START, LATER),
        (AT_START > LATER,),
    ),
    Claim(
        "The start takes the first milliseconds, by the inertia",
        "3.1",
        "a tenth of it is left after {:.2g} ms, with the assumed inertia",
        (1e3 * START_TAKES,),
        (START_TAKES < 5e-3,),
    ),
    _torque_is("The torque is -825 to 409 N m a cycle for e = 0.1", "3.1, fig. 30", MIDDLE, 825.0, 409.0),
    Claim(
        "The force along y is above that along z",
        "3.1, fig. 30-33",
        "across over along {:.3f}; the printed ratios are 3.5 to 4.2",
        (ACROSS / ALONG,),
        (ACROSS > ALONG,),
    ),
    _forces_are("12 375 and 3500 N for e = 0.1", "3.1, fig. 30", MIDDLE, 12375.0, 3500.0),
    _forces_are("6182 and 1462.5 N for e = 0.01", "3.1, fig. 31", LOWEST, 6181.81, 1462.5),
    _forces_are("23 875 and 5750 N for e = 0.2", "3.1, fig. 32", HIGHEST, 23875.0, 5750.0),
    _exponent_raises("The force is lower for e = 0.01 than for 0.1", "3.1, fig. 31", LOWEST, MIDDLE),
    _exponent_raises("The force is significantly higher for e = 0.2 than for 0.1", "3.1, fig. 32", MIDDLE, HIGHEST),
    Claim(
        "The force grows with k and M₀",
        "3.1, fig. 33",
        "across {:.4g} N; along {:.4g} N for k = 1e4, k = 1e5, and k = 1e5 with ten times the torque",
        tuple(column("crank", name, (HIGHEST, STIFF_ONLY, STIFF)) for name in COMPONENTS),
        tuple(cell("crank", STIFF, name) > cell("crank", HIGHEST, name) for name in COMPONENTS),
    ),
    _torque_is("8630 N m for k = 1e5, M₀ = 1e8", "3.1, fig. 33", STIFF, 8630.0),
    _forces_are("2.7e5 and 64 925 N for k = 1e5, M₀ = 1e8", "3.1, fig. 33", STIFF, 2.7e5, 64925.0),
    Claim(
        "A stiffer contact needs a larger M₀",
        "3.1",
        "with the smaller torque a turn takes {:.4f} s, with the larger {:.4f} s: it is not needed",
        (SMALL_TORQUE, LARGE_TORQUE),
        (~near(SMALL_TORQUE, LARGE_TORQUE),),
    ),
    Claim(
        "Mode 3 of the rod has 65.15 kHz, mode 10 has 10.61 kHz",
        "3.2.2, fig. 35",
        "frequencies rise with the number of the mode, so that the two are swapped at the least; ours go from {:.3g} "
        "to {:.3g} kHz in 4 modes",
        tuple(1e-3 * cell("crank_rod", -1, name) for name in ("lowest_mode", "highest_mode")),
        (False,),
    ),
    Claim(
        "With the rod that bends the torque's amplitude is 50 N m",
        "3.2.2, fig. 39",
        "rigid, 2 and 4 modes {:.3g} N m in the first 0.1 s, after the start",
        (BENT_SWING,),
        (near(_swing("crank_rod", BENDING), 50.0),),
    ),
    Claim(
        "Its jump at start-up comes from the shock in the joint",
        "3.2.2, fig. 39",
        "the torque is M₀ at rest and a tenth after {:.4g} ms; the first touch comes at {:.4g} ms, rigid, 2 and 4 "
        "modes",
        (1e3 * ROD_START_TAKES, 1e3 * ROD_TOUCHES),
        (ROD_TOUCHES < ROD_START_TAKES,),
    ),
    _bending_lowers("Extreme values are lower if the rod bends (read: same k, e, M₀)", "crank_rod"),
    _bending_lowers("The same over two cycles (onset of 1 µm)", "crank_cycles"),
    _bending_lowers("The same, for e = 1.5 (ours)", "crank_contact"),
    Claim(
        "With the rod that bends the torque is periodic",
        "3.2.2, fig. 39",
        "2 and 4 modes: a turn in {:.4f} to {:.4f} s; largest torque after the start, first and second turn, {}",
        (BENT_TURNS.map(min), BENT_TURNS.map(max), listed("{:.4g} and {:.4g} N m", FIRST_SWING, SECOND_SWING)),
        (near(BENT_TURNS, 0.63), near(SECOND_SWING, FIRST_SWING)),
    ),
)

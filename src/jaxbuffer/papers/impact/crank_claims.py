"""What the paper's section 3 says of the slider-crank, and what the model says to each."""

from collections.abc import Sequence

from ..study import NO, Claims, ClaimVerdict, Judge, Row, Rows, near, number, verdict

LOWEST, MIDDLE, HIGHEST, STIFF, STIFF_ONLY = range(5)  # the rigid cases: e = 0.01, 0.1, 0.2, and 0.2 with k = 1e5


def _numbers(rows: Sequence[Row], name: str) -> list[float]:
    return [number(row, name) for row in rows]


def _list(values: Sequence[float], form: str = ".4g") -> str:
    return ", ".join(f"{value:{form}}" for value in values)


def _swing(row: Row) -> float:
    """Return the largest size of the torque after the start [N m]."""
    return max(abs(number(row, name)) for name in ("least_torque", "largest_torque"))


CLAIMS = Claims()


def _torque_of(printed: tuple[float, ...], case: int) -> Judge:
    """Judge whether the least or the largest torque after the start is a printed one [N m], of either sign."""

    def judge(rows: Rows) -> ClaimVerdict:
        row = rows["crank"][case]
        ends = [number(row, name) for name in ("least_torque", "largest_torque")]
        finding = f"{ends[0]:.4g} to {ends[1]:.4g} N m; cannot be compared, as no geometry is printed"
        return ClaimVerdict(finding, verdict([any(near(abs(x), p) for x in ends) for p in printed]))

    return judge


def _forces(printed: tuple[float, float], case: int) -> Judge:
    """Judge whether the largest components are the printed ones [N]."""

    def judge(rows: Rows) -> ClaimVerdict:
        forces = [number(rows["crank"][case], name) for name in ("across", "along")]
        finding = f"{forces[0]:.5g} N across, {forces[1]:.5g} N along"
        return ClaimVerdict(finding, verdict([near(a, p) for a, p in zip(forces, printed, strict=True)]))

    return judge


def _exponent(first: int, second: int) -> Judge:
    """Judge whether both components are larger in the second case."""

    def judge(rows: Rows) -> ClaimVerdict:
        pairs = [_numbers([rows["crank"][k] for k in (first, second)], name) for name in ("across", "along")]
        deep = 1e6 * max(_numbers(rows["crank"], "depth"))
        finding = (
            f"across {_list(pairs[0])} N, along {_list(pairs[1])} N: for depths below 1 mm, here {deep:.2g} µm at "
            "most, δ^e falls as e grows"
        )
        return ClaimVerdict(finding, verdict([b > a for a, b in pairs]))

    return judge


def _lower(name: str) -> Judge:
    """Judge whether a rod that bends lowers torque and both components, in every number of modes."""

    def judge(rows: Rows) -> ClaimVerdict:
        forces = [_numbers(rows[name], one) for one in ("across", "along")]
        torques = [_swing(row) for row in rows[name]]
        finding = (
            f"across {_list(forces[0])} N; along {_list(forces[1])} N; torque {_list(torques, '.3g')} N m; impacts "
            f"{_list(_numbers(rows[name], 'impacts'))}: rigid, 2 and 4 modes"
        )
        return ClaimVerdict(finding, verdict([b < values[0] for values in (*forces, torques) for b in values[1:]]))

    return judge


@CLAIMS.judge("Torque and forces repeat at an interval of 0.63 s", "3.1, fig. 30")
def _cycle(rows: Rows) -> ClaimVerdict:
    turns = [time for name in ("first_turn", "second_turn") for time in _numbers(rows["crank"], name)]
    finding = f"{min(turns):.4f} to {max(turns):.4f} s a turn in all printed sets: 2π/ω0, whatever the contact"
    return ClaimVerdict(finding, verdict([near(time, 0.63) for time in turns]))


@CLAIMS.judge("The mechanism runs in correct cycles after the start", "3.1")
def _cyclic(rows: Rows) -> ClaimVerdict:
    pairs = [(number(row, "across"), number(row, "across_second_turn")) for row in rows["crank"][:STIFF_ONLY]]
    finding = ", ".join(f"{a:.4g} and {b:.4g} N" for a, b in pairs)
    finding = f"the turns repeat in time; the largest force across, overall and in the second turn, does not: {finding}"
    # That the turns repeat in time is a part of the claim, which `_cycle` shows to hold.
    return ClaimVerdict(finding, verdict([True, *(near(b, a) for a, b in pairs)]))


@CLAIMS.judge("The torque is largest at start-up", "3.1, fig. 30-33")
def _start(rows: Rows) -> ClaimVerdict:
    # The last set is ours, and the claim is about the printed ones.
    pairs = [(number(row, "torque_at_start"), number(row, "largest_torque")) for row in rows["crank"][:STIFF_ONLY]]
    finding = f"M₀ at rest by its formula, {_list([a for a, _ in pairs])} N m; later {_list([b for _, b in pairs])} N m"
    return ClaimVerdict(finding, verdict([start > later for start, later in pairs]))


@CLAIMS.judge("The start takes the first milliseconds, by the inertia", "3.1")
def _inertia(rows: Rows) -> ClaimVerdict:
    times = _numbers(rows["crank"][:STIFF_ONLY], "start_takes")
    finding = f"a tenth of it is left after {_list([1e3 * t for t in times], '.2g')} ms, with the assumed inertia"
    return ClaimVerdict(finding, verdict([t < 5e-3 for t in times]))


CLAIMS.judge("The torque is -825 to 409 N m a cycle for e = 0.1", "3.1, fig. 30")(_torque_of((825.0, 409.0), MIDDLE))


@CLAIMS.judge("The force along y is above that along z", "3.1, fig. 30-33")
def _order(rows: Rows) -> ClaimVerdict:
    pairs = [(number(row, "across"), number(row, "along")) for row in rows["crank"][:STIFF_ONLY]]
    finding = f"across over along {_list([a / b for a, b in pairs], '.3f')}; the printed ratios are 3.5 to 4.2"
    return ClaimVerdict(finding, verdict([a > b for a, b in pairs]))


CLAIMS.judge("12 375 and 3500 N for e = 0.1", "3.1, fig. 30")(_forces((12375.0, 3500.0), MIDDLE))
CLAIMS.judge("6182 and 1462.5 N for e = 0.01", "3.1, fig. 31")(_forces((6181.81, 1462.5), LOWEST))
CLAIMS.judge("23 875 and 5750 N for e = 0.2", "3.1, fig. 32")(_forces((23875.0, 5750.0), HIGHEST))
CLAIMS.judge("The force is lower for e = 0.01 than for 0.1", "3.1, fig. 31")(_exponent(LOWEST, MIDDLE))
CLAIMS.judge("The force is significantly higher for e = 0.2 than for 0.1", "3.1, fig. 32")(_exponent(MIDDLE, HIGHEST))


@CLAIMS.judge("The force grows with k and M₀", "3.1, fig. 33")
def _stiffness(rows: Rows) -> ClaimVerdict:
    one, only, both = (rows["crank"][k] for k in (HIGHEST, STIFF_ONLY, STIFF))
    parts = []
    for name in ("across", "along"):
        parts.append(f"{name} {_list(_numbers((one, only, both), name))} N")
    finding = "; ".join(parts) + " for k = 1e4, k = 1e5, and k = 1e5 with ten times the torque"
    return ClaimVerdict(finding, verdict([number(both, name) > number(one, name) for name in ("across", "along")]))


CLAIMS.judge("8630 N m for k = 1e5, M₀ = 1e8", "3.1, fig. 33")(_torque_of((8630.0,), STIFF))
CLAIMS.judge("2.7e5 and 64 925 N for k = 1e5, M₀ = 1e8", "3.1, fig. 33")(_forces((2.7e5, 64925.0), STIFF))


@CLAIMS.judge("A stiffer contact needs a larger M₀", "3.1")
def _torque_needed(rows: Rows) -> ClaimVerdict:
    small, large = (number(rows["crank"][k], "second_turn") for k in (STIFF_ONLY, STIFF))
    finding = f"with the smaller torque a turn takes {small:.4f} s, with the larger {large:.4f} s: it is not needed"
    return ClaimVerdict(finding, verdict([not near(small, large)]))


@CLAIMS.judge("Mode 3 of the rod has 65.15 kHz, mode 10 has 10.61 kHz", "3.2.2, fig. 35")
def _frequencies(rows: Rows) -> ClaimVerdict:
    row = rows["crank_rod"][-1]
    lowest, highest = (1e-3 * number(row, name) for name in ("lowest_mode", "highest_mode"))
    finding = (
        "frequencies rise with the number of the mode, so that the two are swapped at the least; ours go from "
        f"{lowest:.3g} to {highest:.3g} kHz in 4 modes"
    )
    return ClaimVerdict(finding, NO)


@CLAIMS.judge("With the rod that bends the torque's amplitude is 50 N m", "3.2.2, fig. 39")
def _amplitude(rows: Rows) -> ClaimVerdict:
    swings = [_swing(row) for row in rows["crank_rod"]]
    finding = f"rigid, 2 and 4 modes {_list(swings, '.3g')} N m in the first 0.1 s, after the start"
    return ClaimVerdict(finding, verdict([near(x, 50.0) for x in swings[1:]]))


@CLAIMS.judge("Its jump at start-up comes from the shock in the joint", "3.2.2, fig. 39")
def _jump(rows: Rows) -> ClaimVerdict:
    cases = rows["crank_rod"]
    finding = (
        f"the torque is M₀ at rest and a tenth after {_list([1e3 * t for t in _numbers(cases, 'start_takes')])} ms; "
        f"the first touch comes at {_list([1e3 * t for t in _numbers(cases, 'first_impact')])} ms, rigid, 2 and 4 modes"
    )
    return ClaimVerdict(finding, verdict([number(row, "first_impact") < number(row, "start_takes") for row in cases]))


CLAIMS.judge("Extreme values are lower if the rod bends (read: same k, e, M₀)", "3.1, 4")(_lower("crank_rod"))
CLAIMS.judge("The same over two cycles (onset of 1 µm)", "3.1, 4")(_lower("crank_cycles"))
CLAIMS.judge("The same, for e = 1.5 (ours)", "3.1, 4")(_lower("crank_contact"))


@CLAIMS.judge("With the rod that bends the torque is periodic", "3.2.2, fig. 39")
def _periodic(rows: Rows) -> ClaimVerdict:
    # The first case is the rigid rod, and the claim is about one that bends.
    cases = rows["crank_cycles"][1:]
    turns = [time for name in ("first_turn", "second_turn") for time in _numbers(cases, name)]
    swings = [(number(row, "swing_first_turn"), number(row, "swing_second_turn")) for row in cases]
    finding = (
        f"2 and 4 modes: a turn in {min(turns):.4f} to {max(turns):.4f} s; largest torque after the start, first and "
    )
    finding += "second turn, " + ", ".join(f"{a:.4g} and {b:.4g} N m" for a, b in swings)
    return ClaimVerdict(finding, verdict([*(near(time, 0.63) for time in turns), *(near(b, a) for a, b in swings)]))

"""What the paper's abstract, note and appendix say, and what three mechanisms say to each."""

from ..study import NO, OPEN, PARTLY, Claims, ClaimVerdict, Judge, Rows, verdict

ORDERS = 0.95  # rank correlation from which on the peaks are in the order of the energies
SAME = 1e-6  # relative: an energy that does not depend on the contact
SPREAD = 0.1  # rms of ln F at one energy from which on contact parameters matter
NAMES = ("cone", "bar", "crank")


def _values(rows: Rows, case: int, column: str) -> list[float]:
    return [float(rows[name][case][column]) for name in NAMES]


def _listed(values: list[float], digits: str = ".4f") -> str:
    return ", ".join(f"{name} {value:{digits}}" for name, value in zip(NAMES, values, strict=True))


CLAIMS = Claims()


def _ordered(case: int, column: str) -> Judge:
    """Judge whether the peaks of a case are in the order of the energies, in each mechanism."""

    def judge(rows: Rows) -> ClaimVerdict:
        ranks, speeds = _values(rows, case, column), _values(rows, case, "rank_speed")
        finding = f"rank correlation {_listed(ranks)}"
        if column == "rank_first":
            finding += f" (of the approach speed alone {_listed(speeds, '.2f')})"
        return ClaimVerdict(finding, verdict([rank >= ORDERS for rank in ranks]))

    return judge


def _open(why: str) -> Judge:
    return lambda rows: ClaimVerdict(why, OPEN)


ONSET = (
    "our bodies' points close fastest at touchdown and stop at the end of compression, a quantity of each impact; the "
    "surfaces' own deformation, which the note speaks of, is no part of these models"
)
INDICATOR = "T_c⁻ characterises the intensity of the impact force"


CLAIMS.judge(f"{INDICATOR}: no friction, no loss", "abstract")(_ordered(0, "rank_first"))
CLAIMS.judge(f"{INDICATOR}: friction and loss, alike in all", "abstract")(_ordered(1, "rank_first"))
CLAIMS.judge(f"{INDICATOR}: friction and loss at random", "abstract")(_ordered(2, "rank_first"))
CLAIMS.judge(f"{INDICATOR}: later impacts as well, no friction, no loss", "abstract")(_ordered(0, "rank_all"))
CLAIMS.judge(f"{INDICATOR}: later impacts as well, friction and loss", "abstract")(_ordered(1, "rank_all"))


@CLAIMS.judge("It depends only on mechanical parameters and configuration", "abstract")
def _only(rows: Rows) -> ClaimVerdict:
    changes = [
        max(abs(float(row["mean_energy"]) / float(rows[name][0]["mean_energy"]) - 1.0) for row in rows[name][1:])
        for name in NAMES
    ]
    finding = f"friction and loss change the mean by {_listed(changes, '.0e')}; but it grows with the speeds squared"
    # No more than in part: an energy that depends on no contact still depends on the speeds, which the text leaves out.
    return ClaimVerdict(finding, PARTLY if max(changes) < SAME else NO)


@CLAIMS.judge("A force's accurate prediction takes the contact's parameters, case by case", "abstract")
def _identified(rows: Rows) -> ClaimVerdict:
    elastic, random = _values(rows, 0, "scatter"), _values(rows, 2, "scatter")
    finding = f"rms of ln F at one T_c⁻: {_listed(elastic, '.3f')}; contact at random {_listed(random, '.3f')}"
    return ClaimVerdict(finding, verdict([value > SPREAD for value in random]))


CLAIMS.judge("The contact points' relative velocity is zero at the very beginning", "note 1")(_open(ONSET))
CLAIMS.judge("Experiments confirm the indicator", "abstract")(_open("the text at hand has no data of the experiments"))

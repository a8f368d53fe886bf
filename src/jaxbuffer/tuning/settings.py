"""The search's settings: the one place where they are declared."""

from typing import ClassVar

from ..fields import Part, number, whole


class Settings(Part):
    """How to search: the keywords of `tune`, and the section ``[tune]`` of a study.

    ``iterations`` of each local search at most; ``starts``: designs screened in a round, the first time the problem's
    own among them (1: that one alone, and no further round); ``searches``: the best of them that are followed;
    ``rounds`` at most; ``seed`` of the samples; ``tolerance`` [-]: a search has converged when first-order information
    predicts no larger reduction of the objective, relative, within a tenth of every range.
    """

    section: ClassVar[str] = "tune"
    iterations: int = whole(40, 1, doc="steps of each local search at most")
    starts: int = whole(32, 1, 2**20, doc="designs screened in a round; 1: the start alone, and no further round")
    searches: int = whole(2, 1, doc="how many of the best of them are followed")
    rounds: int = whole(6, 1, doc="rounds at most")
    seed: int = whole(0, 0, doc="of the samples of starts")
    tolerance: float = number(
        1e-4,
        "-",
        low=0.0,
        high=1.0,
        low_open=True,
        high_open=True,
        doc="a search has converged when slopes predict no larger relative gain",
    )

    @property
    def most_evaluations(self) -> int:
        """Designs evaluated at most in one stage of rounds: in each round ``starts``, and of every search its first
        design and ``iterations``."""
        if self.starts == 1:
            return 1 + self.iterations
        followed = max(2, self.searches) * (1 + self.iterations)
        return self.searches * (1 + self.iterations) + (self.rounds - 1) * followed + self.rounds * self.starts

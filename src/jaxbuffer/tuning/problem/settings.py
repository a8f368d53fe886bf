"""The settings of a search."""

import dataclasses
from collections.abc import Mapping
from typing import Any, ClassVar

from ...errors import check_known, check_single
from ...fields import Part, choice, limits_of, number, whole

OPTIMIZERS = ("adam", "adamw", "amsgrad", "lion", "nadam", "rmsprop", "sgd")  # of optax


class Settings(Part):
    """The settings of a search: the keywords of `tune`, and the section ``[tune]`` of a study.

    ``iterations`` of each local search at most; ``starts``: designs screened in a round, the first time the problem's
    own among them (1: that one alone, and no further round); ``searches``: the best of them that are followed;
    ``rounds`` at most; ``seed`` of the samples; ``tolerance`` [-]: a search has converged when first-order information
    predicts no larger reduction of the objective, relative, within a tenth of every range; ``optimizer``: what takes
    the steps, with its ``learning_rate`` [-] in the variables' ranges if it is one of optax.
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
    optimizer: str = choice("quadratic", "quadratic", *OPTIMIZERS, doc="quadratic programmes, or an optimizer of optax")
    learning_rate: float = number(
        0.05, "-", low=0.0, high=1.0, low_open=True, doc="of an optimizer of optax, in the variables' ranges"
    )

    @property
    def most_evaluations(self) -> int:
        """Return how many designs are evaluated at most in one stage.

        Each round has ``starts``, and every search its first design and ``iterations``.
        """
        if self.starts == 1:
            return 1 + self.iterations
        # A round after the first follows one design near the best and at least one from anywhere.
        followed = max(2, self.searches) * (1 + self.iterations)
        return self.searches * (1 + self.iterations) + (self.rounds - 1) * followed + self.rounds * self.starts


def settings_of(settings: Mapping[str, Any]) -> Settings:
    """Return settings by name. **Raises:** `InputError` for names that are unknown and values out of range."""
    known = [field.name for field in dataclasses.fields(Settings)]
    check_known(settings, known, "tune")
    for name in ("tolerance", "learning_rate"):
        if name in settings:
            limits = limits_of(Settings(), name)
            check_single(f"tune.{name}", settings[name], "-", "it holds for all searches", **limits)
    return Settings(**settings)

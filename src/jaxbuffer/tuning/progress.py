"""How far a tuning has come, as arrays that can be stored and read back."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from .evaluation import Evaluation
from .search import Branch

NUMBERS = ("stage", "captures", "scale", "ceiling", "searches", "apart")


class Progress(NamedTuple):
    """``stage``; ``captures`` spent; ``scale`` of the objective [N]; ``ceiling`` [N] on the first objective in the
    second stage, else NaN; of the first stage, how many ``searches`` were begun and how far the best two that began
    apart are ``apart`` [-]; ``first``: the problem's own start; the searches."""

    stage: int
    captures: int
    scale: float
    ceiling: float
    searches: int
    apart: float
    first: Evaluation
    branches: tuple[Branch, ...]

    def written(self) -> dict[str, np.ndarray]:
        """Flat names and arrays."""
        flat = {name: np.asarray(getattr(self, name)) for name in NUMBERS}
        flat |= _flat("first", self.first)
        for k, branch in enumerate(self.branches):
            flat |= _flat(f"{k}/point", branch.point) | _flat(f"{k}/best", branch.best)
            flat |= {f"{k}/{name}": np.asarray(getattr(branch, name)) for name in Branch._fields[2:]}
        return flat

    @staticmethod
    def read(flat: Mapping[str, np.ndarray] | None) -> "Progress | None":
        """What `written` wrote, or None for nothing."""
        if flat is None:
            return None
        try:
            return Progress._of(flat)
        except KeyError as error:
            raise InputError(f"the stored run is of another version of jaxbuffer: it has no {error}") from None

    @staticmethod
    def _of(flat: Mapping[str, np.ndarray]) -> "Progress":
        branches: list[Branch] = []
        while (k := f"{len(branches)}/radius") in flat:
            k = k.removesuffix("/radius")
            rest = {name: _plain(flat[f"{k}/{name}"]) for name in Branch._fields[2:]}
            branches.append(Branch(_evaluation(flat, f"{k}/point"), _evaluation(flat, f"{k}/best"), **rest))
        numbers = {name: _plain(flat[name]) for name in NUMBERS}
        return Progress(**numbers, first=_evaluation(flat, "first"), branches=tuple(branches))


def _flat(prefix: str, point: Evaluation) -> dict[str, np.ndarray]:
    return {f"{prefix}/{name}": value for name, value in zip(Evaluation._fields, point, strict=True)}


def _evaluation(flat: Mapping[str, np.ndarray], prefix: str) -> Evaluation:
    return Evaluation(*(flat[f"{prefix}/{name}"] for name in Evaluation._fields))


def _plain(value: np.ndarray) -> Any:
    return value if value.ndim else value.item()

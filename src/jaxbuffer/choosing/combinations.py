"""All combinations of one part of each catalogue, and the designs that they make."""

import functools
import math
from collections.abc import Sequence
from typing import Any

import jax
import numpy as np
from jaxtyping import Float, Int

from ..errors import InputError
from ..fields import Part, replace
from ..mechanisms.registry import mechanism_of
from ..tuning.problem.cases import Case
from .catalogue import TOTALS, CataloguePart, PartsCatalogue

MOST = 1_000_000  # combinations
Numbers = tuple[Any, ...]  # the leaves of design and scenario of one run


class Combinations:
    """The product of the catalogues, the last one changing fastest; combinations are known by their number.

    **Arguments:** ``design``: what the parts are put into; ``catalogues``: at least one.
    """

    def __init__(self, design: Part, catalogues: Sequence[PartsCatalogue]) -> None:
        self.design, self.catalogues = design, tuple(catalogues)
        self.shape = tuple(len(it.parts) for it in self.catalogues)
        if math.prod(self.shape) > MOST:
            sizes = " × ".join(map(str, self.shape))
            raise InputError(f"the catalogues have {sizes} = {math.prod(self.shape):.4g} combinations, above {MOST:g}")
        self._designs: dict[int, Part | InputError] = {}

    def __len__(self) -> int:
        return math.prod(self.shape)

    def places(self, number: int) -> tuple[int, ...]:
        """Return the place of each part in its catalogue."""
        return tuple(int(it) for it in np.unravel_index(number, self.shape))

    def number(self, places: Sequence[int]) -> int:
        """Return the number of the combination with the parts at these places: the inverse of `places`."""
        return int(np.ravel_multi_index(tuple(places), self.shape))

    def parts(self, number: int) -> tuple[CataloguePart, ...]:
        """Return the parts of a combination, one of each catalogue."""
        return tuple(it.parts[place] for it, place in zip(self.catalogues, self.places(number), strict=True))

    def names(self, number: int) -> tuple[str, ...]:
        """Return the parts' names."""
        return tuple(part.name for part in self.parts(number))

    def totals(self, name: str) -> Float[np.ndarray, " combinations"]:
        """Return the sum of price or mass [kg] of every combination."""
        # A role whose parts have no price or mass adds nothing to the sums of the others.
        columns = [[part.totals.get(name, 0.0) for part in catalogue.parts] for catalogue in self.catalogues]
        return functools.reduce(np.add.outer, map(np.asarray, columns)).ravel()

    @property
    def units(self) -> dict[str, str]:
        """Return the units that numbers were typed with, by path."""
        return {path: symbol for catalogue in self.catalogues for path, symbol in catalogue.units.items()}

    @property
    def summed(self) -> tuple[str, ...]:
        """Return which of price and mass any part has."""
        return tuple(name for name in TOTALS if any(name in it.totals for it in self.catalogues))

    def built(self, number: int) -> Part | InputError:
        """Return a combination's design, or why its parts do not go together."""
        # Kept, because every load case asks for the same design.
        if number not in self._designs:
            values = {path: it for part in self.parts(number) for path, it in part.fields.items()}
            try:
                self._designs[number] = replace(self.design, values)
            except InputError as error:
                # Parts that do not go together rule out this combination only, so the error becomes its answer.
                self._designs[number] = error
        return self._designs[number]

    def pair(self, number: int, case: Case) -> tuple[Part, Part] | InputError:
        """Return a combination's design as a load case has it built with its scenario, or why they do not fit."""
        design = self.built(number)
        if isinstance(design, InputError):
            return design
        try:
            built = case.of(design)
            mechanism_of(design).check_fit(built, case.scenario)
        except InputError as error:
            return error
        return built, case.scenario

    def fitting(self, number: int, cases: Sequence[Case]) -> bool:
        """Return whether a combination can be run in every load case."""
        return not any(isinstance(self.pair(number, case), InputError) for case in cases)


def stacked(pairs: Sequence[tuple[Part, Part]]) -> list[tuple[Int[np.ndarray, " runs"], Any]]:
    """Return the runs of each program: their places, and design and scenario with an array (runs,) for each number.

    Choices, curves and numbers that are not set make programs of their own.
    """
    groups: dict[Any, tuple[list[int], list[Numbers]]] = {}
    for place, pair in enumerate(pairs):
        leaves, structure = jax.tree.flatten(pair)
        key = structure, tuple(np.shape(leaf) for leaf in leaves)
        places, rows = groups.setdefault(key, ([], []))
        places.append(place)
        rows.append(tuple(leaves))
    made = []
    for (structure, _), (places, rows) in groups.items():
        columns = [np.array(column, float) for column in zip(*rows, strict=True)]
        made.append((np.array(places), jax.tree.unflatten(structure, columns)))
    return made

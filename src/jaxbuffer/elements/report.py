"""What a summary, a figure and a page say of an element: a class beside its physics."""

from collections.abc import Mapping
from typing import Any, Generic, NamedTuple, TypeVar

from .picture import Panel

E = TypeVar("E")


class EnergyShare(NamedTuple):
    """What an element has of a run's energy.

    - ``place``: where the energy was lost, in words: "end stop".
    - ``label``: of a curve of all of it: "in the end stop".
    - ``names``: of the energies that count, of which the last one is what was lost.
    """

    place: str
    label: str
    names: tuple[str, ...]


class Report(Generic[E]):
    """What is said and drawn of an ``element``. Every method has a default that says no more than its name."""

    def __init__(self, element: E):
        self.element = element

    @property
    def words(self) -> str:
        """Return what the element is called in texts."""
        return str(self.element.name).replace("_", " ")  # type: ignore[attr-defined]

    def summary(self, run: Any) -> list[tuple[str, str]]:
        """Return lines of a run's summary, each as its heading and its text."""
        return []

    @property
    def summary_observables(self) -> tuple[str, ...]:
        """Return the observables whose largest values the lines of its summary say, where it has any lines."""
        return ()

    def panels(self, run: Any) -> list[Panel]:
        """Return panels of a figure of a run that has a history."""
        return []

    def moments(self, run: Any) -> Mapping[str, float]:
        """Return when the element does something that a picture should show [s], by what happens in words; NaN of what
        does not happen."""
        return {}

    def warnings(self, run: Any) -> list[str]:
        """Return a line for each limit of validity that a run exceeds."""
        return []

    @property
    def shares(self) -> tuple[EnergyShare, ...]:
        """Return what the element has of a run's energy."""
        return ()

    @property
    def balls(self) -> tuple[Any, ...]:
        """Return the balls on shapes, as `BallContact`, that a plain drawing shows."""
        return ()

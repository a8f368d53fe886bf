"""What is told of a mechanism and drawn of its runs, beside its physics."""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import jax
import numpy as np

from ..fields import Part, paths, unit
from ..labelled.record import heading
from ..value_text import degrees_text, with_unit
from .drawing import Drawing, plain_drawing
from .picture import Meshed, Panel, PanelCurve
from .validity import ValidityLimit


@dataclasses.dataclass(frozen=True)
class Names:
    """What parts of a mechanism are called in tables and files, in the order of their numbers.

    ``bodies``; ``contacts``: those that have impacts; ``multipliers`` of the joints' rows and ``others`` of the
    history, each with its unit; ``shares``: those of the others whose share of its first value a quantity of the same
    name is, and what tables call the number itself.
    """

    bodies: tuple[str, ...] = ()
    contacts: tuple[str, ...] = ("contact",)
    multipliers: Mapping[str, str] = dataclasses.field(default_factory=dict)
    others: Mapping[str, str] = dataclasses.field(default_factory=dict)
    shares: Mapping[str, str] = dataclasses.field(default_factory=dict)

    def contact(self, number: int) -> str:
        """Return the name of a contact by its number, a plain one where it has none; "" for -1, which is no contact."""
        if number < 0:
            return ""
        return self.contacts[number] if number < len(self.contacts) else f"contact {number + 1}"

    def of_contacts(self, count: int) -> tuple[str, ...]:
        """Return the names of the ``count`` contacts that a mechanism has."""
        return tuple(map(self.contact, range(count)))

    def series(self, others: Mapping[str, Any]) -> Iterator[tuple[str, str, Any]]:
        """Yield name in tables, unit and values of each of the history's ``others``."""
        for name, symbol in self.others.items():
            if name not in others:
                continue
            values = others[name]
            yield self.shares.get(name, name), symbol, values
            # Of a run that is traced nobody knows whether its first value is above zero.
            if name in self.shares and not isinstance(values, jax.core.Tracer):
                # A share of nothing is not known.
                values = np.asarray(values)
                first = float(values[0]) if len(values) else 0.0
                yield name, "-", values / first if first > 0.0 else np.full(len(values), np.nan)


def plain_label(scenario: Part, among: Sequence[Part] = ()) -> str:
    """Return a scenario in a few words: its fields' values with their units."""
    names = [name for name in paths(scenario) if name not in scenario.without_effect]
    return ", ".join(f"{name.replace('_', ' ')} {_shown(scenario, name)}" for name in names)


def _shown(scenario: Part, name: str) -> str:
    value, symbol = getattr(scenario, name), unit(scenario, name)
    if symbol == "rad":
        return degrees_text(math.degrees(float(value)), sign=False)
    return with_unit(float(value), symbol, 4) if symbol else str(value)


def plain_panels(run: Any) -> list[Panel]:
    """Return what the elements of a run with a history show; where they show nothing, the mechanism's quantities that
    the history has."""
    if panels := [panel for it in run.elements for panel in it.report.panels(run)]:
        return panels
    others = run.history.others
    for name, quantity in run.mechanism.quantities.items():
        if name in others:
            symbol, factor = quantity.in_figures
            title = quantity.title or name.replace("_", " ")
            curve = PanelCurve("", factor * np.asarray(others[name]))
            panels.append(Panel(title.capitalize(), heading(title, symbol), (curve,), whole=True, to_end=True))
    return panels


class Synonym(NamedTuple):
    """A ``section`` of a design that is called otherwise, and its ``meaning`` in words."""

    section: str
    meaning: str


class Caution(NamedTuple):
    """A line about a design in a scenario, known before anything is computed.

    - ``subject``: of several scenarios' lines on one subject the worst alone is said;
    - ``excess``: how far the numbers go, larger where it is worse [any unit];
    - ``measured``: whether a run measures the same and says it better.
    """

    line: str
    subject: str
    excess: float = 0.0
    measured: bool = False


@dataclasses.dataclass(frozen=True)
class View:
    """What is told and drawn of a mechanism; all of it has a plain default.

    - ``title`` of its summaries; ``run_name``: what a run is called ("capture"); ``contact``: what a contact that has
      impacts is called ("flank"); ``names`` of a design's parts;
    - ``label`` of a scenario among others; ``approach``: a scenario at the end of a figure's title;
    - ``summary`` of a run, None for the plain one (`plain_summary`); ``record``: tables of numbers that a run's record
      has besides, by name; ``notes``: lines below a table of a run's sensitivities; ``diagnosis``: of a run that did
      not end in ``success``, what held it back, a text by heading;
    - ``sanity_checks``: of a design, a line for each number that is easily left at a value that does not fit it;
    - ``largest``: of a design, by the history's name, the largest size that a quantity of its runs can have;
    - ``larger_force``: of a run, a force that exceeds its peak contact force, for headlines: "the largest force on a
      vehicle is the hinge's, 636 N", or "";
    - ``contradictions``: of a design in a scenario, both with plain numbers, a `Caution` for each thing that their
      geometry rules out, such as a tip that misses the cone, or that they let expect;
    - ``limitations``: what the model leaves out, a line each, and where it is told; ``limitations_without``: what it
      leaves out of a design without a part, the part's path and a line each; ``warnings``: a line for each limit
      that a run exceeds, by default those of its elements; ``validity``: the same limits for many runs, from a
      design and what is known of their quantities, an array by name;
    - ``synonyms``: what sections of its designs are called otherwise, by that other name;
    - ``chaotic``: whether small differences grow until later impacts cannot be known, so that the command line tells
      how many of them are (`jb.horizon`);
    - ``panels``: what to draw of a run, by default what its elements show, or else its quantities; ``meshes``: its
      elements at some times of a run, or at a few telling ones; ``drawing``: what a design looks like, from it and its
      bodies' names.
    """

    title: str = "Run"
    run_name: str = "run"
    contact: str = "contact"
    names: Callable[[Any], Names] = lambda design: Names()
    label: Callable[..., str] = plain_label
    approach: Callable[[Any], str] = plain_label
    summary: Callable[[Any], str] | None = None
    record: Callable[[Any], dict[str, dict[str, Any]]] = lambda run: {}
    notes: Callable[[Any], list[str]] = lambda run: []
    diagnosis: Callable[[Any], Mapping[str, str]] = lambda run: {}
    sanity_checks: Callable[[Any], list[str]] = lambda design: []
    largest: Callable[[Any], Mapping[str, float]] = lambda design: {}
    larger_force: Callable[[Any], str] = lambda run: ""
    contradictions: Callable[[Any, Any], list[Caution]] = lambda design, scenario: []
    limitations: tuple[str, ...] = ()
    limitations_without: tuple[tuple[str, str], ...] = ()
    warnings: Callable[[Any], list[str]] = lambda run: [line for it in run.elements for line in it.report.warnings(run)]
    validity: Callable[[Any, Mapping[str, Any]], list[ValidityLimit]] = lambda design, quantities: []
    synonyms: Mapping[str, Synonym] = dataclasses.field(default_factory=dict)
    chaotic: bool = False
    panels: Callable[[Any], list[Panel]] = plain_panels
    meshes: Callable[..., list[Meshed]] = lambda run, times=None: []
    drawing: Callable[[Any, tuple[str, ...]], Drawing] = plain_drawing

    def left_out(self, value_at: Callable[[str], Any]) -> tuple[str, ...]:
        """Return what the model leaves out of a design, given as its value at a path, a line each."""
        without = (line for path, line in self.limitations_without if value_at(path) is None)
        return (*self.limitations, *without)

    def contact_in_words(self, name: str) -> str:
        """Return a contact by its name and what it is: "upper flank"; "cushion" where that is its name."""
        return name if name == self.contact else f"{name} {self.contact}"

    def any_contact(self, design: Any) -> str:
        """Return a contact that is not named, in words: "a flank" of several, "the cone" where there is one."""
        return f"{'a' if len(self.names(design).contacts) > 1 else 'the'} {self.contact}"

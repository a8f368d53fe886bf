"""The stiff part of an assembled mechanism, for implicit steps: springs, contacts and what elements add (M89)."""

import dataclasses

import jax
import jax.numpy as jnp
from jaxtyping import Array

from .._types import stacked
from ..elements.stiff_terms import ContactTerm, SpringTerm, linearised
from ..hybrid import Followers, Linearisation
from ..multibody import SpringDirection, System
from .layout import Closed, EvaluatedState, Layout
from .system import SmoothMemory


def stiff_part(
    system: System, layout: Layout, at: EvaluatedState, active: Closed, smooth: SmoothMemory | None
) -> Linearisation:
    """Return how the stiff forces act on the velocities and answer to motion.

    **Arguments:** ``system``; ``layout``; ``at``: the evaluated state; ``active``: closed contacts and switches;
    ``smooth``: the memory that follows, None for one that events set.
    """
    n, inertias = system.coordinates, layout.spin_inertias
    springs = [_spring_term(system, layout, spring) for spring in system.springs(at.kin)]
    contacts = _contact_terms(system, layout, at, active)
    for element, it, closed in zip(layout.elements, at.elements, layout.of_elements(active), strict=True):
        springs += [_spring_term(system, layout, spring) for spring in element.springs(it, closed)]
        term = element.contact_term(system, it, closed)
        contacts += [] if term is None else [_with_spins(layout, term, None)]
    if not springs and not contacts:
        return dataclasses.replace(Linearisation.none(n, n), followers=_followers(system, layout))
    if not contacts:
        # Seven or eight springs alone take XLA gigabytes to compile; nine do not.
        still = SpringTerm(jnp.zeros(n), 0.0, 0.0)
        springs += [still] * (9 - len(springs) if len(springs) in (7, 8) else 0)
        thin, none = jnp.zeros((n, 0)), jnp.zeros(0)
        contacts = [ContactTerm(thin, thin, *((none, none),) * 3)]
    joined = jax.tree.map(lambda *parts: jnp.concatenate(parts, axis=-1), *contacts)
    decay = None if smooth is None else smooth.all_decay(at.state, 2 * n + len(inertias))
    spins = stacked(list(inertias.values())) if inertias else None
    stiff = linearised(system, at.kin, springs, joined, spins, decay)
    return dataclasses.replace(stiff, followers=_followers(system, layout))


def _followers(system: System, layout: Layout) -> Followers | None:
    """Return the oscillators of the one element that has some, None where none has."""
    places = layout.places
    velocities = places["spins"].stop
    for k, element in enumerate(layout.elements):
        followers = element.followers(places[f"element {k}"].start - velocities, system.order)
        if followers is not None:
            return followers
    return None


def _spring_term(system: System, layout: Layout, spring: SpringDirection) -> SpringTerm:
    # A spring acts on bodies alone: balls that spin by themselves do not feel it.
    direction = jnp.pad(system.direction(spring.blocks), (0, len(layout.spin_inertias)))
    return SpringTerm(direction, spring.stiffness, spring.damping)


def _contact_terms(system: System, layout: Layout, at: EvaluatedState, active: Closed) -> list[ContactTerm]:
    """Return the contacts' shares of the stiff part."""
    memory, closed = layout.of_contacts(at.state[layout.places["memory"]]), layout.of_contacts(active)
    return [
        _with_spins(layout, contact.term(system, it, memory[k], closed[k]), k if contact.spins else None)
        for k, (contact, it) in enumerate(zip(layout.contacts, at.contacts, strict=True))
    ]


def _with_spins(layout: Layout, term: ContactTerm, contact: int | None) -> ContactTerm:
    """Return a term with a row for the spin of each ball that spins freely; ``contact``: whose own it has."""
    order, rows = list(layout.spin_inertias), layout.coordinates
    if not order:
        return term
    before = 0 if contact is None else order.index(contact)
    after = len(order) if contact is None else len(order) - 1 - before

    def widened(columns: Array) -> Array:
        # A contact turns its own ball and no other one.
        own = columns[rows:]
        return jnp.concatenate([columns[:rows], jnp.pad(own, ((before, after), (0, 0)))])

    return term._replace(normals=widened(term.normals), tangents=widened(term.tangents))

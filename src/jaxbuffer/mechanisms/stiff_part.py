"""The stiff part of an assembled mechanism, for implicit steps: what its bodies and elements add to it (M89)."""

import dataclasses

import jax
import jax.numpy as jnp
from jaxtyping import Array

from .._types import stacked
from ..elements.stiff_terms import ContactTerm, SpringTerm, linearised
from ..hybrid import Linearisation, PassiveOscillators
from ..multibody import SpringDirection, System
from .layout import Closed, EvaluatedState, Layout
from .scales import decays


def stiff_part(system: System, layout: Layout, at: EvaluatedState, active: Closed) -> Linearisation:
    """Return how the stiff forces act on the velocities and answer to motion.

    **Arguments:** ``system``; ``layout``; ``at``: the evaluated state; ``active``: closed contacts and switches.
    """
    n, inertias = system.velocities, layout.spin_inertias
    springs = [_spring_term(system, layout, spring) for spring in system.springs(at.kin)]
    contacts = list[ContactTerm]()
    for k, (element, it, closed) in enumerate(
        zip(layout.elements, at.elements, layout.of_elements(active), strict=True)
    ):
        springs += [_spring_term(system, layout, spring) for spring in element.springs(it, closed)]
        term = element.contact_term(system, it, closed)
        if term is not None:
            term = _with_spins(layout, term, k)
            springs += term.across
            contacts.append(term._replace(across=()))
    if not springs and not contacts:
        return dataclasses.replace(
            Linearisation.none(n, system.coordinates),
            followers=_followers(system, layout),
            position_rate=system.position_rate(at.kin.q),
        )
    if not contacts:
        # Seven or eight springs alone take XLA gigabytes to compile; nine do not.
        still = SpringTerm(jnp.zeros(n), 0.0, 0.0)
        springs += [still] * (9 - len(springs) if len(springs) in (7, 8) else 0)
        thin, none = jnp.zeros((n, 0)), jnp.zeros(0)
        contacts = [ContactTerm(thin, thin, *((none, none),) * 3)]
    joined = jax.tree.map(lambda *parts: jnp.concatenate(parts, axis=-1), *contacts)
    spins = stacked(inertias) if inertias else None
    stiff = linearised(system, at.kin, springs, joined, spins, decays(layout, at))
    return dataclasses.replace(stiff, followers=_followers(system, layout))


def _followers(system: System, layout: Layout) -> PassiveOscillators | None:
    """Return the oscillators of the one element that has some, None where none has."""
    places = layout.places
    velocities = places["spins"].stop
    for k, element in enumerate(layout.elements):
        followers = element.followers(places[f"element {k}"].start - velocities, system.velocity_order)
        if followers is not None:
            return followers
    return None


def _spring_term(system: System, layout: Layout, spring: SpringDirection) -> SpringTerm:
    # A spring acts on bodies alone: what spins by itself does not feel it.
    direction = jnp.pad(system.direction(spring.blocks), (0, len(layout.spin_inertias)))
    return SpringTerm(direction, spring.stiffness, spring.damping)


def _with_spins(layout: Layout, term: ContactTerm, element: int) -> ContactTerm:
    """Return an element's term with a row for each spin of the mechanism, of which it has those of its own."""
    rows, counts = layout.velocities, [len(it.spin_inertias) for it in layout.elements]
    if not any(counts):
        return term
    before, after = sum(counts[:element]), sum(counts[element + 1 :])

    def widened(columns: Array) -> Array:
        # An element turns what is its own and no other's.
        own = columns[rows:]
        return jnp.concatenate([columns[:rows], jnp.pad(own, ((before, after), (0, 0)))])

    across = tuple(it._replace(direction=widened(it.direction[:, None])[:, 0]) for it in term.across)
    return term._replace(normals=widened(term.normals), tangents=widened(term.tangents), across=across)

"""Excursions: guards that rise above zero and fall below it again within one step, which its two ends do not show.

Free flight takes steps as long as accuracy allows, and a thrown ball may pass a mark and be back below it at the step's
end. So a step whose ends leave that possible is looked at in between, where the state is interpolated. What is found
there is no event yet: the step is taken again, shorter, to end where the guard is above zero, and then holds a crossing
that `crossing` finds.
"""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from ..._types import Scalar
from ...duplication import evaluated_once
from ..hermite import cubic, maximum_of_cubic, state_within
from ..system import Active, HybridSystem, State
from .guards import Guards, SignedGuards, signed

SAMPLES = 8  # looks at a step, evenly spaced, the last one at its end


class Look(NamedTuple):
    """The guards at one place in a step, negative before their event: ``value``, ``rate`` per step, and ``doubt``: by
    how much the value may be wrong, because the state is interpolated."""

    value: Float[Array, " guards"]
    rate: Float[Array, " guards"]
    doubt: Float[Array, " guards"]


class _Search(NamedTuple):
    """How far the search has come: the last look, which guards have been below zero, and the fraction of the step at
    which the first excursion is above zero (1: there is none)."""

    look: Look
    below: Bool[Array, " guards"]
    fraction: Float[Array, ""]


def excursion_in_step(
    system: HybridSystem,
    start: tuple[State, State],
    end: tuple[State, State],
    before: Guards,
    after: Guards,
    step: Scalar,
    active: Active,
    located: Int[Array, ""],
    when: Bool[Array, ""],
) -> Float[Array, ""]:
    """Return the fraction of a step at which its first excursion is above zero, 1 where there is none.

    **Arguments:** state and rate at both ends of the ``step`` [s], and the guards there; ``active``: closed contacts;
    ``located``: the guard on whose event the step ends, -1 for none; ``when``: whether the step is to be searched.
    Only open contacts and the run's end are looked at: what a closed contact does is resolved by the steps within its
    impact.
    """
    rated = before.gap.shape[0] + before.terminal.shape[0]
    z0, z1 = (SignedGuards(*(part[:rated] for part in signed(guards, active))) for guards in (before, after))
    # a step that ends on an event leaves its guard at zero or on either side of it
    z1 = z1._replace(value=jnp.where(jnp.arange(rated) == located, jnp.minimum(z1.value, 0.0), z1.value))
    open_guards = jnp.concatenate([active < 0.5, jnp.ones(before.terminal.shape[0], bool)])
    possible = when & open_guards & _may_rise(z0, z1, step, before.gap.shape[0])

    def guards_of(state: State) -> Float[Array, " guards"]:
        gaps, terminals = system.gaps_and_terminals(state)
        return jnp.concatenate([-gaps, terminals])

    def guards_along(fraction: Array) -> Look:
        state_at = lambda x: state_within(system, start, end, step, x)  # noqa: E731
        state, motion = jax.jvp(state_at, (fraction,), (jnp.ones(()),))
        state, motion = evaluated_once((state, motion))
        value, change = jax.linearize(guards_of, state)
        # the cubic lacks what the quintic knows of second derivatives: as much may be wrong with the quintic
        cruder = cubic(start[0], end[0], step * start[1], step * end[1], fraction)
        rate, doubt = jax.vmap(change)(jnp.stack([motion, cruder - state]))
        return Look(value, rate, jnp.abs(doubt))

    first = Look(z0.value, z0.rate * step, jnp.zeros_like(z0.value))
    return first_excursion(guards_along, first, possible)


def _may_rise(start: SignedGuards, end: SignedGuards, step: Scalar, contacts: int) -> Bool[Array, " guards"]:
    """Return whether each guard, not above zero at the end of a step, may have been so within it.

    A polynomial lies below the largest of its Bernstein coefficients; of degree five where second derivatives are known
    (contacts), else three. How well it describes the guard is judged by what the parabola from the start misses at the
    end: all that is allowed for.
    """
    z0, z1, m0, m1 = start.value, end.value, start.rate * step, end.rate * step
    jump, of_contact = z1 - z0, jnp.arange(len(z0)) < contacts
    a0 = jnp.where(of_contact, start.acceleration * step**2, 6.0 * jump - 4.0 * m0 - 2.0 * m1)
    a1 = jnp.where(of_contact, end.acceleration * step**2, 2.0 * m0 + 4.0 * m1 - 6.0 * jump)
    early, late = jnp.maximum(m0 / 5.0, 0.4 * m0 + a0 / 20.0), jnp.maximum(-m1 / 5.0, -0.4 * m1 + a1 / 20.0)
    highest = jnp.maximum(z0 + early, z1 + late)
    unknown = jnp.abs(jump - m0 - 0.5 * a0)
    return ((z0 < 0.0) | (m0 < 0.0)) & (z1 <= 0.0) & (highest + unknown > 0.0)


def first_excursion(
    guards_along: Callable[[Float[Array, ""]], Look], first: Look, possible: Bool[Array, " guards"]
) -> Float[Array, ""]:
    """Return the fraction at which the first excursion of any of the ``possible`` guards is above zero; 1 without one.

    **Arguments:** ``guards_along``: the guards at a fraction of the step; ``first``: those at its start.
    """
    width = 1.0 / SAMPLES

    def search(k: Array, s: _Search) -> _Search:
        at = k * width
        look = guards_along(at + width)
        doubt = jnp.maximum(s.look.doubt, look.doubt)
        # a guard left at zero, or a hair above it, by the step that ended on its event counts as below zero there
        start = jnp.where(s.below, s.look.value, jnp.minimum(s.look.value, 0.0))
        top = maximum_of_cubic(start, look.value, s.look.rate * width, look.rate * width)
        turns = (s.look.rate > 0.0) & (look.rate < 0.0)
        inside = turns & s.below & (cubic(start, look.value, s.look.rate * width, look.rate * width, top) + doubt > 0.0)
        below = s.below | (look.value < 0.0)
        there = below & (look.value + look.doubt > 0.0) & (k < SAMPLES - 1)
        fraction = jnp.where(possible & inside, at + width * top, jnp.where(possible & there, at + width, 1.0))
        return _Search(look, below, jnp.minimum(s.fraction, jnp.min(fraction)))

    # No look at all where nothing is possible: most steps. Unlike `cond`, that also spares lanes stepped together.
    looks = jnp.where(jnp.any(possible), SAMPLES, 0)
    return lax.fori_loop(0, looks, search, _Search(first, first.value < 0.0, jnp.ones(()))).fraction

"""What becomes of an attempt: the run goes on from its end, it is shortened onto an event that it holds, or refused."""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool

from .attempt import Attempt
from .events import first_crossing, signed
from .landing import MAX_TRIES, MOST_TRIES, Landing, Verdict, judge
from .progress import Progress
from .task import Task
from .trees import where

OVERSHOT = 5.0  # times the allowed error: a step beyond an event may miss by that and still say where the event is


class Decision(NamedTuple):
    """``accept``: the step counts; ``stands``: it does, but a maximum within it is looked at before the run goes on
    from its end; ``again``: it would, and is taken again with its sensitivities. ``starts``: a landing on an event
    found in it begins; ``dropped``: the landing under way is given up. ``landing``: the one to go on with;
    ``verdict`` on the one that was."""

    accept: Bool[Array, ""]
    stands: Bool[Array, ""]
    again: Bool[Array, ""]
    starts: Bool[Array, ""]
    dropped: Bool[Array, ""]
    landing: Landing
    verdict: Verdict

    @property
    def arrived(self) -> Bool[Array, ""]:
        """Whether the run goes on from the step's end at once."""
        return self.accept & ~self.stands


def decide(task: Task, c: Progress, a: Attempt) -> Decision:
    """Judge an attempt.

    A step that holds an event is taken again, shortened until it ends on the event: the run goes on from there. Only
    where that is a maximum and nothing else, the step itself stands, and the run goes on from its end. What a step
    shows whose error is too large may be a touchdown, but no maximum.
    """
    options, landing, fits = task.options, c.landing.under_way, a.fits
    maxima = fits & (c.landing.tries < MAX_TRIES)
    crossing = first_crossing(c.at.guards, a.guards, a.step, c.active, c.best, c.landing.target, maxima)
    guard = signed(a.guards, c.active)
    own = task.sought(c.landing.target)
    shortfall = options.shortfall * jnp.sum(jnp.where(own, jnp.abs(a.guards.value), 0.0))
    verdict = judge(c.landing, a.step, guard, task.rated, options.event_time, shortfall)
    # On arrival another event may turn out to lie a little before: then land on that one first.
    arrives = landing & verdict.settled & (c.landing.tries < MOST_TRIES)
    # The error of a step that overshoots an event is mostly what is not smooth there.
    near = a.own_norm <= jnp.where(options.solver.is_implicit(a.which), 1.0, OVERSHOT)
    starts = (~landing & ~c.renew & near | arrives) & a.finite & (crossing.which >= 0)
    stands = starts & ~landing & fits & crossing.alone & (crossing.which >= task.rated)
    accept = fits & (~landing | verdict.settled) & (~starts | stands) & a.finite
    dropped = landing & ~starts & (verdict.settled & ~fits | ~a.finite)
    tries = jnp.where(landing, c.landing.tries + 1, 0)
    going = where(landing & ~verdict.settled, verdict.next, Landing.none())
    found = Landing.begin(crossing, signed(c.at.guards, c.active).value, guard.value, tries, stands)
    following = where(dropped, Landing.none(), where(starts, found, going))
    # A step of the state alone that stands is taken again with its sensitivities.
    again = accept & ~a.whole & bool(task.lanes.count)
    following = where(again, c.landing._replace(there=verdict.there), following)
    accept = accept & ~again
    return Decision(accept, stands & accept, again, starts, dropped, following, verdict)
